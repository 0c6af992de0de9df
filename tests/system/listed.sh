#!/bin/sh
# Trajectories with contacts by list in nsdae-vtk, nsdae-animate, nsdae-plot, and xarray where it is; files
# that do not fit together.
# usage: listed.sh BIN_DIR DISKS_RUN CHECK.py; NSDAE_PYTHON may name a Python with vtk 9.3 or later
set -u
bin=$1
disks_run=$2
check=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

python=""
for modules in "h5py, vtkmodules.vtkIOHDF" "h5py, xarray, h5netcdf" h5py; do
  for candidate in ${NSDAE_PYTHON:+"$NSDAE_PYTHON"} python3 /usr/bin/python3; do
    [ -z "$python" ] && "$candidate" -c "import $modules" 2>/dev/null && python=$candidate
  done
done
[ -n "$python" ] || { echo "no Python with h5py: not tested"; exit 77; }
"$bin/nsdae-plot" --version >out 2>err && "$bin/nsdae-animate" --version >out 2>err ||
  { echo "no Python with matplotlib and PIL: not tested"; exit 77; }

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# expect WORDS PROGRAM ARGUMENT...: exit 1 with one line on stderr that has the words
expect() {
  words=$1
  shift
  "$bin/$@" >out 2>err
  got=$?
  if [ "$got" != 1 ] || [ "$(wc -l <err)" != 1 ] || ! grep -qF -- "$words" err; then
    fail "$*: exit $got, stderr: $(cat err) (wanted 1 and one line with: $words)"
  fi
}

for compress in 0 3; do
  "$disks_run" disks$compress.h5 24 6 120 5 $compress >out || fail "disks_run: $(cat out)"
  "$bin/nsdae-vtk" disks$compress.h5 >out 2>err || fail "nsdae-vtk: $(cat err)"
  grep -q '^their contacts in disks.*contacts.vtkhdf' out || fail "nsdae-vtk: $(cat out)"
  "$bin/nsdae-animate" --forces -o disks$compress.html -o disks$compress.gif disks$compress.h5 >out 2>err ||
    fail "nsdae-animate: $(cat err)"
  "$bin/nsdae-plot" disks$compress.h5 >out 2>err || fail "nsdae-plot: $(cat err)"
  "$bin/nsdae-plot" --only contacts -o few.svg disks$compress.h5 >out 2>err || fail "nsdae-plot: $(cat err)"
  grep -q 'median normal' few.svg || grep -q '<svg' few.svg || fail "few.svg"
  "$python" -B "$check" disks$compress.h5 disks$compress.vtkhdf disks$compress.html || fail "disks$compress"
done

# hundreds of balls in space
space=$(dirname "$check")/listed_space.py
"$python" -B "$space" make balls.h5 || fail "balls.h5"
"$bin/nsdae-vtk" balls.h5 >out 2>err || fail "nsdae-vtk: $(cat err)"
"$bin/nsdae-animate" --forces -o balls.html -o balls.gif balls.h5 >out 2>err || fail "nsdae-animate: $(cat err)"
"$python" -B "$space" check balls.h5 balls.vtkhdf balls.html || fail "balls"

# what does not fit together is said, in one line
spoil() {
  cp disks0.h5 bad.h5
  "$python" - "$1" "$2" <<'END'
import sys
import h5py
with h5py.File("bad.h5", "a") as f:
    f[sys.argv[1]][-1] = int(sys.argv[2])
END
}
spoil contacts/first 1000000
expect "record 24 has contacts that are not in its list" nsdae-vtk bad.h5
expect "record 24 has contacts that are not in its list" nsdae-animate --forces -o bad.gif bad.h5
expect "record 24 has contacts that are not in its list" nsdae-plot bad.h5
spoil shapes/position 71
expect "its /shapes do not fit together" nsdae-vtk bad.h5
spoil shapes/shape 9
expect "its /shapes do not fit together" nsdae-animate bad.h5
"$bin/nsdae-bouncing-ball" --quiet --t-end 0.1 --output ball.h5 >out
expect "has no contacts by list" nsdae-animate --forces ball.h5

[ $failures = 0 ] && echo "all as expected"
exit $failures
