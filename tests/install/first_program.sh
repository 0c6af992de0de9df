#!/bin/sh
# The first program of the guide, letter for letter, against an installed tree that was moved.
# usage: first_program.sh BUILD_DIR SOURCE_DIR
set -eu
build=$1
source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/moved"

page=$source/docs/guide/first-program.md
# the programs of the page are those in docs/examples
for program in ball.c ball.cpp ball.f90; do
  awk -v start="<!-- file: $program -->" '
    $0 == start { begun = 1; next } on && /^```$/ { exit } on { print } begun && /^```/ { on = 1 }' "$page" >"$work/$program"
  cmp "$work/$program" "$source/docs/examples/$program"
done

lib=$(dirname "$(find "$work/moved" -name libnsdae.so)")
export PKG_CONFIG_PATH="$lib/pkgconfig" LD_LIBRARY_PATH="$lib"
cc -std=c11 -Wall -Wextra -Wpedantic -Werror "$work/ball.c" $(pkg-config --cflags --libs nsdae) \
  -o "$work/ball"
"$work/ball" >"$work/out"
cat "$work/out"
grep -qFx "$(cat "$work/out")" "$page"

# the same in C++
if command -v c++ >/dev/null; then
  c++ -std=c++11 -Wall -Wextra -Wpedantic -Werror "$work/ball.cpp" \
    $(pkg-config --cflags --libs nsdae) -o "$work/ball-cpp"
  "$work/ball-cpp" | cmp - "$work/out"
fi

# an installed driver, and the picture where it writes a trajectory
if [ -x "$work/moved/bin/nsdae-pendulum" ]; then
  cd "$work"
  moved/bin/nsdae-pendulum --params moved/share/nsdae/data/pendulum.ini >printed
  # what the page says that it prints
  sed -n '/^\$ nsdae-pendulum --params/,/^trajectory in/p' "$page" | sed 1d >wanted
  [ "$(wc -l <wanted)" -gt 10 ]
  if [ -s pendulum.h5 ]; then awk -f "$source/tests/docs/same.awk" wanted printed; fi
  if [ -s pendulum.h5 ]; then
    moved/bin/nsdae-plot pendulum.h5 || moved/bin/nsdae-plot pendulum.h5 2>&1 | grep -q python3-h5py
  fi
fi
echo "installed, moved and used"
