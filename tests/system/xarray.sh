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

# make PROGRAM ARGUMENT...: its trajectory; older NAME: one of format version 1 or 2
make() {
  program=$1
  shift
  "$bin/nsdae-$program" --quiet --output "$program.h5" "$@"
}
older() {
  $python -c "import lzma, shutil, sys; shutil.copyfileobj(lzma.open(sys.argv[1]), sys.stdout.buffer)" "$data/$1.h5.xz" >"$1.h5"
}

make pendulum --t-end 1
make column --set balls=3 --t-end 0.05
make woodpecker --t-end 0.3 --every 7 --compress 4
make rolling-ball --t-end 0.2
older version_1_contacts
older version_2_list
balls=$(for i in 0 1 2; do for q in x y z qw qx qy qz; do echo "$q$i"; done; done)
$python "$check" "pendulum.h5 x y theta" "column.h5 $balls" "woodpecker.h5 y phi_M phi_S" "rolling-ball.h5 x y z e_0 e_x e_y e_z" \
  "version_2_list.h5 $balls" "version_1_contacts.h5 y phi_M phi_S"
