"""Contact lists: the contacts of a record, and the lines of their forces.

A line joins the places of the two blocks that touch, or of one and the place of the nearest fixed plane
that is next to it: a chain of forces. A block is where the first shape is that its coordinates place."""

from collections import namedtuple

import numpy as np

from bodies import WHOLE, is_fixed, normal_of
from trajectory import Problem

# Of one record: id [c], block [c, 2] with -1 for the ground, gap [c], normal and tangential impulse [c],
# [c, nt], mode [c].
Contacts = namedtuple("Contacts", "id block gap normal tangential mode")

# Lines of one record: contact numbers [c], ends [c, 2, 3].
Lines = namedtuple("Lines", "number ends")


def rows_of(file, record):
    """Where a record's contacts are in the list."""
    first, count = int(file["contacts/first"][record]), int(file["contacts/count"][record])
    if first < 0 or count < 0 or first + count > len(file["contacts/id"]):
        raise Problem(f"record {record} has contacts that are not in its list")
    return slice(first, first + count)


def in_memory(file):
    """The contact list of a file, if it is not too long."""
    names = [f"contacts/{name}" for name in ("first", "count", "id", "block", "gap", "normal_impulse", "tangential_impulse", "mode")]
    return {name: file[name][...] for name in names if name in file} if file["contacts/id"].size <= WHOLE else file


def contacts_of(file, record):
    rows = rows_of(file, record)
    path = "contacts/tangential_impulse"
    tangential = file[path][rows] if path in file else np.zeros((rows.stop - rows.start, 0))
    columns = ("id", "block", "gap", "normal_impulse")
    return Contacts(*(file[f"contacts/{name}"][rows] for name in columns), tangential, file["contacts/mode"][rows])


class Origins:
    """Where the blocks are: the places of the first shapes that their coordinates place."""

    def __init__(self, file, bodies):
        first = file["blocks/q"][...]
        self.place = [None] * len(first)
        for body in bodies:
            block = np.searchsorted(first, body.columns, side="right") - 1
            if body.rigid and block[0] >= 0 and np.ptp(block) == 0 and self.place[block[0]] is None:
                self.place[block[0]] = body.position
        self.planes = [(b.position, normal_of(b)) for b in bodies if b.shape == "plane" and is_fixed(b)]

    def at(self, row):
        """[blocks, 3] of one record of the bodies; NaN where there is none."""
        where = np.full((len(self.place), 3), np.nan)
        for i, place in enumerate(self.place):
            if place is not None:
                where[i] = place[row] if place.ndim > 1 else place
        return where

    def feet(self, points):
        """The nearest place [c, 3] of a plane, or the points themselves where there is no plane."""
        best, foot = np.full(len(points), np.inf), points.copy()
        for at, normal in self.planes:
            distance = (points - at) @ normal
            nearer = np.abs(distance) < best
            best[nearer] = np.abs(distance[nearer])
            foot[nearer] = points[nearer] - distance[nearer, None] * normal
        return foot

    def lines(self, row, contacts):
        where = self.at(row)
        block = contacts.block
        if len(block) and (block.max(initial=-1) >= len(where) or block.min(initial=0) < -1):
            raise Problem("a contact is of a block that is not there")
        ends = np.where((block >= 0)[..., None], where[block], np.nan)
        for side in (0, 1):
            ground = block[:, side] < 0
            ends[ground, side] = self.feet(ends[ground, 1 - side])
        shown = np.flatnonzero(np.isfinite(ends).all(axis=(1, 2)))
        return Lines(shown, ends[shown])


def step_length(file):
    """What an impulse is divided by for a mean force [s]."""
    return float(file["options/dt"][()]) if "options/dt" in file else 1.0


FORCES_MAX = 4000  # lines of a frame; the strongest
LONGEST = 3.0  # strength from which arrows have one length


def by_pair(contacts, lines):
    """A line for each pair of blocks with the sum of its normal impulses: contacts of two faces are one."""
    pair = np.sort(contacts.block[lines.number], axis=1)
    _, first, which = np.unique(pair, axis=0, return_index=True, return_inverse=True)
    impulse = np.bincount(which.reshape(-1), contacts.normal[lines.number], len(first))
    strongest = np.argsort(-impulse, kind="stable")[:FORCES_MAX]
    return lines.ends[first[strongest]], impulse[strongest]


def force_lines(file, bodies, rows, records):
    """Lines [[x0, y0, z0, x1, y1, z1, w], ...] of each record. Rows are the records among those of the bodies.

    w is 1 for the force that one in twenty of all is larger than."""
    origins, listed, found = Origins(file, bodies), in_memory(file), []
    for row, record in zip(rows, records):
        contacts = contacts_of(listed, int(record))
        found.append(by_pair(contacts, origins.lines(row, contacts)))
    impulses = np.concatenate([impulse[impulse > 0] for _, impulse in found] or [[]])
    scale = np.quantile(impulses, 0.95) if len(impulses) else 1.0
    return [np.column_stack([ends.reshape(-1, 6), impulse / scale])[impulse > 0] for ends, impulse in found]


def arrows(points, forces, length):
    """Arrows [f, 2, 3] from the points [f, 3] along forces [f, 3] in units of that of this length; none shorter than a fifth."""
    strength = np.linalg.norm(forces, axis=1)
    seen = np.flatnonzero(strength > 0.2)
    seen = seen[np.argsort(-strength[seen], kind="stable")[:FORCES_MAX]]
    along = length * forces[seen] * (np.minimum(strength[seen], LONGEST) / strength[seen])[:, None]
    return np.stack([points[seen], points[seen] + along], axis=1)


def line_arrows(lines):
    """Of lines [f, 7] two arrows each from the middle, along the force on either body."""
    ends = np.asarray(lines)[:, :6].reshape(-1, 2, 3)
    half, middle = (ends[:, 1] - ends[:, 0]) / 2, ends.mean(axis=1)
    size = np.linalg.norm(half, axis=1)
    forces = half * (np.asarray(lines)[:, 6] / np.maximum(size, 1e-9 * size.max(initial=1)))[:, None]
    return np.concatenate([arrows(middle, side * forces, 1.2 * np.median(size) if len(size) else 1.0) for side in (-1, 1)])
