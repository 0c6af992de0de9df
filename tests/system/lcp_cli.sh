#!/bin/sh
# nsdae-lcp as a user meets it: the certificate, exit codes, one-line errors that name what, where
# and what to do. usage: lcp_cli.sh BIN_DIR HDF5 SUNDIALS (ON or OFF)
set -u
bin=$1
hdf5=$2
sundials=$3
lcp=$bin/nsdae-lcp
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

complain() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# refused WORDS ARGUMENT...: exit 2, nothing on stdout, one line on stderr that has the words
refused() {
  words=$1
  shift
  "$lcp" "$@" >out 2>err
  got=$?
  if [ $got != 2 ] || [ -s out ] || [ "$(wc -l <err)" != 1 ] || ! grep -qF -- "$words" err; then
    complain "nsdae-lcp $*: exit $got, stderr: $(cat err) (wanted 2 and one line with: $words)"
  fi
}

# gives EXIT LINES ARGUMENT...: the exit code, and each line (separated by ;) on stdout
gives() {
  code=$1
  wanted=$2
  shift 2
  "$lcp" "$@" >out 2>err
  got=$?
  [ $got = "$code" ] || complain "nsdae-lcp $*: exit $got, wanted $code: $(cat out err)"
  [ ! -s err ] || complain "nsdae-lcp $*: stderr: $(cat err)"
  oldifs=$IFS
  IFS=';'
  for line in $wanted; do
    grep -qxF -- "$line" out || complain "nsdae-lcp $*: no line '$line' in: $(cat out)"
  done
  IFS=$oldifs
}

# x_is N VALUES: the last N lines of stdout, to nine digits
x_is() {
  got=$(tail -n "$1" out | awk '{ printf "%.9g ", $1 }')
  [ "$got" = "$2 " ] || complain "x is $got, not $2"
}

# 2 x1 + x2 - 5, x1 + 2 x2 - 6: x = (4/3, 7/3)
printf '2\n0\n2\n2\n2 2\n2 1\n1 2\n-5 -6\nwhat follows is a comment\n' >two.dat
gives 0 'outcome: solved;stage: lemke;n: 2;tol: 1e-10' two.dat
grep -qE '^residual: [0-9.e+-]+$' out || complain "no residual: $(cat out)"
gives 0 'outcome: solved' --solution two.dat
x_is 2 '1.33333333 2.33333333'
gives 0 'stage: enumerate' --stages enumerate two.dat
gives 0 'stage: lemke;tol: 0.001' --stages=enumerate,lemke --tol=1e-3 two.dat
gives 1 'outcome: unsolved' --stages trivial two.dat

# a column of the text is a column of A: y1 = x1 - 2 x2 + 1, y2 = x2 - 1
printf '2 0 2 2 2 2  1 0  -2 1  1 -1\n' >column.dat
gives 0 'outcome: solved' --solution column.dat
x_is 2 '1 1'
printf '2 0 2 2 2 2  1 -2  0 1  1 -1\n' >row.dat # transposed
gives 0 'outcome: solved' --solution row.dat
x_is 2 '0 1'

# no x >= 0 has -x - 1 >= 0
printf '1 0 1 1 1 1 -1 -1\n' >none.dat
gives 1 'outcome: infeasible;stage: prove;proof: farkas' none.dat
gives 1 'outcome: infeasible' --solution none.dat
grep -qE '^-?[0-9]' out && complain "x printed without a solution: $(cat out)"

# the first one as four blocks of one entry
printf '2 1 2 2  4 2 2  1 2  1 2  3 4  0 2 4  0 1 0 1  0 2 1 1 2 1 3 2  -5 -6\n' >block.dat
gives 0 'outcome: solved' --solution block.dat
x_is 2 '1.33333333 2.33333333'

# one planar contact: mass 1, falling with -1 and sliding with 0.1, mu 0.5: sticks, Lambda_N 1,
# Lambda_T = -0.1 = Lambda_R - mu Lambda_N
printf '2 1 0 2 2 2 2  1 0  0 1  -1 0.1  0.5\n' >contact.dat
gives 0 'outcome: solved;n: 3;contacts: 1' --solution contact.dat
x_is 3 '1 0.4 0'

printf '0 0 0 0 0 0\n' >empty_problem.dat
gives 0 'outcome: solved;n: 0' --solution empty_problem.dat

refused "no FILE given"
refused "cannot read 'none.txt': No such file or directory" none.txt
refused "Is a directory" .
mkfifo pipe.dat
refused "cannot read 'pipe.dat': it must be a regular file" pipe.dat
: >empty.dat
refused "empty.dat: ends where" empty.dat
printf 'neither text nor HDF5' >garbage.dat
refused "garbage.dat: 'neither' where a size must be" garbage.dat
head -c 3000 /dev/zero >zeros.dat
refused "zeros.dat" zeros.dat
printf '2\n0\n2\n2\n2 2\n2 1\n1' >cut.dat
refused "cut.dat: ends where a matrix entry must be" cut.dat
printf '2 1 2 2  4 2 2  1 2  1 2  3 4  2 0 4  0 1 0 1  0 2 1 1 2 1 3 2  -5 -6\n' >pointers.dat
refused "pointers.dat: the row pointers do not rise" pointers.dat
printf '2 1 0 2 2 2 2  1 0  0 1  -1 0.1  -0.5\n' >mu.dat
refused "mu.dat: friction coefficient 1 is -0.5, must be >= 0" mu.dat
# a number of so many digits is one number, or none
printf '1 0 1 1 1 1 %0300d -1\n' 2 >long.dat
gives 0 'outcome: solved' --solution long.dat
x_is 1 0.5
printf '1 0 1 1 1 1 %0500d -1\n' 2 >longer.dat
refused "longer.dat: '0000" longer.dat
printf '2\n0\n2\n2\n2 2\n2 1\n1 nan\n1 1\n' >nan.dat
refused "nan.dat" nan.dat
printf '2\n0\n2\n2\n2 2\n2 1\n1 1\n1 inf\n' >inf.dat
refused "inf.dat" inf.dat
refused "one FILE at a time" two.dat none.dat
refused "did you mean '--solution'?" --solutoin two.dat
refused "unknown option '-x'" -x two.dat
refused "--tol needs a value" --tol
refused "is not a number" --tol small two.dat
for tol in 0 -1 nan inf 1.5; do refused "must be above 0 and at most 1" --tol $tol two.dat; done
refused "did you mean 'lemke'?" --stages lemka two.dat
refused "unknown stage ''" --stages lemke, two.dat

"$lcp" --help >help || complain "--help"
grep -q -- --stages help || complain "--help does not list --stages"
"$lcp" --version | grep -q '^nsdae-lcp nsdae 0' || complain "--version"
if [ -e /dev/full ]; then
  "$lcp" two.dat >/dev/full 2>err
  [ $? = 1 ] && grep -q 'cannot write' err || complain "full disk: $(cat err)"
fi

# A step that fails leaves its problem: a rod inside Painleve's paradox has no contact force.
if [ "$hdf5" = ON ] && [ "$sundials" = ON ]; then
  rod="$bin/nsdae-falling-rod --no-output --method event --set mu=2 --set omega=0"
  $rod --set lcp_dump=step.h5 >out 2>err
  [ $? = 1 ] || complain "the rod inside the paradox did not fail"
  grep -q 'step.h5' out || complain "not said where the problem is: $(cat out)"
  [ "$(wc -l <err)" = 1 ] || complain "more than one line: $(cat err)"
  gives 1 'outcome: infeasible;n: 1;proof: farkas' step.h5
  $rod --quiet --set lcp_dump=no/such/folder/step.h5 >out 2>err
  [ $? = 1 ] && grep -q 'no/such/folder' err || complain "unwritable lcp_dump: $(cat err)"
  "$bin/nsdae-rolling-ball" --quiet --no-output --t-end 0.1 --set lcp_dump=good.h5 || complain run
  [ ! -e good.h5 ] || complain "a dump without a failure"
  head -c 1000 step.h5 >cut.h5
  refused "cannot read 'cut.h5'" cut.h5
  "$bin/nsdae-pendulum" --quiet --t-end 0.1 --output trajectory.h5
  refused "dataset /A is missing" trajectory.h5
  for python in "${NSDAE_PYTHON:-python3}" /usr/bin/python3; do
    "$python" -c 'import h5py' 2>/dev/null && break
    python=
  done
  if [ -n "$python" ]; then
    "$python" - <<'END'
import h5py, numpy
with h5py.File("numpy.h5", "w") as f:
    f["A"] = numpy.array([[1.0, -2.0], [0.0, 1.0]])  # y_1 = x_1 - 2 x_2 + 1
    f["b"] = numpy.array([1.0, -1.0])
END
    # x_2 = 1 makes y_1 = -1 with x_1 = 0: x_1 = 1
    gives 0 'outcome: solved' --solution numpy.h5
    x_is 2 '1 1'
  else
    echo "no Python with h5py: the order of NumPy is not tested here"
  fi
fi

[ $failures = 0 ] && echo "all as expected"
exit $failures
