"""Bodies as surfaces in space: polygons in a body's own frame, and where that is at each record.
What a planar shape does not have, a thickness, is a fraction of how far all bodies go."""

import functools
from collections import namedtuple

import numpy as np

from bodies import extent, is_fixed

# Points [p, 3] and polygons as lists of their numbers, counter-clockwise from outside; dark: of each
# polygon whether it is of the darker parts, which show how a ball turns.
Shape = namedtuple("Shape", "points polygons dark", defaults=(None,))

# A shape whose points are at position + matrix . point: position [n, 3] or [3], matrix [n, 3, 3],
# [3, 3] or None for the unit matrix.
Solid = namedtuple("Solid", "name shape position matrix fixed")


def joined(shapes):
    first = np.cumsum([0] + [len(s.points) for s in shapes])
    return Shape(np.concatenate([s.points for s in shapes]),
                 [[i + first[k] for i in polygon] for k, s in enumerate(shapes) for polygon in s.polygons])


def prism(outline, depth):
    """The outline [p, 3], counter-clockwise from above, extruded along z to both sides."""
    p = len(outline)
    points = np.concatenate([outline + [0, 0, z] for z in (-depth / 2, depth / 2)])
    sides = [[i, (i + 1) % p, (i + 1) % p + p, i + p] for i in range(p)]
    return Shape(points, [list(range(p))[::-1], list(range(p, 2 * p)), *sides])


def area(outline):
    """Of a polygon in x and y, positive where it is counter-clockwise (shoelace formula)."""
    x, y = outline[:, 0], outline[:, 1]
    return (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def box(edges):
    """Of these lengths about its centre."""
    corner = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) / 2 * edges
    return prism(corner, edges[2])


def circle(radius, sides=48):
    angle = 2 * np.pi * np.arange(sides) / sides
    return radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(sides)])


def ring(outer, inner, depth):
    """A hole in a plate."""
    loops = [circle(r) + [0, 0, z]
             for r, z in ((inner, -depth / 2), (outer, -depth / 2), (outer, depth / 2), (inner, depth / 2))]
    quads = [[48 * a + i, 48 * a + (i + 1) % 48, 48 * b + (i + 1) % 48, 48 * b + i]
             for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for i in range(48)]
    return Shape(np.concatenate(loops), quads)


def globe(radius, length=0.0, meridians=24, parallels=12):
    """Quadrilaterals that meet at the poles; every other octant dark. With a length a capsule along
    z: the halves are that far apart, and between them is a row more."""
    polar = np.pi * np.arange(parallels + 1) / parallels
    shift = np.full(parallels + 1, length / 2)
    shift[parallels // 2 + 1 :] *= -1
    if length > 0:
        polar, shift = np.insert(polar, parallels // 2, np.pi / 2), np.insert(shift, parallels // 2 + 1, -length / 2)
    azimuth = 2 * np.pi * np.arange(meridians) / meridians
    points = np.stack(np.broadcast_arrays(radius * np.outer(np.sin(polar), np.cos(azimuth)),
                                          radius * np.outer(np.sin(polar), np.sin(azimuth)),
                                          (radius * np.cos(polar) + shift)[:, None]), axis=-1)
    rows = len(polar) - 1
    quads = [[i * meridians + j, (i + 1) * meridians + j, (i + 1) * meridians + (j + 1) % meridians,
              i * meridians + (j + 1) % meridians] for i in range(rows) for j in range(meridians)]
    dark = [(i * 2 // rows + j * 4 // meridians) % 2 == 1 for i in range(rows) for j in range(meridians)]
    return Shape(points.reshape(-1, 3), quads, dark)


def rod(radius):
    """A round one along z from 0 to 1."""
    return prism(circle(radius, 16) + [0, 0, 0.5], 1)


def cone(radius, height, sides):
    """Its base below, the apex above."""
    points = np.concatenate([circle(radius, sides) - [0, 0, height / 2], [[0, 0, height / 2]]])
    return Shape(points, [list(range(sides))[::-1], *([i, (i + 1) % sides, sides] for i in range(sides))])


def frame_along(direction):
    """Matrices [..., 3, 3] whose third column is the direction [..., 3], the others unit vectors at
    right angles to it and to each other."""
    length = np.linalg.norm(direction, axis=-1, keepdims=True)
    unit = np.where(length > 0, direction / np.where(length > 0, length, 1), [0, 0, 1])
    aside = np.where(np.abs(unit[..., 2:]) < 0.9, [0, 0, 1], [1, 0, 0])
    first = np.cross(aside, unit)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(unit, first), direction], axis=-1)


def tube(points, radius):
    """A round rod between each point and the next."""
    parts = []
    for a, b in zip(points, points[1:]):
        one = rod(radius)
        parts.append(one._replace(points=a + one.points @ frame_along(b - a).T))
    return joined(parts)


def slab(body, low, high, depth, reach):
    """Of a plane what is near the bodies: a square about the foot of their middle, `reach` of their diagonal wide."""
    normal = body.size / np.linalg.norm(body.size)
    basis = frame_along(normal)
    position, rotation = (np.reshape(part, (-1, *part.shape[-k:]))[0]
                          for part, k in ((body.position, 1), (np.eye(3) if body.rotation is None else body.rotation, 2)))
    middle = ((low + high) / 2 - position) @ rotation
    edge = reach * np.linalg.norm(high - low) + depth
    one = box(np.array([edge, edge, depth]))
    return one._replace(points=middle - normal * (middle @ normal) + (one.points - [0, 0, depth / 2]) @ basis.T)


@functools.lru_cache(maxsize=64)
def unit_globe(length, facets):
    return globe(1.0, length, 2 * facets, facets)


def round_shape(radius, length, facets):
    """A ball or capsule; those of one proportion share their polygons."""
    one = unit_globe(length / radius if radius > 0 else 0.0, facets)
    return one._replace(points=radius * one.points)


def facets_of(count):
    """Facets from pole to pole of a ball, for this number of balls: at most about 100 000 in all."""
    return 12 if count <= 300 else 6 if count <= 2000 else 4


def shape_of(body, low, high, facets, reach):
    size = body.size
    scale = np.linalg.norm(high - low) or 1.0
    thickness, thin = scale / 30, scale / 400
    if body.shape == "disc":
        tilts = body.rotation is not None and np.abs(body.rotation[..., 2, 2] - 1).max() > 1e-9  # of a model in space
        deep = thin if tilts else thickness
        return ring(size[0], size[1], deep) if size[1] > 0 else prism(circle(size[0], 4 * facets), deep)
    if body.shape == "polygon":
        return prism(body.points if area(body.points) > 0 else body.points[::-1], thickness)
    if body.shape == "cylinder":
        return prism(circle(size[0], 4 * facets), size[1])
    if body.shape == "cone":
        return cone(size[0], size[1], 4 * facets)
    if body.shape == "ellipsoid":
        ball = round_shape(0.5, 0.0, facets)
        return ball._replace(points=ball.points * size)
    if body.shape == "polyhedron":
        return Shape(body.points, np.arange(len(body.points)).reshape(-1, 3).tolist())
    if body.shape == "plane":
        return slab(body, low, high, thickness, reach)
    return {"point": lambda: globe(scale / 50)._replace(dark=None), "segment": lambda: rod(size[0] / 2 or thin),
            "path": lambda: tube(body.points, size[0] / 2 or thin), "sphere": lambda: round_shape(size[0], 0.0, facets),
            "capsule": lambda: round_shape(size[0], size[1], facets), "box": lambda: box(size)}[body.shape]()


def solids_of(bodies, facets=None, reach=1.3):
    low, high = extent(bodies)
    facets, solids = facets or facets_of(len(bodies)), []
    for body in bodies:
        solids.append(Solid(body.name, shape_of(body, low, high, facets, reach), body.position, matrix_of(body), is_fixed(body)))
    return solids


def matrix_of(body):
    """Of a segment the third column is the vector to its end."""
    return body.rotation if body.end is None else frame_along(body.end - body.position)


def placed(solid, records):
    """The points [records, p, 3] in space, of those records."""
    points = solid.shape.points
    if solid.matrix is not None:
        matrix = solid.matrix if solid.matrix.ndim == 2 else solid.matrix[records]
        points = points @ np.swapaxes(matrix, -1, -2)
    position = solid.position if solid.position.ndim == 1 else solid.position[records, None]
    return np.broadcast_to(position + points, (len(records), *solid.shape.points.shape))


def faces_by_corners(polygons):
    """Polygons by their number of corners: their numbers [n], and their points [n, corners]."""
    corners = np.array([len(polygon) for polygon in polygons])
    for count in sorted(set(corners)):
        mine = np.flatnonzero(corners == count)
        yield mine, np.array([polygons[i] for i in mine])


def normals_of_loops(loops):
    """Of polygons [n, corners, 3], by Newell's sum; of length one, or zero if it has no area."""
    loops = loops - loops[:, :1]  # no cancellation far from the origin
    ahead = np.roll(loops, -1, axis=1)
    # sums of a x b over the edges a b: (y z' - z y', z x' - x z', x y' - y x')
    normals = np.stack([np.einsum("nc,nc->n", loops[..., j], ahead[..., k]) - np.einsum("nc,nc->n", loops[..., k], ahead[..., j])
                        for j, k in ((1, 2), (2, 0), (0, 1))], axis=-1)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0, length, 1)


def normals_of(points, polygons):
    """Of polygons of these points, as above."""
    normals = np.zeros((len(polygons), 3))
    for mine, faces in faces_by_corners(polygons):
        normals[mine] = normals_of_loops(points[faces])
    return normals
