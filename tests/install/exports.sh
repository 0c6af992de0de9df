#!/bin/sh
# The shared library offers the functions of the public headers, no more and no less, and needs
# neither GSL nor MPI itself (Debian's SUNDIALS brings MPI).
# usage: exports.sh LIBRARY INCLUDE_DIR
set -eu
library=$1
include=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cc -E -P -I "$include" -include nsdae/nsdae.h -x c /dev/null | tr '\n' ' ' |
  grep -oE 'visibility\("default"\)\)\)[^;({]*' | grep -oE 'nsdae_[A-Za-z0-9_]+ *$' | tr -d ' ' |
  sort -u >"$work/declared"
nm -D --defined-only "$library" | awk '{print $3}' | sort -u >"$work/exported"
diff "$work/declared" "$work/exported" || {
  echo "< declared in a public header only   > exported only" >&2
  exit 1
}
if readelf -d "$library" | grep NEEDED | grep -iE 'gsl|mpi' || ldd "$library" | grep -i gsl; then
  echo "the library must not need these" >&2
  exit 1
fi
echo "$(wc -l <"$work/exported") functions, all declared; no GSL"
[ -s "$work/exported" ]
