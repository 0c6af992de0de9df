# Exit 0 where the second file is what the first one says: "..." in a line stands for anything in
# it, a line of "..." alone for any lines.
FILENAME == ARGV[1] { wanted[++n] = $0; next }
{ got[++m] = $0 }

# A line against a pattern, from character to character at the dots.
function like(line, pattern,   at, head, i) {
  at = index(pattern, "...")
  if (!at) return line == pattern
  head = substr(pattern, 1, at - 1)
  if (substr(line, 1, at - 1) != head) return 0
  for (i = at; i <= length(line) + 1; i++)
    if (like(substr(line, i), substr(pattern, at + 3))) return 1
  return 0
}

function all_like(i, j) {
  for (; i <= n && wanted[i] != "..."; i++ && j++)
    if (j > m || !like(got[j], wanted[i])) return 0
  if (i > n) return j > m
  for (; j <= m + 1; j++)
    if (all_like(i + 1, j)) return 1
  return 0
}

END { exit !all_like(1, 1) }
