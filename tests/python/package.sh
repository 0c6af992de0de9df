#!/bin/sh
# The package for Python as a user gets it: a wheel of this source, installed into an empty environment, its first
# picture, then its own tests there. A test that pytest skips makes this a skipped test of CTest. The wheel is kept in WHEEL_DIR.
# usage: package.sh SOURCE_DIR BIN_DIR WHEEL_DIR
set -eu
source=$1 bin=$2 kept=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python=${NSDAE_PYTHON:-python3}
skip() {
  echo "skipped: $1"
  exit 77
}
"$python" -c 'import sys, ensurepip; sys.exit(sys.version_info < (3, 9))' 2>/dev/null ||
  skip "no Python 3.9 or later that makes environments (python3-venv)"
"$python" -c 'import os, sysconfig as s, sys; sys.exit(not os.path.exists(os.path.join(s.get_paths()["include"], "Python.h")))' ||
  skip "no Python.h (python3-dev)"
# of the many modules that are installed those are compiled that are imported, and outside the source
export PYTHONPYCACHEPREFIX="$work/compiled"
export PIP_RETRIES=10 # an index that does not answer at once may yet
"$python" -m venv "$work/make"
"$work/make/bin/pip" download -q --no-deps -d "$work/probe" nanobind >/dev/null 2>&1 ||
  skip "no package index to fetch nanobind from"
seconds() { echo "$1: $(($(date +%s) - begin)) s"; }

begin=$(date +%s)
"$work/make/bin/pip" wheel -q "$source" --no-deps -w "$work/wheel" --config-settings=build-dir="$work/build"
mkdir -p "$kept"
for wheel in "$work"/wheel/*.whl; do
  cp "$wheel" "$kept/$$" && mv "$kept/$$" "$kept/${wheel##*/}"
done
seconds "wheel built"

"$python" -m venv "$work/use"
use="$work/use/bin/python"
begin=$(date +%s)
"$work/use/bin/pip" install -q --no-compile "$work"/wheel/nsdae-*.whl
cd "$work"
"$use" -m nsdae demo --no-browser
[ -s nsdae-demo.html ]
seconds "installed into an empty environment with NumPy alone, an animation made"
begin=$(date +%s)
"$work/use/bin/pip" install -q --no-compile "$(echo "$work"/wheel/nsdae-*.whl)[plot]"
awk '/<!-- file: ball.py -->/ { on = 1 } on && /^```$/ { exit } on && code { print } on && /^```python/ { code = 1 }' \
  "$source/docs/guide/python.md" >ball.py
MPLBACKEND=Agg "$use" ball.py
[ -s ball.png ]
seconds "installed into an empty environment, first picture drawn"

# nothing of this system but libc, the loader and, if it was there, Qhull
needed=$(objdump -p "$work"/use/lib/python3*/site-packages/nsdae/_core*.so | awk '$1 == "NEEDED" { print $2 }')
for library in $needed; do
  case $library in libc.so* | libm.so* | libstdc++.so* | libgcc_s.so* | libpthread.so* | libdl.so* | ld-linux* | linux-vdso* | libqhull_r.so*) ;;
  *) echo "FAILED: the module needs $library of the system" && exit 1 ;;
  esac
done

"$work/use/bin/pip" install -q --no-compile pytest
optional="scipy cffi numba mpi4py joblib mypy pandas xarray h5netcdf viser trimesh"
"$work/use/bin/pip" install -q --no-compile --only-binary :all: $optional 2>/dev/null || for one in $optional; do
  "$work/use/bin/pip" install -q --no-compile --only-binary :all: $one || echo "left out: no $one here"
done
NSDAE_BIN=$bin "$use" -m pytest -q -rs -p no:cacheprovider "$source/python/tests" >pytest.log 2>&1 || failed=1
cat pytest.log
[ -z "${failed:-}" ] || exit 1
! grep -q '^SKIPPED ' pytest.log || exit 77
