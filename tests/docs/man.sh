#!/bin/sh
# The man pages: one for each program, without a warning of mandoc and man, with every option,
# method and setting of --help and its default; and the drivers' examples run as they stand there.
# usage: man.sh BIN_DIR MAN1_DIR
set -u
bin=$1
pages=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export PATH="$bin:$PATH"
failures=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

has() { command -v "$1" >/dev/null; }

# One line of words, as a terminal shows the page.
rendered() {
  if has mandoc; then
    mandoc -Tascii "$1"
  else
    nroff -mdoc -Tascii "$1"
  fi | sed 's/.\x08//g' | tr -s ' \t\n' ' '
}

lint() {
  if has mandoc; then
    mandoc -Tlint -Wstyle "$1" | grep -v 'referenced manual not found' # they are not installed here
  fi
  if has man && has groff; then
    LC_ALL=C.UTF-8 man --warnings -l -Tutf8 "$1" 2>&1 >/dev/null
  fi
}

has mandoc || has nroff || { echo "neither mandoc nor nroff: not tested"; exit 77; }

for program in "$bin"/nsdae-*; do
  name=$(basename "$program")
  page=$pages/$name.1
  [ -s "$page" ] || { fail "$name has no page"; continue; }
  lint "$page" >warnings
  [ ! -s warnings ] || fail "$(cat warnings)"
  rendered "$page" >text

  if ! "$program" --help >help 2>err; then
    grep -q 'no Python' err || fail "$name --help"
    continue
  fi
  options=$(grep -oE '(^|[ ,[])--?[a-z][a-z-]*' help | tr -d ' ,[' | sort -u)
  [ -n "$options" ] || fail "$name --help lists no options"
  for option in $options; do
    grep -qE -- "(^|[ [])$option( |,|\\]|\$)" text || fail "$name.1 lacks $option"
  done
  # the tables of a driver: methods, then "name default meaning"
  awk '/^methods$/ {on = 1; next} /^[a-z]/ {on = 0} on && NF {print $1}' help >items
  awk '/^(parameters|run|options)( |$)/ {on = 1; next} /^[A-Za-z]/ {on = 0} on && NF {print $1 " = " $2}' \
    help >>items
  while read -r item; do
    grep -qF -- " $item " text || fail "$name.1 lacks: $item"
  done <items
  echo "$name.1: $(echo "$options" | wc -l) options, $(wc -l <items) methods and settings"

  sed -n "s/^\\.Dl \\\$ \\($name .*\\)/\\1/p" "$page" >examples
  [ -s examples ] || fail "$name.1 has no example"
  case $name in
  nsdae-plot | nsdae-vtk | nsdae-animate | nsdae-view | nsdae-lcp | nsdae-friction | nsdae-scene) ;; # of files that are not here
  *) sh -e ./examples >out 2>&1 || fail "an example of $name.1: $(tail -1 out)" ;;
  esac
done

[ $failures = 0 ] && echo "all as expected"
exit $failures
