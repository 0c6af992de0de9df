#!/bin/sh
# Lists what was skipped in the last run of ctest: tests of CTest, of cmocka within a program, of pytest within the package's
# test. The last line is their number. With CI=true a skipped test is a failure. usage: skipped.sh BUILD_DIR TESTS.log
# TESTS.log: from ctest --output-log
awk '
  FNR == 1 { file++ }
  function note(what) { if (!(what in seen)) { seen[what] = 1; print "skipped: " what; count++ } }
  file == 1 && / Test: / && $1 ~ /^[0-9]+\/[0-9]+$/ { test = $3 }
  file == 1 && /^\[ +SKIPPED \] [a-zA-Z_]/ { note(test ": " $NF); inner[test] = 1 }
  file == 1 && /^SKIPPED \[[0-9]+\] / { note(test ": " $0); inner[test] = 1 }
  file == 2 && /\*\*\*(Skipped|Not Run)/ && !/\(Disabled\)/ && match($0, /: [^ ]+/) {
    test = substr($0, RSTART + 2, RLENGTH - 2)
    if (!(test in inner)) note(test)
  }
  END { print count + 0 " skipped"; exit count > 0 }' "$1/Testing/Temporary/LastTest.log" "$2"
some=$?
[ $some = 0 ] || [ "${CI:-}" != true ] || {
  echo "skipped, which no test is in CI" >&2
  exit 1
}
