#!/bin/sh
# The shared library offers the functions of the public headers and for each kernel, nsdae_d..., its
# face by reference, nsdae_d..._, for any Fortran; no more and no less. It needs no GSL and calls
# no MPI (a SUNDIALS that was built with MPI brings it in).
# usage: exports.sh LIBRARY INCLUDE_DIR
set -eu
library=$1
include=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cc -E -P -I "$include" -include nsdae/nsdae.h -x c /dev/null | tr '\n' ' ' |
  grep -oE 'visibility\("default"\)\)\)[^;({]*' | grep -oE 'nsdae_[A-Za-z0-9_]+ *$' | tr -d ' ' |
  sed 's/^nsdae_d[a-z]*$/&\n&_/' | LC_ALL=C sort -u >"$work/declared"
nm -D --defined-only "$library" | awk '{print $3}' | LC_ALL=C sort -u >"$work/exported"
diff "$work/declared" "$work/exported" || {
  echo "< declared (or the face of a kernel) only   > exported only" >&2
  exit 1
}
if ldd "$library" | grep -i gsl || nm -D --undefined-only "$library" | grep ' MPI_'; then
  echo "the library must not need these" >&2
  exit 1
fi
echo "$(wc -l <"$work/exported") functions, all declared; no GSL, no MPI"
[ -s "$work/exported" ]
