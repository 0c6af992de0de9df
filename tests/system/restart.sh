#!/bin/sh
# Programs killed with SIGKILL at random, each continued from its file: shapes and bytes of all datasets are those of a run
# without a kill. Other tests restore a state within one process; this one proves what only processes can: the file on the disk
# is whole at every moment, the options of the command line come back from it, and each example's own state with them.
# usage: restart.sh BIN_DIR DATA_DIR [KILLS [NAME...]]
# Quick form: each method and each kind of file once, one kill each. NSDAE_TEST_SHARE=1: more programs, two kills each. With
# KILLS, or NSDAE_KILLS=20: these examples, or all, by every method (an hour on one core).
set -u
bin=$1
data=$2
kills=${3:-${NSDAE_KILLS:-}}
[ $# -lt 3 ] && shift 2 || shift 3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0 runs=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# shapes, then bytes, which h5diff compares of equal shapes alone; the attributes of the root have the date
same() {
  h5ls -r "$1" >shapes && h5ls -r "$2" | cmp -s shapes - && h5diff -q --exclude-attribute / "$1" "$2"
}

# kill_at FILE ROWS PID: SIGKILL once the file has that many records, unless the run is done. The program runs for ten
# milliseconds or more at a time and is stopped while the records are counted, so that a loaded machine kills it as early. It
# writes every quarter of a second: the first stop is longer than that.
kill_at() {
  while kill -0 "$3" 2>/dev/null && ! [ -s "$1" ]; do sleep 0.01; done
  kill -STOP "$3" 2>/dev/null && sleep 0.3
  until rows=$(HDF5_USE_FILE_LOCKING=FALSE h5ls "$1/time" 2>/dev/null | sed -n 's/.*{\([0-9]*\).*/\1/p') &&
    [ "${rows:-0}" -ge "$2" ]; do
    kill -CONT "$3" 2>/dev/null || break
    sleep 0.0$((1 + seed / 11 % 3))
    kill -STOP "$3" 2>/dev/null || break
  done
  kill -KILL "$3" 2>/dev/null && killed=$((killed + 1))
}

# attack NAME T_END ARGUMENT...: whole, then killed so many times and gone on with
attack() {
  name=$1
  t_end=$2
  shift 2
  program=$bin/nsdae-$name
  "$program" --quiet --t-end "$t_end" --output whole.h5 "$@" 2>error || { # such as a method that the model does not have
    grep -q . error || fail "$name $*: no error text"
    return
  }
  total=$(h5ls whole.h5/time | sed -n 's/.*{\([0-9]*\).*/\1/p')
  rm -f got.h5
  killed=0
  "$program" --quiet --t-end "$t_end" --output got.h5 "$@" &
  run=$!
  for kill in $(seq "$kills"); do
    seed=$(((seed * 1103515245 + 12345) % 2147483648))
    kill_at got.h5 $((1 + seed / 7 % total * (kills > 1 ? 2 : 1) / 2)) $run
    wait $run 2>/dev/null
    "$program" --quiet --restart got.h5 &
    run=$!
  done
  wait $run || fail "$name $*: the last restart ended with $?"
  same whole.h5 got.h5 || fail "$name $*: other bytes after $killed kills"
  runs=$((runs + 1)) kills_done=$((kills_done + killed))
}

seed=7 kills_done=0
if [ "$kills" ]; then
  for name in ${*:-pendulum bouncing-ball clearance-hinge crank-slider falling-rod incline newtons-cradle \
    rolling-ball shaken-ball woodpecker column arch wall dominoes heap}; do
    few='' # the large ones, of bodies by list, are small and last
    case $name in
      pendulum) t_end=40 ;;
      column) t_end=40 few='--set balls=5' ;;
      arch) t_end=15 few='--set blocks=7' ;;
      wall) t_end=8 few='--set courses=3 --set length=3' ;;
      dominoes) t_end=8 few='--set n=6' ;;
      heap) t_end=8 few='--set spheres=8' ;;
      *) t_end=4 ;;
    esac
    for method in implicit implicit-printed moreau penalty event; do
      attack $name $t_end --method $method $few
    done
    echo "$name: $runs runs, $kills_done kills, $failures failures"
  done
  [ $failures = 0 ]
  exit
fi
if [ "${NSDAE_TEST_SHARE:-}" = 1 ]; then
  kills=2
  for method in implicit implicit-printed moreau penalty event; do
    attack pendulum 40 --method $method
    attack bouncing-ball 3 --method $method
    attack woodpecker 8 --method $method
  done
  attack newtons-cradle 8 --method moreau
  attack falling-rod 3 --method implicit --every 7
  attack incline 4 --method implicit --compress 1
  attack arch 2 --method implicit-printed --set blocks=5 --every 3
  attack dominoes 1 --method moreau --set n=6
  attack heap 2 --method event --set spheres=4 --set rough=0 --every 3
  attack arch 1 --method penalty --set blocks=5 --compress 1
fi
kills=${kills:-1}
attack pendulum 6 --method implicit
attack pendulum 6 --method implicit-printed --compress 1
attack pendulum 6 --method moreau --every 7
attack pendulum 6 --method penalty
attack woodpecker 1.5 --method event
attack clearance-hinge 1 --method implicit --compress 3 --every 2
attack crank-slider 2 --method event
attack rolling-ball 2 --method implicit --every 2
attack wall 0.5 --method implicit --set courses=2 --set length=2
attack column 1 --method event --set balls=5
attack heap 0.5 --method moreau --set spheres=6 --compress 1
echo "$runs runs, $kills_done of them killed"
[ $failures = 0 ] && [ "$kills_done" -gt 0 ]
