# The public headers as Doxygen wants them: input filter of docs/Doxyfile.in.
#   the first comment of a file          documents the file
#   a comment after code                 documents what stands before it
#   any other comment                    documents what follows; declarations that follow it without
#                                        a blank line share it
#   a comment after "double a, b;"        documents each of them
#   lines indented further than the rest  are kept as they are: equations, arguments, tables

# Text of a comment's line: markup that is meant literally.
function literal(text) {
  gsub(/[\\@<>#]/, "\\\\&", text)
  return text
}

# A line of a comment's inside: "   * text". Further indented than by one blank: verbatim.
function inside(line,   indent) {
  ended = sub(/ *\*\/.*$/, "", line)
  sub(/^ *\*?/, "", line)
  match(line, /^ */)
  indent = RLENGTH
  if (line ~ /^ *$/) return (verbatim ? close_verbatim() : "") line
  if (indent >= 3 && !trailing) return (verbatim ? "" : open_verbatim()) line
  return (verbatim ? close_verbatim() : "") literal(line)
}
function open_verbatim() { verbatim = 1; return "@verbatim " }
function close_verbatim() { verbatim = 0; return "@endverbatim " }

# What a line declares: a function or a macro.
function name_of(line) {
  if (match(line, /^#define [A-Z_]+/)) return substr(line, 9, RLENGTH - 8)
  return match(line, /nsdae_[a-z_0-9]+\(/) ? substr(line, RSTART, RLENGTH - 1) : ""
}

# "double a, b;" with its comment in one line: one declaration each.
function split_fields(code, comment,   type, names, n, i, out) {
  match(code, /^ *(const )?[a-z_]+ /)
  type = substr(code, 1, RLENGTH)
  sub(/; *$/, "", code)
  n = split(substr(code, RLENGTH + 1), names, ", ")
  for (i = 1; i <= n; i++) out = out type names[i] "; /**< " comment " */"
  return out
}

function finish(out) {
  if (!ended) return out
  open = 0
  return out (verbatim ? " " close_verbatim() : "") " */"
}

# what a generator or the formatter is told
/^ *\/\* (callbacks\.list: [a-z_]+|clang-format (on|off)) \*\/$/ { next }

/^#define NSDAE_(CALLBACK|OWN)/ { undocumented = 1 }
undocumented { undocumented = /\\$/; next }
/^#undef NSDAE_(CALLBACK|OWN)|^  NSDAE_OWN\(/ { next }

# what nsdae.hpp has for itself
/^namespace detail/ { private = 1 }
private { private = !/^} \/\/ namespace detail/; next }

open { print finish(inside($0)); next }

# a comment begins here
/\/\*/ {
  at = index($0, "/*")
  code = substr($0, 1, at - 1)
  trailing = code ~ /[^ ]/
  head = trailing ? "/**< " : seen++ ? "/** " : "/** @file\n"
  if (code ~ /^ [^(]*, [^(]*; *$/ && $0 ~ /\*\/$/) {
    print split_fields(code, inside(substr($0, at + 2)))
    next
  }
  open = 1
  documented = !trailing
  print code head finish(inside(substr($0, at + 2)))
  next
}

/^ *$/ { documented = 0; last = ""; print; next }

# a function or a macro: it has a comment, or shares that of the one before it
/^(NSDAE_API|#define) / && name_of($0) != "" {
  if (documented) last = name_of($0)
  else if (last != "") print "/** @copydoc " last " */"
  documented = 0
}

# an enum from its list: the last text of an item describes it
/^#define NSDAE_[A-Z_]+_LIST\(X\)/ { items = "" }
/^ *X\(/ {
  item = $0
  sub(/^ *X\(/, "", item)
  split(item, field, ", ")
  text = item
  sub(/"\).*$/, "", text)
  sub(/^.*"/, "", text)
  items = items "  " field[1] " = " field[2] ", /**< " literal(text) " */\n"
}
/^#(define|undef) NSDAE_[A-Z_]+_ENUM/ { next }
/^ *NSDAE_[A-Z_]+_LIST\(/ { printf "%s", items; next }

{ print }
