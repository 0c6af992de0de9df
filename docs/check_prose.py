#!/usr/bin/env python3
"""Checks the project's prose: no private phrase, no sentence of more than 30 words.

  check_prose.py             every file; part of ./run lint
  check_prose.py FILE ...    these files

Every finding is printed as  file:line: rule: sentence.

Sentences of more than 30 words are findings in documentation: Markdown, man pages, notebooks, public headers, Python
docstrings. Phrases are findings there, and in comments and strings of code. Code, tables, targets of links and names of
files are left out; a piece of inline code is one word; a number, a symbol and a single letter are none.
"""

import argparse
import ast
import bisect
import io
import json
import pathlib
import re
import subprocess
import sys
import tokenize

ROOT = pathlib.Path(__file__).resolve().parent.parent
MAX_WORDS = 30
# Phrases that a reader has to read twice.
PHRASES = [re.compile(phrase, re.IGNORECASE) for phrase in (
    r"\b(is|are|was|were|be) (said|told)\b",
    r"\bso many\b",
    r"\bwhat counts as\b",
    r"\bwhat (rests|stands|holds|moves|is left|comes)\b",
    r"\bbut for\b",
    r"\b(gets|get|got) there\b",
    r"\bnobody can tell\b",
    r"\bby itself\b",
    r"\bhas an end\b",
    r"\bgo(es)? on from\b",
    r"\bin two parts\b",
)]
CODE = "Code"  # in place of a piece of inline code
FILE_NAME = re.compile(r"(?<![\w/])[\w./*-]*\w/[\w./*-]+|\b[\w-]+\.(?:c|h|hpp|cpp|f90|py|md|h5|txt|ini|json|html|gif|png)\b")
# "e.g. Fig. 3", an initial "J. Moreau": a point that ends no sentence
ABBREVIATION = re.compile(r"(?:\b(?:e\.g|i\.e|cf|vs|al|Figs?|Eqs?|eqs?|Secs?|Ch|No|pp?|vol|approx|resp|incl|Ref)"
                          r"|(?:^|[,;:(]|\band|\b[A-Z]\.)\s*\b[A-Z])\.$")
SENTENCE_END = re.compile(r"[.?!][)\"'*_]*(?=\s)|[.?!][)\"'*_]*$")
WORD = re.compile(r"[^\W\d_][\w'’-]*[^\W_]|\b[aI]\b")

# Where prose is. A text is a list of (line, words); its boolean says whether the length of sentences counts.


def markdown(source):
    """Paragraphs, items of lists and headings; no code, tables, comments or formulas in blocks."""
    source = re.sub(r"<!--.*?-->", lambda m: "\n" * m[0].count("\n"), source, flags=re.S)
    text, fence, before, in_list = [], None, "", False
    for number, line in enumerate(source.split("\n"), 1):
        mark = re.match(r"\s*(`{3,}|~{3,}|:{3,}|\$\$)", line)
        if mark and (fence is None or line.strip().startswith(fence)):
            directive = line.strip().startswith(":")  # a MyST block of prose: its marks are no text
            one_line = mark[1] == "$$" and line.count("$$") > 1
            fence = None if fence or directive or one_line else mark[1]
        elif fence is not None:
            continue
        elif not line.strip() or re.match(r"\s*(\||:[\w-]+:|\[[^]]+\]: |[-=*]{3,}\s*$|\([\w-]+\)=)", line):
            pass
        elif re.match(r" {4}|\t", line) and not before.strip() and not in_list:
            continue  # an indented block; its next line follows the same blank line
        else:
            item = re.match(r"\s*([-*+]|\d+[.)]|#+|>)\s+", line)
            if item and text:
                yield text, True
                text = []
            in_list = bool(item and not line.lstrip().startswith("#")) or in_list and line[:1] in " \t"
            text.append((number, line[item.end():] if item else line))
            if item and line.lstrip().startswith("#"):
                yield text, True
                text = []
            before = line
            continue
        before = ""
        if text:
            yield text, True
            text = []
    if text:
        yield text, True


def man_page(source):
    """Text of mdoc between requests that begin something new."""
    text = []
    for number, line in enumerate(source.split("\n"), 1):
        request = re.match(r"\.\s*(\w*)\s*(.*)", line)
        if not request and not line.startswith("%"):
            text.append((number, re.sub(r"\\&|\\f.|\\\(..", "", line)))
        elif request and request[1] in ("Ar", "Cm", "Fl", "Li", "Nm", "Op", "Pa", "Ev", "Xr", "Em", "Sy", "Va", "Ql", "Dq"):
            end = re.search(r"\s([.,;:)]+)$", line)
            text.append((number, CODE + (end[1] if end else "")))
        else:
            if text:
                yield text, True
            text = [(number, request[2])] if request and request[1] == "Nd" else []
    if text:
        yield text, True


def paragraphs(first, lines, verbatim):
    """Paragraphs of a comment or docstring; lines indented by as much as verbatim are equations or tables."""
    text, indent = [], None
    for number, line in enumerate(lines, first):
        here = len(line) - len(line.lstrip())
        new = re.match(r"\s*[-*]\s", line) or (indent is not None and verbatim is None and here != indent)
        if not line.strip() or re.match(r"\s*(\||>>>|\.\.\. |-{3,}|@)", line) or verbatim and here >= verbatim:
            new, line = True, ""
        if new and text:
            yield text
            text = []
        if line.strip():
            text.append((number, re.sub(r"^\s*[-*]\s", "", line)))
            indent = here if number > first else None  # the first line follows the opening mark
    if text:
        yield text


def c_source(source, header):
    """Comments, and strings in one piece however many literals they have."""
    pieces = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])+'", re.S)
    joined, end = [], 0  # literals, or // lines, one after the other
    for piece in pieces.finditer(source):
        number = source.count("\n", 0, piece.start()) + 1
        kind = piece[0][:2] if piece[0][0] == "/" else piece[0][0]
        between = source[end:piece.start()]
        own = not source[source.rfind("\n", 0, piece.start()) + 1:piece.start()].strip()
        if joined and (kind != joined[0][2] or between.strip() or kind == "//" and (between.count("\n") != 1 or not own)):
            yield [part[:2] for part in joined], header and joined[0][2] == "//"
            joined = []
        end = piece.end()
        if kind == '"':
            joined.append((number, piece[0][1:-1].replace("\\n", " ").replace('\\"', '"'), kind))
        elif kind == "//":
            joined.append((number, piece[0].lstrip("/"), kind))
        elif kind == "/*":
            body = piece[0][2:-2].lstrip("*!<").split("\n")
            lines = [line if i == 0 else re.sub(r"^\s*\*", "", line) for i, line in enumerate(body)]
            for text in paragraphs(number, lines, 3 if own else 1000):
                yield text, header
    if joined:
        yield [part[:2] for part in joined], header and joined[0][2] == "//"


def fortran(source):
    """Comments, those of successive lines in one, and strings."""
    text, last = [], 0
    for number, line in enumerate(source.split("\n"), 1):
        parts = re.findall(r"'(?:[^']|'')*'|\"[^\"]*\"|![^\n]*", line)
        for part in parts:
            if part[0] != "!":
                yield [(number, part[1:-1])], False
            else:
                if text and (number != last + 1 or not line.lstrip().startswith("!")):
                    yield text, False
                    text = []
                text.append((number, part.lstrip("!<>")))
                last = number
    if text:
        yield text, False


def python(source):
    """Docstrings, with the length of their sentences; other strings and comments without."""
    docstrings = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and ast.get_docstring(node):
            string = node.body[0].value
            docstrings.add(string.lineno)
            for text in paragraphs(string.lineno, string.value.split("\n"), None):
                yield text, True
    text, last = [], 0
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        number = token.start[0]
        if token.type == tokenize.COMMENT:
            if text and number != last + 1:
                yield text, False
                text = []
            text.append((number, token.string.lstrip("#")))
            last = number
        elif token.type == tokenize.STRING and number not in docstrings:
            yield [(number + i, line) for i, line in enumerate(token.string.split("\n"))], False
    if text:
        yield text, False


def notebook(source):
    """Markdown cells; lines are those of the cell."""
    for cell in json.loads(source)["cells"]:
        if cell["cell_type"] == "markdown":
            yield from markdown("".join(cell["source"]))


def texts(path, source):
    """(lines, whether length counts) of each piece of prose of a file."""
    suffix = path.suffix
    if suffix == ".md":
        return markdown(source)
    if suffix in (".mdoc", ".in") and "man" in path.parts:
        return man_page(source)
    if suffix in (".c", ".h", ".cpp", ".hpp"):
        return c_source(source, "include" in path.parts)
    if suffix == ".f90":
        return fortran(source)
    if suffix == ".py":
        return python(source)
    return notebook(source) if suffix == ".ipynb" else ()


def left_out(word, match):
    """word in place of a match, and blanks: what follows keeps its place."""
    length = len(match[0])
    return word.ljust(length) if length >= len(word) else " " * length


def sentences(lines):
    """(line, sentence, its prose) of a text; the prose is without code, targets of links and names of files."""
    starts, text = [], ""
    for number, line in lines:
        starts.append((len(text), number))
        text += line.strip() + " "
    prose = re.sub(r"`+[^`]*`+|\$[^$]+\$", lambda m: left_out(CODE, m), text)
    prose = re.sub(r"\]\([^)]*\)|\]\[[^]]*\]|<?https?:[^\s>]*>?", lambda m: left_out("", m), prose)
    prose = FILE_NAME.sub(lambda m: left_out(CODE, m) if m[0][-1] != "." else left_out(CODE, m)[:-1] + ".", prose)
    begin = 0
    ends = [m.end() for m in SENTENCE_END.finditer(prose) if not ABBREVIATION.search(prose[begin:m.start() + 1])]
    for end in ends + [len(prose)]:
        if prose[begin:end].strip():
            first = begin + len(prose[begin:end]) - len(prose[begin:end].lstrip())
            yield starts[bisect.bisect(starts, (first, 1 << 30)) - 1][1], text[begin:end], prose[begin:end]
        begin = end


def findings(path, source):
    """(line, rule, sentence) of everything against the rules in a file."""
    for lines, length_counts in texts(path, source):
        for number, sentence, prose in sentences(lines):
            shown, prose = " ".join(sentence.split()), " ".join(prose.split())
            for phrase in PHRASES:
                if phrase.search(prose):
                    yield number, f"phrase '{phrase.search(prose)[0]}'", shown
            words = len(WORD.findall(prose))
            if length_counts and words > MAX_WORDS:
                yield number, f"{words} words", shown


def covered():
    """The project's files that have prose."""
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True,
                            capture_output=True, text=True).stdout
    parts = re.compile(r"(README|CHANGELOG|CONTRIBUTING)\.md$|docs/|include/|lib/|drivers/|python/(?!tests/)")
    return [pathlib.Path(name) for name in sorted(listed.split("\n")) if parts.match(name) and (ROOT / name).is_file()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    failed = False
    for path in arguments.files or covered():
        text = (path if arguments.files else ROOT / path).read_text(encoding="utf-8", errors="replace")
        for number, rule, sentence in sorted(findings(path, text)):
            failed = True
            print(f"{path}:{number}: {rule}: {sentence}")
    return failed


if __name__ == "__main__":
    sys.exit(main())
