#!/bin/sh
# Clang reads all sources of the library for other systems, with the headers of their C libraries that the package
# ziglang has: glibc on four processors, musl, macOS, FreeBSD and Windows. Nothing is compiled or run.
# usage: systems.sh SOURCE_DIR BUILD_DIR WORK_DIR INCLUDE_DIR...   (of the libraries that it stands on)
set -eu
source=$1 build=$2 work=$3
shift 3

lacks() {
  if [ "${CI:-}" = true ]; then
    echo "CI reads the sources for other systems: $1" >&2
    exit 1
  fi
  echo "left out: $1"
  exit 77
}

command -v clang >/dev/null || lacks "install clang"
mkdir -p "$work/include"
[ -x "$work/venv/bin/pip" ] || python3 -m venv "$work/venv" || lacks "install python3-venv"
"$work/venv/bin/pip" install -q --no-compile 'ziglang==0.17.1' 2>"$work/log" || lacks "no package ziglang here"
headers=$(echo "$work"/venv/lib/python3*/site-packages/ziglang/lib/libc/include)

# headers of those libraries alone, less what they found out about this system
for folder in "$@" /usr/include; do
  for name in "$folder"/lapack*.h "$folder"/cblas*.h "$folder"/openblas_config.h "$folder"/amd.h \
    "$folder"/SuiteSparse_config.h "$folder"/H5*.h "$folder"/hdf5*.h "$folder"/sundials "$folder"/ida \
    "$folder"/nvector "$folder"/libqhull_r "$folder"/sunmatrix "$folder"/sunlinsol "$folder"/sunnonlinsol; do
    [ ! -e "$name" ] || [ -e "$work/include/${name##*/}" ] || cp -rL "$name" "$work/include"
  done
done
sed -i.orig -e '/HAVE_FEATURES_H/d' -e '/define OPENBLAS_OS_LINUX/d' "$work"/include/H5pubconf*.h \
  "$work"/include/openblas_config.h

find "$source/lib" -name '*.c' >"$work/sources"
echo "$build/lib/build_info.c" >>"$work/sources"
folders=$(find "$source/lib" -type d | sed 's/^/-I/')

# reads TRIPLE "FOLDERS OF HEADERS" OPTION...
failed=0
reads() {
  triple=$1 system=
  for folder in $2; do
    system="$system -isystem $headers/$folder"
  done
  shift 2
  if xargs -P2 -n8 clang -target "$triple" -nostdlibinc $system "$@" -std=c11 -fsyntax-only -Wall -Wextra -Wpedantic \
    -Wshadow -Wmissing-prototypes -Werror -I"$source/include" $folders -isystem "$work/include" \
    <"$work/sources" >"$work/log" 2>&1; then
    echo "read for $triple"
  else
    failed=1
    echo "failed for $triple:"
    head -40 "$work/log"
  fi
}

for processor in x86_64:x86 aarch64:aarch64 i686:x86 s390x:s390x; do
  of=${processor#*:}
  reads "${processor%:*}-linux-gnu" "$of-linux-gnu generic-glibc $of-linux-any any-linux-any" -D__GLIBC_MINOR__=28
done
reads x86_64-linux-musl "x86_64-linux-musl generic-musl x86-linux-any any-linux-any"
reads x86_64-apple-macosx11 any-darwin-any -D_Float16=float # which an older clang has not
reads x86_64-unknown-freebsd13 "x86_64-freebsd-none generic-freebsd"
reads x86_64-w64-windows-gnu any-windows-any -D__MSVCRT_VERSION__=0xE00 -D_WIN32_WINNT=0x0a00
exit $failed
