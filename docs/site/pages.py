"""The tree of pages in which Sphinx works: the Markdown of the project. Its links work on GitHub; here they become links
between pages. The order of the pages is that of the links of the pages that head others."""

import os
import re
import shutil

TOP = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")  # pages beside those of docs/
HEADED = ("index.md", "guide/README.md", "methods.md")  # in this order pages are taken into the tree of contents
LINK = re.compile(r"(\[[^\]\n]*\])\(([^)\s:]+)\)")
CODE = re.compile(r"(^ *```.*?^ *```$)", re.M | re.S)
CONTENTS = re.compile(r"<!-- contents: (.*?) -->", re.S)


def place_of(path, root):
    """Where a file of the project is in the tree of pages; None for one that has no page."""
    if path.parent == root and path.name in TOP:
        return path.name
    if path.is_relative_to(root / "docs") and path.is_file():
        return str(path.relative_to(root / "docs"))
    if path.suffix == ".ipynb":
        return f"notebooks/{path.name}"
    return None


def linked(page, source, root, stage):
    """The text of a page of the project for the tree. A link to a file of the sources is one to a copy; one to a folder
    stays as its text."""
    here = os.path.dirname(place_of(page, root))

    def new(match):
        path, mark, heading = match[2].partition("#")
        aim = root / os.path.normpath(os.path.relpath(page.parent / path, root))
        if not path or not aim.exists():
            return match[0]  # Sphinx says what is wrong
        if aim.is_dir():
            return match[1][1:-1]
        place = place_of(aim, root)
        if not place or not (stage / place).suffix in (".md", ".ipynb", ".png", ".svg", ".gif"):
            place = f"source/{aim.relative_to(root)}"
            (stage / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(aim, stage / place)
        return f"{match[1]}({os.path.relpath(place, here or '.')}{mark}{heading})"

    return "".join(part if i % 2 else LINK.sub(new, part) for i, part in enumerate(CODE.split(source)))


def targets(place, source):
    """The pages to which a page links, in order."""
    found = [os.path.normpath(os.path.join(os.path.dirname(place), target.partition("#")[0]))
             for _, target in LINK.findall(source)]
    return list(dict.fromkeys(name.rpartition(".")[0] for name in found if name.endswith((".md", ".ipynb"))))


def tree(names, caption):
    """The tree of contents for the side of the page. The project's own pages go by their files' names."""
    lines = [f"{name} </{name}>" if f"{name}.md" in TOP else f"/{name}" for name in names]
    return "\n```{toctree}\n:hidden:\n" + caption + "\n" + "\n".join(lines) + "\n```\n"


def with_contents(place, source, taken):
    """A page that heads others, with the tree of contents that its links are; on the front page each heading has a part.
    Pages that are made have no links on GitHub: <!-- contents: PAGE ... --> is a list of links to them."""
    front = place == "index.md"
    parts = re.split(r"(?m)^(?=## )", source) if front else [source]
    for i, part in enumerate(parts):
        heading = re.match(r"## (.*)", part)
        caption = f":caption: {heading[1]}\n" if front and heading else ""
        if front and not heading:
            continue  # the first lines of the front page name pages of other parts
        made = CONTENTS.search(part)
        names = made[1].split() if made else []
        if made:
            part = part.replace(made[0], "".join(f"- {{doc}}`/{name}`\n" for name in names))
        mine = names + [name for name in targets(place, part) if name not in taken and f"{name}.md" not in (place, "index.md")]
        taken.update(mine)
        parts[i] = part + (tree(mine, caption) if mine else "")
    return "".join(parts)


def write(root, stage):
    """Fills the tree with the pages and pictures of the project."""
    listed = [root / name for name in TOP if (root / name).exists()] + sorted((root / "python/notebooks").glob("*.ipynb"))
    listed += [path for path in sorted((root / "docs").rglob("*"))
               if path.suffix in (".md", ".png", ".svg", ".gif") and not path.is_relative_to(root / "docs/site")]
    texts = {}
    for path in listed:
        place = place_of(path, root)
        (stage / place).parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".md":
            texts[place] = linked(path, path.read_text(), root, stage)
        else:
            shutil.copy(path, stage / place)
    taken = set()
    for place in HEADED:
        texts[place] = with_contents(place, texts[place], taken)
    for place, text in texts.items():
        (stage / place).write_text(text)
