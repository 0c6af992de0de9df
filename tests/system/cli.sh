#!/bin/sh
# The drivers' command line as a user meets it: exit codes, one-line errors that name what, where
# and what to do, and a trajectory. usage: cli.sh BIN_DIR DATA_DIR
set -u
bin=$1
data=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

# expect EXIT WORDS COMMAND...: the exit code, and one line on stderr that has the words
expect() {
  code=$1
  words=$2
  shift 2
  "$@" >out 2>err
  got=$?
  lines=$(wc -l <err)
  if [ "$got" != "$code" ] || [ "$lines" != 1 ] || ! grep -qF -- "$words" err; then
    echo "FAILED: $*: exit $got (wanted $code), stderr: $(cat err) (wanted one line with: $words)"
    failures=$((failures + 1))
  fi
}

check() {
  if ! "$@"; then
    echo "FAILED: $*"
    failures=$((failures + 1))
  fi
}

pendulum=$bin/nsdae-pendulum
expect 2 "did you mean '--method'?" "$pendulum" --metod moreau
expect 2 "did you mean '--output'?" "$pendulum" --out x.h5
expect 2 "unknown option '--foo'; --help lists all" "$pendulum" --foo
expect 2 "did you mean 'moreau'?" "$pendulum" --method moraeu
expect 2 "did you mean 'theta_0'?" "$pendulum" --set theta0=1
expect 2 "unknown name 'lenght'; did you mean 'L' (length of the rod)?" "$pendulum" --set lenght=2
expect 2 "did you mean 'length'?" "$bin/nsdae-wall" --set lenght=2
expect 2 "dt = -0.1 is outside its range: it must be greater than 0" "$pendulum" --dt -0.1
expect 2 "dt = 0 is outside" "$pendulum" --dt 0
expect 2 "m = nan is outside" "$pendulum" --set m=nan
expect 2 "t_end = inf is outside its range: it must be finite and greater than 0" "$pendulum" --t-end inf
expect 2 "unknown name 'a?b'" "$pendulum" --set "a
b=1"
expect 2 "is longer than 511 characters" "$pendulum" --set L="$(printf '%0600d' 1)"
expect 2 "e_N = 1.5 is outside its range: it must be at least 0 and at most 1" \
  "$pendulum" --set e_N=1.5
expect 2 "is not a number" "$pendulum" --dt fast
expect 2 "needs a value" "$pendulum" --dt
expect 2 "takes no value" "$pendulum" --quiet=1
expect 2 "NAME=VALUE" "$pendulum" --set mass
expect 2 "--output needs a file name" "$pendulum" --output=
expect 2 "error: cannot read '.'" "$pendulum" --params .
expect 2 "r = 0.04 is outside its range: it must be less than R = 0.03" \
  "$bin/nsdae-clearance-hinge" --quiet --no-output --set r=0.04
expect 2 "must be at most R - r = 0.014" "$bin/nsdae-clearance-hinge" --quiet --no-output --set dY=0.02
expect 2 "cannot read 'none.ini'" "$pendulum" --params none.ini
printf 'L = 1\n\nlenght = 2\n' >bad.ini
expect 2 "bad.ini line 3" "$pendulum" --params bad.ini
printf 'L = 1\n# %01100d\n' 0 >long.ini
printf 'L = 1\n\000' >nul.ini
expect 2 "nul.ini line 2: a NUL byte" "$pendulum" --params nul.ini
expect 2 "long.ini line 2: a line is longer" "$pendulum" --params long.ini
expect 2 "no FILE given: nsdae-scene FILE.csv" "$bin/nsdae-scene"
expect 2 "cannot read 'none.csv'" "$bin/nsdae-scene" none.csv
sed 's/^box,/torus,/' "$data/scene_boxes.csv" >bad.csv
expect 2 "'bad.csv' line 9, column 1 (kind): kind has no choice 'torus'" "$bin/nsdae-scene" bad.csv
expect 2 "'b.csv': one FILE at a time" "$bin/nsdae-scene" a.csv b.csv
expect 2 "unknown option 'arch.csv'" "$bin/nsdae-arch" arch.csv

# a scene: its own step unless another is named; continued in its file; the generator writes it
# --brief: one line, the first impulse beside its exact value; a warning would be a line more. Of the cradle it is m v_0,
# less (gap / v_0)^2 g / (2 L) = 2.5e-7 of it, where the exact solution and the methods agree; the wall's is its weight.
for figure in "pendulum: first impact 13.8097 N s, exact 13.8102" "newtons-cradle: first impact 0.1 N s, exact 0.1" \
  "wall: floor 76.4199 N, exact 76.4199"; do
  name=${figure%%:*}
  check "$bin/nsdae-$name" --params "$data/$name.ini" --no-output --brief >line
  check [ "$(wc -l <line)" = 1 ]
  check grep -q "^$name .* steps .* impacts .*${figure#*: }\$" line
done

check "$bin/nsdae-scene" "$data/scene_wall.csv" --t-end 0.01 >table
check grep -q 'dt 0.002 s, to 0.01 s' table
check grep -q '^46 bodies: penetration' table
check grep -q '^CPU time of a step: mean' table
check "$bin/nsdae-scene" --dt 0.001 "$data/scene_wall.csv" --no-output --t-end 0.01 >table
check grep -q 'dt 0.001 s, to 0.01 s' table
check "$bin/nsdae-scene" --restart scene.h5 --t-end 0.02 >table
check grep -q 'dt 0.002 s, to 0.02 s' table
if command -v python3 >/dev/null; then
  sed -n 's/^ *make_scene.py \(.*\) > \(scene_.*\)/\1 \2/p' "$data/make_scene.py" >commands
  check test "$(wc -l <commands)" = 4
  while read -r line; do
    # shellcheck disable=SC2086
    python3 "$data/make_scene.py" ${line% *} >made.csv
    check cmp made.csv "$data/${line##* }"
  done <commands
fi

# the shaft touches the hole at the start, which R - r gives to rounding only
check "$bin/nsdae-clearance-hinge" --quiet --no-output --t-end 0.1 --set dX=0.014
expect 1 "no/such/folder" "$pendulum" --quiet --output no/such/folder/x.h5
expect 1 "Is a directory" "$pendulum" --quiet --output /
expect 1 "did not converge" "$pendulum" --quiet --no-output --dt 10 --t-end 1e4 --set iteration_max=3

check "$pendulum" --help >help
check grep -q -- --t-end help
check grep -q theta_0 help
check "$pendulum" -h >short
check cmp -s help short
check grep -q 'e_N .*at least 0 and at most 1' help
check "$pendulum" --version >version
check grep -q '^nsdae-pendulum nsdae 0' version

# --quiet prints nothing; a parameter file counts before what stands on the command line
check "$pendulum" --quiet --params "$data/pendulum.ini" --no-output >quiet 2>&1
check test ! -s quiet
check "$pendulum" --quiet --compare --no-output >quiet 2>&1
check test ! -s quiet
if [ -w /dev/full ]; then
  for printing in --no-output --help --version; do
    "$pendulum" $printing 2>err >/dev/full
    check test $? = 1
    check grep -q 'cannot write to standard output' err
  done
fi
printf 'dt = 0.01\nt_end = 1\n' >mine.ini
check "$pendulum" --dt 0.02 --params mine.ini --output a.h5 >table
check grep -q 'dt 0.02 s, to 1 s' table
check grep -q '13.810204189' table # the exact first impulse

# the same run twice: the same bytes of q and v
if command -v h5dump >/dev/null; then
  check "$pendulum" --quiet --dt 0.02 --params mine.ini --output b.h5
  for set in q v; do
    h5dump -d /$set -b LE -o a.bin a.h5 >/dev/null
    h5dump -d /$set -b LE -o b.bin b.h5 >/dev/null
    check cmp -s a.bin b.bin
  done
fi

for example in clearance-hinge crank-slider; do
  check "$bin/nsdae-$example" --params "$data/$example.ini" --output $example.h5 >table
  check grep -q 'worst LCP residual' table
done

# one that is not there or lacks the modules hands over to the next
if NSDAE_PYTHON=/nonexistent "$bin/nsdae-plot" --version >version 2>err; then
  printf '#!/bin/sh\nexec python3 -S "$@"\n' >bare
  chmod +x bare
  if ! ./bare -c 'import h5py' 2>err; then
    check env NSDAE_PYTHON="$work/bare" "$bin/nsdae-plot" --version >again
    check cmp version again
  fi
else
  check grep -q 'python3-h5py' err
fi

# computing PID: until it has used 0.15 s of processor time, several times what precedes its first step, or has ended
computing() {
  until read -r stat <"/proc/$1/stat" 2>/dev/null && set -- "$1" ${stat##*)} && [ "${13}" -ge 15 ]; do
    kill -0 "$1" 2>/dev/null || break
    sleep 0.05
  done
}

# a second run to the same file leaves it to the first
"$pendulum" --quiet --dt 1e-5 --t-end 1e4 --output busy.h5 &
first=$!
until HDF5_USE_FILE_LOCKING=FALSE h5dump -a /status busy.h5 >/dev/null 2>&1; do # a whole file, which its writer has locked
  kill -0 $first 2>/dev/null || break
  sleep 0.05
done
expect 1 "cannot write 'busy.h5': another program has it open" "$pendulum" --quiet --output busy.h5
kill -9 $first
wait $first 2>/dev/null
check h5dump -a /status busy.h5 >status
check grep -q running status

# Ctrl-C: the run ends after its step with the file closed
"$pendulum" --quiet --dt 1e-5 --t-end 1e4 --output long.h5 2>err &
computing $!
kill -INT $!
wait $!
check test $? = 1
check grep -q 'interrupted at t =' err
check h5dump -a /status long.h5 >status
check grep -q interrupted status

# a closed terminal does the same; nohup is heeded
"$pendulum" --quiet --dt 1e-5 --t-end 1e4 --output hung_up.h5 2>err &
computing $!
kill -HUP $!
wait $!
check test $? = 1
check grep -q 'interrupted at t =' err
check h5dump -a /status hung_up.h5 >status
check grep -q interrupted status
(trap '' HUP && exec "$pendulum" --quiet --dt 1e-4 --t-end 12 --output heeded.h5) 2>err &
computing $!
kill -HUP $!
wait $!
check test $? = 0

# a file at the limit of its size: an error of the write, and the run can be continued
(ulimit -f 3000 && exec "$pendulum" --quiet --dt 1e-4 --t-end 4 --output most.h5) 2>err
check test $? = 1
check grep -q "cannot write to 'most.h5': File too large" err
check "$pendulum" --quiet --restart most.h5 --t-end 4

# a pipe without a writer is refused at once
mkfifo pipe.ini pipe.h5 pipe.csv
expect 2 "cannot read 'pipe.ini': it must be a regular file" timeout 60 "$pendulum" --params pipe.ini
expect 2 "cannot read 'pipe.h5': it is not a regular file" timeout 60 "$pendulum" --restart pipe.h5
expect 1 "cannot write 'pipe.h5': it is not a regular file" timeout 60 "$pendulum" --output pipe.h5
expect 2 "cannot read 'pipe.csv': it must be a regular file" timeout 60 "$bin/nsdae-scene" pipe.csv

# inside a step too, here one that the integrator goes on in for minutes: the step is dropped
"$pendulum" --quiet --method penalty --set e_N=1 --rtol 1e-12 --dt 1e6 --t-end 1e6 --output inside.h5 2>err &
computing $!
kill -INT $!
wait $!
check test $? = 1
if ! grep -q 'NSDAE_SUNDIALS=OFF' err; then
  check grep -q 'interrupted at t = .*the step was discarded' err
  check h5dump -a /status inside.h5 >status
  check grep -q interrupted status
fi

# and in the comparison, once the summary of the run itself is out
"$pendulum" --compare --method moreau --dt 1e-5 --t-end 4 --no-output >out 2>err &
until grep -q 'energy balance' out; do
  kill -0 $! 2>/dev/null || break
  sleep 0.05
done
kill -INT $!
wait $!
check test $? = 1
check grep -q 'interrupted while comparing' err

[ $failures = 0 ] && echo "all as expected"
exit $failures
