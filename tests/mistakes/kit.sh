#!/bin/sh
# The answers to the mistakes with the kit are those of the table in docs/guide/mistakes.md.
# usage: kit.sh PAGE PROGRAM
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sed -n 's/^| .* | `\(NSDAE_.*\)` |$/\1/p' "$1" >"$work/expected"
shift
"$@" >"$work/answers"
diff "$work/expected" "$work/answers"
[ "$(wc -l <"$work/answers")" -ge 20 ]
echo "$(wc -l <"$work/answers") mistakes with the kit, each named"
