"""Trajectories with contacts by list in nsdae-vtk, nsdae-animate, nsdae-plot, and xarray where it is, against their own
numbers; files that do not fit together. usage: listed_check.py BIN_DIR DISKS_RUN"""

import json
import re
import shutil
import sys

import h5py
import listed_space
import numpy as np
import tools

RADIUS = 0.05  # of the disks
EPS = 1e-12


def expect(name, holds, what=""):
    if not holds:
        sys.exit(f"{name} {what}")


class Run:
    """What the file says, read with h5py alone."""

    def __init__(self, path):
        with h5py.File(path) as f:
            self.time, self.q, self.dt = f["time"][...], f["q"][...], f["options/dt"][()]
            self.list = {name: f[f"contacts/{name}"][...] for name in f["contacts"] if name != "side"}
            self.width = float(f["bodies/x"].asstr()[list(f["bodies/name"].asstr()).index("right wall")])
            expect("version", f.attrs["format_version"] == 3 and f["contacts"].attrs["fixed"] == 0)
            expect("a shape for each block", len(f["shapes/name"]) == len(f["blocks/q"]) == self.q.shape[1] // 3)
            expect("planes are bodies", list(f["bodies/name"].asstr()) == ["floor", "left wall", "right wall"])
        self.n, self.disks = len(self.time), self.q.shape[1] // 3
        end = self.list["first"] + self.list["count"]
        expect("lists join", self.list["first"][0] == 0 and np.array_equal(end[:-1], self.list["first"][1:]))
        expect("and are all", end[-1] == len(self.list["id"]))

    def contacts(self, record):
        rows = slice(self.list["first"][record], self.list["first"][record] + self.list["count"][record])
        return {name: values[rows] for name, values in self.list.items() if name not in ("first", "count")}

    def ends(self, record, contacts):
        """[c, 2, 3]: centres of the disks; of the ground what is next to the centre, by the id of the contact."""
        centre = np.zeros((self.disks, 3))
        centre[:, :2] = self.q[record].reshape(-1, 3)[:, :2]
        ends = np.zeros((len(contacts["id"]), 2, 3))
        for i, (number, (a, b)) in enumerate(zip(contacts["id"], contacts["block"])):
            ends[i, 1] = centre[b]
            ends[i, 0] = centre[a]
            if a < 0:
                expect("id of the ground", number // 3 == b)
                ends[i, 0] = centre[b]
                axis, at = ((1, 0.0), (0, 0.0), (0, self.width))[number % 3]
                ends[i, 0, axis] = at
        return ends


def check_bodies(run, path):
    with h5py.File(path) as f:
        root = f["VTKHDF"]
        size, names = int(root["NumberOfPoints"][0]), list(root["CellData/body"].attrs["names"])
        points = root["Points"][...].reshape(run.n, size, 3)
        ids, offsets, number = root["Polygons/Connectivity"][...], root["Polygons/Offsets"][...], root["CellData/body"][...]
        expect("times", np.array_equal(root["Steps/Values"], run.time))
    for disk in (0, run.disks // 2, run.disks - 1):
        cells = np.flatnonzero(number == names.index(f"disk {disk}"))
        mine = np.unique(np.concatenate([ids[offsets[c] : offsets[c + 1]] for c in cells]))
        centre = run.q[:, None, 3 * disk : 3 * disk + 2]
        off = points[:, mine, :2] - centre
        expect("radius", np.abs(np.hypot(off[..., 0], off[..., 1]) - RADIUS).max() < EPS)
        turned = np.arctan2(off[:, 0, 1], off[:, 0, 0]) - run.q[:, 3 * disk + 2]
        expect("angle", np.abs(np.exp(1j * turned) - np.exp(1j * turned[0])).max() < 1e-10)


def check_contacts(run, path):
    with h5py.File(path) as f:
        root = f["VTKHDF"]
        most = int(root["Lines/NumberOfCells"][0])
        expect("as many lines as the most", most == run.list["count"].max())
        points = root["Points"][...].reshape(run.n, most, 2, 3)
        data = {name: root[f"CellData/{name}"][...].reshape(run.n, most) for name in root["CellData"]}
        for name in data:
            expect(f"offsets of {name}", np.array_equal(root[f"Steps/CellDataOffsets/{name}"], most * np.arange(run.n)))
        expect("offsets of points", np.array_equal(root["Steps/PointOffsets"], 2 * most * np.arange(run.n)))
    for record in range(run.n):
        contacts = run.contacts(record)
        count = len(contacts["id"])
        expect("ids", np.array_equal(data["id"][record, :count], contacts["id"]) and np.all(data["id"][record, count:] == -1))
        expect("normal forces", np.array_equal(data["normal_force"][record, :count], contacts["normal_impulse"] / run.dt))
        friction = np.abs(contacts["tangential_impulse"][:, 0]) / run.dt
        expect("friction", np.abs(data["friction_force"][record, :count] - friction).max(initial=0) < EPS * (1 + friction.max(initial=0)))
        expect("modes, gaps", all(np.array_equal(data[n][record, :count], contacts[n]) for n in ("mode", "gap")))
        expect("ends", np.abs(points[record, :count] - run.ends(record, contacts)).max(initial=0) < EPS)
        expect("no length", not np.any(points[record, count:, 0] - points[record, count:, 1]))


def check_page(run, path):
    with open(path, encoding="utf-8") as file:
        scene = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', file.read()).group(1))
    expect("frames", np.allclose(scene["time"], run.time) and len(scene["forces"]) == run.n)
    poses = {body["name"]: np.array(body["pose"]) for body in scene["bodies"]}
    for disk in range(run.disks):
        x, y, angle = run.q[:, 3 * disk : 3 * disk + 3].T
        expect("pose", np.abs(poses[f"disk {disk}"] - np.column_stack([x, y, np.cos(angle), np.sin(angle)])).max() < 1e-5)
    scales = []
    for record, lines in enumerate(scene["forces"]):
        contacts = run.contacts(record)
        pushing = contacts["normal_impulse"] > 0
        ends = run.ends(record, contacts)[pushing].reshape(-1, 6)
        one_wall = contacts["block"][pushing, 0] < 0  # several contacts of a disk with the ground are one line
        expect("a line for each pair", len(lines) == np.count_nonzero(~one_wall) + len(set(contacts["block"][pushing, 1][one_wall])))
        for *line, weight in lines:
            near = np.flatnonzero(np.abs(ends - line).max(axis=1) < 1e-5)
            expect("a line is that of a contact", len(near) == 1)
            if not one_wall[near[0]]:
                scales.append(contacts["normal_impulse"][pushing][near[0]] / weight if weight > 0.01 else np.nan)
    expect("one scale", np.nanmax(scales) / np.nanmin(scales) < 1.001)


def check_vtk(path, run):
    """By VTK itself, where it is."""
    try:
        from vtkmodules.vtkIOHDF import vtkHDFReader
    except ImportError:
        return "not read by VTK"
    reader = vtkHDFReader()
    reader.SetFileName(path)
    for record in (0, run.n // 2, run.n - 1):
        reader.SetStep(record)
        reader.Update()
        got = reader.GetOutput()
        ids = [got.GetCellData().GetArray("id").GetValue(i) for i in range(got.GetNumberOfCells())]
        expect("ids by VTK", ids[: run.list["count"][record]] == run.contacts(record)["id"].tolist())
    return "read by VTK"


def check_xarray(path):
    try:
        import h5netcdf  # noqa: F401
        import xarray
    except ImportError:
        return "not by xarray"
    run = Run(path)
    with xarray.open_dataset(path, engine="h5netcdf", group="contacts") as contacts:
        expect("dimensions", contacts.gap.dims == ("id",) and contacts.block.dims == ("id", "side") and
               contacts["first"].dims == ("time",))
        which = int(run.list["id"][-1])
        mine = contacts.normal_impulse.sel(id=which)
        expect("by id", np.array_equal(np.ravel(mine), run.list["normal_impulse"][run.list["id"] == which]))
    with xarray.open_dataset(path, engine="h5netcdf") as whole:
        expect("coordinates", whole.q.dims == ("time", "coordinate"))
    return "by xarray"


def check_file(stem):
    run = Run(f"{stem}.h5")
    expect("contacts enough", run.list["count"].max() > run.disks / 2)
    check_bodies(run, f"{stem}.vtkhdf")
    check_contacts(run, f"{stem}.contacts.vtkhdf")
    check_page(run, f"{stem}.html")
    print(stem, check_vtk(f"{stem}.contacts.vtkhdf", run), check_xarray(f"{stem}.h5"))


def check_disks(disks_run):
    for compress in ("0",) if tools.QUICK else ("0", "3"):
        stem = f"disks{compress}"
        tools.runs_plainly([disks_run, f"{stem}.h5", "24", "6", "120", "5", compress])
        said = tools.runs("nsdae-vtk", f"{stem}.h5")
        tools.expect(re.search("^their contacts in disks.*contacts.vtkhdf", said, re.MULTILINE), "nsdae-vtk:", said)
        tools.runs("nsdae-animate", "--forces", "-o", f"{stem}.html", *([] if tools.QUICK else ["-o", f"{stem}.gif"]), f"{stem}.h5")
        if not tools.QUICK:
            tools.runs("nsdae-plot", f"{stem}.h5")
        tools.runs("nsdae-plot", "--only", "contacts", "-o", "few.svg", f"{stem}.h5")
        with open("few.svg", encoding="utf-8") as file:
            tools.expect("<svg" in file.read(), "few.svg")
        with tools.judged(stem):
            check_file(stem)


def check_space():
    """Hundreds of balls in space."""
    listed_space.make("balls.h5")
    tools.runs("nsdae-vtk", "balls.h5")
    tools.runs("nsdae-animate", "--forces", "-o", "balls.html", *([] if tools.QUICK else ["-o", "balls.gif"]), "balls.h5")
    with tools.judged("balls"):
        listed_space.check("balls.h5", "balls.vtkhdf", "balls.html")


def check_forces(program, *arguments):
    """Fixed contacts and a list with points and forces: points in the file of contacts, lines from there on the page."""
    tools.runs(f"nsdae-{program}", "--quiet", "--t-end", "0.5", "--every", "25", "--set", "contact_forces=1", *arguments, "--output", "f.h5")
    tools.runs("nsdae-vtk", "f.h5")
    tools.runs("nsdae-animate", "--forces", "-o", "f.html", "f.h5")
    with tools.judged(program), h5py.File("f.h5") as f, h5py.File("f.contacts.vtkhdf") as g, open("f.html", encoding="utf-8") as page:
        root = g["VTKHDF"]
        scene = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read()).group(1))
        n, most = len(f["time"]), int(root["Vertices/NumberOfCells"][0])
        points, force = root["Points"][...].reshape(n, most, 3), root["PointData/force"][...].reshape(n, most, 3)
        data = {name: root[f"PointData/{name}"][...].reshape(n, most) for name in ("id", "normal_force", "friction_force")}
        expect("offsets", all(np.array_equal(root[f"Steps/{name}"], most * np.arange(n)) for name in ("PointOffsets", "PointDataOffsets/force")))
        seen = 0
        for record in range(n):
            first, count = (f[f"contacts/{name}"][record] for name in ("first", "count")) if "contacts/first" in f else (0, 0)
            rows = slice(first, first + count) if count or "contacts/first" in f else record
            at, own = f["contacts/point"][rows], f["contacts/force"][rows]
            has = np.isfinite(at[:, 0])
            used = np.count_nonzero(has)
            expect("points and forces", np.array_equal(points[record, :used], at[has]) and np.array_equal(force[record, :used], own[has]))
            expect("unused", not force[record, used:].any() and np.all(data["id"][record, used:] == -1))
            size = np.hypot(data["normal_force"][record, :used], data["friction_force"][record, :used])
            expect("size", np.abs(size - np.linalg.norm(own[has], axis=1)).max(initial=0) < 1e-9 * size.max(initial=1))
            for *line, weight in scene["forces"][record]:
                tail, along = np.array(line[:3]), np.subtract(line[3:], line[:3])
                near = np.linalg.norm(at[has] - tail, axis=1) < 1e-4
                cosine = own[has][near] @ along / (np.linalg.norm(own[has][near], axis=1) * np.linalg.norm(along))
                expect("a line is that of a contact", weight == 1 and cosine.max() > 1 - 1e-3)
                seen += 1
        expect("forces", seen > 10)


def spoilt(name, value):
    shutil.copy("disks0.h5", "bad.h5")
    with h5py.File("bad.h5", "a") as file:
        file[name][-1] = value
    return "bad.h5"


def check_refused():
    """What does not fit together, in one line."""
    path = spoilt("contacts/first", 1000000)
    tools.refuses(1, "record 24 has contacts that are not in its list", "nsdae-vtk", path)
    tools.refuses(1, "record 24 has contacts that are not in its list", "nsdae-animate", "--forces", "-o", "bad.gif", path)
    tools.refuses(1, "record 24 has contacts that are not in its list", "nsdae-plot", path)
    tools.refuses(1, "its /shapes do not fit together", "nsdae-vtk", spoilt("shapes/position", 71))
    for shape in (9, 99):  # a polyhedron without points; none
        tools.refuses(1, "its /shapes do not fit together", "nsdae-animate", spoilt("shapes/shape", shape))
    with h5py.File("f.h5", "a") as file:
        values = file["contacts/force"][..., :2]
        del file["contacts/force"]
        file["contacts/force"] = values
    for program in (["nsdae-vtk"], ["nsdae-animate", "--forces"]):
        tools.refuses(1, "the columns of the contacts of record 0 do not fit together", *program, "f.h5")
    tools.runs("nsdae-bouncing-ball", "--quiet", "--t-end", "0.1", "--output", "ball.h5")
    tools.refuses(1, "has no contact forces and no contact list for --forces", "nsdae-animate", "--forces", "ball.h5")


check_disks(sys.argv[2])
check_space()
check_forces("gripper")
if tools.QUICK:
    check_forces("column", "--set", "balls=3", "--t-end", "0.5", "--every", "10")
else:
    check_forces("ragdoll")
check_refused()
tools.end()
