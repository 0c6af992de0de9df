#!/bin/sh
# Instructions of a step of a few bodies, for two builds of cost.c: that of an older library, ours; exact, whatever else
# the machine does. usage: cost.sh OLD NEW [METHOD...]
#
# OLD: cost.c compiled and linked with another build, as in
#   git worktree add /tmp/old COMMIT && cmake --preset release -S /tmp/old -B /tmp/old/build && cmake --build /tmp/old/build
#   cc -O2 -I/tmp/old/include -I/tmp/old/drivers/common -I/tmp/old/drivers/models tests/bench/cost.c -o /tmp/cost \
#     /tmp/old/drivers/models/{model_names,newtons_cradle,falling_rod,woodpecker}.c \
#     -L/tmp/old/build/lib -lnsdae -lm -Wl,-rpath,/tmp/old/build/lib
set -eu
old=$1 new=$2
shift 2
[ $# -gt 0 ] || set -- implicit implicit-printed moreau penalty event
export OPENBLAS_NUM_THREADS=1

# of steps 1001 to 3000: what comes before is not counted
instructions() {
  for steps in 1000 3000; do
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$1" "$2" "$3" $steps 2>&1 |
      sed -n 's/.*Collected : //p'
  done | awk 'NR == 1 { first = $1 } NR == 2 { printf "%.0f", ($1 - first) / 2000 }'
}

printf "%-17s %-9s %9s %9s  ratio\n" method scene old new
for method in "$@"; do
  for scene in falling closed sliding ball pendulum turning column-3 column-10 newtons-cradle falling-rod woodpecker; do
    before=$(instructions "$old" $scene "$method")
    after=$(instructions "$new" $scene "$method")
    awk -v m="$method" -v s="$scene" -v a="$before" -v b="$after" \
      'BEGIN { printf "%-17s %-9s %9d %9d  %.3f\n", m, s, a, b, b / a }'
  done
done
