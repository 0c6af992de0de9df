#!/bin/sh
# Whether two builds take the same steps to the last bit. usage: bytes.sh OLD NEW
#
# OLD: what bench_bytes of another build printed, or that program; NEW: bench_bytes of this build.
# Prints the lines of scenes and methods that differ: name, run, hash, impacts.
set -eu
export OPENBLAS_NUM_THREADS=1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for which in old new; do
  if [ -x "$1" ]; then "$1" >"$work/$which"; else cp "$1" "$work/$which"; fi
  shift
done
diff "$work/old" "$work/new" && echo "$(wc -l <"$work/new") runs with the same bytes"
