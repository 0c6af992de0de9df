#!/bin/sh
# The verb `./run install`, with the tree that is built already: into ~/nsdae, or into the folder
# named, and what it prints is all that a shell needs to compile and run the README's program.
# usage: run.sh BUILD_DIR SOURCE_DIR
set -eu
build=$1
source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# a checkout whose build is the one given, and where nothing is to be installed or built first
mkdir "$work/tree" "$work/bin" "$work/home"
cp "$source/run" "$work/tree/"
ln -s "$build" "$work/tree/build"
cat >"$work/bin/cmake" <<END
#!/bin/sh
case \$1 in -S | --build) echo "\$@" >>"$work/built" ;; *) exec "$(command -v cmake)" "\$@" ;; esac
END
printf '#!/bin/sh\necho ok installed\n' >"$work/bin/dpkg-query"
chmod +x "$work/bin/cmake" "$work/bin/dpkg-query"
export HOME="$work/home" PATH="$work/bin:$PATH"

# installed FOLDER [ARGUMENT]: by the verb, there; used as it says, from another folder; called from $work
installed() {
  folder=$1
  shift
  (cd "$work" && tree/run install "$@") >"$work/said"
  grep -q -e '--build build --target installed' "$work/built" # it is built first
  grep '^  export ' "$work/said" >"$work/exports"
  (
    cd "$work"
    unset PKG_CONFIG_PATH LD_LIBRARY_PATH
    . "$work/exports"
    cc -std=c11 "$source/docs/examples/ball.c" $(pkg-config --cflags --libs nsdae) -o ball
    ldd ball | grep -qF "$folder/" # not with another one that is about
    ./ball >out
    grep -qFx "$(cat out)" "$source/docs/guide/first-program.md"
    [ "$(command -v nsdae-lcp)" = "$folder/bin/nsdae-lcp" ]
    nsdae-lcp --version >/dev/null
  )
  rm -rf "$folder"
}

installed "$work/home/nsdae"
installed "$work/elsewhere" "$work/elsewhere"
installed "$work/here" here

# a folder that cannot be made is told, and by the exit status
touch "$work/file"
if "$work/tree/run" install "$work/file/nsdae" >"$work/said" 2>&1; then
  echo "installed into a file" >&2
  exit 1
fi
if grep -q 'export' "$work/said"; then exit 1; fi
echo "./run install: installed and used"
