"""Which of many lines a row of a picture draws: those whose names were asked for, or those that vary most."""

import fnmatch

import numpy as np

from trajectory import Problem

LEGEND_MAX = 12  # lines in a legend
MOST = 6  # drawn lines of a row that has more
BAND = 48  # of more columns the range is drawn


class Choice:
    """names: patterns such as "z*", of what is drawn; none: all, or those that vary most. panels: those asked for."""

    def __init__(self, names=None, panels=None):
        self.names, self.panels, self.found, self.left_out = names or [], panels or [], set(), []

    def of(self, names, values):
        """Numbers of the columns [n, c] that are drawn, and what a legend says of the others."""
        if self.names:
            mine = [i for i, name in enumerate(names) if self.asks_for(name)]
            return mine, ""
        if len(names) <= LEGEND_MAX:
            return list(range(len(names))), ""
        finite = np.where(np.isfinite(values), values, np.nan)
        some = ~np.isnan(finite).all(axis=0)
        span = np.zeros(len(names))
        span[some] = np.nanmax(finite[:, some], axis=0) - np.nanmin(finite[:, some], axis=0)
        return sorted(np.argsort(-span, kind="stable")[:MOST]), f"{MOST} of {len(names)}: those that\nvary most, or --name"

    def leaves_out(self, panel, count, what):
        """Whether the panel is not drawn: it has more lines than a legend, and was not asked for."""
        if count <= LEGEND_MAX or self.names or panel in self.panels:
            return False
        self.left_out.append(f"{count} {what} (--only {panel})")
        return True

    def asks_for(self, name):
        asked = [pattern for pattern in self.names if fnmatch.fnmatchcase(name, pattern)]
        self.found.update(asked)
        return bool(asked)

    def banded(self, count):
        """Whether the row is a band of all columns."""
        return count > BAND and not self.names

    def check(self):
        lost = [pattern for pattern in self.names if pattern not in self.found]
        if lost:
            raise Problem(f"--name '{lost[0]}' is the name of nothing that is drawn; a pattern is e.g. 'z*'")
