"""What an animation shows, as plain lists that the drawing in Python and the page's in JavaScript
read alike: bodies with a pose per frame, the modes of the contacts over the time, impacts.

Planar, a pose is [x, y, a, b]: the body's point p is at (x + a p_x - b p_y, y + b p_x + a p_y).
In space it is [x, y, z] and the nine numbers of a matrix, row by row; of a ball among many [x, y, z].
A body that never moves has one pose. Positions are those of the file's records, never between them.
Forces are lines [x0, y0, z0, x1, y1, z1, w] of each frame, w their strength."""

import numpy as np

from bodies import at_records, extent, is_fixed, is_spatial
from modes import MODE_COLOURS, MODES, strips
from shapes import solids_of
from trajectory import text

COLOURS = ["#3b6ea5", "#d1792f", "#4f9d5b", "#b0483f", "#7d67a8", "#8a6d4f", "#c66fa1", "#3f9ea3"]
FIXED, GROUND, THREAD = "#a9aeb5", "#dfe2e6", "#6b7178"
IMPACTS_MAX = 2000
MESHES_MAX = 30   # where there are more bodies balls are drawn as discs


def rounded(values, scale):
    """Seven digits of what the scale is large of: a hundredth of a pixel is a tenth of a millionth."""
    return np.round(values, int(7 - np.floor(np.log10(scale)))).tolist() if scale > 0 else np.asarray(values).tolist()


def outline(body):
    """The planar body in its own frame, as (kind, what it needs)."""
    size, xy = body.size, body.points[:, :2]
    if body.shape in ("disc", "sphere", "capsule"):
        return {"kind": "circle", "radius": size[0], "hole": size[1] if body.shape == "disc" else 0.0,
                "spoke": body.rotation is not None}
    if body.shape == "segment":
        return {"kind": "line", "points": [[0.0, 0.0], [1.0, 0.0]], "width": size[0]}
    if body.shape == "path":
        return {"kind": "line", "points": xy.tolist(), "width": size[0]}
    if body.shape == "box":
        xy = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * size[:2]
    if body.shape == "plane":  # along its surface, which the body's own x axis is turned to by the pose
        along = np.array([size[1], -size[0]]) / np.hypot(size[0], size[1])
        return {"kind": "ground", "along": along.tolist()}
    return {"kind": "mark"} if body.shape == "point" else {"kind": "area", "points": xy.tolist()}


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


def is_ball(body, count):
    return body.shape == "sphere" and count > MESHES_MAX


def mesh(shape, scale):
    return {"kind": "mesh", "points": rounded(shape.points, scale), "faces": [list(map(int, f)) for f in shape.polygons],
            "dark": [int(d) for d in shape.dark or []]}


def drawn_bodies(bodies, frames, spatial, scale):
    """In the order of drawing: what is fixed is behind what moves. frames: among the records of the bodies."""
    moved = [at_records(body, frames) for body in bodies]
    solids = solids_of(bodies) if spatial else [None] * len(bodies)
    drawn, colour = [], 0
    for whole, body, solid in zip(bodies, moved, solids):
        fixed = is_fixed(whole)
        if spatial and is_ball(body, len(bodies)):
            pose, shape = body.position.reshape(-1, 3), {"kind": "ball", "radius": body.size[0]}
        elif spatial:
            pose = spatial_pose(solid._replace(position=body.position, matrix=at_frames(solid.matrix, frames)))
            shape = mesh(solid.shape, scale)
        else:
            pose, shape = planar_pose(body), outline(body)
        thread = body.shape in ("segment", "path") and body.size[0] == 0
        grey = GROUND if body.shape == "plane" else THREAD if thread else FIXED if fixed else None
        drawn.append({"name": body.name, "fixed": bool(grey), "colour": grey or COLOURS[colour % len(COLOURS)],
                      "plane": body.shape == "plane", **shape, "pose": rounded(pose, scale)})
        colour += not grey
    return sorted(drawn, key=lambda b: (not b["plane"], not b["fixed"]))


def at_frames(matrix, frames):
    return matrix if matrix is None or matrix.ndim == 2 else matrix[frames]


def impacts(file, start, end):
    """[time, contact] of those in the times shown, the strongest of them where there are many."""
    if "impact/time" not in file or "impact/contact" not in file:
        return []  # by list: a contact has no strip
    time, contact, impulse = (file[f"impact/{name}"][...] for name in ("time", "contact", "normal_impulse"))
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


def scene(file, time, bodies, frames, at, forces):
    """Of these records (numbers, ascending), which are those at `at` of the bodies'; forces: of each frame."""
    spatial = is_spatial(bodies)
    seen = [at_records(body, slice(at[0], at[-1] + 1)) for body in bodies]
    box = bounds(seen, spatial)
    scale = float(np.max(np.subtract(box[1], box[0])))
    attrs = {name: text(file.attrs.get(name, "")) for name in ("model", "method", "status")}
    return {
        **attrs,
        "spatial": spatial,
        "low": box[0],
        "high": box[1],
        "time": [float(t) for t in time[frames]],
        "bodies": drawn_bodies(bodies, at, spatial, scale),
        "strips": strips(file, time[frames[0] : frames[-1] + 1], frames),
        "impacts": impacts(file, time[frames[0]], time[frames[-1]]),
        "forces": [rounded(lines, scale) for lines in forces],
        "modes": MODES,
        "mode_colours": MODE_COLOURS,
    }
