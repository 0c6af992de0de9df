#!/bin/sh
# The commands of docs/fortran.md, letter for letter, in a home directory of their own; then the
# programs in C and Fortran print the same numbers with 17 digits, which tell every double apart.
# usage: first_program.sh BUILD_DIR SOURCE_DIR LIBDIR
set -eu
command -v gfortran >/dev/null || exit 77 # the guide names it
build=$1
source=$2
libdir=$3
HOME=$(mktemp -d)
export HOME
trap 'rm -rf "$HOME"' EXIT
cd "$HOME"
ln -s "$build" build
ln -s "$source/docs" docs

# the commands are the first indented block of the section
awk '/^## / {on = /A first program/} on && /^    / {print substr($0, 5)}' docs/fortran.md |
  sed "s,~/nsdae/lib,~/nsdae/$libdir,g" >commands
[ "$(wc -l <commands)" -eq 3 ]
. ./commands >out
tail -n 1 out
[ "$(tail -n 1 out | tr E e)" = "t 3 s, height -1.2e-04 m, velocity 0.0e+00 m/s" ]

[ "$(wc -l <docs/examples/ball.f90)" -le 60 ]

sed 's/%.1e/%.16e/g' docs/examples/ball.c >digits.c
sed 's/es8.1/es23.16/; s/es7.1/es23.16/' docs/examples/ball.f90 >digits.f90
cc -std=c11 digits.c $(pkg-config --cflags --libs nsdae) -o digits_c
gfortran digits.f90 $(pkg-config --cflags --libs nsdae-fortran) -o digits_f
./digits_c >c.txt
./digits_f | tr E e | tr -s ' ' >f.txt
cat c.txt f.txt
cmp c.txt f.txt
grep -q 'e-04 m' c.txt
