"""Checks the bodies that a file has by itself against where the program that made it saw each solid's
frame: their places by the formulas, at every record. usage: shown_check.py DRIVERS_PYTHON FILE.h5 2|3"""

import sys

sys.path.insert(0, sys.argv[1])

import h5py
import numpy as np
from bodies import named

EPS = 1e-12  # some hundred roundings of values of order one


def close(name, a, b):
    error = np.max(np.abs(a - b))
    if not error <= EPS:
        sys.exit(f"{sys.argv[2]}: {name}: off by {error:.3g}, allowed {EPS:g}")


def expect(name, holds):
    if not holds:
        sys.exit(f"{sys.argv[2]}: {name}")


with h5py.File(sys.argv[2]) as file:
    time = file["time"][...]
    bodies = named(file, time, file["q"][...])
    seen = file["seen"][...].reshape(len(time), -1, 4, 3)

planar = sys.argv[3] == "2"
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
