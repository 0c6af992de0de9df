"""Bodies of an nsdae trajectory as a VTKHDF file, which ParaView 5.12 and later animates.

One VTKHDF 2.0 PolyData of one part: the polygons once, the points of every step after each other,
and in the group Steps the times and where each step's points begin
(https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format)."""

import io
import os
import sys

import h5py
import numpy as np

from bodies import columns_of, read_motion
from shapes import placed, solids_of
from trajectory import Parser, Problem, open_trajectory, replace, tell

BLOCK = 512  # steps in memory at a time


def topology(bodies):
    """Connectivity and offsets of all polygons, and the number of each one's body."""
    first = np.cumsum([0] + [len(b.shape.points) for b in bodies])
    polygons = [np.array(cell) + first[i] for i, b in enumerate(bodies) for cell in b.shape.polygons]
    number = [i for i, b in enumerate(bodies) for _ in b.shape.polygons]
    offsets = np.cumsum([0] + [len(cell) for cell in polygons])
    return np.concatenate(polygons), offsets, np.array(number)


def write_cells(root, connectivity, offsets):
    """The four kinds of cells that the format wants, all empty but for the polygons."""
    for kind in ("Vertices", "Lines", "Polygons", "Strips"):
        mine = (connectivity, offsets) if kind == "Polygons" else ([], [0])
        group = root.create_group(kind)
        group["NumberOfConnectivityIds"] = np.array([len(mine[0])], "i8")
        group["NumberOfCells"] = np.array([len(mine[1]) - 1], "i8")
        group["Connectivity"] = np.array(mine[0], "i8")
        group["Offsets"] = np.array(mine[1], "i8")


def write_steps(root, time, size):
    """Every step has the one part and its cells; only its points begin where the last ones end."""
    n = len(time)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(n)
    steps["Values"] = time
    steps["PartOffsets"] = np.zeros(n, "i8")
    steps["NumberOfParts"] = np.ones(n, "i8")
    steps["PointOffsets"] = size * np.arange(n, dtype="i8")
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = np.zeros((n, 4), "i8")
    for name in ("body", "dark"):
        steps[f"CellDataOffsets/{name}"] = np.zeros(n, "i8")


def write_points(root, bodies, records, size):
    points = root.create_dataset("Points", (len(records) * size, 3), "f8")
    for start in range(0, len(records), BLOCK):
        some = records[start : start + BLOCK]
        block = np.concatenate([placed(b, some) for b in bodies], axis=1)
        points[start * size : (start + len(some)) * size] = block.reshape(-1, 3)


def image(time, bodies, records):
    """The file's bytes. Made in memory: HDF5 itself crashes after a write that found the disk full."""
    size = sum(len(b.shape.points) for b in bodies)
    connectivity, offsets, number = topology(bodies)
    whole = io.BytesIO()
    with h5py.File(whole, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], "i8")
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
        root["NumberOfPoints"] = np.array([size], "i8")
        write_points(root, bodies, records, size)
        write_cells(root, connectivity, offsets)
        data = root.create_group("CellData")
        data.create_dataset("body", data=number, dtype="i4").attrs["names"] = [b.name for b in bodies]
        data["dark"] = np.concatenate([np.array(b.shape.dark or [0] * len(b.shape.polygons), "i4") for b in bodies])
        write_steps(root, time[records], size)
    return whole.getbuffer()


def parse(argv):
    parser = Parser(prog="nsdae-vtk", description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("file", help="trajectory, e.g. pendulum.h5")
    parser.add_argument("-o", "--output", metavar="OUT.vtkhdf", help="default FILE.vtkhdf")
    parser.add_argument("--every", metavar="N", type=int, default=1, help="every N-th record (default 1)")
    parser.add_argument("--point", metavar="X,Y,Z", action="append", type=columns_of,
                        help="instead of the file's bodies a point at these coordinates of q, counted from 0, "
                        "- for none; repeatable")
    parser.add_argument("--version", action="version", version="nsdae-vtk @PROJECT_VERSION@")
    arguments = parser.parse_args(argv)
    if arguments.every < 1:
        parser.error(f"--every {arguments.every} is outside its range: it must be at least 1")
    arguments.output = arguments.output or os.path.splitext(arguments.file)[0] + ".vtkhdf"
    if os.path.realpath(arguments.output) == os.path.realpath(arguments.file):
        parser.error(f"--output '{arguments.output}' is the trajectory itself")
    return arguments


def main(argv):
    arguments = parse(argv)
    try:
        with open_trajectory(arguments.file) as file:
            time, bodies = read_motion(file, arguments.file, arguments.point)
        records = np.arange(0, len(time), arguments.every)
        replace(arguments.output, image(time, solids_of(bodies), records))
        tell(f"{len(records)} steps of {len(bodies)} bodies in {arguments.output}")
    except Problem as problem:
        print(f"nsdae-vtk: error: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
