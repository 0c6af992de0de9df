"""A trajectory of 400 balls in space, placed by coordinates alone, made here number by number: what the programs draw
of it (of listed_check.py)."""

import json
import re
import sys

import h5py
import numpy as np

BALLS, RECORDS, RADIUS = 400, 5, 0.1


def motion():
    """Coordinates [n, 7 balls]: a cube of balls that turn and drift, quaternions of any length."""
    rng = np.random.default_rng(5)
    q = np.zeros((RECORDS, BALLS, 7))
    at = np.stack(np.unravel_index(np.arange(BALLS), (8, 8, 7)), axis=1) * 2.05 * RADIUS
    q[:, :, :3] = at + 0.01 * np.arange(RECORDS)[:, None, None] * rng.normal(size=(BALLS, 3))
    q[:, :, 3:] = rng.normal(size=(BALLS, 4)) + 0.2 * np.arange(RECORDS)[:, None, None] * rng.normal(size=(BALLS, 4))
    return q.reshape(RECORDS, -1)


def make(path):
    with h5py.File(path, "w") as f:
        f.attrs.update({"format": "nsdae-trajectory", "format_version": 3, "model": "balls", "method": "moreau", "status": "complete"})
        f["time"], f["q"] = 0.1 * np.arange(RECORDS), motion()
        f["options/dt"] = 0.1
        f["blocks/q"] = np.arange(0, 7 * BALLS, 7, dtype="i4")
        pairs = np.array([[i, i + 1] for i in range(0, BALLS - 1, 2)])
        count = np.full(RECORDS, len(pairs))
        count[0] = 0  # of the start there are none
        f["contacts/first"], f["contacts/count"] = np.cumsum(count) - count, count.astype("i4")
        rows = (RECORDS - 1) * len(pairs)
        f["contacts/id"], f["contacts/block"] = np.arange(rows) % len(pairs), np.tile(pairs, (RECORDS - 1, 1))
        for name in ("gap", "normal_impulse"):
            f[f"contacts/{name}"] = np.linspace(0.1, 1, rows)
        f["contacts/tangential_impulse"], f["contacts/mode"] = np.zeros((rows, 2)), np.ones(rows, "i4")
        f["shapes/name"] = [f"ball {i}" for i in range(BALLS)]
        columns = {"shape": 5, "dimension": 3, "points": 0}
        for name, value in columns.items():
            f[f"shapes/{name}"] = np.full(BALLS, value, "i4")
        f["shapes/position"], f["shapes/turn"] = 7 * np.arange(BALLS), 7 * np.arange(BALLS) + 3
        f["shapes/size"] = np.tile([RADIUS, 0, 0], (BALLS, 1))


def expect(name, holds):
    if not holds:
        sys.exit(f"listed_space: {name}")


def check(path, vtk, page):
    q = motion().reshape(RECORDS, BALLS, 7)
    with h5py.File(vtk) as f:
        root = f["VTKHDF"]
        points = root["Points"][...].reshape(RECORDS, BALLS, -1, 3)
        off = points - q[:, :, None, :3]
        expect("radius", np.abs(np.linalg.norm(off, axis=3) - RADIUS).max() < 1e-12)
        # the pole of the first point is turned as (0, 0, 1) by e / |e|: its z is 1 - 2 (x^2 + y^2)
        e = q[..., 3:] / np.linalg.norm(q[..., 3:], axis=2, keepdims=True)
        expect("turn", np.abs(off[:, :, 0, 2] / RADIUS - (1 - 2 * (e[..., 1] ** 2 + e[..., 2] ** 2))).max() < 1e-12)
    with h5py.File(vtk.replace(".vtkhdf", ".contacts.vtkhdf")) as f:
        lines = f["VTKHDF/Points"][...].reshape(RECORDS, -1, 2, 3)
        expect("lines", np.abs(lines[1:, :, 0] - q[1:, 0::2, :3]).max() < 1e-12 and
               np.abs(lines[1:, :, 1] - q[1:, 1::2, :3]).max() < 1e-12)
        expect("none at the start", np.all(f["VTKHDF/CellData/id"][: BALLS // 2] == -1))
    with open(page, encoding="utf-8") as file:
        scene = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', file.read()).group(1))
    expect("in space", scene["spatial"] and len(scene["bodies"]) == BALLS)
    for body in scene["bodies"]:
        i = int(body["name"].split()[1])
        expect("a ball", scene["styles"][body["parts"][0][0]]["radius"] == RADIUS)
        expect("its place", np.abs(np.array(body["pose"]) - q[:, i, :3]).max() < 1e-5)
    expect("forces", [len(lines) for lines in scene["forces"]] == [0] + [BALLS // 2] * (RECORDS - 1))

