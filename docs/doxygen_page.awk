# A page of the documentation for Doxygen: the first heading gets the page's place as its name, which
# would else come from where the sources lie. The main page has none.
FNR == 1 && /^# / && FILENAME !~ /guide\/README/ {
  name = FILENAME
  if (!sub(/^.*\/docs\//, "", name)) sub(/^.*\//, "", name)
  sub(/\.md$/, "", name)
  gsub(/[^A-Za-z]+/, "_", name)
  $0 = $0 " {#" name "}"
}
{ print }
