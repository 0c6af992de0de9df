#!/bin/sh
# What is written of each callback follows from callbacks.list. Says what is not current and ends with 1;
# with --write brings it up to date. usage: callbacks.sh [--write]
set -eu
cd "$(dirname "$0")/../.."
new=$(mktemp)
trap 'rm -f "$new"' EXIT
stale=0
for file in $(grep -rlE "callbacks\.list: [a-z_]+" include lib docs |
  grep -v 'lib/system/callbacks[.]\(awk\|list\|sh\)' || true); do
  awk -f lib/system/callbacks.awk lib/system/callbacks.list "$file" >"$new"
  cmp -s "$new" "$file" && continue
  if [ "${1-}" = --write ]; then
    cat "$new" >"$file"
    echo "written: $file"
  else
    echo "not current: $file (run lib/system/callbacks.sh --write)"
    diff "$file" "$new" || true
    stale=1
  fi
done
exit $stale
