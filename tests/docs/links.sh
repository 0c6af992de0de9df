#!/bin/sh
# Every link of the documentation that is not to the web resolves: files and headings; and every file of the source and
# every name of the library in a page exists. Not in blocks of code.
# usage: links.sh SOURCE_DIR
set -eu
export LC_ALL=C # the order of sort and comm
cd "$1"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
find . -name '*.md' -not -path './build*' -not -path './.git/*' | sed 's,^\./,,' | sort >"$work/pages"
[ -s "$work/pages" ]

# "PAGE TARGET" of each link in a page
xargs awk '
  FNR == 1 { code = 0 }
  /^ *```/ { code = !code; next }
  code || /^    / { next }
  {
    gsub(/`[^`]*`/, "")
    while (match($0, /\]\([^)]*\)/)) {
      print FILENAME, substr($0, RSTART + 2, RLENGTH - 3)
      $0 = substr($0, RSTART + RLENGTH)
    }
  }' <"$work/pages" >"$work/links"
# "PAGE PATH" of each file or folder of the source that a page names in code, without placeholders
xargs awk '
  FNR == 1 { code = 0 }
  /^ *```/ { code = !code; next }
  code || /^    / { next }
  {
    while (match($0, /`[^`]*`/)) {
      name = substr($0, RSTART + 1, RLENGTH - 2)
      $0 = substr($0, RSTART + RLENGTH)
      if (name ~ /^(lib|include|drivers|tests|python|docs|data|cmake|packaging)\/[A-Za-z0-9_.\/-]*\.[a-z0-9]+$/ && name !~ /NAME/) print FILENAME, name
    }
  }' <"$work/pages" >"$work/names"

# A heading as the web shows it: "# When it runs" is when-it-runs.
anchors() { sed -n 's/^#\{1,6\} *//p' "$1" | tr 'A-Z ' 'a-z-' | tr -cd 'a-z0-9_\n-'; }

broken=0
while read -r page target; do
  case $target in http://* | https://* | mailto:*) continue ;; esac
  file=${target%%#*}
  [ -z "$file" ] && path=$page || path=$(dirname "$page")/$file
  if [ ! -e "$path" ]; then
    echo "FAILED: $page: no $target"
    broken=$((broken + 1))
  elif [ "$file" != "$target" ] && ! anchors "$path" | grep -qxF -- "${target#*#}"; then
    echo "FAILED: $page: no heading ${target#*#} in $path"
    broken=$((broken + 1))
  fi
done <"$work/links"
while read -r page name; do
  [ -e "$name" ] && continue
  echo "FAILED: $page: no file $name"
  broken=$((broken + 1))
done <"$work/names"
# and every function, type and constant of the library that a page names; what is gone has its place in the changelog
grep -ohE '\b(nsdae|NSDAE)_[A-Za-z0-9_]*[A-Za-z0-9]\b' -r include lib cmake CMakeLists.txt tests/CMakeLists.txt | sort -u >"$work/known"
grep -vx 'CHANGELOG.md' "$work/pages" | while read -r page; do
  grep -ohE '`[^`]*`' "$page" | grep -oE '\b(nsdae|NSDAE)_[A-Za-z0-9_]*[A-Za-z0-9]\b' | sort -u | comm -23 - "$work/known" |
    sed "s|^|$page |"
done >"$work/unknown"
while read -r page name; do
  echo "FAILED: $page: the library has no $name"
  broken=$((broken + 1))
done <"$work/unknown"
echo "$(wc -l <"$work/pages") pages, $(wc -l <"$work/links") links, $(wc -l <"$work/names") files, $broken broken"
[ "$broken" = 0 ]
