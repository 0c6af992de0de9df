# Makes a shell script of a chapter: blocks after "<!-- file: NAME -->" are put into that file, one
# after the other; blocks "console" become: run 'LINE' 'COMMAND' with what it must print as its input.

function quoted(text) {
  gsub(/'/, "'\\''", text)
  return "'" text "'"
}

function end_command() {
  if (command) print "CHAPTER_END"
  command = 0
}

/^<!-- file: .* -->$/ { file = $3; next }

/^```/ && !kind {
  kind = substr($0, 4)
  if (kind ~ /^(c|cpp|python|matlab|julia|fortran|sh)$/ && file == "") {
    printf "%s:%d: a block of code without a file\n", FILENAME, FNR > "/dev/stderr"
    exit 1
  }
  if (kind != "console") printf "cat >>%s <<'CHAPTER_END'\n", quoted(file)
  next
}

/^```$/ {
  if (kind == "console") end_command()
  else print "CHAPTER_END"
  kind = file = ""
  next
}

kind == "console" && /^\$ / {
  end_command()
  printf "run %d %s <<'CHAPTER_END'\n", FNR, quoted(substr($0, 3))
  command = 1
  next
}

kind { print }

END { if (kind) { print FILENAME ": a block is not closed" > "/dev/stderr"; exit 1 } }
