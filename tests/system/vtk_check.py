"""nsdae-vtk: what it wrote of every example against the trajectory: the structure of the file, and the bodies by what
the trajectory says on its own: gaps, potential energy, constraint drift, angles; by VTK itself too, where it is.
One-line errors, and a full disk. usage: vtk_check.py BIN_DIR DATA_DIR"""

import os
import sys

import h5py
import numpy as np
import tools

WRITTEN = ""  # the file that is looked at

EPS = 1e-12  # some 5000 roundings of values of order one


def close(name, a, b, scale=1.0):
    error = np.max(np.abs(np.asarray(a) - np.asarray(b))) / scale
    if not error <= EPS:
        sys.exit(f"{WRITTEN}: {name}: off by {error:.3g}, allowed {EPS:g}")


def expect(name, holds):
    if not holds:
        sys.exit(f"{WRITTEN}: {name}")


def drifted(name, f, error, factor=2):
    """The error is that of the constraints of its record, times at most this factor."""
    expect(f"{name}: beyond the drift", np.all(np.abs(error) <= factor * f["certificate/constraint_drift"][...] + EPS))


class Animation:
    """The file as the format's specification has it to be read."""

    def __init__(self, path):
        with h5py.File(path) as file:
            root = file["VTKHDF"]
            expect("type", root.attrs["Type"] == b"PolyData" and list(root.attrs["Version"]) == [2, 0])
            steps = root["Steps"]
            self.n = int(steps.attrs["NSteps"])
            self.time = steps["Values"][...]
            size = int(root["NumberOfPoints"][0])
            expect("one part", list(root["NumberOfPoints"]) == [size] and np.all(steps["NumberOfParts"][...] == 1))
            expect("one topology", not np.any(steps["CellOffsets"][...]) and not np.any(steps["PartOffsets"][...]))
            expect("steps", all(len(steps[s]) == self.n for s in ("Values", "PartOffsets", "PointOffsets")))
            first = steps["PointOffsets"][...]
            points = root["Points"][...]
            expect("points", points.dtype == np.float64 and len(points) == size * self.n)
            self.points = np.array([points[f : f + size] for f in first])
            cells = root["Polygons"]
            ids, offsets = cells["Connectivity"][...], cells["Offsets"][...]
            expect("sizes", cells["NumberOfCells"][0] == len(offsets) - 1 and cells["NumberOfConnectivityIds"][0] == len(ids))
            expect("offsets", offsets[0] == 0 and offsets[-1] == len(ids) and np.all(np.diff(offsets) >= 3))
            expect("ids", ids.min() >= 0 and ids.max() < size)
            self.polygons = [ids[a:b] for a, b in zip(offsets, offsets[1:])]
            self.number = root["CellData/body"][...]
            self.dark = root["CellData/dark"][...]
            self.names = [str(name) for name in root["CellData/body"].attrs["names"]]
            expect("a body for each polygon", len(self.number) == len(self.polygons))
            expect("names", len(set(self.names)) == len(self.names))
            self.of = {name: [] for name in self.names}
            for polygon, i in zip(self.polygons, self.number):
                self.of[self.names[i]].append(polygon)

    def polygons_of(self, name):
        return self.of[name]

    def body(self, name):
        """Its points [n, p, 3]."""
        return self.points[:, np.unique(np.concatenate(self.polygons_of(name)))]

    def centre(self, name):
        return self.body(name).mean(axis=1)


def volume(points, polygons):
    """By the divergence theorem over fans of triangles: positive where all look outwards."""
    return sum(np.dot(points[p[0]], np.cross(points[p[i]], points[p[i + 1]])) / 6
               for p in polygons for i in range(1, len(p) - 1))


def check_surfaces(a):
    """Every edge is met once in each direction: closed and oriented; the volume is positive."""
    shift = list(map(tuple, np.round(a.points[0], 9).tolist()))
    for name in a.names:
        polygons = a.polygons_of(name)
        edges = [(shift[x], shift[y]) for p in polygons for x, y in zip(p, np.roll(p, -1)) if shift[x] != shift[y]]
        expect(f"{name} is closed", sorted(edges) == sorted((y, x) for x, y in edges))
        expect(f"{name} looks outwards", volume(a.points[0] - a.points[0, polygons[0][0]], polygons) > 0)


def along(a, name, centre, angle):
    """Distances of a body's points from its centre, along the direction that hangs at that angle."""
    out = a.body(name)[..., :2] - centre[:, None, :2]
    return np.einsum("npi,ni->np", out, np.column_stack([np.sin(angle), -np.cos(angle)]))


def pendulum(a, f, p):
    q = f["q"][...]
    half = along(a, "rod", q, q[:, 2])
    close("length of the rod", np.abs(half), p["L"] / 2)
    tip = np.array([x[h > 0].mean(axis=0) for x, h in zip(a.body("rod"), half)])
    close("gap at the tip", tip[:, 0] - q[:, 0] + p["L"] / 2 * np.sin(q[:, 2]), f["contacts/gap"][:, 0])
    close("potential", p["m"] * p["g"] * a.centre("rod")[:, 1], f["energy/potential"][...], p["m"] * p["g"])


def clearance_hinge(a, f, p):
    q = f["q"][...]
    close("length of the rod", np.abs(along(a, "rod", q, q[:, 2])), p["l"] / 2)
    distance = np.linalg.norm(a.centre("shaft") - a.centre("hole"), axis=1)
    close("gap", p["R"] - p["r"] - distance, f["contacts/gap"][:, 0])
    close("radius", np.linalg.norm((a.body("shaft") - a.centre("shaft")[:, None])[..., :2], axis=2), p["r"])
    close("potential", p["m"] * p["g"] * a.centre("rod")[:, 1], f["energy/potential"][...], p["m"] * p["g"])


def crank_slider(a, f, p):
    crank, rod, slider = (a.centre(name) for name in ("crank", "rod", "slider"))
    close("slider in the slot", np.abs(slider[:, 0]), f["certificate/constraint_drift"][...])
    close("joint at the pin", 2 * crank, 2 * rod - slider)
    close("length of the crank", np.linalg.norm(2 * crank, axis=1), p["L1"])
    close("length of the rod", 2 * np.linalg.norm(rod - slider, axis=1), p["L2"])
    u = slider[:, 1] + p["L1"] + p["L2"]
    U = p["g"] * (p["m1"] * crank[:, 1] + p["m2"] * rod[:, 1] + p["m3"] * slider[:, 1]) + p["k"] * u * u / 2
    close("potential", U, f["energy/potential"][...], np.abs(U).max())


def squeezer(a, f, p):
    K = {name: 2 * a.centre(name)[:, :2] for name in a.names}  # begin + end of each link
    O, A, B, C = np.zeros(2), np.array([-0.06934, -0.00227]), np.array([-0.03635, 0.03273]), np.array([0.014, 0.072])
    F, G, H, P = K["K1"] - O, K["K5"] - A, K["K7"] - A, K["K3"] - B
    for name, begin in (("K2", F), ("K4", G), ("K6", H)):
        drifted(f"end of {name}", f, np.linalg.norm(K[name] - begin - P, axis=1))
    for name, link, length in (("K1", F - O, 7e-3), ("K2", P - F, 28e-3), ("K3", P - B, 35e-3), ("K4", P - G, 2e-2),
                               ("K5", G - A, 4e-2), ("K6", P - H, 2e-2), ("K7", H - A, 4e-2)):
        drifted(f"length of {name}", f, np.linalg.norm(link, axis=1) - length)
    longer = np.linalg.norm(K["K3, arm"] - B - C, axis=1) - p["rest"]  # D from C
    U = p["stiffness"] * longer**2 / 2 - p["torque"] * f["q"][:, 0]
    close("potential", U, f["energy/potential"][...], 4530 * 0.02)  # stiffness times a length


def car_axis(a, f, p):
    left, right, axis = (2 * a.centre(name)[:, :2] for name in ("left spring", "right spring", "axis"))
    foot = right - (axis - left)
    drifted("length of the axis", f, np.linalg.norm(axis - 2 * left, axis=1) - p["L"])
    close("distance of the feet", np.linalg.norm(foot, axis=1), p["L"])
    drifted("right angle", f, np.einsum("ni,ni->n", left, foot))
    longer = np.array([np.linalg.norm(x, axis=1) - p["L0"] for x in (left, axis - left - foot)])
    U = p["k"] * (longer**2).sum(axis=0) / 2 + p["M"] * p["g"] / 2 * axis[:, 1]
    close("potential", U, f["energy/potential"][...], p["k"] * p["L"])


def flexible_crank(a, f, p):
    crank, rod, slider = (a.centre(name)[:, :2] for name in ("crank", "rod", "slider"))
    close("joint at the pin", 2 * crank, 2 * rod - slider)
    close("length of the crank", np.linalg.norm(2 * crank, axis=1), 0.15)
    close("length of the rod", 2 * np.linalg.norm(rod - slider, axis=1), 0.3 + f["q"][:, 6])
    drifted("angle of the motor", f, np.unwrap(np.arctan2(crank[:, 1], crank[:, 0])) - p["omega"] * f["time"][...])


def incline(a, f, p):
    q, block = f["q"][...], a.centre("block")
    U = p["m"] * p["g"] * block[:, 2]
    close("potential", U - U[0], f["energy/potential"][...] - f["energy/potential"][0])
    close("way", np.linalg.norm(block - block[0], axis=1), np.linalg.norm(q - q[0], axis=1))
    top, bottom = a.body("plane")[0], a.body("block")
    normal = np.array([np.sin(p["slope"]) * np.cos(p["turn"]), np.sin(p["slope"]) * np.sin(p["turn"]), np.cos(p["slope"])])
    close("gap", (bottom @ normal).min(axis=1) - (top @ normal).max(), f["contacts/gap"][:, 0])


def turned(e, x):
    """x [p, 3] by the quaternions e [n, 4]: e (0, x) e* / |e|^2, product by product."""
    w, u = e[:, None, :1], e[:, None, 1:]
    x = x[None]
    scalar, vector = -np.sum(u * x, axis=-1, keepdims=True), w * x + np.cross(np.broadcast_to(u, (*u.shape[:1], x.shape[1], 3)), x)
    back = -scalar * u + w * vector + np.cross(vector, np.broadcast_to(-u, vector.shape))
    return back / np.sum(e * e, axis=-1)[:, None, None]


def rolling_ball(a, f, p):
    q, v = f["q"][...], f["v"][...]
    ball = a.body("ball")
    close("radius", np.linalg.norm(ball - q[:, None, :3], axis=2), p["r"])
    close("potential", p["m"] * p["g"] * q[:, 2], f["energy/potential"][...])
    close("orientation", ball - q[:, None, :3], turned(q[:, 3:], ball[0] - q[0, :3]))
    expect("octants", set(a.dark) == {0, 1} and abs(np.mean(a.dark[a.number == a.names.index("ball")]) - 0.5) < 0.01)
    # a step turns by its mean angular velocity, to second order: the rest goes with its third power
    mean = (v[1:, 3:] + v[:-1, 3:]) / 2 * np.diff(a.time)[:, None]
    for i in range(1, a.n):  # the turn that fits best (least squares, SVD)
        U, _, V = np.linalg.svd((ball[i] - q[i, :3]).T @ (ball[i - 1] - q[i - 1, :3]))
        R = U @ V
        axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
        angle = np.linalg.norm(mean[i - 1])
        expect("turn of a step", np.linalg.norm(axis - mean[i - 1] * np.sinc(angle / np.pi)) <= angle**3 / 8)


def bouncing_ball(a, f, p):
    ball, floor = a.body("ball"), a.body("floor")
    close("gap", ball[..., 1].min(axis=1) - floor[..., 1].max(axis=1), f["contacts/gap"][:, 0])
    U = p["m"] * p["g"] * a.centre("ball")[:, 1]
    close("potential", U - U[0], f["energy/potential"][...] - f["energy/potential"][0], U.max())


def shaken_ball(a, f, p):
    ball, table = a.body("ball"), a.body("table")
    close("gap", ball[..., 1].min(axis=1) - table[..., 1].max(axis=1), f["contacts/gap"][:, 0])
    U = p["m"] * p["g"] * a.centre("ball")[:, 1]
    close("potential", U - U[0], f["energy/potential"][...] - f["energy/potential"][0])


def falling_rod(a, f, p):
    q, rod = f["q"][...], a.body("rod")
    half = along(a, "rod", q, q[:, 2] + np.pi / 2)
    close("length of the rod", np.abs(half), p["l"])
    ends = [np.array([x[s * h > 0].mean(axis=0) for x, h in zip(rod, half)]) for s in (-1, 1)]
    close("gaps", np.column_stack([end[:, 1] for end in ends]), f["contacts/gap"][...])
    close("floor", a.body("floor")[..., 1].max(), 0)
    close("potential", p["m"] * p["g"] * a.centre("rod")[:, 1], f["energy/potential"][...], p["m"] * p["g"])


def newtons_cradle(a, f, p):
    names = [name for name in a.names if name.startswith("ball")]
    balls = np.array([a.centre(name) for name in names])
    reach = [np.ptp(a.body(name)[..., 0], axis=1) / 2 for name in names]
    for i, name in enumerate(names):  # each at its string, which hangs from its place at the height L
        string = a.body(name.replace("ball", "string"))
        low = np.array([points[points[:, 1] < p["L"] / 2 + balls[i, k, 1] / 2].mean(axis=0) for k, points in enumerate(string)])
        close("end of a string", low, balls[i])
    between = np.diff(balls[..., 0], axis=0) - np.add(reach[1:], reach[:-1])
    close("gaps", between.T, f["contacts/gap"][...])
    close("potential", p["m"] * p["g"] * balls[..., 1].sum(axis=0), f["energy/potential"][...])


def woodpecker(a, f, p):
    gap, wall = f["contacts/gap"][...], a.body("sleeve, right")
    middle = (a.centre("sleeve, left") + a.centre("sleeve, right")) / 2
    beak = a.body("beak")
    tip = np.argmin(beak[0, :, 0])  # nearest to the pole
    close("gap of the beak", beak[:, tip, 0] - p["r_0"], gap[:, 0])
    close("radius of the pole", np.ptp(a.body("pole")[..., 0]) / 2, p["r_0"])
    low, high = (edge(wall[0, :, 1]) for edge in (np.min, np.max))  # at the start the tilt is small
    for contact, level in ((1, low), (2, high)):
        corner = np.argmin(np.hypot(wall[0, :, 0] - p["r_0"] - gap[0, contact], wall[0, :, 1] - level))
        close("gaps of the sleeve", wall[:, corner, 0] - p["r_0"], gap[:, contact])
    bird = a.centre("spring")[:, 1] * 2 - (middle[:, 1] + p["l_M"] * f["q"][:, 1])
    turn = f["q"][:, 1] - f["q"][:, 2]
    U = p["g"] * (p["m_M"] * middle[:, 1] + p["m_S"] * bird) + p["c"] * turn**2 / 2
    close("potential", U, f["energy/potential"][...])


def blocks(a, f, p, corners):
    """Each block's corners [blocks, 4, 2] at the start, moved as q says; of density 1 kg/m^2."""
    q = f["q"][...].reshape(a.n, -1, 3)
    expect("number of blocks", q.shape[1] == len(corners) == len(a.names) - 1)
    expect("turned at the start", not np.any(q[0, :, 2]))
    U = 0
    for i, corner in enumerate(corners):
        out, x = corner - q[0, i, :2], q[:, i, None]
        c, s = np.cos(x[..., 2]), np.sin(x[..., 2])
        face = np.stack([x[..., 0] + c * out[:, 0] - s * out[:, 1], x[..., 1] + s * out[:, 0] + c * out[:, 1]], axis=-1)
        points = a.body(f"polygon {i + 1}")  # its front and its back
        close("corners", points[..., :2], np.concatenate([face, face], axis=1))
        close("faces", points[..., 2], points[0, -1, 2] * np.repeat([-1, 1], 4))
        d, e = corner[2] - corner[0], corner[3] - corner[1]
        U = U + p["g"] * (d[0] * e[1] - d[1] * e[0]) / 2 * q[:, i, 1]
    energy = f["energy/potential"][...]
    close("potential", U - U[0], energy - energy[0], np.abs(U).max())
    close("floor", a.body("plane 0")[..., 1].max(), 0)


def arch(a, f, p):
    angle = np.linspace(0, np.pi, p["blocks"] + 1)
    inner, outer = (p["R"] * (1 + side * p["t"] / 2) * np.column_stack([np.cos(angle), np.sin(angle)]) for side in (-1, 1))
    blocks(a, f, p, np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1))


def rectangles(left, right, low, high):
    left, right, low, high = np.broadcast_arrays(left, right, low, high)
    return np.stack([np.column_stack(corner) for corner in ((left, low), (right, low), (right, high), (left, high))], axis=1)


def dominoes(a, f, p):
    front = np.arange(p["n"]) * (p["s"] + p["d"])
    blocks(a, f, p, rectangles(front - p["d"], front, 0, p["h"]))


def wall(a, f, p):
    """Joints of every second course are in the middle between those of the others."""
    end, corners = p["length"] * p["width"], []
    for course in range(p["courses"]):
        joint = np.arange(p["length"] + 1) * p["width"]
        if course % 2:
            joint = np.concatenate([[0], joint[:-1] + p["width"] / 2, [end]])
        corners.append(rectangles(joint[:-1] + p["gap"] / 2, joint[1:] - p["gap"] / 2,
                                  course * p["height"], (course + 1) * p["height"]))
    blocks(a, f, p, np.concatenate(corners))


def planar(a, q, name):
    """The body moves as q [n, 3] of its centre; its points beside the centre at the start [p, 2]."""
    out, c, s = a.body(name)[..., :2] - q[:, None, :2], np.cos(q[:, 2, None]), np.sin(q[:, 2, None])
    own = np.stack([c * out[..., 0] + s * out[..., 1], c * out[..., 1] - s * out[..., 0]], axis=-1)
    close(f"motion of {name}", own, own[:1])
    return own[0]


def gripper(a, f, p):
    q, s = f["q"][...].reshape(a.n, -1, 3), p["size"]
    for i, half in enumerate([(1.5, 0.2), (0.1, 0.9), (0.1, 0.9), (0.5, 0.5)]):
        close("half sizes", np.abs(planar(a, q[:, i], f"polygon {i}")), s * np.array(half))
    for finger, side in ((1, -1), (2, 1)):
        close("a finger at the box", side * (q[:, finger, 0] - q[:, 3, 0]), 0.6 * s)


def geneva(a, f, p):
    """A slot is between the side of a tooth and that of the next one, which are parallel, as far apart as the pin is wide."""
    q, n, C = f["q"][...].reshape(a.n, -1, 3), p["slots"], p["distance"]
    teeth = [np.unique(np.round(planar(a, q[:, 0], f"polygon {i}"), 14), axis=0) for i in range(n)]
    for i in range(n):
        angle = (2 * i + 1) * np.pi / n  # of the slot after the tooth i
        for tooth, side in ((teeth[i], -1), (teeth[(i + 1) % n], 1)):
            beside = side * tooth @ [-np.sin(angle), np.cos(angle)]
            close("sides of a slot", np.sort(beside)[:2], p["pin"] + p["play"])
            close("end of a slot", (tooth @ [np.cos(angle), np.sin(angle)]).max(), C * np.cos(np.pi / n))
    pin = planar(a, q[:, 1], f"disc {n + 1}")
    close("the pin", np.linalg.norm(pin - [C * np.sin(np.pi / n), 0], axis=1), p["pin"])


def backlash(a, f, p):
    """The wheels roll on each other. The arm is as far from each stop of the gear as the gap of its limit."""
    q = f["q"][...].reshape(a.n, -1, 3)
    wheels = [planar(a, q[:, i], f"disc {i}") for i in range(2)]
    radius = [np.linalg.norm(w, axis=1) for w in wheels]
    close("wheels touch", radius[0].max() + radius[1].max(), np.ptp(q[0, :2, 0]))
    drifted("rolling", f, radius[0].max() * q[:, 0, 2] + radius[1].max() * q[:, 1, 2])
    arm = np.column_stack([np.cos(q[:, 2, 2]), np.sin(q[:, 2, 2])])  # its normal, to the right
    width = np.ptp(planar(a, q[:, 2], "segment 4")[:, 0]) / 2
    for side, (stop, gap) in zip((-1, 1), (("disc 2", 0), ("disc 3", 1))):
        out = a.centre(stop)[:, :2]
        angle = np.arcsin(side * np.einsum("ni,ni->n", out, arm) / np.linalg.norm(out, axis=1))
        touching = np.arcsin(2 * width / np.linalg.norm(out, axis=1))
        close(f"gap of {stop}", angle - touching, f["contacts/gap"][:, gap])


def spheres(a, f, p, names, mass):
    q = f["q"][...].reshape(a.n, -1, 7)
    expect("number of spheres", q.shape[1] == len(names) == len(mass))
    for i, name in enumerate(names):
        out = a.body(name) - q[:, i, None, :3]
        close("radius", np.linalg.norm(out, axis=2), p["r"])
        close("both poles", np.abs(out.sum(axis=1)), 0)
        close("orientation", out, turned(q[:, i, 3:], turned(q[:1, i, 3:] * [1, -1, -1, -1], out[0])[0]))
    U, energy = p["g"] * q[..., 2] @ mass, f["energy/potential"][...]
    close("potential", U - U[0], energy - energy[0], np.abs(U).max())
    close("floor", a.body("plane 0")[..., 2].max(), 0)


def column(a, f, p):
    n = p["balls"]
    expect("number of bodies", len(a.names) == 1 + n)
    spheres(a, f, p, [f"sphere {i + 1}" for i in range(n)], p["m"] * np.where(np.arange(n) % 2, p["ratio"], 1))
    close("place", f["q"][0].reshape(n, 7)[:, :3], np.outer(2 * np.arange(n) + 1, [0, 0, p["r"]]), 2 * n * p["r"])


def heap(a, f, p):
    n = p["spheres"]
    side = int(np.ceil(np.cbrt(n / 2) - 1e-9))
    grit = (6 * side) ** 2 if p["rough"] else 0
    expect("number of bodies", len(a.names) == 1 + grit + n)
    place = 2 * p["r"] * (np.arange(6 * side) - (6 * side - 1) / 2)
    for i in range(grit):  # row by row
        out = a.body(f"sphere {i + 1}") - [place[i % (6 * side)], place[i // (6 * side)], 0]
        close("grit", np.linalg.norm(out, axis=2), p["r"])
    mass = np.full(n, 1000 * 4 / 3 * np.pi * p["r"] ** 3)
    spheres(a, f, p, [f"sphere {grit + i + 1}" for i in range(n)], mass)


def moved(a, f, name, first):
    """Its bodies of that name, numbered from the first on: their centres, and motions of their corners as one body."""
    q = f["q"][...].reshape(a.n, -1, 7)
    for i in range(q.shape[1]):
        out = a.body(f"{name} {i + first}") - q[:, i, None, :3]
        close("centre", out.mean(axis=1), 0)
        close("orientation", out, turned(q[:, i, 3:], turned(q[:1, i, 3:] * [1, -1, -1, -1], out[0])[0]))


def scene(a, f, p):
    moved(a, f, "box", 5)


def ragdoll(a, f, p):
    """Each corner of the stairs is one of a tread."""
    moved(a, f, "capsule", 2)
    stairs = a.body("mesh 1")[0]
    for i in range(p["steps"]):
        tread = stairs[np.abs(stairs[:, 2] - (p["steps"] - i) * p["rise"]) < 1e-9]
        close("a step", tread.max(axis=0)[:2], [1, (0.5 - i) * p["run"]])
        close("a step", tread.min(axis=0)[:2], [-1, -(i + 0.5) * p["run"]])


def cam(a, f, p):
    """The highest point of the cam is at the face of the follower: the overlap is at most a step of its corners, 0.1 mm."""
    gap = a.body("polygon 1")[..., 1].min(axis=1) - a.body("polygon 0")[..., 1].max(axis=1)
    expect("the follower is on the cam", np.abs(gap).max() < 1e-4)


def gears(a, f, p):
    """The tips are as far from the axes as the addendum, a module."""
    apart, first = p["module"] * (p["driver"] + p["driven"]) / 2, p["driver"] + 1
    for number, teeth, x in ((0, p["driver"], 0), (first, p["driven"], apart)):
        for i in range(teeth):
            out = np.linalg.norm(a.body(f"polygon {number + i}")[..., :2] - [x, 0], axis=2).max(axis=1)
            close("addendum", out, p["module"] * (teeth / 2 + 1))


CHECKS = {"bouncing-ball": bouncing_ball, "falling-rod": falling_rod, "newtons-cradle": newtons_cradle,
          "woodpecker": woodpecker, "pendulum": pendulum, "clearance-hinge": clearance_hinge, "crank-slider": crank_slider,
          "incline": incline, "rolling-ball": rolling_ball, "arch": arch, "dominoes": dominoes, "wall": wall, "column": column,
          "heap": heap, "shaken-ball": shaken_ball, "squeezer": squeezer, "car-axis": car_axis,
          "flexible-crank": flexible_crank, "scene": scene, "gripper": gripper,
          "geneva": geneva, "ragdoll": ragdoll, "backlash": backlash, "cam": cam, "gears": gears}


def check_with_vtk(a):
    """The reader of ParaView sees the same steps, times, points and cells; None: no such VTK here."""
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkVersion
        from vtkmodules.vtkIOHDF import vtkHDFReader
    except ImportError:
        return "no vtk here: read back with h5py only"
    version = vtkVersion.GetVTKVersion()
    if tuple(map(int, version.split(".")[:2])) < (9, 3):
        return f"vtk {version} is too old for PolyData in time (9.3): read back with h5py only"
    reader = vtkHDFReader()
    reader.SetFileName(WRITTEN)
    reader.UpdateInformation()
    expect("VTK's number of steps", reader.GetNumberOfSteps() == a.n)
    for step in range(0, a.n, max(1, a.n // 40)):
        reader.SetStep(step)
        reader.Update()
        got = reader.GetOutput()
        expect("VTK's time", reader.GetTimeValue() == a.time[step])
        expect("VTK's points", np.array_equal(vtk_to_numpy(got.GetPoints().GetData()), a.points[step]))
        expect("VTK's polygons", got.GetNumberOfPolys() == got.GetNumberOfCells() == len(a.polygons))
        expect("VTK's bodies", np.array_equal(vtk_to_numpy(got.GetCellData().GetArray("body")), a.number))
    return f"read back with vtk {version}"


def check_example(example):
    global WRITTEN
    WRITTEN = f"{example}.vtkhdf"
    a = Animation(WRITTEN)
    with h5py.File(f"{example}.h5") as f:
        expect("times", np.array_equal(a.time, f["time"][...]))
        check_surfaces(a)
        CHECKS[f.attrs["model"]](a, f, {k: v[()] for k, v in f["parameters"].items()})
    print(f"{WRITTEN}: {a.n} steps, {len(a.names)} bodies; {check_with_vtk(a)}")


SHORTER = {"column": ("--set", "balls=20"), "heap": ("--t-end", "0.2"), "scene": ("--t-end", "0.2"),
           "ragdoll": ("--t-end", "0.2")}  # their meshes are large


def check_examples(data):
    count = 0
    for example in tools.examples():
        tools.make(example, data, SHORTER.get(example, ()))
        tools.runs("nsdae-vtk", f"{example}.h5")
        with tools.judged(example):
            check_example(example)
        count += 1
    tools.expect(count >= (9 if tools.QUICK else 15), count, "examples")


def check_options():
    """Thinned out: records 0, 7, 14 ...; and points at coordinates. As users start it."""
    said = tools.started_by_launcher("nsdae-vtk", "--every", "7", "-o", "few.vtkhdf", "--point", "0,1,-", "--point", "2,-,-",
                                     "pendulum.h5")
    with h5py.File("pendulum.h5") as g:
        steps = len(g["time"][::7])
    tools.expect(said.startswith(f"{steps} steps of 2 bodies"), "--every 7:", said)
    with h5py.File("few.vtkhdf") as f, h5py.File("pendulum.h5") as g:
        q, points = g["q"][::7], f["VTKHDF/Points"][...].reshape(steps, 2, -1, 3).mean(axis=2)
        tools.expect(np.array_equal(f["VTKHDF/Steps/Values"], g["time"][::7]), "--every: times")
        tools.expect(np.abs(points[:, 0, :2] - q[:, :2]).max() < 1e-12 and np.abs(points[:, 0, 2]).max() < 1e-12, "--point 0,1,-")
        tools.expect(np.abs(points[:, 1, 0] - q[:, 2]).max() < 1e-12, "--point 2,-,-")


def check_errors():
    def refuses(code, words, *arguments):
        tools.refuses(code, words, "nsdae-vtk", *arguments)

    with h5py.File("pendulum.h5") as old, h5py.File("other.h5", "w") as new:
        for name in ("time", "q"):
            old.copy(name, new)
        new.attrs.update(old.attrs)
        new.attrs["model"] = "bead"
    with open("text.h5", "w", encoding="ascii") as file:
        file.write("text")
    refuses(1, "cannot read 'none.h5': No such file or directory", "none.h5")
    refuses(1, "cannot read 'text.h5'", "text.h5")
    refuses(1, "'pendulum.vtkhdf' is not an nsdae trajectory", "pendulum.vtkhdf", "-o", "x")
    refuses(1, "'other.h5' names no bodies", "other.h5")
    refuses(1, "--point 0,1,-", "other.h5")
    refuses(1, "the coordinates 0 to 2, not 3", "other.h5", "--point", "3,-,-")
    refuses(1, "cannot write 'no/x': No such file or directory", "pendulum.h5", "-o", "no/x")
    refuses(1, "cannot write '/': Is a directory", "pendulum.h5", "-o", "/")
    refuses(2, "is the trajectory itself", "pendulum.h5", "-o", "pendulum.h5")
    refuses(2, "--every 0 is outside its range", "pendulum.h5", "--every", "0")
    refuses(2, "X,Y,Z", "pendulum.h5", "--point", "1")
    refuses(2, "required: file")


def check_full_disk():
    """The reason, and the file that was there stays whole."""
    with open("pendulum.vtkhdf", "rb") as file:
        kept = file.read()
    done = tools.run("nsdae-vtk", "pendulum.h5", most=100 * 512)
    tools.expect(done.code == 1 and "cannot write 'pendulum.vtkhdf': File too large" in done.err, "full disk:", done.code, done.err)
    with open("pendulum.vtkhdf", "rb") as file:
        tools.expect(file.read() == kept, "the old file is lost")
    tools.expect(not os.path.exists("pendulum.vtkhdf.part"), "a part is left")


check_examples(sys.argv[2])
check_options()
check_errors()
check_full_disk()
tools.end()
