#!/bin/sh
# nsdae-friction as a user meets it: the certificate, what is kept, the same bits again, solutions in
# two parts, exit codes, one-line errors that name what, where and what to do. usage: friction_cli.sh BIN_DIR SAMPLE_WRITER
set -u
friction=$1/nsdae-friction
write=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

complain() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# refused EXIT WORDS ARGUMENT...: that exit, nothing on stdout, one line on stderr that has the words
refused() {
  code=$1
  words=$2
  shift 2
  "$friction" "$@" >out 2>err
  got=$?
  if [ $got != "$code" ] || [ -s out ] || [ "$(wc -l <err)" != 1 ] || ! grep -qF -- "$words" err; then
    complain "nsdae-friction $*: exit $got, stderr: $(cat err) (wanted $code and one line with: $words)"
  fi
}

# gives EXIT LINES ARGUMENT...: the exit code, and each line (separated by ;) on stdout
gives() {
  code=$1
  wanted=$2
  shift 2
  "$friction" "$@" >out 2>err
  got=$?
  [ $got = "$code" ] || complain "nsdae-friction $*: exit $got, wanted $code: $(cat out err)"
  [ ! -s err ] || complain "nsdae-friction $*: stderr: $(cat err)"
  oldifs=$IFS
  IFS=';'
  for line in $wanted; do
    grep -qxF -- "$line" out || complain "nsdae-friction $*: no line '$line' in: $(cat out)"
  done
  IFS=$oldifs
}

# the problem of any step of an example, solved again from where its step began: the same bits
bin=$(dirname "$friction")
"$bin/nsdae-rolling-ball" --quiet --no-output --t-end 0.05 --dt 0.001 --method moreau \
  --set friction_dump=ball.h5 --set friction_step=20 || complain "no dump of the ball"
gives 0 'outcome: solved;form: global;contacts: 1;tol: 1e-10' --output again.h5 ball.h5
for at in r u; do
  h5dump -d /solution/$at -b LE -o then.bin ball.h5 >/dev/null || complain "no $at in ball.h5"
  h5dump -d /solution/$at -b LE -o now.bin again.h5 >/dev/null || complain "no $at in again.h5"
  [ -s then.bin ] && cmp then.bin now.bin || complain "another $at than the step's"
done
h5dump -a step ball.h5 | grep -q '(0): 20$' || complain "not step 20"
# that of a planar step, which was a complementarity problem: the same impulses but for the tolerance
"$bin/nsdae-woodpecker" --no-output --t-end 0.3 --method moreau --set friction_dump=bird.h5 >out ||
  complain "no dump of the woodpecker: $(cat out)"
if grep -q 'bird.h5: nsdae-friction' out; then gives 0 'outcome: solved;form: local' bird.h5; fi
# contacts by list in one large island: the same bits
"$bin/nsdae-wall" --quiet --no-output --set courses=3 --set length=4 --set friction_dump=wall.h5 \
  --set friction_step=15 || complain "no dump of the wall"
gives 0 'outcome: solved;form: global;islands: 1' --output again.h5 wall.h5
for at in r u; do
  h5dump -d /solution/$at -b LE -o then.bin wall.h5 >/dev/null || complain "no $at in wall.h5"
  h5dump -d /solution/$at -b LE -o now.bin again.h5 >/dev/null || complain "no $at in again.h5"
  [ -s then.bin ] && cmp then.bin now.bin || complain "another $at than the wall's"
done
# methods that solve no such problem: that of a step of moreau from the record before
for method in event penalty; do
  "$bin/nsdae-incline" --no-output --method $method --t-end 0.05 --set friction_dump=$method.h5 \
    --set friction_step=8 >out || complain "no run of $method"
  grep -q "problem of step 8 in $method.h5" out || complain "no dump of $method: $(cat out)"
  gives 0 'outcome: solved;form: global;contacts: 1' $method.h5
  h5dump -a method $method.h5 | grep -q moreau || complain "$method.h5 does not say moreau"
done
# where there is none that is said, and the run goes on
"$bin/nsdae-bouncing-ball" --quiet --no-output --t-end 0.1 --set friction_dump=no.h5 2>err ||
  complain "the ball's run"
grep -q 'friction_dump: step .* has no problem' err && [ ! -e no.h5 ] || complain "no.h5: $(cat err)"

# spheres of 60 contacts or so, global and local
"$write" spheres.h5 local.h5 heavy.h5 || complain "no sample"
gives 0 'outcome: solved;form: global;tol: 1e-10' spheres.h5
grep -qE '^residual: [0-9.e+-]+$' out || complain "no residual: $(cat out)"
contacts=$(sed -n 's/^contacts: //p' out)
gives 0 "outcome: solved;form: local;contacts: $contacts;tol: 1e-06" --set tol=1e-6 local.h5

# what is kept is the solution, and gives it again
gives 0 'outcome: solved' --solution r.txt --output kept.h5 spheres.h5
[ "$(wc -l <r.txt)" = $((3 * contacts)) ] || complain "r.txt has $(wc -l <r.txt) lines"
gives 0 'outcome: solved' --solution=again.txt kept.h5
cmp r.txt again.txt || complain "another solution from the file that was kept"
h5dump -d /solution/u kept.h5 >/dev/null || complain "no u in the file that was kept"
h5dump -d /solution/v kept.h5 >/dev/null || complain "no v in the file that was kept"

# a body of 1 on one of 3e-7 that two bars hold: no r of doubles is a solution to 1e-12
gives 1 'outcome: unsolved' --set tol=1e-12 heavy.h5
! grep -q '^parts' out || complain "parts without --twice: $(cat out)"
gives 0 'outcome: solved;parts: 2;contacts: 1;bilateral: 2' --set tol=1e-12 --twice \
  --solution two.txt --output two.h5 heavy.h5
[ "$(grep -cE '^[-+.e0-9]+ [-+.e0-9]+$' two.txt)" = 4 ] || complain "not two columns: $(cat two.txt)"
# the bars bear the normal impulse and the weight of the light body, 3e-8: sums of near numbers are exact
awk '{ r[NR] = $1; low[NR] = $2 }
  END { off = ((r[3] - r[1]) - 3e-8) + (low[3] - low[1]); alone = (r[3] - r[1]) - 3e-8
        exit !(off * off < 1e-39 && alone * alone > 1e-36) }' two.txt || complain "no weight: $(cat two.txt)"
# the same numbers are in the file, of the contact beside r and of the bars beside l
for at in r:1,2:1 r_low:1,2:2 l:3,4:1 l_low:3,4:2; do
  column=${at##*:} rows=${at#*:}
  h5dump -d /solution/${at%%:*} -y -m %.17g -o kept.txt two.h5 >/dev/null || complain "no ${at%%:*}"
  awk -v column="$column" '{ print $column }' two.txt | sed -n "${rows%:*}p" >wanted.txt
  tr -d ' ' <kept.txt | tr ',' '\n' | grep . | cmp - wanted.txt || complain "another ${at%%:*}: $(cat kept.txt)"
done
gives 0 'outcome: solved;parts: 2' --set tol=1e-12 --twice --solution=again.txt two.h5
cmp two.txt again.txt || complain "another solution in two parts from the file that was kept"
# one part is enough: the same r, zeros beside it
gives 0 'outcome: solved;parts: 1' --twice --solution=again.txt --output one.h5 spheres.h5
[ "$(grep -c ' 0$' again.txt)" = $((3 * contacts)) ] || complain "not zeros: $(head -3 again.txt)"
cut -d' ' -f1 again.txt | cmp - r.txt || complain "another r with --twice"
h5dump -d /solution/r_low one.h5 >/dev/null || complain "no r_low with --twice"
h5dump -d /solution/r_low kept.h5 >/dev/null 2>&1 && complain "r_low without --twice"

# stages and bounds
gives 1 'outcome: unsolved' --set stages=nsgs --set max_sweeps=1 spheres.h5
"$friction" --set stages=nsgs --set max_sweeps=1 --solution none.txt spheres.h5 >/dev/null
[ ! -e none.txt ] || complain "a solution was written that is none"
gives 0 'outcome: solved' --cold spheres.h5
gives 0 '  --version          version and build' --help
cp out help
gives 0 '  --version          version and build' -h
cmp out help || complain "-h says something else than --help"
gives 0 '' --version
grep -q '^nsdae-friction ' out || complain "--version: $(cat out)"

refused 2 "no FILE given" --set tol=1e-3
refused 2 "unknown option '--tol'" --tol 1 spheres.h5
refused 2 "did you mean '--solution'" --soluton x spheres.h5
refused 2 "--set needs a value" spheres.h5 --set
refused 2 "must be NAME=VALUE" --set tol spheres.h5
refused 2 "did you mean 'tol'" --set tool=1 spheres.h5
refused 2 "tol" --set tol=0 spheres.h5
refused 2 "did you mean 'warm'" --set stages=wram spheres.h5
refused 2 "one FILE at a time" spheres.h5 local.h5
refused 2 "cannot read 'nothing.h5'" nothing.h5
echo no >no.h5
refused 2 "cannot read 'no.h5'" no.h5
"$friction" --output /nonexistent/x.h5 spheres.h5 >out 2>err
[ $? = 1 ] || complain "a file that cannot be written: $(cat err)"
grep -q nonexistent err || complain "no name in: $(cat err)"
if [ -e /dev/full ]; then
  "$friction" spheres.h5 >/dev/full 2>err
  [ $? = 1 ] || complain "a certificate that did not get out: $(cat err)"
fi

[ $failures = 0 ] && echo "all as expected"
exit $failures
