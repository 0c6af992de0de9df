"""Writes nsdae/_tables.py: the library's tables of statuses and options as classes, which type checkers read.

usage: tables.py FOLDER OUTPUT, where FOLDER has the built module _core.
"""

import sys


def statuses(core):
    yield "class Status(enum.IntEnum):"
    yield '    """Status of a call of the library: 0 completed, < 0 failed, > 0 completed with a message."""\n'
    for name, value in core.STATUS.items():
        yield f"    {name} = {value}"


def kind_of(kind):
    if isinstance(kind, str):
        return kind
    spelled = dict.fromkeys(choice for name in kind for choice in (name.replace("-", "_"), name))
    choices = f"Literal[{', '.join(map(repr, spelled))}]"
    return f"Union[bool, {choices}]" if kind == ("no", "yes") else choices


def options(core):
    yield "class Options(TypedDict, total=False):"
    yield '    """Options of `solve` and `Sim`."""\n'
    for key, unit, what, values, kind in core.OPTIONS:
        yield f"    {key}: {kind_of(kind)}"
        yield f'    """{what}{f" [{unit}]" if unit not in ("", "1") else ""}: {values}"""'


def main(folder, output):
    sys.path.insert(0, folder)
    import _core as core
    lines = ['"""Statuses and options, made from the tables of the library."""\n', "import enum",
             "from typing import Literal, TypedDict, Union\n\n", *statuses(core), "\n", *options(core)]
    with open(output, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


main(*sys.argv[1:])
