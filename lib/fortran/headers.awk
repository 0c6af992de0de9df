# Writes behind the markers of a module what the C headers declare:
#
#   ! headers: functions nsdae_sim_ create step    the interfaces c_create, c_step of nsdae_sim_create, nsdae_sim_step
#   ! headers: wrappers nsdae_sim_ step            the function nsdae_sim_step of a type(nsdae_sim), by c_step and at
#   ! headers: constants NSDAE_MODE_ NSDAE_OK      all constants whose names begin so
#   ! headers: type nsdae_c_record                 the struct nsdae_record
#
# usage: see fill.sh

pass == "headers" { read_header($0); next }
pass == "modules" { # the structs that have a type nsdae_c_<name> beside the one of the user
  if (match($0, /nsdae_c_[a-z_]+/)) mirrored[substr($0, RSTART + 8, RLENGTH - 8)] = 1
  next
}
{ print }
/^ *! headers: functions / { for (i = 5; i <= NF; i++) write_function($4 $i, "c_" $i) }
/^ *! headers: wrappers / { for (i = 5; i <= NF; i++) write_wrapper($4 $i, "c_" $i) }
/^ *! headers: constants / { for (i = 4; i <= NF; i++) write_constants($i) }
/^ *! headers: type / { write_type(substr($4, 9)) }

function fail(message) { print FILENAME ": " message > "/dev/stderr"; failed = 1; exit 1 }

# ---- the headers: prototypes, enumerators, members of structs, without comments

function read_header(line,   part, name, value) {
  if (match(line, /X\(NSDAE_[A-Z_]+, -?[0-9]+/)) { # an entry of a list that makes an enum
    split(substr(line, RSTART + 2, RLENGTH - 2), part, ", ")
    add_constant(part[1], part[2])
  }
  while (match(line, /\/\*[^*]*(\*+[^*\/][^*]*)*\*+\//)) line = substr(line, 1, RSTART - 1) substr(line, RSTART + RLENGTH)
  if (in_comment) {
    if (!match(line, /\*\//)) return
    line = substr(line, RSTART + 2)
    in_comment = 0
  }
  if (match(line, /\/\*/)) { line = substr(line, 1, RSTART - 1); in_comment = 1 }
  if (line ~ /^#/ || line ~ /^extern/ || line ~ /^  [A-Z]+_[A-Z_]+\(/) return
  text = text " " line
  if (text ~ /NSDAE_API/) {
    if (text !~ /;/) return
    sub(/.*NSDAE_API /, "", text)
    name = text; sub(/ *\(.*/, "", name); sub(/.*[ *]/, "", name)
    prototype[name] = text
  } else if (text ~ /^ *enum .*\{/) {
    if (text !~ /\}/) return
    read_enum(text)
  } else if (text ~ /typedef struct [a-z_]+ \{/) {
    if (text !~ /\} [a-z_]+;/) return
    name = text; sub(/.*\} /, "", name); sub(/;.*/, "", name)
    sub(/.*typedef struct [a-z_]+ \{/, "", text); sub(/\}.*/, "", text)
    members[name] = text
  } else if (text !~ /;|\}|\)$/) return
  text = ""
}

function read_enum(body,   item, count, i, part, value) {
  sub(/.*\{/, "", body); sub(/\}.*/, "", body)
  value = -1
  count = split(body, item, ",")
  for (i = 1; i <= count; i++) {
    gsub(/ /, "", item[i])
    if (item[i] == "") continue
    value = split(item[i], part, "=") > 1 ? part[2] : value + 1
    add_constant(part[1], value)
  }
}

function add_constant(name, value) { constant[++constants] = name; value_of[name] = value }

# ---- C types in Fortran

function number(c) {
  return c == "double" ? "real(c_double)" : c == "long" ? "integer(c_long)" : \
    c == "size_t" ? "integer(c_size_t)" : c ~ /^(int|enum [a-z_]+)$/ ? "integer(c_int)" : ""
}

function struct(c,   name) {
  name = c; sub(/^nsdae_/, "", name)
  return "type(" (name in mirrored ? "nsdae_c_" name : c) ")"
}

# base, stars, length of "const double *x[3]" into the globals; returns the name
function read_declarator(words,   name) {
  constant_type = words ~ /^ *const /
  gsub(/const /, "", words)
  length_of = ""
  if (match(words, /\[[^]]*\]/)) { length_of = substr(words, RSTART + 1, RLENGTH - 2); words = substr(words, 1, RSTART - 1) }
  stars = gsub(/\*/, "", words)
  gsub(/^ +| +$/, "", words)
  name = words; sub(/.* /, "", name)
  base = words; sub(/ *[A-Za-z_0-9]+$/, "", base)
  return name
}

# ---- what is written

function write_constants(prefix,   i, found) {
  for (i = 1; i <= constants; i++) {
    if (index(constant[i], prefix) != 1) continue
    print "  integer(c_int), parameter, public :: " constant[i] " = " value_of[constant[i]]
    found = 1
  }
  if (!found) fail("no constant " prefix)
}

function write_type(name,   item, count, i, parts, part, k, first, declared) {
  if (!("nsdae_" name in members)) fail("no struct nsdae_" name)
  print "  type, bind(C), public :: nsdae_c_" name
  count = split(members["nsdae_" name], item, ";")
  for (i = 1; i < count; i++) {
    parts = split(item[i], part, ",")
    for (k = 1; k <= parts; k++) {
      declared = read_declarator(k == 1 ? part[1] : first " " part[k])
      if (k == 1) first = base
      print "    " member_type() " :: " declared (length_of == "" ? "" : "(" length_of ")") initial()
    }
  }
  print "  end type"
}

function member_type() {
  if (stars) return "type(c_ptr)"
  if (base ~ /_fn$/) return "type(c_funptr)"
  if (base == "char") return "character(kind=c_char)"
  return number(base) != "" ? number(base) : struct(base)
}

function initial() {
  if (stars) return " = c_null_ptr"
  if (base ~ /_fn$/) return " = c_null_funptr"
  if (base == "char") return " = c_null_char"
  return number(base) != "" ? " = 0" : ""
}

# The arguments of a prototype into item; their count.
function read_prototype(name, item,   list) {
  if (!(name in prototype)) fail("no function " name)
  list = prototype[name]; sub(/^[^(]*\(/, "", list); sub(/\) *;.*/, "", list)
  result = substr(prototype[name], 1, index(prototype[name], name) - 1)
  result = result ~ /\*/ ? "type(c_ptr) function" : result ~ /void/ ? "subroutine" : "integer(c_int) function"
  return list == "void" ? 0 : split(list, item, ",")
}

function write_function(name, ours,   item, count, i, dummy, names, lines, many) {
  count = read_prototype(name, item)
  for (i = 1; i <= count; i++) {
    dummy = read_declarator(item[i])
    names = names (i > 1 ? ", " : "") dummy
    lines = lines "      " argument(dummy, many) "\n"
    many = dummy == "n"
  }
  print statement("    " result " " ours "(", names ")", "bind(C, name='" name "')")
  print "      import"
  printf "%s", lines
  sub(/.* /, "", result)
  print "    end " result
}

# On one line, or on two.
function statement(head, names, tail) {
  return head names " " (length(head names tail) < 98 ? "" : "&\n        ") tail
}

# A status, or a text: of the first argument, an object, and of numbers and structs.
function write_wrapper(name, ours,   item, count, i, dummy, names, given, lines, text) {
  count = read_prototype(name, item)
  text = result ~ /c_ptr/
  for (i = 1; i <= count; i++) {
    dummy = read_declarator(item[i])
    names = names (i > 1 ? ", " : "") dummy
    given = given (i > 1 ? ", " : "") (stars && !(base in members) ? "at(" dummy ")" : dummy)
    lines = lines "    " (stars ? "type(" base ")" : number(base)) ", intent(" \
      (stars && base in members && !constant_type ? "inout" : "in") ") :: " dummy "\n"
  }
  print statement("  " (text ? "function " : "integer(c_int) function ") name "(", names ")", "result(answer)")
  printf "%s", lines
  if (text) print "    character(len=:), allocatable :: answer"
  print "    answer = " (text ? "from_c(" ours "(" given "))" : ours "(" given ")")
  print "  end function"
}

# many: the argument before was a count n
function argument(dummy, many,   intent, shape) {
  intent = ", intent(" (constant_type ? "in" : "inout") ")"
  shape = dummy ~ /^(mass|residual|n|size)$/ ? "" : "(*)" # numbers that are returned alone
  if (base ~ /_fn$/) return "type(c_funptr), value :: " dummy
  if (base == "void") return dummy == "block" ? "type(*)" intent " :: block(*)" : "type(c_ptr), value :: " dummy
  if (!stars && length_of == "") return number(base) ", value :: " dummy
  if (base == "char") return stars == 2 ? "type(c_ptr), intent(in) :: " dummy "(*)" : "character(kind=c_char)" intent " :: " dummy "(*)"
  if (number(base) != "") return number(base) intent " :: " dummy shape
  if (stars == 2) return "type(c_ptr), intent(inout) :: " dummy
  if (!(base in members)) return "type(c_ptr), value :: " dummy # opaque
  return struct(base) intent ", optional :: " dummy (many ? "(*)" : "")
}
