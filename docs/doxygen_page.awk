# A page of the documentation for Doxygen: the first heading gets the page's place as its name, which
# would else come from where the sources lie, and links to other pages go by that name, for not every
# version of Doxygen finds a named page by its file. The main page has the name "index".

function name_of(path) {
  while (sub(/\/[^\/]+\/\.\.\//, "/", path));
  if (path ~ /docs\/guide\/README\.md$/) return "guide"
  if (path !~ /docs\//) return "index"
  if (!sub(/^(.*\/)?docs\//, "", path)) sub(/^.*\//, "", path)
  sub(/\.md$/, "", path)
  gsub(/[^A-Za-z]+/, "_", path)
  return path
}

FNR == 1 {
  here = FILENAME
  if (!sub(/[^\/]*$/, "", here)) here = ""
  if (/^# / && name_of(FILENAME) != "index") $0 = $0 " {#" name_of(FILENAME) "}"
}

{
  done = ""
  while (match($0, /\]\([^):#]*\.md\)/)) {
    target = substr($0, RSTART + 2, RLENGTH - 3)
    done = done substr($0, 1, RSTART + 1) "@ref " name_of(here target) ")"
    $0 = substr($0, RSTART + RLENGTH)
  }
  print done $0
}
