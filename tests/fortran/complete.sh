#!/bin/sh
# Whatever the C headers declare (functions, types, constants, fields), the module nsdae has: programs
# that use every name compile; and the test layout looks at the place of every field.
# Complementarity problems come and go as plain arrays, solids free their allocatable ones.
# usage: complete.sh INCLUDE_DIR MODULE_DIR COMPILER SOURCE_DIR
set -eu
include=$1
modules=$2
compiler=$3
source=$4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$include/nsdae"

# without comments and directives
cat ./*.h |
  sed -e ':a; s,/\*[^*]*\*\+\([^/*][^*]*\*\+\)*/,,g; /\/\*/{N; ba}' -e '/^#/d' >"$work/text"
{
  grep -oE 'nsdae_[a-z0-9_]+ *\(' "$work/text" | tr -d ' ('   # functions
  grep -oE 'nsdae_[a-z_]+_fn' "$work/text"                    # callbacks
  grep -oE '^(typedef struct|typedef struct [a-z_]+;|\}) nsdae_[a-z_]+' "$work/text" |
    grep -oE 'nsdae_[a-z_]+$'                                 # types
  grep -oE '\bNSDAE_[A-Z_]+\b' "$work/text" |
    grep -vE '^NSDAE_(API|[A-Z_]+_(LIST|ENUM))$' || true       # constants
  grep -oE 'X\(NSDAE_[A-Z_]+' status.h | tr -d 'X('           # statuses
} | sort -u | grep -vxE 'nsdae_(lcp_(problem|file|file_release)|friction_points|solid_release)' >"$work/names"
printf '%s names\n' "$(wc -l <"$work/names")"
[ "$(wc -l <"$work/names")" -gt 150 ]

{
  echo "program all"
  while read -r name; do echo "  use nsdae, only: $name"; done <"$work/names"
  echo "end program"
} >"$work/all.f90"
"$compiler" -I"$modules" -fsyntax-only "$work/all.f90"

# "struct field" of every struct
awk '/^typedef struct [a-z_]+ \{/ {name = $3; text = ""; next}
     /^\}/ {
       n = split(name == "" ? "" : text, declarations, ";")
       for (i = 1; i < n; i++) {
         m = split(declarations[i], parts, ",")
         for (j = 1; j <= m; j++) {
           sub(/\[.*/, "", parts[j])
           words = split(parts[j], word, /[ *]+/)
           print name, word[words]
         }
       }
       name = ""
     }
     {text = text " " $0}' "$work/text" >"$work/fields"
printf '%s fields\n' "$(wc -l <"$work/fields")"
[ "$(wc -l <"$work/fields")" -gt 90 ]

# what the module turns into a type of its own has the struct as nsdae_c_<name>
{
  echo "program fields"
  for module in "$modules"/nsdae_f_*.mod; do echo "  use $(basename "$module" .mod)"; done
  echo "  use, intrinsic :: iso_c_binding"
  for struct in $(cut -d' ' -f1 "$work/fields" | uniq); do
    type=nsdae_c_${struct#nsdae_}
    grep -qE "(public ::|headers: type) $type\$" "$source"/lib/fortran/*.f90 || type=$struct
    echo "  type($type) :: ${struct}_x"
  done
  while read -r struct field; do echo "  print *, c_sizeof(${struct}_x%$field)"; done <"$work/fields"
  echo "end program"
} >"$work/fields.f90"
"$compiler" -I"$modules" -fsyntax-only "$work/fields.f90"

# the first field of a struct is where the struct begins
previous=""
while read -r struct field; do
  if [ "$struct" = "$previous" ] && ! grep -q "AT($struct, $field)" "$source/tests/fortran/layout.c"; then
    echo "layout.c does not look at the place of $struct.$field"
    exit 1
  fi
  previous=$struct
done <"$work/fields"
