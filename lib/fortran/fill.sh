#!/bin/sh
# Prints the module of that name with its marked sections filled: those of the callbacks (callbacks.awk), and what the
# C headers declare (headers.awk). usage: fill.sh NAME
set -eu
cd "$(dirname "$0")/../.."
callbacks=$(awk -f lib/system/callbacks.awk lib/system/callbacks.list "lib/fortran/$1.f90")
printf '%s\n' "$callbacks" |
  awk -f lib/fortran/headers.awk pass=headers include/nsdae/*.h pass=modules lib/fortran/*.f90 pass=fill -
