#!/bin/sh
# Mechanisms of the kit: their files name the bodies by themselves, each where it is, and the programs
# that draw take them as they are. usage: shown.sh SHOWN BIN_DIR DRIVERS_PYTHON CHECK.py
set -u
shown=$1
bin=$2
modules=$3
check=$4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

python=""
for candidate in ${NSDAE_PYTHON:+"$NSDAE_PYTHON"} python3 /usr/bin/python3; do
  [ -z "$python" ] && "$candidate" -c "import h5py, matplotlib, PIL" 2>/dev/null && python=$candidate
done
[ -n "$python" ] || { echo "no Python with h5py, matplotlib and PIL: not tested"; exit 77; }

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

for dimension in 2 3; do
  for seed in 1 2 3 4 5; do
    "$shown" $dimension it.h5 $seed || fail "$dimension dimensions, seed $seed"
    "$python" -B "$check" "$modules" it.h5 $dimension || fail "$dimension dimensions, seed $seed"
  done
  "$bin/nsdae-vtk" it.h5 >out 2>err || fail "nsdae-vtk: $(cat err)"
  grep -q '^21 steps of 13 bodies' out || fail "nsdae-vtk: $(cat out)"
  "$bin/nsdae-animate" -o it.html it.h5 >out 2>err || fail "nsdae-animate: $(cat err)"
  grep -q '^21 frames of 13 bodies' out || fail "nsdae-animate: $(cat out)"
done

[ $failures = 0 ] && echo "all as expected"
exit $failures
