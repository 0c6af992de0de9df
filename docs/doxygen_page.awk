# A page of the documentation for Doxygen: the first heading gets the page's place as its name, which
# would else come from where the sources lie, and links to other pages go by that name, for not every
# version of Doxygen finds a named page by its file. The main page has the name "index".
# A further heading gets the page's name and its own anchor, to which links to a heading go: Doxygen before 1.9.7 makes
# no anchors of its own.

function name_of(path) {
  while (sub(/\/[^\/]+\/\.\.\//, "/", path));
  if (path ~ /docs\/guide\/README\.md$/) return "guide"
  if (path ~ /(CONTRIBUTING|CHANGELOG)\.md$/) return path ~ /CONTRIBUTING/ ? "contributing" : "changelog"
  if (path !~ /docs\//) return "index"
  if (!sub(/^(.*\/)?docs\//, "", path)) sub(/^.*\//, "", path)
  sub(/\.md$/, "", path)
  gsub(/[^A-Za-z]+/, "_", path)
  return path
}

# As the web makes it: "## When it runs" is when-it-runs.
function anchor_of(heading) {
  sub(/^#+ */, "", heading)
  heading = tolower(heading)
  gsub(/ /, "-", heading)
  gsub(/[^a-z0-9_-]/, "", heading)
  return heading
}

# The name of what a link goes to: PAGE.md, PAGE.md#HEADING or #HEADING.
function target_of(link,   page, heading) {
  page = heading = link
  sub(/#.*/, "", page)
  if (!sub(/^[^#]*#/, "", heading)) heading = ""
  page = name_of(page == "" ? FILENAME : here page)
  return heading == "" ? page : page "-" heading
}

FNR == 1 {
  here = FILENAME
  if (!sub(/[^\/]*$/, "", here)) here = ""
  if (/^# / && name_of(FILENAME) != "index") $0 = $0 " {#" name_of(FILENAME) "}"
}

/^ *```/ { code = !code }

!code && /^##+ / {
  anchor = name_of(FILENAME) "-" anchor_of($0)
  if (!named[anchor]++) $0 = $0 " {#" anchor "}"
}

{
  done = ""
  while (match($0, /\]\(([^):#]*\.md)?(#[^):#]*)?\)/) && RLENGTH > 3) {
    target = target_of(substr($0, RSTART + 2, RLENGTH - 3))
    done = done substr($0, 1, RSTART + 1) "@ref " target ")"
    $0 = substr($0, RSTART + RLENGTH)
  }
  print done $0
}
