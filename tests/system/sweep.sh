#!/bin/sh
# nsdae-sweep: the same bytes for any number of processes, killed and taken up again; a killed process is named with its
# run; failures keep their reason; what the runs give, against single runs and exact maps. usage: sweep.sh BIN_DIR SOURCE
# The quick form has fewer runs, ranks and kills than with NSDAE_TEST_SHARE=1.
set -u
bin=$1
here=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
sweep=$bin/nsdae-sweep
failures=0
long=
[ "${NSDAE_TEST_SHARE:-}" != 1 ] || long=yes

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# expect STATUS TEXT COMMAND...: its exit status, and the text in what it says
expect() {
  wants=$1 text=$2
  shift 2
  "$@" >out 2>err
  got=$?
  [ $got = "$wants" ] || fail "$* exits with $got, not $wants: $(cat err)"
  cat out err | grep -qF -- "$text" || fail "$* does not say '$text': $(cat out err)"
}

python=
for candidate in ${NSDAE_PYTHON:+"$NSDAE_PYTHON"} python3 /usr/bin/python3; do
  if "$candidate" -c 'import h5py, numpy' 2>/dev/null; then
    python=$candidate
    break
  fi
done

mpi=yes
"$sweep" bouncing-ball --grid h0=1,2 --t-end 0.1 --processes 2 --output probe.h5 >out 2>err || mpi=
[ "$mpi" ] || { grep -qE 'needs (a build with MPI|mpirun)' err || fail "two processes: $(cat err)"; echo "no MPI: one process"; }

ball="bouncing-ball --t-end 2.5 --keep final --keep impacts=4 --keep statistics --quiet"
grid="--grid h0=0.5:2:600 --grid e_N=0.3,0.9"
many=${long:+4000} # runs of a sweep that is killed, for each e_N
many="--grid h0=0.5:2:${many:-600} --grid e_N=0.3,0.9" # the quick form: those of grid
"$sweep" $ball $grid --processes 1 --output one.h5 || fail "a sweep"
if [ "$mpi" ]; then
  for n in 2 ${long:+3}; do
    mpirun -n $n "$sweep" $ball $grid --output $n.h5 || fail "$n ranks"
    cmp one.h5 $n.h5 || fail "$n ranks: other bytes"
  done
fi

# a run that is killed, group and all, then taken up; --quiet or not is no other sweep
killed() {
  setsid "$sweep" $ball $many --processes "$1" --output killed.h5 &
  pid=$!
  until h5dump -d /status killed.h5 2>/dev/null | grep -q ': 0,'; do
    kill -0 $pid || break
    sleep 0.01
  done
  ranks=$(pgrep -P $pid) # mpirun's have groups of their own
  kill -KILL -$pid $ranks
  wait $pid
  for rank in $ranks; do
    while grep -qs ") [^ZX] " "/proc/$rank/stat"; do sleep 0.02; done
  done
}
if [ "$long" ]; then
  "$sweep" $ball $many --processes 1 --output whole.h5 || fail "the whole sweep"
else
  cp one.h5 whole.h5
fi
for n in 1 ${mpi:+${long:+2}}; do
  rm -f killed.h5
  killed $n 2>/dev/null
  cmp -s killed.h5 whole.h5 && fail "it was over before it was killed"
  expect 0 "continued:" "$sweep" bouncing-ball --t-end 2.5 --keep final --keep impacts=4 --keep statistics \
    $many --processes 1 --output killed.h5
  cmp killed.h5 whole.h5 || fail "taken up again: other bytes"
done
expect 0 "already complete" "$sweep" bouncing-ball --t-end 2.5 --keep final --keep impacts=4 --keep statistics $grid --output one.h5
expect 2 "it has 't_end=2.5', this one 't_end=2'" "$sweep" $ball $grid --t-end 2 --output one.h5
"$sweep" bouncing-ball --grid h0=1,2 --t-end 0.1 --processes 1 --quiet --output probe.h5
expect 2 "it has 'e_N=0.9" "$sweep" bouncing-ball --grid h0=1,2 --t-end 0.1 --set e_N=0.1 --output probe.h5

# one process of two or three is killed, in a long run and in short ones: which run it was in
killed_rank() { # PROCESSES RANK STEP
  rm -f rank.h5
  "$sweep" bouncing-ball --grid h0=0.5:2:100000 --dt "$3" --t-end 2.5 --processes "$1" --output rank.h5 >out 2>err &
  pid=$!
  victim=
  while kill -0 $pid 2>/dev/null && [ -z "$victim" ]; do
    for child in $(pgrep -P $pid); do
      tr '\0' '\n' <"/proc/$child/environ" 2>/dev/null | grep -qx "OMPI_COMM_WORLD_RANK=$2" && victim=$child
    done
    sleep 0.1
  done
  while kill -0 $pid 2>/dev/null && ! grep -q processes out; do sleep 0.02; done # the runs begin
  if [ "$victim" ]; then
    kill -KILL "$victim"
    wait $pid && fail "a killed rank is no success"
    [ "$(grep -cE "error: rank $2 was killed (in run [0-9]+ \(h0=[0-9.]+\)|between two runs)" err)" = 1 ] ||
      fail "rank $2 of $1, steps of $3: the run of the one that was killed: $(cat err)"
  else
    kill $pid # a launcher of another kind
    wait $pid
  fi
}
if [ "$mpi" ] && [ -d /proc/self ]; then
  killed_rank 2 1 5e-3
  if [ "$long" ]; then
    killed_rank 2 0 5e-3
    killed_rank 2 0 2e-6
    killed_rank 2 1 2e-6
    killed_rank 3 1 5e-3
  fi
fi

# failures are results with a reason: the rod of the clearance hinge does not fit where r > R
expect 0 "runs failed" "$sweep" clearance-hinge --t-end 0.01 --grid r=0.015:0.05:8 --processes 1 --output failed.h5
h5dump -d /failure/reason failed.h5 | grep -q '"' || fail "no reasons"
cp failed.h5 again.h5
rm failed.h5
"$sweep" clearance-hinge --t-end 0.01 --grid r=0.015:0.05:8 --quiet ${mpi:+--processes 2} --output failed.h5
cmp failed.h5 again.h5 || fail "failures: other bytes"

# a disk that fills while the file is made: exit 1 with the reason, and no part is left
for blocks in 8 60 300; do # of 512 bytes; the file has 840 of them
  (trap '' XFSZ && ulimit -f $blocks && exec "$sweep" bouncing-ball --dt 1e-3 --t-end 0.01 --grid e_N=0:1:200 \
    --grid h0=0.1:1:100 --processes 1 --output full.h5) >out 2>err
  got=$?
  [ $got = 1 ] && grep -q "cannot write 'full.h5': File too large" err || fail "full disk: exit $got, $(cat err)"
  ls full.h5* 2>/dev/null && fail "full disk: a part is left"
done

# draws depend on the seed alone
draws="bouncing-ball --t-end 0.5 --quiet --random 200 --grid h0=0.5:2 --grid e_N=0:1"
"$sweep" $draws --seed 7 --processes 1 --output draws.h5 || fail "draws"
"$sweep" $draws --seed 7 ${mpi:+--processes 2} --output again7.h5 && cmp draws.h5 again7.h5 || fail "the same seed: other bytes"
"$sweep" $draws --seed 8 --processes 1 --output draws8.h5 && cmp -s draws.h5 draws8.h5 && fail "another seed: the same draws"

expect 2 "did you mean 'bouncing-ball'" "$sweep" bouncing-bal --grid h0=1,2
expect 2 "did you mean 'h0'" "$sweep" bouncing-ball --grid h1=1,2
expect 2 "is none of" "$sweep" bouncing-ball --grid h0
expect 2 "is none of" "$sweep" bouncing-ball --grid h0=1,2,x
expect 2 "has no count" "$sweep" bouncing-ball --grid h0=1:2
expect 2 "nothing to vary" "$sweep" bouncing-ball
expect 2 "named twice" "$sweep" bouncing-ball --grid h0=1,2 --grid h0=3,4
expect 2 "--keep 'everything'" "$sweep" bouncing-ball --grid h0=1,2 --keep everything
expect 2 "no parameter of bouncing-ball" "$sweep" bouncing-ball --grid h0=1,2 --keep samples=3@T
expect 2 "--compare" "$sweep" bouncing-ball --grid h0=1,2 --compare
expect 2 "is not an integer" "$sweep" bouncing-ball --grid h0=1,2 --processes many
expect 2 "outside" "$sweep" bouncing-ball --grid e_N=2,3 --output range.h5
echo text >taken.h5
expect 1 "cannot be read as HDF5" "$sweep" bouncing-ball --grid h0=1,2 --output taken.h5
[ "$(cat taken.h5)" = text ] || fail "a file that is no sweep was changed"

if [ "$python" ]; then
  shaken="shaken-ball --method event --rtol 1e-10 --atol 1e-12 --t-end 6 --quiet"
  gammas=${long:+60}
  "$sweep" $shaken --grid gamma=1.1:1.69:${gammas:-12} --keep samples=16@T --keep impacts=16 --keep extremes --output shaken.h5 ||
    fail "the shaken ball"
  "$bin/nsdae-bouncing-ball" --set h0=2 --set e_N=0.3 --t-end 2.5 --quiet --output single.h5 || fail "a single run"
  "$python" "$here/sweep_check.py" one.h5 single.h5 shaken.h5 failed.h5 draws.h5 || failures=$((failures + 1))
  if [ "$long" ] && "$bin/nsdae-plot" --version >/dev/null 2>&1; then
    expect 0 "picture in shaken.png" "$bin/nsdae-plot" shaken.h5
    expect 0 "picture in map.png" "$bin/nsdae-plot" --only final/q --only statistics/impacts one.h5 -o map.png
    expect 0 "picture in slice.svg" "$bin/nsdae-plot" --at e_N=0.9 --only final/q one.h5 -o slice.svg
    expect 0 "picture in draws.png" "$bin/nsdae-plot" draws.h5
    expect 1 "the sweep has no 'final/w'" "$bin/nsdae-plot" --only final/w one.h5
    expect 2 "--only 'height'" "$bin/nsdae-plot" --only height one.h5
  fi
else
  echo "no Python with h5py: results and pictures were not looked at"
fi
[ $failures = 0 ]
