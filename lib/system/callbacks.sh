#!/bin/sh
# Compares the sections "callbacks.list: ..." of headers, sources and documentation with callbacks.list and ends
# with 1 if one differs; --write updates them. The build fills those of lib/fortran/system.f90.
# usage: callbacks.sh [--write]
set -eu
cd "$(dirname "$0")/../.."
new=$(mktemp)
trap 'rm -f "$new"' EXIT
stale=0
for file in $(grep -rlE "callbacks\.list: [a-z_]+" include lib docs |
  grep -v 'lib/system/callbacks[.]\(awk\|list\|sh\)\|lib/fortran/' || true); do
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
