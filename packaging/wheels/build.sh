#!/bin/sh
# Wheels for Linux on x86-64 with glibc 2.17 or later, on Debian 12: PyPI's ziglang compiles and links for that glibc.
# Twice each, in two folders; the bytes must be the same. Tools from PyPI have one version each and are checked by hash. With the
# wheels comes an SBOM of all that is linked.
# usage: build.sh [--draft] FOLDER [PYTHON...]
# --draft: also of a tree that is not ready to be released. PYTHON: an interpreter for each wheel, by default python3; one of
# 3.12 serves all later ones. Needs the packages of ./run dist, python3-venv and the network.
set -eu
draft=""
[ "${1:-}" = --draft ] && draft=yes && shift
folder=${1:?a folder for the wheels} && shift
[ $# -gt 0 ] || set -- python3
source=$(cd "$(dirname "$0")/../.." && pwd)
glibc=2.17 platform=manylinux_2_17_x86_64
[ -n "$draft" ] || "$source/packaging/release.py" check
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git -C "$source" log -1 --format=%ct)}
export SOURCE_DATE_EPOCH
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
. "$source/packaging/zig.sh"
zig_tools "$1" "x86_64-linux-gnu.$glibc" "$source/packaging/wheels/repair.txt"

# Debian's own archives of these are not position-independent, or not optimised.
cd "$work"
debian_sources qhull sundials suitesparse
zig_dependencies

# Debian's archives of OpenBLAS, LAPACKE and libgfortran call nothing later than that glibc, as auditwheel checks below.
system=/usr/lib/x86_64-linux-gnu
archives="$system/libopenblas.a $system/liblapacke.a $(gcc -print-file-name=libgfortran.a)"
cp /usr/include/lapack.h /usr/include/lapacke*.h "$(dirname "$(readlink -f /usr/include/x86_64-linux-gnu/cblas.h)")"/*.h "$prefix/include"
cp -L $archives "$prefix/lib"
printf '!<arch>\n' >"$prefix/lib/libquadmath.a" # nothing of it is called

# Debian's Python.h includes a header of a folder that only Debian's compilers search
mkdir -p "$prefix/include/x86_64-linux-gnu"
find /usr/include/x86_64-linux-gnu -maxdepth 1 -name 'python3*' -exec cp -r {} "$prefix/include/x86_64-linux-gnu" \;

export CMAKE_PREFIX_PATH="$prefix" LDFLAGS="-L$prefix/lib" CXXFLAGS="-include cstdio -I$prefix/include"
for time in first second; do
  for python in "$@"; do # the library is compiled once for all of them
    "$python" -m venv --clear "$work/venv"
    "$work/venv/bin/pip" install -q --require-hashes -r "$source/packaging/wheels/backend.txt"
    "$work/venv/bin/pip" wheel -v "$source" --no-deps --no-build-isolation -w "$work/$time/wheel" --config-settings=build-dir="$work/$time/build" \
      --config-settings=cmake.define.NSDAE_SUNDIALS=ON --config-settings=cmake.define.CMAKE_AR="$AR" \
      --config-settings=cmake.define.CMAKE_RANLIB="$RANLIB" >"$work/pip.log" 2>&1 ||
      { tail -40 "$work/pip.log" && exit 1; }
  done
  for wheel in "$work/$time/wheel"/*.whl; do
    auditwheel repair --plat "$platform" --only-plat -w "$work/$time/repaired" "$wheel" >/dev/null 2>&1
  done
done
for wheel in "$work/first/repaired"/*.whl; do
  cmp "$wheel" "$work/second/repaired/${wheel##*/}"
  auditwheel show "$wheel" | tr '\n' ' ' | grep -q "platform tag: \"$platform\""
done
{
  awk '/^Source:/ { name = $2 } /^Version:/ { print "pkg:deb/debian/" name "@" $2 "?arch=source" }' ./*.dsc
  "$work/tools/bin/pip" freeze | sed -n 's,^ziglang==,pkg:pypi/ziglang@,p' # libc++
  "$work/venv/bin/pip" freeze | sed -n 's,^nanobind==,pkg:pypi/nanobind@,p'
  echo pkg:generic/robin-map # in nanobind
} >linked
[ "$(wc -l <linked)" = 6 ]
release=$(basename "$wheel" | cut -d- -f1,2)
"$source/packaging/release.py" sbom $(cat linked) $archives >"$folder/$release-wheels.cdx.json"
mv "$work/first/repaired"/*.whl "$folder"
ls -l "$folder"
