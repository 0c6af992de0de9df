#!/bin/sh
# The library built by gcc without HDF5, SUNDIALS, Qhull and Fortran, and by clang with all but Fortran and with the programs,
# Debug and Release: it builds without a warning, needs nothing of what it was built without, reports what is missing, and
# its installed tree can be used.
# usage: variants.sh SOURCE_DIR [CMAKE_OPTION...]
set -eu
source=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# lacks PART LIBRARY: the tree installed last does not need it, nor has it the component
lacks() {
  part=$1 library=$2
  if readelf -d "$lib/libnsdae.so" | grep NEEDED | grep "$library"; then
    echo "built without $part, it needs $library" >&2
    exit 1
  fi
  printf 'cmake_minimum_required(VERSION 3.21)\nproject(x C)\n%s\n' \
    "find_package(nsdae CONFIG REQUIRED COMPONENTS $part)" >"$work/CMakeLists.txt"
  if cmake -S "$work" -B "$tree/refused-$part" -DCMAKE_PREFIX_PATH="$tree" >"$work/log" 2>&1; then
    echo "the component $part was not refused" >&2
    exit 1
  fi
  grep -q "no component $part" "$work/log"
}

# answers PART...: what a program of that tree gets that needs one of the parts
answers() {
  (cd "$work" && PKG_CONFIG_PATH="$lib/pkgconfig" &&
    export PKG_CONFIG_PATH LD_LIBRARY_PATH="$lib" &&
    cc -std=c11 "$source/tests/install/consumer/missing.c" \
      $(pkg-config --cflags --libs nsdae) -o missing && ./missing "$@")
}

# variant SOURCE COMPILER BUILD_TYPE OPTION...
variant() {
  from=$1 compiler=$2 type=$3 tree=$work/$2
  shift 3
  if ! command -v "$compiler" >/dev/null; then
    if [ "${CI:-}" = true ]; then
      echo "CI builds with $compiler: install it" >&2
      exit 1
    fi
    compiler=cc
  fi
  {
    CC=$compiler cmake -S "$from" -B "$tree/build" -DCMAKE_BUILD_TYPE=$type \
      -DCMAKE_INSTALL_PREFIX="$tree" -DNSDAE_WERROR=ON "$@" &&
      cmake --build "$tree/build" -j2 && cmake --install "$tree/build"
  } >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
  lib=$(dirname "$(find "$tree" -path "$tree/build" -prune -o -name libnsdae.so -print)")
  echo "$compiler, $type: $*"
}

# within a project that has a target docs: the library alone, all of its files in the folder of the subproject
variant "$source/tests/install/parent" gcc Debug -DNSDAE_SOURCE="$source" -DNSDAE_INSTALL=ON -DNSDAE_HDF5=OFF \
  -DNSDAE_SUNDIALS=OFF -DNSDAE_QHULL=OFF "$@"
"$tree/build/app" >/dev/null
if find "$tree/build" -iname '*nsdae*' | grep -v "^$tree/build/nsdae\(/\|$\)"; then
  echo "the subproject wrote outside its folder" >&2
  exit 1
fi
objects=$(find "$tree/build" -name '*.o' | wc -l) sources=$(find "$source/lib" -name '*.c' | wc -l)
[ "$objects" -le $((sources + 2)) ] # lib, what it was built with, and the program
lacks HDF5 libhdf5
lacks SUNDIALS libsundials
lacks Fortran libgfortran
answers HDF5 SUNDIALS Qhull Fortran
variant "$source" clang Release -DCMAKE_C_FLAGS_RELEASE="-O1 -DNDEBUG" -DNSDAE_FORTRAN=OFF \
  -DBUILD_TESTING=OFF "$@" # warnings need no more, which takes twice as long
answers Fortran
echo "built without HDF5, SUNDIALS, Qhull and Fortran by gcc, with all but Fortran by clang"
