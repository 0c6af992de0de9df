#!/bin/sh
# The library and the programs for another C library or processor, on Debian 12, and a run of the bouncing ball.
# usage: cross.sh TARGET FOLDER; TARGET: x86_64-linux-musl, aarch64-linux-musl or aarch64-linux-gnu, as zig names them.
# Needs python3-venv, gfortran (gfortran-aarch64-linux-gnu and qemu-user-static for aarch64) and the network. Without HDF5.
set -eu
target=${1:?a target} folder=${2:?a folder}
source=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$folder"
work=$(cd "$folder" && pwd)
processor=${target%%-*} fortran=gfortran run=""
if [ "$processor" = aarch64 ]; then
  fortran=aarch64-linux-gnu-gfortran run="qemu-aarch64-static -L /usr/aarch64-linux-gnu"
fi
. "$source/packaging/zig.sh"
zig_tools python3 "$target"
cd "$work"
debian_sources lapack qhull sundials suitesparse
system="-DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=$processor"
zig_dependencies $system

# The reference BLAS and LAPACK: what gfortran makes of them fits both C libraries, but its run-time library is glibc's.
# The two functions that LAPACK calls of it are written here; a*b+c is rounded twice, as in nsdae.
lapack=$(echo "$work"/lapack-*)
cat >runtime.c <<'END'
#include <stdio.h>
#include <string.h>
void xerbla_(const char *name, const int *info, size_t length);
void xerbla_(const char *name, const int *info, size_t length)
{
  fprintf(stderr, "%.*s: argument %d has an illegal value\n", (int)length, name, *info);
}
void _gfortran_concat_string(size_t size, char *to, size_t m, const char *a, size_t n, const char *b);
void _gfortran_concat_string(size_t size, char *to, size_t m, const char *a, size_t n, const char *b)
{
  for (size_t i = 0; i < size; i++) to[i] = i < m ? a[i] : i - m < n ? b[i - m] : ' ';
}
END
for file in cblas cblas_f77; do cp "$lapack/CBLAS/include/$file.h" "$prefix/include"; done
cp "$lapack"/LAPACKE/include/*.h "$prefix/include"
for part in CBLAS/include/cblas LAPACKE/include/lapacke; do
  cp "$lapack/${part}_mangling_with_flags.h.in" "$prefix/include/${part##*/}_mangling.h"
done
mkdir -p objects/cblas
(cd objects/cblas && "$fortran" -c -fPIC "$lapack/SRC/la_constants.f90" "$lapack/SRC/la_xisnan.F90" &&
  ls "$lapack"/BLAS/SRC/[di]*.f* "$lapack/BLAS/SRC/lsame.f" "$lapack"/CBLAS/src/[di]*sub.f "$lapack"/SRC/[di]*.f* \
    "$lapack/INSTALL/dlamch.f" "$lapack/INSTALL/droundup_lwork.f" | xargs -n 20 -P 2 "$fortran" -c -O2 -fPIC -ffp-contract=off -w)
called=$(grep -rhoE "(cblas|LAPACKE)_d[a-z0-9_]+" "$source/lib" | sort -u | sed -n \
  -e "s|^cblas.*|$lapack/CBLAS/src/&.c|p" -e "s|^LAPACKE_|$lapack/LAPACKE/src/lapacke_|; s|lapacke_.*work\$|&.c|p")
archive cblas -I"$lapack/CBLAS/include" runtime.c $called "$lapack/CBLAS/src/cblas_xerbla.c" "$lapack/CBLAS/src/cblas_globals.c" \
  "$lapack/LAPACKE/src/lapacke_dgetrf.c" "$lapack/LAPACKE/src/lapacke_nancheck.c" \
  "$lapack"/LAPACKE/utils/lapacke_d[gpst][eory]_*.c "$lapack"/LAPACKE/utils/lapacke_[lx]*.c
for empty in gfortran quadmath; do printf '!<arch>\n' >"$prefix/lib/lib$empty.a"; done

export LDFLAGS="-L$prefix/lib"
cmake -S "$source" -B build -G Ninja -DCMAKE_BUILD_TYPE=Release $system -DCMAKE_AR="$AR" -DCMAKE_RANLIB="$RANLIB" \
  -DCMAKE_FIND_ROOT_PATH="$prefix" -DCMAKE_FIND_ROOT_PATH_MODE_LIBRARY=ONLY -DCMAKE_FIND_ROOT_PATH_MODE_INCLUDE=ONLY \
  -DCMAKE_FIND_ROOT_PATH_MODE_PACKAGE=ONLY -DNSDAE_STATIC_DEPENDENCIES=ON -DNSDAE_HDF5=OFF -DNSDAE_SUNDIALS=ON -DNSDAE_FORTRAN=OFF \
  -DBUILD_TESTING=OFF
cmake --build build
$run build/bin/nsdae-bouncing-ball --no-output
