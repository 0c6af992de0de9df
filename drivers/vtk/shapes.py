"""Shapes and motions of rigid bodies for nsdae-vtk: arrays of points, cells and rotations."""

from collections import namedtuple

import numpy as np

# Points [p, 3] in the body's own frame, and polygons as lists of their numbers.
Shape = namedtuple("Shape", "points polygons")

# A shape that is at position + rotation . point: position [n, 3] or [3], rotation [n, 3, 3] or None.
Body = namedtuple("Body", "name shape position rotation", defaults=(None,))


def prism(outline, depth):
    """The outline [p, 2], counter-clockwise, extruded along z to both sides."""
    p = len(outline)
    points = [np.column_stack([outline, np.full(p, z)]) for z in (-depth / 2, depth / 2)]
    sides = [[i, (i + 1) % p, (i + 1) % p + p, i + p] for i in range(p)]
    return Shape(np.vstack(points), [list(range(p))[::-1], list(range(p, 2 * p)), *sides])


def box(x, y, z):
    """Of these edge lengths about its centre."""
    return prism(np.array([[-x, -y], [x, -y], [x, y], [-x, y]]) / 2, z)


def circle(radius, sides=48):
    angle = 2 * np.pi * np.arange(sides) / sides
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def cylinder(radius, depth):
    return prism(circle(radius), depth)


def ring(inner, outer, depth):
    """A hole in a plate."""
    loops = [np.column_stack([circle(r), np.full(48, z)])
             for r, z in ((inner, -depth / 2), (outer, -depth / 2), (outer, depth / 2), (inner, depth / 2))]
    quads = [[48 * a + i, 48 * a + (i + 1) % 48, 48 * b + (i + 1) % 48, 48 * b + i]
             for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for i in range(48)]
    return Shape(np.vstack(loops), quads)


def sphere(radius, dark=None, meridians=24, parallels=12):
    """Of quadrilaterals that meet at the poles; dark: only every other octant of it, so that two
    bodies, the light and the dark one, show how it turns."""
    polar, azimuth = np.meshgrid(np.pi * np.arange(parallels + 1) / parallels,
                                 2 * np.pi * np.arange(meridians) / meridians, indexing="ij")
    points = radius * np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                                np.cos(polar)], axis=-1).reshape(-1, 3)

    def is_dark(i, j):
        return (i * 2 // parallels + j * 4 // meridians) % 2 == 1

    quads = [[i * meridians + j, (i + 1) * meridians + j, (i + 1) * meridians + (j + 1) % meridians,
              i * meridians + (j + 1) % meridians]
             for i in range(parallels) for j in range(meridians) if dark is None or is_dark(i, j) == dark]
    return Shape(points, quads)


def about_z(angle):
    """Rotations [n, 3, 3] by these angles [n]."""
    rotation = np.zeros((len(angle), 3, 3))
    rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(angle)
    rotation[:, 1, 0] = np.sin(angle)
    rotation[:, 0, 1] = -np.sin(angle)
    rotation[:, 2, 2] = 1
    return rotation


def tilted(angle):
    """The same to first order in the angles: 1 + angle K."""
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 0]])
    return np.eye(3) + angle[:, None, None] * turn


def rotation_by(vector):
    """About the vector [3] by its length: I + sin(a)/a K + (1 - cos a)/a^2 K^2, K x = vector x x
    (Rodrigues)."""
    a = np.linalg.norm(vector)
    K = np.array([[0, -vector[2], vector[1]], [vector[2], 0, -vector[0]], [-vector[1], vector[0], 0]])
    return np.eye(3) + np.sinc(a / np.pi) * K + np.sinc(a / (2 * np.pi)) ** 2 / 2 * (K @ K)


def rotations_by(angular):
    """Rotations [n, 3, 3] of a body whose integrated angular velocity, in space axes, is that [n, 3]:
    each step turns by its increment, exactly where the angular velocity is constant in the step."""
    rotation = np.empty((len(angular), 3, 3))
    rotation[0] = np.eye(3)
    for i in range(1, len(angular)):
        rotation[i] = rotation_by(angular[i] - angular[i - 1]) @ rotation[i - 1]
    return rotation


def planar(x, y):
    """Positions [n, 3] in the plane z = 0."""
    return np.column_stack([x, y, np.zeros(len(x))])


def placed(body, records):
    """The body's points [records, p, 3] in space, of those records."""
    points = body.shape.points
    if body.rotation is not None:
        rotation = body.rotation if body.rotation.ndim == 2 else body.rotation[records]
        points = points @ np.swapaxes(rotation, -1, -2)
    position = body.position if np.ndim(body.position) == 1 else body.position[records, None]
    return np.broadcast_to(position + points, (len(records), *body.shape.points.shape))
