"""The contacts of a record, and their forces.

With /contacts/point and /contacts/force a force is an arrow at its point. Without them a line joins the places of the two
blocks that touch: a chain of forces. The place of the ground is that of the nearest fixed plane which is next to the block. A
block is where the first shape is that its coordinates place."""

from collections import namedtuple

import numpy as np

from bodies import WHOLE, extent, is_fixed, normal_of
from trajectory import Problem, has_forces, has_list

# Of one record: id [c], gap [c], normal and tangential impulse [c], [c, nt], mode [c]; of a list block [c, 2] with -1 for the
# ground; point and force [c, 3], if the file has them.
Contacts = namedtuple("Contacts", "id gap normal tangential mode block point force")

# Places of contacts of one record: contact numbers [c], and their points [c, 1, 3] or ends of lines [c, 2, 3].
Places = namedtuple("Places", "number points")


def rows_of(file, record):
    """Where a record's contacts are in the list; of fixed contacts the record."""
    if not has_list(file):
        return record
    first, count = int(file["contacts/first"][record]), int(file["contacts/count"][record])
    if first < 0 or count < 0 or first + count > len(file["contacts/id"]):
        raise Problem(f"record {record} has contacts that are not in its list")
    return slice(first, first + count)


COLUMNS = ("id", "gap", "normal_impulse", "tangential_impulse", "mode", "block", "point", "force")


def in_memory(file):
    """The contact list of a file, if it is not too long."""
    names = [f"contacts/{name}" for name in ("first", "count", *COLUMNS)]
    return {name: file[name][...] for name in names if name in file} if has_list(file) and file["contacts/id"].size <= WHOLE else file


def contacts_of(file, record):
    rows = rows_of(file, record)
    columns = {name: file[f"contacts/{name}"][rows] for name in COLUMNS[1:] if f"contacts/{name}" in file}
    number = file["contacts/id"][rows if has_list(file) else ...]
    if any(len(column) != len(number) for column in columns.values()) or any(
            columns[name].shape[1:] != (3,) for name in ("point", "force") if name in columns):
        raise Problem(f"the columns of the contacts of record {record} do not fit together")
    return Contacts(number, columns["gap"], columns["normal_impulse"], columns.get("tangential_impulse", np.zeros((len(number), 0))),
                    columns["mode"], columns.get("block"), columns.get("point"), columns.get("force"))


def acting(contacts):
    """Numbers of the contacts that have a point."""
    return np.flatnonzero(np.isfinite(contacts.point).all(axis=1))


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
        return Places(shown, ends[shown])


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
    return lines.points[first[strongest]], impulse[strongest]


def force_lines(file, bodies, rows, records):
    """Lines [[x0, y0, z0, x1, y1, z1, w], ...] of each record. Rows are the records among those of the bodies.

    w is 1 for the force that one in twenty of all is larger than, and for arrows."""
    if has_forces(file):
        low, high = extent(bodies)
        return [np.column_stack([a.reshape(-1, 6), np.ones(len(a))]) for a in force_arrows(file, records, np.linalg.norm(high - low) / 10)]
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


def force_arrows(file, records, length):
    """Arrows of each record. This length is that of the force that one in twenty of all is larger than."""
    listed, found = in_memory(file), []
    for record in records:
        contacts = contacts_of(listed, int(record))
        of = acting(contacts)
        found.append((contacts.point[of], contacts.force[of]))
    unit = unit_of(np.concatenate([force for _, force in found]))
    return [arrows(point, force / unit, length) for point, force in found]


def unit_of(forces):
    """The force that one in twenty is larger than; 1 without forces."""
    return (np.quantile(np.linalg.norm(forces, axis=1), 0.95) if len(forces) else 0) or 1.0
