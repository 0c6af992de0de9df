#!/bin/sh
# Runs tests/system/tools_suite.py in an empty folder, with the first Python that has most of what it uses.
# usage: tools.sh BIN_DIR SUITE.py ARGUMENT...
set -u
bin=$1
check=$2
shift 2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export HOME="$work" MPLBACKEND=Agg MPLCONFIGDIR="$work" # of the browser; of matplotlib

python=""
for modules in vtkmodules "xarray h5netcdf" ""; do # vtk may be one of the user's own, 9.3 or later
  for candidate in ${NSDAE_PYTHON:+"$NSDAE_PYTHON"} python3 /usr/bin/python3; do
    [ -z "$python" ] && "$candidate" -c 'import sys
from importlib.util import find_spec
sys.exit(not all(map(find_spec, sys.argv[1:])))' h5py matplotlib PIL $modules 2>/dev/null && python=$candidate
  done
done
if [ -n "$python" ]; then
  "$python" -B "$check" "$bin" "$@"
  exit
fi
for program in nsdae-plot nsdae-vtk nsdae-animate nsdae-view; do # they say what to install
  "$bin/$program" --version 2>err && exit 1
  grep -q python3-h5py err || exit 1
done
echo "no Python with h5py, matplotlib and PIL: not tested"
exit 77
