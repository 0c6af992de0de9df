#!/bin/sh
# Trajectories of several shapes and of older versions opened by xarray. usage: xarray.sh BIN_DIR CHECK.py DATA_DIR
set -eu
bin=$1
check=$2
data=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python=/usr/bin/python3
[ -x $python ] || python=python3

# look NAME... -- ARGUMENT...: a program's file with these coordinates
look() {
  program=$1
  names=$2
  shift 2
  "$bin/nsdae-$program" --quiet --output "$program.h5" "$@"
  $python "$check" "$program.h5" $names
}

look pendulum "x y theta" --t-end 1
look column "$(for i in 0 1 2; do for q in x y z qw qx qy qz; do echo "$q$i"; done; done)" --set balls=3 --t-end 0.05
look woodpecker "y phi_M phi_S" --t-end 0.3 --every 7 --compress 4
look rolling-ball "x y z e_0 e_x e_y e_z" --t-end 0.2

# older NAME COORDINATE...: a file of format version 1 or 2
older() {
  file=$1
  shift
  xz -dc "$data/$file.h5.xz" >"$file.h5"
  $python "$check" "$file.h5" "$@"
}
older version_1_contacts y phi_M phi_S
older version_2_list $(for i in 0 1 2; do for q in x y z qw qx qy qz; do echo "$q$i"; done; done)
