#!/bin/sh
# All code of the guide: every chapter's files are written, its commands run letter for letter on an
# installed tree, and what they print compared with the page ("..." matches anything). So with README.md.
# A command whose program is not here is left out, and said so. usage: guide.sh BUILD_DIR SOURCE_DIR
set -u
build=$1
source=$2
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export HOME="$work/home"
mkdir -p "$HOME" "$work/chapters" "$work/shims"
cmake --install "$build" --prefix "$HOME/nsdae" >/dev/null || exit 1
lib=$(dirname "$(find "$HOME/nsdae" -name 'libnsdae.so')")
# where it is lib64 or, as for /usr on Debian, a folder in lib: what is in it is in lib too
if [ "$lib" != "$HOME/nsdae/lib" ]; then
  mkdir -p "$HOME/nsdae/lib"
  ln -s "$lib"/* "$HOME/nsdae/lib"
fi
# folders of their own that dependencies are in
folders=$(ldd "$lib/libnsdae.so" | sed -n 's|.*=> \(/.*\)/[^/]* (.*|\1|p' |
  grep -v -e '^/lib' -e '^/usr/lib' | sort -u | paste -sd:)
export LIBRARY_PATH="$folders"
ln -s "$source/docs" "$source/data" "$work/chapters"
cd "$work/chapters" || exit 1

# python3 is one that has h5py
for candidate in ${NSDAE_PYTHON:+"$NSDAE_PYTHON"} python3 /usr/bin/python3; do
  if "$candidate" -c 'import h5py' 2>/dev/null; then
    printf '#!/bin/sh\nexec "%s" "$@"\n' "$(command -v "$candidate")" >"$work/shims/python3"
    chmod +x "$work/shims/python3"
    export PATH="$work/shims:$PATH"
    break
  fi
done

failures=0 done=0 left=0

# Why a command cannot run here; nothing if it can.
hindrance() {
  for word in $1; do # the sources it names
    case $word in docs/* | data/*) [ -e "$word" ] || echo "no $word" ;; esac
  done
  case $1 in # what needs the module
  *nsdae-fortran* | *mine/build*) pkg-config --exists nsdae-fortran || echo "built without Fortran" ;;
  esac
  case $1 in # its calls have other arguments in version 7
  *sundials_cvode*)
    printf '#include <sundials/sundials_config.h>\n#if SUNDIALS_VERSION_MAJOR != 6\n#error\n#endif\n' |
      cc -E - >/dev/null 2>&1 || echo "no SUNDIALS 6"
    ;;
  esac
  program=${1%% *}
  case $program in
  export | sed | mkdir | mine/*) ;;
  paraview) echo "opens a window" ;;
  python3)
    [ -x "$work/shims/python3" ] || echo "no Python with h5py"
    script=${1#python3 }
    for module in $(sed -n 's/^import \([a-z0-9]*\).*/\1/p' "${script%% *}" 2>/dev/null); do
      [ "$module" != xarray ] || module="xarray, h5netcdf"
      "$work/shims/python3" -c "import $module" 2>/dev/null || echo "no $module"
    done
    ;;
  julia)
    command -v julia >/dev/null || echo "no julia" && return
    julia -e 'using HDF5' 2>/dev/null || echo "no HDF5.jl"
    ;;
  nsdae-view) echo "it waits for Ctrl-C" ;;
  nsdae-vtk | nsdae-animate) "$program" --version >/dev/null 2>&1 || echo "no Python for it" ;;
  *) command -v "$program" >/dev/null || echo "no $program" ;;
  esac
}

# run LINE COMMAND <EXPECTED
run() {
  cat >"$work/expected"
  why=$(hindrance "$2")
  if [ -n "$why" ]; then
    echo "$chapter:$1: left out ($why): $2"
    left=$((left + 1))
    return
  fi
  case $2 in
  export*)
    eval "$2" && PATH="$work/shims:$PATH" LD_LIBRARY_PATH="$LD_LIBRARY_PATH${folders:+:$folders}" &&
      return
    ;;
  esac
  sh -c "$2" >"$work/printed" 2>"$work/complaints"
  status=$?
  done=$((done + 1))
  if ! awk -f "$here/same.awk" "$work/expected" "$work/printed"; then
    echo "FAILED: $chapter:$1: $2 (exit $status) prints"
    sed 's/^/    /' "$work/printed" "$work/complaints"
    failures=$((failures + 1))
  fi
}

for chapter in guide/first-program ../README guide/bodies guide/joints guide/sensors guide/model guide/large guide/scenes guide/which-method guide/coming-from \
  guide/states guide/trajectory guide/animation guide/paraview guide/errors guide/mistakes; do
  name=$(basename "$chapter")
  awk -f "$here/guide.awk" "$source/docs/$chapter.md" >"$work/$name.sh" || exit 1
  . "$work/$name.sh"
done
for page in "$source"/docs/guide/*.md; do
  name=$(basename "$page" .md)
  case $name in README | python) continue ;; esac # the package's own tests run python's, in an environment that has it
  [ -e "$work/$name.sh" ] || { echo "FAILED: $name.md is not tested"; exit 1; }
done

# every status of the list is in the table, with its value, and nothing else is
sed -n 's/^ *X(\(NSDAE_[A-Z_]*\), \(-*[0-9]*\),.*/\1 \2/p' "$source/include/nsdae/status.h" >"$work/list"
sed -n 's/^| `\(NSDAE_[A-Z_]*\)` | \(-*[0-9]*\) | .*/\1 \2/p' "$source/docs/guide/errors.md" >"$work/table"
[ -s "$work/list" ] && diff "$work/list" "$work/table" || {
  echo "FAILED: the table of errors.md (>) is not the list of status.h (<)"
  failures=$((failures + 1))
}
# every dataset and attribute of a trajectory is in the page about the layout
if command -v h5dump >/dev/null; then
  for example in clearance-hinge crank-slider incline; do
    nsdae-$example --quiet --t-end 0.02 --output layout.h5
    h5dump -n 1 layout.h5 | awk '$1 == "dataset" || $1 == "attribute" && $2 ~ /^\/[^\/]*$/ {print $2}' |
      grep -v -e '^/options/' -e '^/parameters/'
  done | sort -u >"$work/datasets"
  [ -s "$work/datasets" ] || failures=$((failures + 1))
  while read -r name; do
    grep -qF -e "\`$name\`" -e "\`${name#/}\`" "$source/docs/trajectory.md" || {
      echo "FAILED: docs/trajectory.md does not know $name"
      failures=$((failures + 1))
    }
  done <"$work/datasets"
fi
# every method is in the table of methods
for method in $(nsdae-pendulum --help | awk '/^methods$/ {on = 1; next} /^[a-z]/ {on = 0} on && NF {print $1}'); do
  grep -q "^|.*| \`$method\` |\$" "$source/docs/guide/which-method.md" || {
    echo "FAILED: which-method.md does not say when to use $method"
    failures=$((failures + 1))
  }
done

echo "$done commands as they stand there, $left left out, $failures failed"
[ $failures = 0 ] && [ $done -gt 15 ]
