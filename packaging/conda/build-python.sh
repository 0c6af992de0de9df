#!/bin/bash
# What conda-build runs for nsdae, the package for Python: as pip builds it, with shared libraries in place of archives.
set -euo pipefail

export SKBUILD_CMAKE_DEFINE="NSDAE_STATIC_DEPENDENCIES=OFF;NSDAE_SUNDIALS=ON;NSDAE_CBLAS_LIBRARY=$PREFIX/lib/libcblas.so"
"$PYTHON" -m pip install . -vv --no-deps --no-build-isolation
