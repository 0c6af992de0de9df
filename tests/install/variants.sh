#!/bin/sh
# The library built without HDF5, without SUNDIALS, without Fortran, with gcc and clang, Release and
# Debug: it builds without a warning, needs nothing of what it was built without, says so where that
# would be needed, and its installed tree can be used.
# usage: variants.sh SOURCE_DIR [CMAKE_OPTION...]
set -eu
source=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# variant COMPONENT COMPILER BUILD_TYPE LIBRARY
variant() {
  part=$1 compiler=$2 type=$3 library=$4 tree=$work/$1
  option=NSDAE_$(echo "$1" | tr '[:lower:]' '[:upper:]')
  shift 4
  command -v "$compiler" >/dev/null || compiler=cc
  {
    CC=$compiler cmake -S "$source" -B "$tree/build" -DCMAKE_BUILD_TYPE=$type \
      -DCMAKE_INSTALL_PREFIX="$tree" -DNSDAE_WERROR=ON -DNSDAE_DRIVERS=OFF -DBUILD_TESTING=OFF \
      "-D$option=OFF" "$@" &&
      cmake --build "$tree/build" -j2 && cmake --install "$tree/build"
  } >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
  lib=$(dirname "$(find "$tree" -path "$tree/build" -prune -o -name libnsdae.so -print)")
  if readelf -d "$lib/libnsdae.so" | grep NEEDED | grep "$library"; then
    echo "built without $part, it needs $library" >&2
    exit 1
  fi
  (cd "$work" && PKG_CONFIG_PATH="$lib/pkgconfig" &&
    export PKG_CONFIG_PATH LD_LIBRARY_PATH="$lib" &&
    cc -std=c11 "$source/tests/install/consumer/missing.c" \
      $(pkg-config --cflags --libs nsdae) -o missing && ./missing "$part")
  printf 'cmake_minimum_required(VERSION 3.21)\nproject(x C)\n%s\n' \
    "find_package(nsdae CONFIG REQUIRED COMPONENTS $part)" >"$work/CMakeLists.txt"
  if cmake -S "$work" -B "$tree/refused" -DCMAKE_PREFIX_PATH="$tree" >"$work/log" 2>&1; then
    echo "the component $part was not refused" >&2
    exit 1
  fi
  grep -q "no component $part" "$work/log"
  echo "without $part: $compiler, $type"
}

variant HDF5 gcc Debug libhdf5 "$@"
variant SUNDIALS clang Release libsundials "$@"
variant Fortran gcc Debug libgfortran "$@"
echo "built without HDF5, SUNDIALS and Fortran"
