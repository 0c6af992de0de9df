#!/bin/sh
# Every link of the documentation that is not to the web resolves: files and headings. Not in code.
# usage: links.sh SOURCE_DIR
set -eu
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
echo "$(wc -l <"$work/pages") pages, $(wc -l <"$work/links") links, $broken broken"
[ "$broken" = 0 ]
