"""Bodies of a trajectory from its groups /bodies and /shapes: shapes and positions at every record."""

import re
from collections import namedtuple

import numpy as np

from formula import evaluate, names_in
from trajectory import Problem, text

WHOLE = 4 << 20  # numbers of a dataset that are read at once

COLOURS = ["#3b6ea5", "#d1792f", "#4f9d5b", "#b0483f", "#7d67a8", "#8a6d4f", "#c66fa1", "#3f9ea3"]
SHAPES = ("point", "disc", "segment", "polygon", "path", "sphere", "capsule", "box", "plane", "polyhedron",
          "cylinder", "cone", "ellipsoid")

OF_POINTS = ("polygon", "path", "polyhedron")

# size [3] and points [p, 3] in the body's own frame; position [n, 3] or, if it never moves, [3];
# rotation [n, 3, 3], [3, 3] or None; end as position, of a segment, else None. columns: of q, that place
# it; rigid: the columns that place and that rotate it, equal for the shapes of one rigid body.
# colour: "#rrggbb" or "".
Body = namedtuple("Body", "name shape size points position rotation end columns rigid colour",
                  defaults=(None, None, (), None, ""))


def is_fixed(body):
    parts = (body.position, body.rotation, body.end)
    return all(part is None or part.ndim == least for part, least in zip(parts, (1, 2, 1)))


def normal_of(plane):
    """Unit normals [n, 3] of a plane, or [3]."""
    return (np.eye(3) if plane.rotation is None else plane.rotation) @ plane.size / np.linalg.norm(plane.size)


def is_thread(body):
    return body.shape in ("segment", "path") and body.size[0] == 0


def colours_of(bodies):
    """Of each body its own; None if it is fixed or a thread. Shapes of one rigid body have one colour."""
    number, colours = {}, []
    for body in bodies:
        grey = is_fixed(body) or is_thread(body)
        chosen = None if grey else COLOURS[number.setdefault(body.rigid or body.name, len(number)) % len(COLOURS)]
        colours.append(body.colour or chosen)
    return colours


def given_colours(group, count):
    """Texts "#rrggbb" or "" of the dataset `colour` of a group, if it has one."""
    given = [text(value) for value in group["colour"][...]] if "colour" in group else [""] * count
    if len(given) != count or not all(re.fullmatch("(#[0-9a-fA-F]{6})?", colour) for colour in given):
        raise Problem(f"its {group.name}/colour is not one of #rrggbb for each body")
    return given


def about_z(angle):
    """Rotations [..., 3, 3] by these angles [...]."""
    rotation = np.zeros((*np.shape(angle), 3, 3))
    rotation[..., 0, 0] = rotation[..., 1, 1] = np.cos(angle)
    rotation[..., 1, 0] = np.sin(angle)
    rotation[..., 0, 1] = -np.sin(angle)
    rotation[..., 2, 2] = 1
    return rotation


def by_quaternion(q):
    """Rotations [..., 3, 3] of the quaternions q [..., 4] = (w, u), of which only the direction
    counts: (w^2 - |u|^2) I + 2 u u^T + 2 w [u]x, over |q|^2."""
    w, u = q[..., :1, None], q[..., 1:]
    square = np.sum(q * q, axis=-1)[..., None, None]
    if not np.all(square > 0):
        raise Problem("a body's quaternion is zero at some time")
    cross = np.zeros((*q.shape[:-1], 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        cross[..., k, j], cross[..., j, k] = u[..., i], -u[..., i]
    uu = u[..., :, None] * u[..., None, :]
    return ((w * w - np.sum(u * u, axis=-1)[..., None, None]) * np.eye(3) + 2 * uu + 2 * w * cross) / square


def stacked(formulas, names):
    """Values [n, formulas], or [formulas] where none depends on the record; "" stands for 0."""
    values = [evaluate(formula or "0", names) for formula in formulas]
    return np.stack(np.broadcast_arrays(*values), axis=-1)


def coordinates_of(file, count):
    """Column of q of each name that a formula may use."""
    given = file["coordinate"][:count] if "coordinate" in file else []
    return {**{text(name): i for i, name in enumerate(given)}, **{f"q{i}": i for i in range(count)}}


def names_of(file, time, q):
    """Everything that a formula may name."""
    names = {name: np.float64(value[()]) for name, value in file.get("parameters", {}).items()
             if np.issubdtype(value.dtype, np.number)}
    names.update((name, q[:, i]) for name, i in coordinates_of(file, q.shape[1]).items())
    return {**names, "t": time, "pi": np.float64(np.pi)}


def body_of(row, size, points, names, coordinates):
    def formulas(*columns):
        return [row[column] for column in columns]

    angle, quaternion = row["angle"], formulas("quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z")
    rotation = end = None
    if angle:
        rotation = about_z(evaluate(angle, names))
    elif any(quaternion):
        rotation = by_quaternion(stacked(quaternion, names))
    if row["shape"] == "segment":
        end = stacked(formulas("end_x", "end_y", "end_z"), names)
    if row["shape"] not in SHAPES:
        raise Problem(f"the body '{row['name']}' has the unknown shape '{row['shape']}'")

    def columns(*formulas):
        return tuple(sorted({coordinates[name] for formula in formulas for name in names_in(formula) if name in coordinates}))

    all_of = columns(*formulas(*COLUMNS[2:]))
    rigid = (all_of, columns(angle, *quaternion)) if all_of and end is None else None  # a rod may be between two bodies
    return Body(row["name"], row["shape"], size, points, stacked(formulas("x", "y", "z"), names), rotation, end,
                all_of, rigid)


COLUMNS = ("name", "shape", "x", "y", "z", "angle", "quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z",
           "end_x", "end_y", "end_z")


def firsts(count, rows):
    """First row of each body's points and the end of the last one's; None if they are not among the rows."""
    first = np.cumsum([0, *count], dtype=object)  # no overflow
    return None if np.any(count < 0) or first[-1] > rows else first.astype("i8")


def named(file, time, q):
    """The bodies that the file names."""
    group, names, coordinates = file["bodies"], names_of(file, time, q), coordinates_of(file, q.shape[1])
    table = {column: [text(value) for value in group[column][...]] for column in COLUMNS}
    point = group["point"][...].reshape(-1, 3) if "point" in group else np.zeros((0, 3))
    first = firsts(group["points"][...], len(point))
    if first is None or not len(group["size"]) == len(table["name"]) == len(first) - 1:
        raise Problem("its /bodies do not fit together")
    return [body_of({column: table[column][i] for column in COLUMNS}, group["size"][i], point[first[i] : first[i + 1]],
                    names, coordinates)._replace(colour=colour)
            for i, colour in enumerate(given_colours(group, len(table["name"])))]


def shaped(file, q):
    """What is placed by coordinates alone, all at once: bodies by the thousand."""
    group = file["shapes"]
    kind, dimension, position, turn, size, count = (group[name][...] for name in (
        "shape", "dimension", "position", "turn", "size", "points"))
    point = group["point"][...] if "point" in group else np.zeros((0, 3))
    name, first = [text(n) for n in group["name"][...]], firsts(count, len(point))
    far = np.maximum(position + dimension, turn + np.where(dimension == 2, 1, 4))
    if not len(name) == len(kind) == len(dimension) == len(position) == len(turn) == len(size) == len(count) or \
            first is None or np.any(far > q.shape[1]) or np.any(position < 0) or \
            np.any((kind < 0) | (kind >= len(SHAPES)) | (kind == SHAPES.index("segment"))) or \
            np.any((count == 0) & np.isin(kind, [SHAPES.index(of) for of in OF_POINTS])):
        raise Problem("its /shapes do not fit together")
    where = np.zeros((len(q), len(name), 3))
    for d in (2, 3):
        mine = dimension == d
        where[:, mine, :d] = q[:, position[mine, None] + np.arange(d)]
    rotation = np.zeros((len(q), len(name), 3, 3))
    flat, spatial = (dimension == 2) & (turn >= 0), (dimension == 3) & (turn >= 0)
    rotation[:, flat] = about_z(q[:, turn[flat]])
    rotation[:, spatial] = by_quaternion(q[:, turn[spatial, None] + np.arange(4)])
    bodies, colour = [], given_colours(group, len(name))
    for i in range(len(name)):
        turns = tuple(range(turn[i], turn[i] + (1 if dimension[i] == 2 else 4))) if turn[i] >= 0 else ()
        columns = tuple(sorted({*range(position[i], position[i] + dimension[i]), *turns}))
        bodies.append(Body(name[i], SHAPES[kind[i]], size[i], point[first[i] : first[i + 1]], where[:, i],
                           rotation[:, i] if turns else None, None, columns, (columns, turns), colour[i]))
    return bodies


def columns_of(word):
    """The columns of "0,1,-": None where there is no coordinate."""
    if not re.fullmatch(r"(\d+|-),(\d+|-),(\d+|-)", word):
        raise ValueError
    return [None if c == "-" else int(c) for c in word.split(",")]


columns_of.__name__ = "point (X,Y,Z: numbers of coordinates from 0, or -)"  # argparse quotes it


def point(number, columns, q):
    for c in columns:
        if c is not None and c >= q.shape[1]:
            raise Problem(f"it has the coordinates 0 to {q.shape[1] - 1}, not {c}")
    where = np.column_stack([np.zeros(len(q)) if c is None else q[:, c] for c in columns])
    return Body(f"point {number}", "point", np.zeros(3), np.zeros((0, 3)), where)


def bodies_of(file, path, columns, time, q):
    """What the file names, or points at these triples of columns of q."""
    try:
        if columns:
            return [point(i, c, q) for i, c in enumerate(columns)]
        found = (named(file, time, q) if "bodies" in file else []) + (shaped(file, q) if "shapes" in file else [])
        if found:
            return found
    except Problem as problem:
        raise Problem(f"'{path}': {problem}") from problem
    raise Problem(f"'{path}' names no bodies (nsdae_trajectory_set_bodies does): give the moving points with --point, "
                  "e.g. --point 0,1,- for a point at (q0, q1, 0)")


def count_of(file, columns):
    """How many bodies read_motion will find."""
    return len(columns) if columns else sum(len(file[f"{group}/name"]) for group in ("bodies", "shapes") if group in file)


def times_of(file):
    """Of the records that are whole: one dataset may be ahead while a run writes along."""
    return file["time"][: min(len(file["time"]), len(file["q"]))]


def read_rows(dataset, records):
    """Those rows, ascending; no more than they are in memory where all are many."""
    if dataset.size <= WHOLE:
        return dataset[...][records]
    return np.stack([dataset[int(record)] for record in records])


def read_motion(file, path, columns, records):
    """The bodies at these records (numbers, ascending)."""
    q = read_rows(file["q"], records)
    if not np.isfinite(q).all():
        raise Problem(f"'{path}' has coordinates that are not finite")
    return bodies_of(file, path, columns, file["time"][...][records], q)


def at(values, least, records):
    """The part of position, rotation or end that belongs to the records."""
    return values if values is None or values.ndim == least else values[records]


def at_records(body, records):
    return body._replace(position=at(body.position, 1, records), rotation=at(body.rotation, 2, records),
                         end=at(body.end, 1, records))


def ends_of(body):
    """Points [..., p, 3] in space that its extent is judged by, without its thickness."""
    cube = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
    own = {"polygon": body.points, "path": body.points, "polyhedron": body.points,
           "box": cube * body.size, "ellipsoid": cube * body.size,
           "cylinder": cube * body.size[[0, 0, 1]] * [2, 2, 1], "cone": cube * body.size[[0, 0, 1]] * [2, 2, 1],
           "capsule": np.array([[0, 0, -1], [0, 0, 1]]) * body.size[1] / 2}.get(body.shape, np.zeros((1, 3)))
    if body.rotation is not None:
        own = own @ np.swapaxes(body.rotation, -1, -2)
    points = body.position[..., None, :] + own
    return points if body.end is None else np.concatenate(np.broadcast_arrays(points, body.end[..., None, :]), axis=-2)


def boxes_of(body, count):
    """Smallest and largest coordinates [count, 3] of a body at each record."""
    round_by = {"disc": body.size[0], "sphere": body.size[0], "capsule": body.size[0], "segment": body.size[0] / 2,
                "path": body.size[0] / 2}.get(body.shape, 0.0)
    points = ends_of(body)
    points = np.broadcast_to(points, (count, *points.shape[-2:]))
    return points.min(axis=1) - round_by, points.max(axis=1) + round_by


def box_of(body):
    """Smallest and largest coordinates [3] of a body over the records."""
    low, high = boxes_of(body, max(len(part) if part is not None and part.ndim > least else 1 for part, least in
                                   ((body.position, 1), (body.rotation, 2), (body.end, 1))))
    return low.min(axis=0), high.max(axis=0)


def extent(bodies):
    """Smallest and largest coordinates [3] of moving bodies, and of fixed bodies that are not much farther away.

    Fixed planes are not included, of a moving plane its position is.
    """
    moving, fixed = [], []
    for body in bodies:
        if body.shape != "plane" or not is_fixed(body):
            (fixed if is_fixed(body) else moving).append(box_of(body))
    if not moving and not fixed:
        return np.zeros(3), np.zeros(3)
    low, high = np.min([m[0] for m in moving or fixed], axis=0), np.max([m[1] for m in moving or fixed], axis=0)
    reach = 0.3 * np.max(high - low)
    near = [(np.clip(a, low - reach, high + reach), np.clip(b, low - reach, high + reach)) for a, b in fixed]
    return np.min([low] + [a for a, _ in near], axis=0), np.max([high] + [b for _, b in near], axis=0)


def is_spatial(bodies):
    """Whether the plane z = 0 does not say it all: something is off it or turns out of it."""
    def off(values):
        return values is not None and np.any(values[..., 2] != 0)

    def turned(rotation):
        return rotation is not None and np.any(rotation[..., 2, 2] != 1)

    return any(off(b.position) or off(b.end) or turned(b.rotation) or np.any(b.points[:, 2:] != 0) or
               (b.shape == "plane" and b.size[2] != 0) for b in bodies)
