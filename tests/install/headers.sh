#!/bin/sh
# Every public header alone, as C11, C++11 and C++20, with every compiler that is there.
# usage: headers.sh INCLUDE_DIR
set -eu
include=$1
warnings="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
compiled=0

# alone COMPILER LANGUAGE STANDARD HEADER; twice in one file, for the guard
alone() {
  printf '#include <%s>\n#include <%s>\n' "$4" "$4" >"$work/alone"
  "$1" -x "$2" "-std=$3" $warnings -fsyntax-only -I "$include" "$work/alone" || {
    echo "$4 does not compile alone: $1 -std=$3" >&2
    exit 1
  }
  compiled=$((compiled + 1))
}

for compiler in gcc clang; do
  command -v $compiler >/dev/null || continue
  for header in "$include"/nsdae/*.h; do
    alone $compiler c c11 "nsdae/${header##*/}"
  done
done
for compiler in g++ clang++; do
  command -v $compiler >/dev/null || continue
  for header in "$include"/nsdae/*.h "$include"/nsdae/*.hpp; do
    [ -e "$header" ] || continue
    for standard in c++11 c++20; do
      alone $compiler c++ $standard "nsdae/${header##*/}"
    done
  done
done

# nsdae.hpp has a member for every callback of a system
for name in $(tr -d '\n' <"$include/nsdae/system.h" |
  grep -oE 'nsdae_system_set_[a-z_]+\(nsdae_system \*system, *nsdae_[a-z_]+_fn' |
  sed 's/nsdae_system_set_//; s/(.*//'); do
  grep -q "NSDAE_CALLBACK($name)" "$include/nsdae/nsdae.hpp" || {
    echo "nsdae.hpp has no member for the callback $name" >&2
    exit 1
  }
  callbacks="${callbacks:-} $name"
done
echo "callbacks:$callbacks"
echo "$compiled compilations without a warning"
[ $compiled -gt 0 ]
