#!/bin/sh
# Every example by every method, killed at random and gone on with: the file has the datasets of the
# run that was left alone, byte for byte. usage: restart.sh BIN_DIR DATA_DIR [KILLS [NAME...]]
# With KILLS, or NSDAE_KILLS=20, these examples, or all, by every method, each killed so often (an hour on one core).
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

# same WHOLE GOT: all datasets
same() {
  h5diff -q "$1" "$2" /time /time && for group in $(h5ls "$1" | awk '$2 == "Group" {print $1}') \
    $(h5ls "$1" | awk '$2 == "Dataset" {print $1}'); do
    h5diff -q "$1" "$2" "/$group" "/$group" || return 1
  done
}

# wait_for FILE ROWS PID: until it has so many records, or the run is done
wait_for() {
  while kill -0 "$3" 2>/dev/null; do
    rows=$(HDF5_USE_FILE_LOCKING=FALSE h5ls "$1/time" 2>/dev/null | sed -n 's/.*{\([0-9]*\).*/\1/p')
    [ "${rows:-0}" -ge "$2" ] && return
    sleep 0.02
  done
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
    wait_for got.h5 $((1 + seed / 7 % total)) $run
    kill -9 $run 2>/dev/null && killed=$((killed + 1))
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
kills=2
for method in implicit implicit-printed moreau penalty event; do
  attack pendulum 40 --method $method
  attack bouncing-ball 3 --method $method
  attack woodpecker 8 --method $method
done
attack clearance-hinge 4 --method implicit
attack crank-slider 4 --method event
attack newtons-cradle 8 --method moreau
attack falling-rod 3 --method implicit --every 7
attack rolling-ball 8 --method implicit --compress 3 --every 2
attack incline 4 --method implicit --compress 1
attack column 4 --method moreau --set balls=5
attack wall 1 --method implicit --set courses=2 --set length=2
attack arch 2 --method implicit-printed --set blocks=5 --every 3
attack dominoes 1 --method moreau --set n=6
attack heap 1 --method moreau --set spheres=6 --compress 1
attack column 4 --method event --set balls=5
attack heap 2 --method event --set spheres=4 --set rough=0 --every 3
attack arch 1 --method penalty --set blocks=5 --compress 1
echo "$runs runs, $kills_done of them killed"
[ $failures = 0 ]
