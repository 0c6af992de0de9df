#!/bin/sh
# Files of unknown origin, given to every tool that reads one: refused in one line, or read; and pages with hostile names
# in a browser. usage: hostile.sh BIN_DIR CHECK.py
set -u
bin=$1
check=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export HOME="$work" MPLBACKEND=Agg # of the browser, of matplotlib

for candidate in ${NSDAE_PYTHON:+"$NSDAE_PYTHON"} python3 /usr/bin/python3; do
  "$candidate" -c "import h5py, matplotlib, PIL" 2>/dev/null && exec "$candidate" -B "$check" "$bin"
done
echo "no Python with h5py, matplotlib and PIL: not tested"
exit 77
