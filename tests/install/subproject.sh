#!/bin/sh
# The library alone, without HDF5, SUNDIALS, Qhull and Fortran, within a project that has a target docs: it builds without a
# warning, all of its files are in the folder of the subproject, it needs nothing of what it was built without, reports what
# is missing, and its installed tree can be used.
# usage: subproject.sh SOURCE_DIR [CMAKE_OPTION...]
set -eu
source=$1
shift
work=$(mktemp -d)
tree=$work/tree
trap 'rm -rf "$work"' EXIT

# lacks PART LIBRARY: the installed tree does not need it, nor has it the component
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

{
  cmake -S "$source/tests/install/parent" -B "$tree/build" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_INSTALL_PREFIX="$tree" \
    -DNSDAE_WERROR=ON -DNSDAE_SOURCE="$source" -DNSDAE_INSTALL=ON -DNSDAE_HDF5=OFF -DNSDAE_SUNDIALS=OFF -DNSDAE_QHULL=OFF "$@" &&
    cmake --build "$tree/build" -j2 && cmake --install "$tree/build"
} >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
lib=$(dirname "$(find "$tree" -path "$tree/build" -prune -o -name libnsdae.so -print)")
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
# what a program gets that needs one of them
cd "$work"
export PKG_CONFIG_PATH="$lib/pkgconfig" LD_LIBRARY_PATH="$lib"
cc -std=c11 "$source/tests/install/consumer/missing.c" $(pkg-config --cflags --libs nsdae) -o missing
./missing HDF5 SUNDIALS Qhull Fortran
echo "built without HDF5, SUNDIALS, Qhull and Fortran"
