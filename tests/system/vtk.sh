#!/bin/sh
# nsdae-vtk: every example's animation against its trajectory, one-line errors, and a full disk.
# usage: vtk.sh BIN_DIR DATA_DIR CHECK.py; NSDAE_PYTHON may name a Python with vtk 9.3 or later
set -u
bin=$1
data=$2
check=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

python=""
for modules in "h5py, vtkmodules.vtkIOHDF" h5py; do
  for candidate in ${NSDAE_PYTHON:+"$NSDAE_PYTHON"} python3 /usr/bin/python3; do
    [ -z "$python" ] && "$candidate" -c "import $modules" 2>/dev/null && python=$candidate
  done
done
if [ -z "$python" ]; then
  "$bin/nsdae-vtk" --version 2>err && exit 1
  grep -q python3-h5py err || exit 1
  echo "no Python with h5py: not tested"
  exit 77
fi

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# expect EXIT WORDS ARGUMENT...: the exit code, and one line on stderr that has the words
expect() {
  code=$1
  words=$2
  shift 2
  "$bin/nsdae-vtk" "$@" >out 2>err
  got=$?
  if [ "$got" != "$code" ] || [ "$(wc -l <err)" != 1 ] || ! grep -qF -- "$words" err; then
    fail "nsdae-vtk $*: exit $got (wanted $code), stderr: $(cat err) (wanted one line with: $words)"
  fi
}

for program in "$bin"/nsdae-*; do
  example=${program##*/nsdae-}
  "$program" --help 2>/dev/null | grep -q 'FILE.h5 *trajectory' || continue # not an example
  params=$data/$example.ini
  shorter=""
  case $example in
  column) shorter="--set balls=20" ;; # their meshes are large
  heap) shorter="--t-end 0.2" ;;
  esac
  "$program" --quiet $([ ! -e "$params" ] || echo --params "$params") $shorter --output "$example.h5" ||
    fail "$example"
  if "$bin/nsdae-vtk" "$example.h5" >out 2>err; then
    "$python" -B "$check" "$example.h5" "$example.vtkhdf" || fail "$example.vtkhdf"
  else
    fail "nsdae-vtk $example.h5: $(cat err)"
  fi
done

# thinned out: records 0, 7, 14 ...; and points at coordinates
"$bin/nsdae-vtk" --every 7 -o few.vtkhdf --point 0,1,- --point 2,-,- pendulum.h5 >out || fail "--every"
grep -q '^201 steps of 2 bodies' out || fail "--every 7 of 1401: $(cat out)"
"$python" - <<'END' || fail "--point"
import h5py, numpy as np
with h5py.File("few.vtkhdf") as f, h5py.File("pendulum.h5") as g:
    q, points = g["q"][::7], f["VTKHDF/Points"][...].reshape(201, 2, -1, 3).mean(axis=2)
    assert np.array_equal(f["VTKHDF/Steps/Values"], g["time"][::7])
    assert np.abs(points[:, 0, :2] - q[:, :2]).max() < 1e-12 and np.abs(points[:, 0, 2]).max() < 1e-12
    assert np.abs(points[:, 1, 0] - q[:, 2]).max() < 1e-12
    g = h5py.File("other.h5", "w")
    with h5py.File("pendulum.h5") as old:
        for name in ("time", "q"):
            old.copy(name, g)
        g.attrs.update(old.attrs)
    g.attrs["model"] = "bead"
    g.close()
END

expect 1 "cannot read 'none.h5': No such file or directory" none.h5
printf 'text' >text.h5
expect 1 "cannot read 'text.h5'" text.h5
expect 1 "'pendulum.vtkhdf' is not an nsdae trajectory" pendulum.vtkhdf -o x
expect 1 "'other.h5' names no bodies" other.h5
expect 1 "--point 0,1,-" other.h5
expect 1 "the coordinates 0 to 2, not 3" other.h5 --point 3,-,-
expect 1 "cannot write 'no/x': No such file or directory" pendulum.h5 -o no/x
expect 1 "cannot write '/': Is a directory" pendulum.h5 -o /
expect 2 "is the trajectory itself" pendulum.h5 -o pendulum.h5
expect 2 "--every 0 is outside its range" pendulum.h5 --every 0
expect 2 "X,Y,Z" pendulum.h5 --point 1
expect 2 "required: file"

# a disk that fills: said, and the file that was there stays whole
cp pendulum.vtkhdf kept
(ulimit -f 100 && "$bin/nsdae-vtk" pendulum.h5 >out 2>err)
[ $? = 1 ] && grep -q "cannot write 'pendulum.vtkhdf': File too large" err || fail "full disk: $(cat err)"
cmp pendulum.vtkhdf kept || fail "the old file is lost"
[ ! -e pendulum.vtkhdf.part ] || fail "a part is left"

[ $failures = 0 ] && echo "all as expected"
exit $failures
