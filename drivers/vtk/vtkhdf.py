"""Bodies of an nsdae trajectory as a VTKHDF file, which ParaView 5.12 and later animates.

The file is one VTKHDF 2.0 PolyData with one part. It has the polygons once and the points of all steps one after another. The
group Steps has the times and the first point of each step
(https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format).

Contacts are written to a second file of this kind, with force and mode as data. They are points, if the trajectory has them;
those of a contact list without points are lines between two bodies. Every step has the largest number of contacts. Unused ones
have no force, lines no length, and the id -1.
"""

import io
import os
import sys

import h5py
import numpy as np

from bodies import colours_of, columns_of, read_motion, times_of
from contacts import Origins, Places, acting, contacts_of, in_memory, step_length
from shapes import placed, solids_of
from trajectory import Parser, Problem, has_forces, has_list, open_trajectory, replace, tell

BLOCK = 1 << 20  # points in memory at a time
MOST = 1 << 31  # bytes of a file's points


def topology(bodies):
    """Connectivity and offsets of all polygons, and the number of each one's body."""
    first = np.cumsum([0] + [len(b.shape.points) for b in bodies])
    polygons = [np.array(cell) + first[i] for i, b in enumerate(bodies) for cell in b.shape.polygons]
    number = [i for i, b in enumerate(bodies) for _ in b.shape.polygons]
    offsets = np.cumsum([0] + [len(cell) for cell in polygons])
    return np.concatenate(polygons), offsets, np.array(number)


def write_cells(root, filled, connectivity, offsets):
    """The four kinds of cells of the format; all except one are empty."""
    for kind in ("Vertices", "Lines", "Polygons", "Strips"):
        mine = (connectivity, offsets) if kind == filled else ([], [0])
        group = root.create_group(kind)
        group["NumberOfConnectivityIds"] = np.array([len(mine[0])], "i8")
        group["NumberOfCells"] = np.array([len(mine[1]) - 1], "i8")
        group["Connectivity"] = np.array(mine[0], "i8")
        group["Offsets"] = np.array(mine[1], "i8")


def write_steps(root, time, size, of, **data):
    """Offsets of the steps.

    Every step has the same part and cells; its points begin after those of the step before. data: number of values per step of each
    dataset of `of`, "Cell" or "Point", 0 if they are constant.
    """
    n = len(time)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(n)
    steps["Values"] = time
    steps["PartOffsets"] = np.zeros(n, "i8")
    steps["NumberOfParts"] = np.ones(n, "i8")
    steps["PointOffsets"] = size * np.arange(n, dtype="i8")
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = np.zeros((n, 4), "i8")
    for name, values in data.items():
        steps[f"{of}DataOffsets/{name}"] = values * np.arange(n, dtype="i8")


def write_points(root, bodies, steps, size):
    points = root.create_dataset("Points", (steps * size, 3), "f8")
    block = max(BLOCK // size, 1)
    for start in range(0, steps, block):
        some = np.arange(start, min(start + block, steps))
        rows = np.concatenate([placed(b, some) for b in bodies], axis=1)
        points[start * size : (start + len(some)) * size] = rows.reshape(-1, 3)


def check_size(path, every, steps, size):
    """All is made in memory."""
    if 24 * steps * size > MOST:
        more = every * int(np.ceil(24 * steps * size / MOST))
        raise Problem(f"'{path}' has {steps} steps of {size} points: {24e-9 * steps * size:.1f} GB; "
                      f"take fewer, with --every {more}")


def begin(file, size):
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array([2, 0], "i8")
    root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
    root["NumberOfPoints"] = np.array([size], "i8")
    return root


GREY = "#a9aeb5"  # of what is fixed


def rgb(colours):
    return np.array([list(bytes.fromhex((colour or GREY)[1:])) for colour in colours], "u1")


def image(time, bodies, colours=()):
    """The file's bytes. Made in memory: HDF5 itself crashes after a write that found the disk full."""
    size = points_of(bodies)
    connectivity, offsets, number = topology(bodies)
    whole = io.BytesIO()
    with h5py.File(whole, "w") as file:
        root = begin(file, size)
        write_points(root, bodies, len(time), size)
        write_cells(root, "Polygons", connectivity, offsets)
        data = root.create_group("CellData")
        data.create_dataset("body", data=number, dtype="i4")
        name_bodies(data, [b.name for b in bodies])
        data["dark"] = np.concatenate([np.array(b.shape.dark or [0] * len(b.shape.polygons), "i4") for b in bodies])
        if len(colours):
            data["colour"] = rgb(colours)[number]
        write_steps(root, time, size, "Cell", body=0, dark=0, **({"colour": 0} if len(colours) else {}))
    return whole.getbuffer()


def name_bodies(data, names):
    """As an attribute, which has room for so much and no more."""
    if sum(len(name.encode()) + 32 for name in names) < 60000:
        data["body"].attrs["names"] = names


def points_of(bodies):
    return sum(len(b.shape.points) for b in bodies)


def contact_places(file, bodies, records):
    """Of each record its contacts and their places."""
    origins, listed = None if has_forces(file) else Origins(file, bodies), in_memory(file)
    for row, record in enumerate(records):
        contacts = contacts_of(listed, int(record))
        of = acting(contacts) if origins is None else None
        yield contacts, origins.lines(row, contacts) if of is None else Places(of, contacts.point[of, None])


def contact_image(file, time, found):
    """The bytes of the file of contacts."""
    most, n = max((len(places.number) for _, places in found), default=0), len(time)
    ends = 1 if has_forces(file) else 2
    points, data = np.zeros((n, most, ends, 3)), {"normal_force": np.zeros((n, most)), "friction_force": np.zeros((n, most)),
                                                  "gap": np.zeros((n, most)), "mode": np.zeros((n, most), "i4"),
                                                  "id": np.full((n, most), -1, "i8")}
    if ends == 1:
        data["force"] = np.zeros((n, most, 3))
    for i, (contacts, places) in enumerate(found):
        used, of = slice(0, len(places.number)), places.number
        points[i, used] = places.points
        points[i, len(of) :] = places.points[0, 0] if len(of) else 0
        normal, friction = contacts.normal[of], np.linalg.norm(contacts.tangential[of], axis=1)
        dt = step_length(file) if ends == 2 else np.hypot(normal, friction) / np.linalg.norm(contacts.force[of], axis=1)
        data["normal_force"][i, used], data["friction_force"][i, used] = normal / dt, friction / dt
        for name in set(data) - {"normal_force", "friction_force"}:
            data[name][i, used] = getattr(contacts, name)[of]
    whole, (kind, of) = io.BytesIO(), ("Vertices", "Point") if ends == 1 else ("Lines", "Cell")
    with h5py.File(whole, "w") as target:
        root = begin(target, ends * most)
        root["Points"] = points.reshape(-1, 3)
        write_cells(root, kind, np.arange(ends * most), ends * np.arange(most + 1))
        for name, values in data.items():
            root[f"{of}Data/{name}"] = values.reshape(n * most, *values.shape[2:])
        write_steps(root, time, ends * most, of, **dict.fromkeys(data, most))
    return whole.getbuffer()


def parse(argv):
    parser = Parser(prog="nsdae-vtk", description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("file", help="trajectory, e.g. pendulum.h5")
    parser.add_argument("-o", "--output", metavar="OUT.vtkhdf", help="default FILE.vtkhdf")
    parser.add_argument("--every", metavar="N", type=int, default=1, help="every N-th record (default 1)")
    parser.add_argument("--point", metavar="X,Y,Z", action="append", type=columns_of,
                        help="a point at these coordinates of q, numbered from 0, in place of the bodies, "
                        "- for none; repeatable")
    parser.add_argument("--version", action="version", version="nsdae-vtk @PROJECT_VERSION@")
    arguments = parser.parse_args(argv)
    if arguments.every < 1:
        parser.error(f"--every {arguments.every} is outside its range: it must be at least 1")
    arguments.output = arguments.output or os.path.splitext(arguments.file)[0] + ".vtkhdf"
    if os.path.realpath(arguments.output) == os.path.realpath(arguments.file):
        parser.error(f"--output '{arguments.output}' is the trajectory itself")
    return arguments


def convert(file, arguments):
    time = times_of(file)
    records = np.arange(0, len(time), arguments.every)
    bodies = read_motion(file, arguments.file, arguments.point, records)
    solids = solids_of(bodies)
    check_size(arguments.file, arguments.every, len(records), points_of(solids))
    replace(arguments.output, image(time[records], solids, colours_of(bodies) if any(b.colour for b in bodies) else ()))
    tell(f"{len(records)} steps of {len(bodies)} bodies in {arguments.output}")
    if (has_list(file) or has_forces(file)) and not arguments.point:
        found = list(contact_places(file, bodies, records))
        path = os.path.splitext(arguments.output)[0] + ".contacts.vtkhdf"
        replace(path, contact_image(file, time[records], found))
        tell(f"their contacts in {path}")


def main(argv):
    arguments = parse(argv)
    try:
        with open_trajectory(arguments.file) as file:
            convert(file, arguments)
    except Problem as problem:
        print(f"nsdae-vtk: error: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
