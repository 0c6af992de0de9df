"""Modes of contacts and frictional joints over time, as intervals between mode transitions."""

import numpy as np

from trajectory import has_list, names_of_rows

MODES = ["open", "slip", "stick"]
MODE_COLOURS = ["#e6e8eb", "#e8a33d", "#3b6ea5"]
MODES_OF = {"contact": "contacts/mode", "frictional_joint": "frictional_joint/mode"}
SPANS_MAX = 2000  # of a strip; what changes oftener is shown at some records only


def spans(time, mode, some):
    """[from, to, mode] of each stretch without a change. A record's mode is that of the step that
    ends there; the first record's step has no length. some: the records of a strip that has too many."""
    if np.count_nonzero(np.diff(mode)) > SPANS_MAX:
        time, mode = time[some], mode[some]
    last = np.flatnonzero(np.append(np.diff(mode) != 0, True))
    start = np.append(time[0], time[last[:-1]])
    return [[float(a), float(b), int(m)] for a, b, m in zip(start, time[last], mode[last])]


def has_strips(file):
    return any(kinds_of(file))


def kinds_of(file):
    """What a strip is drawn for: contacts of a list have none."""
    return [kind for kind, path in MODES_OF.items() if path in file and not (kind == "contact" and has_list(file))]


def strips(file, time, some):
    """Name and spans of every fixed contact and frictional joint over these times.

    They are the file's first ones from some[0] on. some: records, ascending, which count from the file's first."""
    shown = []
    for kind in kinds_of(file):
        modes = file[MODES_OF[kind]][some[0] : some[0] + len(time)]
        shown += [{"name": name, "kind": kind, "number": i, "spans": spans(time[: len(modes)], modes[:, i], some - some[0])}
                  for i, name in enumerate(names_of_rows(file, kind, modes.shape[1]))]
    return shown
