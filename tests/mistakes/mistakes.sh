#!/bin/sh
# What is said to each mistake is what docs/guide/mistakes.md has, and none ends with status 0 but those that the
# check doubts.
# usage: mistakes.sh PAGE PROGRAM [AT_ONCE]    AT_ONCE: setters are refused when they are called (C++)
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sed -n 's/^    \(NSDAE_E_.*\|NSDAE_WARN_.*\|doubted: .*\)/\1/p' "$1" >"$work/expected"
[ "$#" -lt 3 ] || sed -i 's/nsdae_system_set_[a-z_]* was refused: //' "$work/expected"
"$2" >"$work/said"
diff "$work/expected" "$work/said"
! grep -v '^NSDAE_E_\|^NSDAE_WARN_\|^doubted: ' "$work/said"
[ "$(wc -l <"$work/said")" -gt 20 ]
echo "$(wc -l <"$work/said") mistakes, each named"
