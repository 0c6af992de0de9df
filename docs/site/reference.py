"""The pages of the reference: C and C++ by Breathe from Doxygen's XML, Python by autodoc, Fortran (of which Sphinx has no
domain) as its own source."""

import re
import subprocess

HEAD = "# {}\n\n{}\n\n"


PROCEDURE = re.compile(r"^ *(?:[\w() ]* )?(?:function|subroutine) (\w+)\(")


def procedure(lines, at):
    """Its statement and the declarations of its arguments."""
    kept, statement = [], ""
    while True:
        kept.append(lines[at])
        statement += lines[at].rstrip("& ")
        at += 1
        if not lines[at - 1].rstrip().endswith("&"):
            break
    arguments = set(re.findall(r"\w+", " ".join(re.findall(r"\(([^()]*)\)", re.split(r"\b(?:function|subroutine) ", statement)[1]))))
    while at < len(lines) and re.match(r"\s*(import|use\b|.*::)", lines[at]):
        declared = re.sub(r"\([^()]*\)", "", lines[at].split("::")[-1].split("!")[0])
        if "::" in lines[at] and set(re.findall(r"\w+", declared)) & arguments:
            kept.append(lines[at])
        at += 1
    indent = len(kept[0]) - len(kept[0].lstrip())
    return "\n".join(line[indent:] for line in kept)


def above(lines, at):
    """The comment above a line, as text."""
    text = []
    while at > 0 and re.match(r"\s*! ?\S", lines[at - 1]):
        at -= 1
        if not re.match(r"\s*! (headers|callbacks.list): ", lines[at]):  # marks of sections that are filled
            text.insert(0, re.sub(r"^\s*! ?", "", lines[at]))
    return " ".join(text)


def plain(text):
    """A comment's text in Markdown: names and formulas are not its marks."""
    return re.sub(r"[\\*_<>\[\]`$#]", r"\\\g<0>", text)


def fortran_page(title, source, private, documented):
    """A module as a page in Markdown: its types and procedures, without those that are private. documented: what the
    reference of C has."""
    lines = source.split("\n")
    head = re.match(r"(?:!.*\n)*", source)[0]
    parts = [f"# {title}\n", plain(" ".join(line.lstrip("! ") for line in head.split("\n"))), ""]
    for at, line in enumerate(lines):
        kind = re.match(r"  type, (?:bind\(C\), )?public :: (nsdae_\w+)$", line)
        found = PROCEDURE.match(line) if not line.lstrip().startswith(("!", "end")) else None
        generic = re.match(r"  interface (nsdae_\w+)$", line)
        name = next((match[1] for match in (kind, generic, found) if match), "")
        if name in private or not name.startswith("nsdae_") or name.startswith("nsdae_c_"):
            continue
        if kind:
            code = "\n".join(each[2:] for each in lines[at:lines.index("  end type", at) + 1])
        elif generic:  # the procedures behind the name
            parts_of = re.findall(r"\w+", lines[at + 1].split("procedure")[1])
            code = "\n\n".join(procedure(lines, i) for i, each in enumerate(lines)
                               if PROCEDURE.match(each) and PROCEDURE.match(each)[1] in parts_of)
        else:
            code = procedure(lines, at)
        role = "struct" if kind else "func"
        more = f"In C: {{c:{role}}}`{name}`." if name in documented else ""
        parts += [f"({name.replace('_', '-')}-fortran)=", f"## {name}\n", plain(above(lines, at)), more,
                  f"\n```fortran\n{code}\n```\n"]
    return "\n".join(parts) + "\n"


def list_of(name, title, text, pages):
    """A page that heads others."""
    tree = "```{toctree}\n:maxdepth: 1\n\n" + "\n".join(pages) + "\n```\n"
    return {name: HEAD.format(title, text) + tree}


def c_pages(root):
    """A page for each header, in the order in which nsdae.h includes them."""
    names = re.findall(r"#include <nsdae/(\w+)\.h>", (root / "include/nsdae/nsdae.h").read_text())
    names += sorted({path.stem for path in (root / "include/nsdae").glob("*.h")} - {*names, "nsdae"})
    pages = {f"c-{name}": f"# nsdae/{name}.h\n\n```{{doxygenfile}} {name}.h\n```\n" for name in names}
    return pages | list_of("c", "C", "`#include <nsdae/nsdae.h>` includes every header.", pages)


def cpp_pages(work):
    """The classes of nsdae.hpp."""
    names = [re.search(r"<compoundname>nsdae::(\w+)<", path.read_text())[1]
             for path in sorted((work / "xml").glob("classnsdae_1_1*.xml"))]
    text = "`#include <nsdae/nsdae.hpp>`: owning handles over the functions of C."
    classes = "\n".join(f"## {name}\n\n```{{doxygenclass}} nsdae::{name}\n:members:\n```\n" for name in names)
    return {"cpp": HEAD.format("C++", text) + classes}


def module(root, name):
    """The source of the module nsdae_f_<name>, with its marked sections filled."""
    return subprocess.run(["sh", root / "lib/fortran/fill.sh", name], capture_output=True, text=True, check=True).stdout


def fortran_pages(root, documented):
    """A page for each module behind the module nsdae."""
    whole = (root / "lib/fortran/nsdae.f90").read_text()
    private = set(re.findall(r"\w+", whole[whole.index("private ::"):]))
    names = re.findall(r"use nsdae_f_(\w+)", whole)
    pages = {f"fortran-{name}": fortran_page(f"nsdae_f_{name}", module(root, name), private, documented)
             for name in names}
    return pages | list_of("fortran", "Fortran", "`use nsdae` brings every module. [From Fortran](../fortran.md) shows a "
                           "program.", pages)


def python_pages():
    """The package, by its docstrings."""
    return {"python": HEAD.format("Python", "`import nsdae`. [The guide](../guide/python.md) shows programs.")
            + "```{eval-rst}\n.. automodule:: nsdae\n   :members:\n```\n"}


def pages(root, work):
    """name: text of each page."""
    documented = {name for path in (work / "xml").glob("*.xml")
                  for name in re.findall(r"<(?:compound)?name>(nsdae_\w+)<", path.read_text())}
    return c_pages(root) | cpp_pages(work) | fortran_pages(root, documented) | python_pages()
