"""Scene of an animation, as plain lists for the drawing in Python and the page in JavaScript.

It has bodies with points, parts and a pose per frame, the modes of the contacts over time, and impacts.

A part is [style, point, point, ...], with indices into the styles and the points of the body. It is a polygon if its style has
a fill, a disc about the point if it has a radius, else a line. Radii are in metres, possibly with a hole, and at least `least`
pixels. An edge is `width` pixels wide, or `metres`. Lit parts are faces in space, drawn if they face the viewer, and darker
the less they face the light.

- A planar pose is [x, y, a, b]: the point p of the body is at (x + a p_x - b p_y, y + b p_x + a p_y).
- A spatial pose is [x, y, z] and the nine numbers of a matrix, row by row; of a ball among many [x, y, z].
- A fixed body has one pose. Positions are those of the records, without interpolation.
- Bodies cast shadows on the planes of `shadows`, each [normal, point], along the light.
- With a camera, what is seen of frame i is low + camera[i] to high + camera[i], else low to high.
- Forces are lines [x0, y0, z0, x1, y1, z1, w] of each frame, w their width.
"""

import json

import numpy as np

from bodies import at_records, boxes_of, colours_of, extent, is_fixed, is_spatial, is_thread, normal_of
from modes import MODE_COLOURS, MODES, strips
from shapes import solids_of
from trajectory import has_list, text

FIXED, GROUND, THREAD = "#a9aeb5", "#dfe2e6", "#6b7178"
GRID, SHADOW = "#bcc1c8", "#a4aab2"
INK, PALE, BACKGROUND = "#30353b", "#8b9198", "#ffffff"
FORCE = {"edge": "#b0161c", "width": 3, "round": 1}  # of a strength of 1
VIEW = np.radians([-60, 20]).tolist()  # azimuth and elevation of the eye
LIGHT = (np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])).tolist()  # where it comes from
IMPACTS_MAX = 2000
STEEP = np.cos(np.pi / 4)  # light that falls on a plane at a smaller angle to its normal casts shadows
REACH = 3.0  # of the ground, in diagonals of the bodies' box: half of one, and its shadow at that angle, both ways
FAR_AWAY, SIZES = 6.0, 3.0  # travel from which the camera follows, and half the width that it sees, in sizes of the bodies
GRID_MAX = 100  # lines of a grid each way
MESHES_MAX, BALLS_MAX = 30, 10  # where there are more bodies and balls, balls are drawn as discs
SHADOWS_MAX = 100  # bodies with shadows
FAR = 100.0  # pictures from the middle to the end of the ground: the page may be zoomed out as far


def rounded(values, scale):
    """Seven digits of what the scale is large of: a hundredth of a pixel is a tenth of a millionth."""
    return np.round(values, int(7 - np.floor(np.log10(scale)))).tolist() if scale > 0 else np.asarray(values).tolist()


def shaded(colour, light):
    return "#" + "".join(f"{int(int(colour[i : i + 2], 16) * light):02x}" for i in (1, 3, 5))


def outline(body, colour, scale):
    """Of the planar body, in its own frame: points, and the parts' styles with their points."""
    size, xy = body.size, body.points[:, :2]
    line = {"edge": colour, "metres": size[0], "width": 1.2, "round": 1}
    area = {"fill": colour, "edge": shaded(colour, 0.75), "width": 1}
    if body.shape in ("disc", "sphere", "capsule", "cylinder", "cone"):
        hole = size[1] if body.shape == "disc" else 0.0
        spoke = [({"edge": BACKGROUND, "width": 2}, 0, 1)] if body.rotation is not None and not hole > 0 else []
        return [[0.0, 0.0], [size[0], 0.0]], [({**area, "radius": size[0], "hole": hole, "least": 1}, 0), *spoke]
    if body.shape == "segment":
        return [[0.0, 0.0], [1.0, 0.0]], [(line, 0, 1)]
    if body.shape == "path":
        return xy, [(line, *range(len(xy)))]
    if body.shape == "plane":  # along its surface, which the body's own x axis is turned to by the pose
        along = np.array([size[1], -size[0]]) / np.hypot(size[0], size[1])
        far = FAR * scale + 4 * np.abs(body.position).max()
        ends = far * np.array([-along, along])
        deep = far * np.array([along[1], -along[0]])
        return [*ends, ends[1] + deep, ends[0] + deep], [({"fill": GROUND}, 0, 1, 2, 3), ({"edge": colour, "width": 2}, 0, 1)]
    if body.shape == "point":
        return [[0.0, 0.0]], [({"fill": colour, "radius": 0.0, "hole": 0.0, "least": 4}, 0)]
    if body.shape == "box":
        xy = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * size[:2]
    return xy, [(area, *range(len(xy)))]


def planar_pose(body):
    """[n, 4], or [1, 4] of what never moves."""
    turn = np.array([1.0, 0.0])
    if body.end is not None:
        turn = (body.end - body.position)[..., :2]
    elif body.rotation is not None:
        turn = body.rotation[..., :2, 0]
    lead = np.broadcast_shapes(body.position.shape[:-1], turn.shape[:-1])
    pose = np.concatenate([np.broadcast_to(body.position[..., :2], (*lead, 2)), np.broadcast_to(turn, (*lead, 2))], axis=-1)
    return pose.reshape(-1, 4)


def spatial_pose(solid):
    """[n, 12], or [1, 12] of what never moves."""
    matrix = np.eye(3) if solid.matrix is None else solid.matrix
    lead = np.broadcast_shapes(solid.position.shape[:-1], matrix.shape[:-2])
    pose = np.concatenate([np.broadcast_to(solid.position, (*lead, 3)),
                           np.broadcast_to(matrix, (*lead, 3, 3)).reshape(*lead, 9)], axis=-1)
    return pose.reshape(-1, 12)


def has_balls(bodies):
    """Whether spheres are drawn as discs."""
    return len(bodies) > MESHES_MAX and sum(body.shape == "sphere" for body in bodies) > BALLS_MAX


def ball(radius, colour):
    """Of one among many: a disc, with a lighter one where the light comes from."""
    rim = {"fill": shaded(colour, 0.75), "edge": shaded(colour, 0.5), "width": 0.6, "radius": radius, "hole": 0.0, "least": 1}
    light = {"fill": colour, "radius": 0.55 * radius, "hole": 0.0, "least": 0.55}
    return [[0.0, 0.0, 0.0], 0.3 * radius * np.array(LIGHT)], [(rim, 0), (light, 1)]


def facets_of(count):
    """Of a ball from pole to pole: at most some 5000 of all balls are drawn in a frame."""
    return 24 if count <= 4 else 16 if count <= 10 else 12


def grid(corners, size):
    """On a square [4, 3] lines a round length apart, up to eight on the size that is seen: points, and pairs of them."""
    edge = np.linalg.norm(corners[1] - corners[0])
    least = max(size / 8, edge / GRID_MAX)
    power = 10.0 ** np.floor(np.log10(least))
    step = power * next(m for m in (1, 2, 5, 10) if m * power >= least)
    number = int(edge / 2 / step)
    along = 0.5 + step / edge * np.arange(-number, number + 1)[:, None]
    a, b, c, d = corners
    points = np.concatenate([a + (b - a) * along, d + (c - d) * along, a + (d - a) * along, b + (c - b) * along])
    n = len(along)
    return points, [(i + j * n, i + (j + 1) * n) for j in (0, 2) for i in range(n)]


def ground(shape, colour, scale):
    """The mesh of a plane, with a grid on it."""
    points, parts = mesh(shape, colour)
    more, lines = grid(points[4:], scale)
    return np.concatenate([points, more]), parts + [({"edge": GRID, "width": 1}, a + 8, b + 8) for a, b in lines]


def mesh(shape, colour):
    looks = [{"fill": c, "lit": 1} for c in (colour, shaded(colour, 0.6))]
    return shape.points, [(looks[dark], *face) for face, dark in zip(shape.polygons, shape.dark or [False] * len(shape.polygons))]


class Styles:
    """All that are used, each once."""

    def __init__(self):
        self.all = {}

    def numbered(self, style, *points):
        return [self.all.setdefault(json.dumps(style), len(self.all)), *map(int, points)]

    def list(self):
        return [json.loads(style) for style in self.all]


def colour_of(body, own):
    """Its own colour, or that of what is fixed."""
    return own or (THREAD if is_thread(body) else GROUND if body.shape == "plane" else FIXED)


def drawn_bodies(bodies, frames, spatial, scale, styles):
    """In the order of drawing: fixed bodies first. frames: indices into the records of the bodies."""
    moved, balls = [at_records(body, frames) for body in bodies], spatial and has_balls(bodies)
    solids = solids_of(bodies, facets_of(len(bodies)) if len(bodies) <= MESHES_MAX else None, REACH) if spatial else [None] * len(bodies)
    drawn = []
    for own, whole, body, solid in zip(colours_of(bodies), bodies, moved, solids):
        colour = colour_of(body, own)
        if balls and body.shape == "sphere":
            pose, (points, parts) = body.position.reshape(-1, 3), ball(body.size[0], colour)
        elif spatial:
            pose = spatial_pose(solid._replace(position=body.position, matrix=at_frames(solid.matrix, frames)))
            points, parts = ground(solid.shape, colour, scale) if body.shape == "plane" else mesh(solid.shape, colour)
        else:
            pose, (points, parts) = planar_pose(body), outline(body, own or PALE if body.shape == "plane" else colour, scale)
        drawn.append({"name": body.name, "fixed": bool(is_fixed(whole) or is_thread(whole)), "colour": colour, "plane": body.shape == "plane",
                      "points": rounded(points, scale), "parts": [styles.numbered(*part) for part in parts],
                      "pose": rounded(pose, scale)})
    return sorted(drawn, key=lambda b: (not b["plane"], not b["fixed"]))


def at_frames(matrix, frames):
    return matrix if matrix is None or matrix.ndim == 2 else matrix[frames]


def impacts(file, start, end):
    """[time, contact] of those in the times shown, the strongest of them where there are many."""
    if "impact/time" not in file or has_list(file):
        return []  # a contact of a list has no strip
    time, contact, impulse = (file[f"impact/{name}"][...] for name in ("time", "id", "normal_impulse"))
    shown = np.flatnonzero((time >= start) & (time <= end))
    shown = np.sort(shown[np.argsort(-impulse[shown], kind="stable")[:IMPACTS_MAX]])
    return [[float(time[i]), int(contact[i])] for i in shown]


def bounds(bodies, spatial):
    """Smallest and largest coordinates with what a planar picture needs beside the bodies."""
    low, high = extent(bodies)
    size = np.max(high - low) or 1.0
    margin = 0.06 * size
    least = 0.25 * size  # a picture is not a thread
    grow = np.maximum(least - (high - low), 0) / 2 if not spatial else 0
    return [(low - margin - grow).tolist(), (high + margin + grow).tolist()]


def shadows(bodies):
    """Planes that shadows fall on."""
    planes = [b for b in bodies if b.shape == "plane" and is_fixed(b)] if len(bodies) <= SHADOWS_MAX else []
    return [[normal_of(b).tolist(), b.position.tolist()] for b in planes if normal_of(b) @ LIGHT > STEEP]


def camera(bodies, count):
    """Of bodies that travel many times their size, on planes alone: the box that is seen at the start, and its way.

    The way [count, 3] has at every frame the shortest step that keeps the bodies in the box. None of other bodies.
    """
    moving = [b for b in bodies if not is_fixed(b)]
    if not moving or any(is_fixed(b) and b.shape != "plane" for b in bodies):
        return None
    boxes = [boxes_of(b, count) for b in moving]
    low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
    size, middle = np.max(high - low), (low + high) / 2
    if size <= 0 or np.max(np.ptp(middle, axis=0)) <= FAR_AWAY * size:
        return None
    way = [middle[0]]
    for least, most in zip(high - SIZES * size, low + SIZES * size):
        way.append(np.clip(way[-1], least, most))
    return [(middle[0] + side * SIZES * size).tolist() for side in (-1, 1)], np.array(way[1:]) - middle[0]


def scene(file, time, bodies, frames, at, forces):
    """Of these records (numbers, ascending), which are those at `at` of the bodies'; forces: of each frame."""
    spatial = is_spatial(bodies)
    seen = [at_records(body, slice(at[0], at[-1] + 1)) for body in bodies]
    follow = camera([at_records(body, at) for body in bodies], len(frames)) if spatial else None
    box = follow[0] if follow else bounds(seen, spatial)
    scale = float(np.max(np.subtract(box[1], box[0])))
    styles = Styles()
    drawn = drawn_bodies(bodies, at, spatial, scale, styles)
    attrs = {name: text(file.attrs.get(name, "")) for name in ("model", "method", "status")}
    return {
        **attrs,
        "spatial": spatial,
        "low": box[0],
        "high": box[1],
        "time": [float(t) for t in time[frames]],
        "bodies": drawn,
        "styles": styles.list(),
        "force": FORCE,
        "view": VIEW,
        "light": LIGHT,
        "shadows": shadows(bodies) if spatial else [],
        "shadow": SHADOW,
        "camera": rounded(follow[1], scale) if follow else [],
        "ink": INK,
        "strips": strips(file, time[frames[0] : frames[-1] + 1], frames),
        "impacts": impacts(file, time[frames[0]], time[frames[-1]]),
        "forces": [rounded(lines, scale) for lines in forces],
        "modes": MODES,
        "mode_colours": MODE_COLOURS,
    }
