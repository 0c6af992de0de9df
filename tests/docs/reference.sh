#!/bin/sh
# The reference of the headers: what the filter makes of them still compiles, Doxygen has nothing to warn of, and
# every exported function has its entry with a description. usage: reference.sh SOURCE_DIR DOXYFILE
set -eu
source=$1
doxyfile=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$source"

mkdir -p "$work/include/nsdae"
for header in include/nsdae/*.h; do
  awk -f docs/doxygen.awk "$header" >"$work/$header"
done
cc -std=c11 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I "$work/include" docs/examples/ball.c

command -v doxygen >/dev/null || { echo "no doxygen: not tested"; exit 77; }
sed "s,^OUTPUT_DIRECTORY.*,OUTPUT_DIRECTORY = $work," "$doxyfile" >"$work/Doxyfile"
echo 'GENERATE_XML = YES' >>"$work/Doxyfile"
doxygen "$work/Doxyfile" >"$work/warnings" 2>&1 || { cat "$work/warnings"; exit 1; }
[ ! -s "$work/warnings" ] || { cat "$work/warnings"; exit 1; }

# it opens on what this is, with pictures that move; every option has its row; C++ has its entries
for picture in woodpecker.gif cradle.gif; do
  grep -q "$picture" "$work/html/index.html" && [ -s "$work/html/$picture" ] || { echo "FAILED: no $picture"; exit 1; }
done
sed -n '/typedef struct nsdae_sim_options/,/} nsdae_sim_options/p' include/nsdae/sim.h |
  sed -n 's/^  \(int\|double\) \([a-z_, ]*\);.*/\2/p' | tr -d ' ' | tr ',' '\n' | grep -v initialised >"$work/fields"
[ "$(wc -l <"$work/fields")" -gt 15 ]
while read -r option; do
  grep -q ">$option<" "$work/html/options.html" || { echo "FAILED: no row for the option $option"; exit 1; }
done <"$work/fields"
grep -q 'class nsdae::trajectory' "$work"/xml/*.xml || grep -q '<compoundname>nsdae::trajectory<' "$work"/xml/*.xml

count=0
for function in $(sed -n 's/^NSDAE_API[^(]*\(nsdae_[a-z_0-9]*\)(.*/\1/p' include/nsdae/*.h); do
  # its entry: from the name to the end of the member, with a paragraph that is not empty
  cat "$work"/xml/*_8h.xml | tr '\n' ' ' | sed 's,</memberdef>,&\n,g' |
    grep "<name>$function</name>" | grep -q '<para>.*[a-z]' || {
    echo "FAILED: no description of $function"
    exit 1
  }
  count=$((count + 1))
done
echo "$count functions described, no warning"
[ $count -gt 50 ]
