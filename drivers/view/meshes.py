"""Bodies as batches of triangle meshes, for a renderer: bodies whose shapes differ in size only share one mesh.

A renderer averages the normals of the triangles that share a vertex. A vertex is therefore split where faces meet at a
crease: a sharp edge remains sharp, and the facets of a round shape look smooth."""

from collections import namedtuple

import numpy as np

from shapes import matrix_of, normals_of

# Bodies of one shape: members, their numbers [k]; sizes [k], the factors of the mesh; parts, its meshes
Batch = namedtuple("Batch", "members sizes parts")

# vertices [p, 3], triangles [f, 3]; dark: whether it is of the darker parts, which show how a ball turns
Mesh = namedtuple("Mesh", "vertices triangles dark")

# positions [n, k, 3], rotations [n, k, 3, 3] and scales [n, k, 3] of a batch; n is 1 if it never moves
Poses = namedtuple("Poses", "positions rotations scales")

CREASE = np.cos(np.radians(35))  # round shapes have facets of at most 30 degrees, corners of a hexagon 60
DIGITS = 6  # in which points of equal shapes agree, in units of their size; a renderer has seven


def facets_of(count):
    """Facets from pole to pole of a ball, at least 6 of 30 degrees: at most about a million triangles in all."""
    return 24 if count <= 200 else 12 if count <= 1500 else 6


def inside(points, a, b, c):
    """Whether points [p, 2] are in or on the triangle, which is counter-clockwise."""
    def left(u, v):
        return (v[0] - u[0]) * (points[:, 1] - u[1]) - (v[1] - u[1]) * (points[:, 0] - u[0]) >= 0

    return left(a, b) & left(b, c) & left(c, a)


def ears(outline):
    """Triangles of a polygon [p, 2], counter-clockwise, by cutting ears (Meisters 1975)."""
    left, found = list(range(len(outline))), []
    while len(left) > 3:
        for k, here in enumerate(left):
            before, after = left[k - 1], left[(k + 1) % len(left)]
            (x0, y0), (x1, y1), (x2, y2) = corners = outline[[before, here, after]]
            others = outline[[i for i in left if i not in (before, here, after)]]
            if (x1 - x0) * (y2 - y1) > (y1 - y0) * (x2 - x1) and not inside(others, *corners).any():
                break
        else:  # no ear: the outline crosses itself
            k, before, here, after = 0, left[-1], left[0], left[1]
        found.append((before, here, after))
        del left[k]
    return [*found, tuple(left)]


def flattened(points, normal):
    """The points [p, 3] of a face in the plane of two coordinates, counter-clockwise: its largest projection."""
    axis = int(np.abs(normal).argmax())
    across = [(axis + 1) % 3, (axis + 2) % 3]
    return points[:, across if normal[axis] > 0 else across[::-1]]


def is_convex(loop, normal):
    edge = np.roll(loop, -1, axis=0) - loop
    return np.all(np.cross(edge, np.roll(edge, -1, axis=0)) @ normal >= 0)


def triangulated(points, polygons):
    """Triangles [f, 3] of the polygons, and which polygon each is of [f]; those without an area are left out."""
    found, of = [], []
    for number, (polygon, normal) in enumerate(zip(polygons, normals_of(points, polygons))):
        if len(polygon) <= 4 or is_convex(points[polygon], normal):
            cut = [(0, i, i + 1) for i in range(1, len(polygon) - 1)]
        else:
            cut = ears(flattened(points[polygon], normal))
        found += [[polygon[a], polygon[b], polygon[c]] for a, b, c in cut]
        of += [number] * len(cut)
    found, of = np.array(found, int).reshape(-1, 3), np.array(of, int)
    has_area = np.linalg.norm(normals_of(points, found), axis=1) > 0.5
    return found[has_area], of[has_area]


def welded(points):
    """The points that differ, and the number of each point's."""
    unique, number = np.unique(points.round(DIGITS) + 0.0, axis=0, return_inverse=True)
    return unique, number.reshape(-1)


def is_smooth(normals):
    total = normals.sum(axis=0)
    return (normals @ total).min() >= CREASE * np.linalg.norm(total)


def creased(points, triangles):
    """The mesh with vertices split: a corner joins those at its vertex whose normals, one after another, are within CREASE.

    If they end farther than CREASE from their sum, as at the apex of a cone, there is no normal, and each corner stays alone."""
    normals = normals_of(points, triangles)
    corner = triangles.reshape(-1)
    order = np.argsort(corner, kind="stable")
    vertices, split = [], np.empty(len(corner), int)
    for start in np.split(order, np.flatnonzero(np.diff(corner[order])) + 1):
        groups = []
        for c in start:
            near = [g for g in groups if (normals[np.array(g) // 3] @ normals[c // 3]).max() >= CREASE]
            groups = [g for g in groups if g not in near] + [[c, *(i for g in near for i in g)]]
        parts = [[g] if is_smooth(normals[np.array(g) // 3]) else [[c] for c in g] for g in groups]
        for group in (group for part in parts for group in part):
            split[group] = len(vertices)
            vertices.append(points[corner[group[0]]])
    return np.array(vertices).reshape(-1, 3), split.reshape(-1, 3)


def meshes_of(shape, size):
    """Of a shape the meshes of its lighter and its darker parts."""
    points, number = welded(shape.points / size)
    triangles, of = triangulated(points, [number[polygon].tolist() for polygon in shape.polygons])
    if not len(triangles):
        return []
    vertices, split = creased(points, triangles)
    dark = np.array(shape.dark if shape.dark is not None else [False] * len(shape.polygons), bool)[of]
    return [Mesh(vertices, split[dark == which], which) for which in (False, True) if np.any(dark == which)]


def batches_of(solids, numbers):
    """Batches of the solids with these numbers."""
    members, first = {}, {}
    for i in numbers:
        shape = solids[i].shape
        size = float(np.abs(shape.points).max()) or 1.0
        key = ((shape.points / size).round(DIGITS) + 0.0).tobytes(), len(shape.polygons), shape.dark is None
        members.setdefault(key, []).append((i, size))
        first.setdefault(key, (shape, size))
    return [Batch([i for i, _ in some], np.array([size for _, size in some]), meshes_of(*first[key]))
            for key, some in members.items()]


def poses_of(bodies, batch, unit):
    """Poses of a batch of bodies, in units of length."""
    positions, matrices = [], []
    for i in batch.members:
        matrix = matrix_of(bodies[i])
        positions.append(bodies[i].position.reshape(-1, 3))
        matrices.append(np.eye(3)[None] if matrix is None else matrix.reshape(-1, 3, 3))
    n = max(len(part) for part in positions + matrices)
    positions = np.stack([np.broadcast_to(p, (n, 3)) for p in positions], axis=1)
    matrices = np.stack([np.broadcast_to(m, (n, 3, 3)) for m in matrices], axis=1)
    scales = np.linalg.norm(matrices, axis=-2)  # of a segment the third is its length
    rotations = matrices / np.where(scales > 0, scales, 1)[..., None, :]
    flat = scales[..., 2] == 0
    rotations[flat, :, 2] = np.cross(rotations[flat, :, 0], rotations[flat, :, 1])
    return Poses(positions / unit, rotations, scales * (batch.sizes / unit)[:, None])
