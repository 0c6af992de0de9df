"""Mechanisms of the kit: their files name the bodies, each at its place: the formulas of every record against where the
program that made the file saw each solid's frame; the programs that draw take the files. usage: shown_check.py BIN_DIR SHOWN"""

import sys

import h5py
import numpy as np
import tools
from bodies import named

FILE = "it.h5"

EPS = 1e-12  # some hundred roundings of values of order one


def close(name, a, b):
    error = np.max(np.abs(a - b))
    if not error <= EPS:
        sys.exit(f"{name}: off by {error:.3g}, allowed {EPS:g}")


def expect(name, holds):
    if not holds:
        sys.exit(f"{name}")


def check(dimension):
    with h5py.File(FILE) as file:
        time = file["time"][...]
        bodies = named(file, time, file["q"][...])
        seen = file["seen"][...].reshape(len(time), -1, 4, 3)

    planar = dimension == 2
    solids = bodies[: seen.shape[1]]
    shapes = ("point", "disc", "segment", "polygon", "plane") if planar else ("point", "sphere", "capsule", "box", "plane")
    expect("its shapes", [body.shape for body in solids] == [s for s in shapes for _ in range(2)])
    expect("a body without solids is a point", [b.shape for b in bodies if b.name == "body 3"] == ["point"])
    expect("spring and rod", [b.shape for b in bodies if b.name in ("spring 0", "rod 0")] == ["segment"] * 2)
    expect("nothing else", len(bodies) == len(solids) + 3)

    for i, body in enumerate(solids):
        origin, axes = seen[:, i, 0], seen[:, i, 1:] - seen[:, i, :1]
        moves = np.ptp(origin, axis=0).max() > 0.01
        expect(f"{body.name} stands still or moves", moves == (i % 2 == 0))
        if body.shape == "segment":
            half = np.linalg.norm(body.end - body.position, axis=-1)[..., None] / 2
            close(body.name, (body.position + body.end) / 2, origin)
            close(body.name, (body.end - body.position) / (2 * half), axes[:, 0])
            continue
        rotation = np.broadcast_to(body.rotation, (len(time), 3, 3))
        if body.shape == "polygon":
            own = np.array([[-0.5, -0.4, 0], [0.6, -0.3, 0], [0.5, 0.5, 0], [-0.4, 0.3, 0]])
            corners = body.position[..., None, :] + np.einsum("nij,pj->npi", rotation, body.points)
            close(body.name, corners, origin[:, None] + np.einsum("nji,pj->npi", axes, own))
            continue
        close(body.name, body.position, origin)
        if body.shape == "plane":
            close(body.name, rotation @ body.size, axes[:, 1 if planar else 2])
            continue
        for j in range(2 if planar else 3):
            close(body.name, rotation[:, :, j], axes[:, j])


for dimension in (2, 3):
    for seed in range(1, 6):
        tools.runs_plainly([sys.argv[2], str(dimension), FILE, str(seed)])
        with tools.judged(dimension, "dimensions, seed", seed):
            check(dimension)
    said = tools.runs("nsdae-vtk", FILE)
    tools.expect(said.startswith("21 steps of 13 bodies"), "nsdae-vtk:", said)
    said = tools.runs("nsdae-animate", "-o", "it.html", FILE)
    tools.expect(said.startswith("21 frames of 13 bodies"), "nsdae-animate:", said)
tools.end()
