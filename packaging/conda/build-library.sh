#!/bin/bash
# What conda-build runs for libnsdae: the library, without the example programs.
set -euo pipefail

cmake -S . -B build -G Ninja ${CMAKE_ARGS:-} \
  -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_INSTALL_PREFIX="$PREFIX" \
  -DCMAKE_INSTALL_LIBDIR=lib \
  -DNSDAE_CBLAS_LIBRARY="$PREFIX/lib/libcblas.so" \
  -DNSDAE_FORTRAN=ON \
  -DNSDAE_SUNDIALS=ON \
  -DNSDAE_DRIVERS=OFF \
  -DBUILD_TESTING=OFF
cmake --build build -j"${CPU_COUNT:-2}"
cmake --install build
