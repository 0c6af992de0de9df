"""The public headers for Doxygen. They are commented for the reader of C; Doxygen's marks are added here.

- The first comment documents the file.
- A comment after code documents that code; of "double a, b;" both.
- Any other comment documents what follows. Declarations without a blank line between them share it.
- Lines indented by 3 or more are kept as they are (equations, tables).
- X(name, value, ..., "text") becomes an enumerator with its text.
"""

import re

DIRECTIVE = re.compile(r"^ */\* (callbacks\.list: \w+|clang-format (on|off)) \*/\n", re.M)
MACROS = re.compile(r"^#define NSDAE_(?:CALLBACK|OWN)\b(?:.*\\\n)*.*\n|^#undef NSDAE_(?:CALLBACK|OWN)\n|^  NSDAE_OWN\(.*\n", re.M)
DETAIL = re.compile(r"^namespace detail\n.*?^} // namespace detail\n", re.M | re.S)
LIST = re.compile(r"^#define (NSDAE_\w+_LIST)\(X\)((?:.*\\\n)*.*)\n", re.M)
ITEM = re.compile(r'X\((\w+), (-?\d+),[^"]*(?:"[^"]*", )*"([^"]*)"\)')
COMMENT = re.compile(r"^(?P<code>[^\n]*?)/\*(?P<text>.*?)\*/", re.M | re.S)


def literal(text):
    """Text without a meaning for Doxygen."""
    return re.sub(r"[\\@<>#]", r"\\\g<0>", text)


def body(text, block):
    """Inside of a comment: its lines without stars, indented ones of a block verbatim."""
    lines, verbatim = [], False
    for number, line in enumerate(text.split("\n")):
        line = re.sub(r"^\s*\*", "", line) if number and block else line if block else " " + line.strip()
        indented = block and number > 0 and re.match(r" {3,}\S", line) is not None
        mark = "" if indented == verbatim else "@verbatim\n" if indented else "@endverbatim\n"
        lines.append(mark + (line if indented else literal(line)))
        verbatim = indented
    return "\n".join(lines) + ("\n@endverbatim " if verbatim else "")


def marked(source):
    """Comments with Doxygen's marks."""
    out, end, first = [], 0, True
    for comment in COMMENT.finditer(source):
        code, text = comment["code"], comment["text"]
        own = not code.strip()
        out.append(source[end:comment.start()])
        several = re.match(r"( *(?:const )?\w+ )([^(;]*, [^(;]*); *$", code)
        if own:
            out.append(f"{code}/**{' @file' + chr(10) if first else ''}{body(text, True)}*/")
        elif several:
            out.append(" ".join(f"{several[1]}{name}; /**<{body(text, False)} */" for name in several[2].split(", ")))
        else:
            out.append(f"{code}/**<{body(text, False)} */")
        first, end = False, comment.end()
    return "".join(out) + source[end:]


def shared(source):
    """A function or macro directly after another has its documentation."""
    out, last, documented = [], "", False
    for line in source.split("\n"):
        name = re.match(r"(?:NSDAE_API .*?\b(nsdae_\w+)\(|#define (NSDAE_\w+))", line)
        if not line.strip():
            documented, last = False, ""
        elif line.endswith("*/") and not name and not re.search(r"/\*\*<", line):
            documented = True
        elif name:
            if documented:
                last = name[1] or name[2]
            elif last:
                out.append(f"/** @copydoc {last} */")
            documented = False
        out.append(line)
    return "\n".join(out)


def for_doxygen(source):
    """A header with Doxygen's marks."""
    for pattern in (DIRECTIVE, MACROS, DETAIL):
        source = pattern.sub("", source)
    items = {macro: "".join(f"  {name} = {value}, /**< {literal(text)} */\n" for name, value, text in ITEM.findall(body))
             for macro, body in LIST.findall(source)}
    source = re.sub(r"^#(define|undef) NSDAE_\w+_ENUM.*\n", "", shared(marked(source)), flags=re.M)
    return re.sub(r"^ *(NSDAE_\w+_LIST)\(\w+\)\n", lambda m: items[m[1]], source, flags=re.M)
