#!/bin/sh
# Programs in every language against an installed tree that was moved: by find_package and by
# pkg-config, shared and static. All must print the same bits.
# usage: consumers.sh BUILD_DIR SOURCE_DIR LANGUAGE...  (of C, CXX, Fortran)
set -eu
build=$1
source=$2
shift 2
here=$source/tests/install
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/moved"
lib=$(dirname "$(find "$work/moved" -name libnsdae.so)")

if grep -rlF -e "$work" -e "$build" -e "$source" "$lib/cmake" "$lib/pkgconfig"; then
  echo "these files name folders of the machine that built them" >&2
  exit 1
fi

# where a dependency is in a folder of its own, libnsdae.a needs to be told
folders=$(ldd "$lib/libnsdae.so" | sed -n 's|.*=> \(/.*\)/[^/]* (.*|\1|p' |
  grep -v -e '^/lib' -e '^/usr/lib' | sort -u | paste -sd:)
export CMAKE_LIBRARY_PATH="$folders"

# agree PROGRAM KIND: it prints what the first one did, and needs libnsdae.so only where shared
agree() {
  "$1" >"$work/out"
  [ -s "$work/out" ]
  [ -e "$work/expected" ] || cp "$work/out" "$work/expected"
  cmp "$work/out" "$work/expected"
  case $2,$(ldd "$1" | grep -c libnsdae || :) in
  shared,[1-9] | static,0) echo "same bits: ${1#"$work"/}" ;;
  *)
    echo "$1 is not linked as $2" >&2
    exit 1
    ;;
  esac
}

languages=$(echo "$@" | tr ' ' ';')
for kind in shared static; do
  cmake -S "$here/consumer" -B "$work/$kind" -DCMAKE_PREFIX_PATH="$work/moved" -DKIND=$kind \
    "-DLANGUAGES=$languages" >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
  cmake --build "$work/$kind" >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
  for program in c cxx fortran; do
    [ ! -x "$work/$kind/$program" ] || agree "$work/$kind/$program" $kind
  done
done

export PKG_CONFIG_PATH="$lib/pkgconfig" LIBRARY_PATH="$folders" LD_LIBRARY_PATH="$lib:$folders"
cd "$work" # where Fortran leaves its module files
for language in "$@"; do
  case $language in
  C) compile="cc -std=c11" file=ball.c module=nsdae ;;
  CXX) compile="c++ -std=c++11" file=ball.cpp module=nsdae ;;
  Fortran) compile="gfortran -std=f2018" file=ball.f90 module=nsdae-fortran ;;
  esac
  $compile "$here/consumer/$file" -o "$work/pc-$language" $(pkg-config --cflags --libs $module)
  agree "$work/pc-$language" shared
  $compile "$here/consumer/$file" -o "$work/pc-$language" $(pkg-config --cflags --libs --static $module)
  agree "$work/pc-$language" shared
  [ $language != Fortran ] || continue
  $compile "$here/consumer/$file" -o "$work/pc-$language" $(pkg-config --cflags --libs nsdae-static)
  agree "$work/pc-$language" static
done

# what is not there is refused, in words
for wrong in "nsdae 0.4" "nsdae 0.3 COMPONENTS Cobol"; do
  printf 'cmake_minimum_required(VERSION 3.21)\nproject(x C)\nfind_package(%s CONFIG REQUIRED)\n' \
    "$wrong" >"$work/CMakeLists.txt"
  if cmake -S "$work" -B "$work/wrong" -DCMAKE_PREFIX_PATH="$work/moved" >"$work/log" 2>&1; then
    echo "find_package($wrong) was not refused" >&2
    exit 1
  fi
  grep -qE 'Cobol|0\.3' "$work/log"
done
echo "installed, moved and used from $*"
