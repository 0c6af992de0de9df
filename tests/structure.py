#!/usr/bin/env python3
"""Structure of the C sources: no circle of includes, no header name twice, contacts in one form; prints the ratio of comments.

A file is its header and its source together: block_list.h and block_list.c. usage: structure.py SOURCE_DIR
"""
import collections
import pathlib
import re
import sys

# Rebuilt with the contact pipeline.
EXCEPTED = ("lib/contact/", "lib/terms/")


def header_names(root):
    """Headers by name, over the folders that share include paths."""
    headers = collections.defaultdict(list)
    for folder in ("lib", "include", "drivers"):
        for path in sorted((root / folder).rglob("*.h*")):
            headers[path.name].append(path.relative_to(root).with_suffix("").as_posix())
    return headers


def include_graph(root, headers):
    """Of each file of lib (without its suffix) the files whose headers it includes."""
    graph = collections.defaultdict(set)
    for path in sorted((root / "lib").rglob("*.[ch]")):
        name = path.relative_to(root).with_suffix("").as_posix()
        for included in re.findall(r'^#include "(?:.*/)?([^"/]+)"', path.read_text(), re.M):
            graph[name].update(set(headers.get(included, [])) - {name})
    return graph


def circles(graph):
    """Strongly connected components of more than one file: what each of two files reaches of the other."""
    reached = {}
    for start in list(graph):
        seen, todo = set(), [start]
        while todo:
            for target in graph.get(todo.pop(), ()):
                if target not in seen:
                    seen.add(target)
                    todo.append(target)
        reached[start] = seen
    groups = {tuple(sorted(b for b in reached[a] if a in reached.get(b, ()))) for a in reached if a in reached[a]}
    return sorted(groups)


def asked(root):
    """Where C code asks how a system describes its contacts: only lib/system and the sources of the terms may."""
    found = []
    for path in sorted((root / "lib").rglob("*.[ch]")):
        name = path.relative_to(root).as_posix()
        bare = re.sub(r'/\*.*?\*/|"[^"\n]*"', "", path.read_text(), flags=re.S)
        words = r"by_list|is_listed|nsdae_system_is_listed"
        if not name.startswith(("lib/system/", "lib/terms/", "lib/bodies/")):
            words += "" if name.startswith(("lib/friction/", "lib/lcp/")) else "|listed"
            found += [f"{name} asks how contacts are described: {word}" for word in set(re.findall(rf"\b(?:{words})\b", bare))]
    return found


def comment_ratio(root):
    """Lines of comments over lines of comments and code, in C sources of lib."""
    comments = code = 0
    for path in (root / "lib").rglob("*.[ch]"):
        text = path.read_text()
        whole = sum(1 for line in text.split("\n") if line.strip())
        bare = re.sub(r"/\*.*?\*/", lambda m: "\n" * m.group().count("\n"), text, flags=re.S)
        left = sum(1 for line in bare.split("\n") if line.strip())
        comments += whole - left
        code += left
    return code, comments, comments / (comments + code)


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    headers = header_names(root)
    graph = include_graph(root, headers)
    assert len(headers) > 100 and len(graph) > 150, "the sources were not found"
    assert circles({"a": {"b"}, "b": {"a"}, "c": {"a"}}) == [("a", "b")], "a circle is not found"
    faults = [f"two headers are called {name}: {', '.join(paths)}" for name, paths in headers.items() if len(paths) > 1]
    for circle in circles(graph):
        if not all(name.startswith(EXCEPTED) for name in circle):
            faults.append("a circle of includes: " + ", ".join(circle))
    faults += asked(root)
    print("lib, C: %d lines of code, %d of comments: %.1f %%" % (lambda c, k, r: (c, k, 100 * r))(*comment_ratio(root)))
    print(f"{len(headers)} headers, {sum(map(len, graph.values()))} includes between files")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


sys.exit(main())
