# Fills the sections "callbacks.list: NAME" .. "callbacks.list: end" of a file from the list.
# usage: awk -f callbacks.awk callbacks.list FILE

FNR == NR { read_list(); next }
skipping && /callbacks\.list: end/ { skipping = 0 }
skipping { next }
{ print }
/callbacks\.list: [a-z_]+/ && !/callbacks\.list: end/ {
  match($0, /callbacks\.list: [a-z_]+/)
  emit(substr($0, RSTART + 16, RLENGTH - 16))
  skipping = 1
}
END { if (skipping) { print "callbacks.awk: a section has no end" > "/dev/stderr"; exit 1 } }

# ---- the list

function read_list(   i, part) {
  if ($0 ~ /^-/) { remark[++remarks] = $0; return }
  if ($0 ~ /^#/ || NF == 0) return
  n++
  name[n] = $1; type[n] = $2; needs[n] = $5
  has_v[n] = $3 ~ /v/
  for (i = 1; i <= remarks; i++) text[n, i] = remark[i]
  texts[n] = remarks
  remarks = 0
  gsub(/nv,nv/, "nv;nv", $4); gsub(/\[m,nv/, "[m;nv", $4); gsub(/\[nv,/, "[nv;", $4)
  outs[n] = split($4, part, ",")
  for (i = 1; i <= outs[n]; i++) read_output(n, i, part[i])
}

# W[nv;k]? : out, rows, cols ("" for a vector), rows "" for a scalar
function read_output(c, i, spec,   shape) {
  nullable[c, i] = spec ~ /\?$/
  out[c, i] = spec; sub(/\[.*/, "", out[c, i])
  match(spec, /\[.*\]/)
  split(substr(spec, RSTART + 1, RLENGTH - 2) ";", shape, ";")
  rows[c, i] = shape[1]; cols[c, i] = shape[2]
}

# ---- lines that fill up to the width: items are joined by ", "

# head item, item, ... tail; further lines are indented by indent and end, where they go on, with more
function filled(head, items, count, tail, indent, width, more,   line, i, piece, lines) {
  line = head
  for (i = 1; i <= count; i++) {
    piece = items[i] (i < count ? "," : tail)
    if (i > 1 && length(line) + 1 + length(piece) + (i < count ? length(more) : 0) > width) {
      lines = lines line more "\n"
      line = sprintf("%" indent "s", "") piece
    } else line = line (i > 1 ? " " : "") piece
  }
  return lines line
}

function comment(c, language, first, next_line, last,   i, lines, line) {
  for (i = 1; i <= texts[c]; i++) {
    line = text[c, i]
    if (line !~ "^-" language "? ") continue
    sub(/^-[cf]? /, "", line)
    lines = lines (lines == "" ? first : "\n" next_line) line
  }
  return lines last
}

# ---- what each section holds

function emit(section,   c) {
  if (section == "holders") print "  /* clang-format off */"
  if (section == "table") print "| callback | arguments before `user` | shapes |\n|---|---|---|"
  for (c = 1; c <= n; c++) {
    if (section == "types") c_type(c)
    else if (section == "declarations") c_declaration(c)
    else if (section == "list") c_entry(c)
    else if (section == "holders") cpp_holder(c)
    else if (section == "members") cpp_member(c)
    else if (section == "interfaces") f_interface(c)
    else if (section == "procedures") f_procedure(c)
    else if (section == "public_types") print "  public :: nsdae_" type[c] "_fn"
    else if (section == "public_setters") print "  public :: nsdae_system_set_" name[c]
    else if (section == "c_setters") f_c_setter(c)
    else if (section == "f_setters") f_setter(c)
    else if (section == "calls") f_call(c)
    else if (section == "table") f_table(c)
    else { print "callbacks.awk: no section " section > "/dev/stderr"; exit 1 }
  }
  if (section == "holders") print "  /* clang-format on */"
}

# ---- C

function ld(c, i) { return "ld" tolower(out[c, i]) }

# arguments of the callback in C into arg; with types
function c_arguments(c, last,   i) {
  delete arg
  args = 0
  arg[++args] = "double t"; arg[++args] = "const double *q"
  if (has_v[c]) arg[++args] = "const double *v"
  for (i = 1; i <= outs[c]; i++) {
    arg[++args] = "double *" out[c, i]
    if (cols[c, i] != "") arg[++args] = "int " ld(c, i)
  }
  if (last != "") arg[++args] = last
}

function c_type(c,   head) {
  print comment(c, "c", "/* ", " * ", " */")
  c_arguments(c, "void *user")
  head = "typedef int (*nsdae_" type[c] "_fn)("
  print filled(head, arg, args, ");", length(head), 100, "")
}

function c_declaration(c,   head, item) {
  head = "NSDAE_API int nsdae_system_set_" name[c] "("
  item[1] = "nsdae_system *system"; item[2] = "nsdae_" type[c] "_fn callback"
  print filled(head, item, 2, ");", length(head), 100, "")
}

function kind(size) {
  if (size == "nq") return "COORDINATE"
  if (size == "nv") return "VELOCITY"
  if (size == "m") return "CONSTRAINT"
  if (size ~ /^k/) return "CONTACT"
  return size == "f" ? "FRICTIONAL_JOINT" : "-1"
}

# what a system must have for it
function of(c,   what) {
  what["-"] = "ANY"; what["m"] = "CONSTRAINTS"; what["k"] = "CONTACTS"; what["k*nt"] = "DIRECTIONS"
  what["f"] = "JOINTS"; what["k+f"] = "SLIDING"
  return what[needs[c]]
}

# an entry of the list in C: name, type, of, arguments, outputs
function c_entry(c,   i, item, count, arguments) {
  if (has_v[c]) arguments = ", at->v"
  for (i = 1; i <= outs[c]; i++) {
    arguments = arguments ", out[" i - 1 "]"
    if (cols[c, i] != "") arguments = arguments ", ld[" i - 1 "]"
  }
  item[++count] = name[c]; item[++count] = "nsdae_" type[c] "_fn"; item[++count] = of(c)
  item[++count] = "(" substr(arguments, 3) ")"; item[++count] = outs[c]
  for (i = 1; i <= outs[c]; i++)
    item[++count] = (i > 1 ? "" : "{") "{\"" out[c, i] "\", " kind(rows[c, i]) ", " kind(cols[c, i]) \
      ", " ((rows[c, i] cols[c, i]) ~ /\*nt/) ", " nullable[c, i] + 0 "}" (i < outs[c] ? "" : "}")
  print filled("  X(", item, count, ")", 4, 98, " \\") " \\"
}

# ---- C++

function cpp_holder(c,   head, i) {
  c_arguments(c, "")
  for (i = 1; i <= args; i++) sub(/ ?[A-Za-z_]+$/, "", arg[i])
  head = "  callback<"
  print filled(head, arg, args, "> " name[c] ";", length(head), 100, "")
}

function cpp_member(c) {
  print comment(c, "c", "  /* ", "   * ", "")
  c_arguments(c, "")
  print filled("   *   f(", arg, args, ") */", 9, 100, "")
  print "  template <class F> system &" name[c] "(F f)\n  {\n    return keep(NSDAE_CALLBACK(" name[c] "), std::move(f));\n  }"
}

# ---- Fortran

function size_of(size) { gsub(/[a-z]+/, "dims%&", size); gsub(/\*/, " * ", size); return size }

function f_interface(c,   i, count, item, head) {
  print comment(c, "f", "    ! ", "    ! ", "")
  count = f_names(c, item, "", "user")
  head = "    integer(c_int) function nsdae_" type[c] "_fn("
  print filled(head, item, count, ")", 8, 98, " &")
  print "      import"
  print "      real(c_double), intent(in) :: t, q(:)" (has_v[c] ? ", v(:)" : "")
  delete item
  for (i = 1; i <= outs[c]; i++)
    item[i] = out[c, i] (cols[c, i] != "" ? "(:, :)" : rows[c, i] != "" ? "(:)" : "")
  print filled("      real(c_double), intent(inout) :: ", item, outs[c], "", 10, 98, " &")
  print "      class(*), intent(inout) :: user"
  print "    end function"
}

# names of the arguments into item; ld after matrices where it is asked for
function f_names(c, item, with_ld, last,   i, count) {
  item[++count] = "t"; item[++count] = "q"
  if (has_v[c]) item[++count] = "v"
  for (i = 1; i <= outs[c]; i++) {
    item[++count] = out[c, i]
    if (cols[c, i] != "" && with_ld != "") item[++count] = with_ld
  }
  item[++count] = last
  return count
}

function f_procedure(c) {
  print "    procedure(nsdae_" type[c] "_fn), pointer, nopass :: " name[c] " => null()"
}

function f_c_setter(c) {
  print "    integer(c_int) function c_set_" name[c] "(system, callback) &"
  print "        bind(C, name='nsdae_system_set_" name[c] "')"
  print "      import"
  print "      type(c_ptr), value :: system"
  print "      type(c_funptr), value :: callback"
  print "    end function"
}

function f_setter(c,   head) {
  head = "  integer(c_int) function nsdae_system_set_" name[c] "(system, " name[c] ")"
  print head (length(head) > 84 ? " &\n      result(status)" : " result(status)")
  print "    type(nsdae_system), intent(in) :: system"
  print "    procedure(nsdae_" type[c] "_fn) :: " name[c]
  print "    status = c_set_" name[c] "(at(system), c_funloc(call_" name[c] "))"
  print "    if (status == NSDAE_OK) system%model%" name[c] " => " name[c]
  print "  end function\n"
}

function f_call(c,   i, count, item, vectors, pointers) {
  count = f_names(c, item, "ld", "user")
  print filled("  integer(c_int) function call_" name[c] "(", item, count, ") &", 6, 98, " &")
  print "      result(status) bind(C, name='')"
  print "    real(c_double), value :: t"
  print "    real(c_double), intent(in) :: q(*)" (has_v[c] ? ", v(*)" : "")
  for (i = 1; i <= outs[c]; i++)
    if (cols[c, i] != "") print "    integer(c_int), value :: ld"
  for (i = 1; i <= outs[c]; i++) {
    if (nullable[c, i]) pointers = pointers out[c, i] ", "
    else vectors = vectors (vectors == "" ? "" : ", ") out[c, i] \
      (cols[c, i] != "" ? "(ld, *)" : rows[c, i] != "" ? "(*)" : "")
  }
  if (vectors != "") print "    real(c_double), intent(inout) :: " vectors
  print "    type(c_ptr), value :: " pointers "user"
  print "    type(model), pointer :: here"
  print "    here => model_at(user)"
  print "    associate (dims => here%dims)"
  delete item
  count = 0
  item[++count] = "t"; item[++count] = "q(:dims%nq)"
  if (has_v[c]) item[++count] = "v(:dims%nv)"
  for (i = 1; i <= outs[c]; i++) item[++count] = f_shaped(c, i)
  item[++count] = "here%user"
  print filled("      status = here%" name[c] "(", item, count, ")", 10, 98, " &")
  print "    end associate"
  print "  end function\n"
}

function f_shaped(c, i) {
  if (nullable[c, i]) return "array_at(" out[c, i] ", " size_of(rows[c, i]) ")"
  if (cols[c, i] != "") return out[c, i] "(:" size_of(rows[c, i]) ", :" size_of(cols[c, i]) ")"
  return out[c, i] (rows[c, i] != "" ? "(:" size_of(rows[c, i]) ")" : "")
}

function f_table(c,   i, item, shapes, count, line) {
  count = f_names(c, item, "", "")
  for (i = 1; i < count; i++) line = line (i > 1 ? ", " : "") item[i]
  for (i = 1; i <= outs[c]; i++)
    shapes = shapes (i > 1 ? ", " : "") (rows[c, i] == "" ? "a scalar" : "`" out[c, i] "(" rows[c, i] \
      (cols[c, i] != "" ? ", " cols[c, i] : "") ")`")
  gsub(/\*/, " ", shapes)
  print "| `" name[c] "` | `" line "` | " shapes " |"
}
