# To be sourced, on Debian 12: compilers for another C library or processor, and what nsdae needs, built with them.
# PyPI's ziglang has clang and the C libraries. The caller sets $work, a folder of its own, and $source, that of nsdae.

# zig_tools PYTHON TARGET [REQUIREMENTS]: $CC, $CXX, $AR and $RANLIB for zig's TARGET, and what pip installs beside them
zig_tools() {
  python=$1 target=$2
  prefix=$work/prefix
  mkdir -p "$prefix/lib" "$prefix/include/libqhull_r" "$work/bin"
  "$python" -m venv "$work/tools" # Debian's NumPy-free Python suffices
  "$work/tools/bin/pip" install -q --require-hashes -r "$source/packaging/compilers.txt" ${3:+-r "$3"}
  for tool in "cc cc -target $target" "cxx c++ -target $target" "ar ar" "ranlib ranlib"; do
    name=${tool%% *}
    printf '#!/bin/sh\nexec %s -m ziglang %s "$@"\n' "$work/tools/bin/python" "${tool#* }" >"$work/bin/$name"
    chmod +x "$work/bin/$name"
  done
  export PATH="$work/tools/bin:$PATH" CC="$work/bin/cc" CXX="$work/bin/cxx" AR="$work/bin/ar" RANLIB="$work/bin/ranlib"
}

# debian_sources PACKAGE...: their original sources, unpacked in $work
debian_sources() {
  . /etc/os-release
  echo "deb-src http://deb.debian.org/debian $VERSION_CODENAME main" >sources.list
  mkdir -p lists
  for verb in update "source --download-only $*"; do
    apt-get -qq -o Dir::Etc::sourcelist="$work/sources.list" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$work/lists" $verb
  done
  for archive in *.orig.tar.*; do tar xf "$archive"; done
}

# archive NAME FLAGS FILE...: compiles the files into libNAME.a
archive() {
  name=$1 flags=$2
  shift 2
  mkdir -p "objects/$name"
  for file in "$@"; do "$CC" -O2 -fPIC $flags -I"$prefix/include" -c "$file" -o "objects/$name/$(basename "$file" .c).o"; done
  "$AR" rcs "$prefix/lib/lib$name.a" "objects/$name"/*.o
}

# zig_dependencies CMAKE_OPTION...: Qhull, AMD and SUNDIALS' IDA in $prefix
zig_dependencies() {
  cp qhull-*/src/libqhull_r/*.h "$prefix/include/libqhull_r"
  archive qhull_r "" qhull-*/src/libqhull_r/*.c
  suite=$(echo SuiteSparse-*)
  cp "$suite/AMD/Include/amd.h" "$suite/SuiteSparse_config/SuiteSparse_config.h" "$prefix/include"
  archive amd "-DDINT -I$suite/AMD/Include" "$suite"/AMD/Source/amd_*.c # indices of int
  archive suitesparseconfig -DNTIMER "$suite/SuiteSparse_config/SuiteSparse_config.c"
  cmake -S sundials-* -B sundials -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR=lib \
    -DCMAKE_AR="$AR" -DCMAKE_RANLIB="$RANLIB" -DBUILD_SHARED_LIBS=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DBUILD_ARKODE=OFF \
    -DBUILD_CVODE=OFF -DBUILD_CVODES=OFF -DBUILD_IDAS=OFF -DBUILD_KINSOL=OFF -DEXAMPLES_ENABLE_C=OFF -DEXAMPLES_INSTALL=OFF \
    "$@" >sundials.log
  cmake --build sundials --target install >>sundials.log
}
