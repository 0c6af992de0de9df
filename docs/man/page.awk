# A driver's man page: its template with the lines %SECTION% replaced by that section of its --help,
# %summary% by what --help says first and %about% by the file of that name.
# Lines after %compare% are for the drivers that have --compare.
# usage: awk -f page.awk -v about=FILE HELP TEMPLATE

# Text of the page in lines of at most 78 characters, none of which is taken for a request.
function escaped(text,   word, words, i, line, lines) {
  gsub(/\\/, "\\e", text)
  words = split(text, word, " ")
  for (i = 1; i <= words; i++)
    if (line != "" && length(line " " word[i]) > 78) {
      lines = lines guarded(line) "\n"
      line = word[i]
    } else line = line == "" ? word[i] : line " " word[i]
  return lines guarded(line)
}

function guarded(line) { return line ~ /^[.']/ ? "\\&" line : line }

function number(text) { # minus signs that can be copied
  gsub(/-/, "\\-", text)
  return text
}

# "--dt S          step": the first 24 columns are the left side
function flag(line,   left, word, n) {
  left = substr(line, 3, 24)
  n = split(left, word, " ")
  if (word[1] == "-h,") return ".It Fl h , Fl -help\n" escaped(substr(line, 28))
  return ".It Fl " substr(word[1], 2) (n > 1 ? " Ar " word[2] : "") "\n" escaped(substr(line, 28))
}

function method(line,   word) {
  split(line, word, " ")
  return ".It Cm " number(word[1]) "\n" escaped(substr(line, 28))
}

# "dt    0.005    step [s]"
function setting(line,   word, text) {
  split(line, word, " ")
  text = line
  sub(/^ *[^ ]+ +[^ ]+ +/, "", text)
  return ".It Cm " word[1] " No = " (word[2] == "\"\"" ? "\\(dq\\(dq" : number(word[2])) "\n" escaped(text)
}

FNR == 1 { file++ }

file == 1 && FNR == 1 { summary = $0; sub(/^[^:]*: /, "", summary); section = "flags"; next }
file == 1 && /^[a-z]/ { if ($1 != "usage:") section = $1; next }
file == 1 && /^  --compare/ { compares = 1 }
file == 1 && /^  / {
  item = section == "flags" ? flag($0) : section == "methods" ? method($0) : setting($0)
  items[section] = items[section] item "\n"
  next
}

file == 2 && /^%[a-z]+%$/ {
  name = substr($0, 2, length($0) - 2)
  if (name == "about") while ((getline line < about) > 0) print line
  else if (name in items) printf ".Bl -tag -width Ds\n%s.El\n", items[name]
  else if (name != "summary") { print "page.awk: --help has no section " name > "/dev/stderr"; exit 1 }
  next
}
file == 2 && sub(/^%compare%/, "") && !compares { next }
file == 2 { gsub(/%summary%/, summary); print }
