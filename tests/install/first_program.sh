#!/bin/sh
# The README's first program, letter for letter, against an installed tree that was moved.
# usage: first_program.sh BUILD_DIR SOURCE_DIR
set -eu
build=$1
source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/moved"

# the program in the README is the one in docs/examples
awk '/^```c$/ {on = 1; next} /^```$/ {on = 0} on' "$source/README.md" >"$work/ball.c"
cmp "$work/ball.c" "$source/docs/examples/ball.c"

awk '/^```cpp$/ {on = 1; next} /^```$/ {on = 0} on' "$source/README.md" | cmp - "$source/docs/examples/ball.cpp"
awk '/^```fortran$/ {on = 1; next} /^```$/ {on = 0} on' "$source/README.md" | cmp - "$source/docs/examples/ball.f90"

lib=$(dirname "$(find "$work/moved" -name libnsdae.so)")
export PKG_CONFIG_PATH="$lib/pkgconfig" LD_LIBRARY_PATH="$lib"
cc -std=c11 -Wall -Wextra -Wpedantic -Werror "$work/ball.c" $(pkg-config --cflags --libs nsdae) \
  -o "$work/ball"
"$work/ball" >"$work/out"
cat "$work/out"
grep -qF "$(cat "$work/out")" "$source/README.md"

# the same in C++
if command -v c++ >/dev/null; then
  c++ -std=c++11 -Wall -Wextra -Wpedantic -Werror "$source/docs/examples/ball.cpp" \
    $(pkg-config --cflags --libs nsdae) -o "$work/ball-cpp"
  "$work/ball-cpp" | cmp - "$work/out"
fi

# an installed driver, and the picture where it writes a trajectory
if [ -x "$work/moved/bin/nsdae-pendulum" ]; then
  cd "$work"
  moved/bin/nsdae-pendulum --params moved/share/nsdae/data/pendulum.ini >printed
  # what the README says that it prints
  sed -n '/^    \$ nsdae-pendulum/,/^    trajectory in/p' "$source/README.md" |
    sed -e 1d -e 's/^    //' -e 's/^ *\.\.\.$/.../' >wanted
  [ "$(wc -l <wanted)" -gt 10 ]
  if [ -s pendulum.h5 ]; then awk -f "$source/tests/docs/same.awk" wanted printed; fi
  if [ -s pendulum.h5 ]; then
    moved/bin/nsdae-plot pendulum.h5 || moved/bin/nsdae-plot pendulum.h5 2>&1 | grep -q python3-h5py
  fi
fi
echo "installed, moved and used"
