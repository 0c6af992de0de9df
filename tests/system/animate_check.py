"""nsdae-animate: every example's animations against its trajectory: the times and places in the page of HTML by the
model's own equations, the number and the durations of the frames, and where in the pictures of the GIF and the MP4
(where ffmpeg is) the bodies are; the page run by a browser where one is, one-line errors, a full disk.
usage: animate_check.py BIN_DIR DATA_DIR"""

import json
import os
import re
import shutil
import subprocess
import sys

import h5py
import numpy as np
import tools
from bodies import COLOURS, Body, extent
from painter import FINE, SHADOW, Faces, paint
from PIL import Image, ImageDraw
from raster import Drawing
from scene import BACKGROUND, Styles, drawn_bodies

STEM = ""  # of an example's .h5, .gif, .html and .mp4


def expect(name, holds, what=""):
    if not holds:
        sys.exit(f"{STEM}: {name} {what}")


def page_data(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    shown = re.sub("'sha256-[^']*'|// ", "", text)  # a hash may contain // as may a comment
    expect("offline", not re.search(r"https?:|//\w|\bsrc=|\bhref=|@import|url\(|fetch\(", shown), path)
    return text, json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)[1])


class Page:
    def __init__(self, path, f):
        self.text, self.scene = page_data(path)
        self.time = np.array(self.scene["time"])
        time = f["time"][...]
        self.at = np.searchsorted(time, self.time)
        expect("times", np.array_equal(time[self.at], self.time))
        expect("first and last", self.at[0] == 0 and self.at[-1] == len(time) - 1)
        expect("number of frames", len(self.at) == min(len(time), 1500))
        self.q, self.p = f["q"][...][self.at], {k: v[()] for k, v in f["parameters"].items()}
        scale = np.max(np.subtract(self.scene["high"], self.scene["low"]))
        self.rounding = 10.0 ** -int(7 - np.floor(np.log10(scale)))  # half of it is the error

    def pose(self, name):
        (body,) = [b for b in self.scene["bodies"] if b["name"] == name]
        pose = np.array(body["pose"])
        return np.broadcast_to(pose, (len(self.at), pose.shape[1]))

    def close(self, name, pose, *expected):
        columns = np.column_stack(np.broadcast_arrays(*expected))
        error = np.abs(self.pose(name)[:, : columns.shape[1]] - columns).max()
        expect(f"place of {name}", error <= 0.51 * self.rounding, f"is off by {error:g}")


def turn(angle):
    return np.cos(angle), np.sin(angle)


def pendulum(a, q, p):
    a.close("rod", "pose", q[:, 0], q[:, 1], *turn(q[:, 2]))


def clearance_hinge(a, q, p):
    a.close("rod", "pose", q[:, 0], q[:, 1], *turn(q[:, 2]))
    a.close("shaft", "pose", q[:, 0] - p["l"] / 2 * np.sin(q[:, 2]), q[:, 1] + p["l"] / 2 * np.cos(q[:, 2]), *turn(q[:, 2]))


def crank_slider(a, q, p):
    x, y = p["L1"] * np.sin(q[:, 0]), -p["L1"] * np.cos(q[:, 0])
    u, v = p["L2"] * np.sin(q[:, 1]), -p["L2"] * np.cos(q[:, 1])
    a.close("crank", "pose", 0, 0, x, y)  # from the origin, as long and turned as this
    a.close("rod", "pose", x, y, u, v)
    a.close("slider", "pose", x + u, y + v, 1, 0)


def squeezer(a, q, p):
    beta, theta, delta, epsilon = q[:, 0], q[:, 1], q[:, 4], q[:, 6]
    x, y = -0.06934, -0.00227  # the joint of two chains; the end of the first chain is common
    end = 7e-3 * np.cos(beta) - 28e-3 * np.cos(beta + theta), 7e-3 * np.sin(beta) - 28e-3 * np.sin(beta + theta)
    g = x + 4e-2 * np.cos(delta), y + 4e-2 * np.sin(delta)
    h = x + 4e-2 * np.sin(epsilon), y - 4e-2 * np.cos(epsilon)
    a.close("K1", "pose", 0, 0, 7e-3 * np.cos(beta), 7e-3 * np.sin(beta))
    a.close("K3", "pose", -0.03635, 0.03273, end[0] + 0.03635, end[1] - 0.03273)
    a.close("K4", "pose", *g, end[0] - g[0], end[1] - g[1])
    a.close("K5", "pose", x, y, g[0] - x, g[1] - y)
    a.close("K6", "pose", *h, end[0] - h[0], end[1] - h[1])
    a.close("K7", "pose", x, y, h[0] - x, h[1] - y)


def car_axis(a, q, p):
    y = p["r"] * np.sin(p["omega"] * a.time)
    x = np.sqrt(p["L"] ** 2 - y**2)
    a.close("left spring", "pose", 0, 0, q[:, 0], q[:, 1])
    a.close("right spring", "pose", x, y, q[:, 2] - x, q[:, 3] - y)
    a.close("axis", "pose", q[:, 0], q[:, 1], q[:, 2] - q[:, 0], q[:, 3] - q[:, 1])


def flexible_crank(a, q, p):
    l = 0.3 + q[:, 6]
    a.close("crank", "pose", 0, 0, 0.15 * np.cos(q[:, 0]), 0.15 * np.sin(q[:, 0]))
    a.close("rod", "pose", 0.15 * np.cos(q[:, 0]), 0.15 * np.sin(q[:, 0]), l * np.cos(q[:, 1]), l * np.sin(q[:, 1]))
    a.close("slider", "pose", q[:, 2], 0, 1, 0)


def bouncing_ball(a, q, p):
    a.close("ball", "pose", 0, q[:, 0] + p["h0"] / 20, 1, 0)


def shaken_ball(a, q, p):
    w, unit = 2 * np.pi / p["T"], p["g"] * p["T"] ** 2
    start = np.arccos(min(1, np.pi * (1 - p["e_N"]) / (1 + p["e_N"]) / p["gamma"]))  # where the periodic orbit meets it
    top = p["gamma"] * p["g"] / w**2 * np.sin(w * a.time + start)
    a.close("table", "pose", 0, top - unit / 200)  # it is as thick as twice this
    a.close("ball", "pose", 0, q[:, 0] + unit / 50)


def falling_rod(a, q, p):
    a.close("rod", "pose", q[:, 0], q[:, 1], *turn(q[:, 2]))


def newtons_cradle(a, q, p):
    for i in range(q.shape[1]):
        x0 = i * (p["L"] / 5 + p["gap"])
        rise = q[:, i] ** 2 / (2 * p["L"])
        a.close(f"ball {i}", "pose", x0 + q[:, i], rise, 1, 0)
        a.close(f"string {i}", "pose", x0, p["L"], q[:, i], rise - p["L"])


def woodpecker(a, q, p):
    height = q[:, 0] + p["l_M"] * q[:, 1] + p["l_G"] * q[:, 2]
    bird = a.pose("bird")
    a.close("sleeve, right", "pose", p["r_M"] * (1 - np.sqrt(1 - q[:, 1] ** 2)), q[:, 0], np.sqrt(1 - q[:, 1] ** 2), q[:, 1])
    beak = bird[:, 0] - p["l_S"] * bird[:, 2] - p["h_S"] * bird[:, 3]
    away = np.abs(beak - (p["l_M"] + p["l_G"] - p["l_S"] - p["h_S"] * q[:, 2])).max()
    expect("the beak", away < 2 * a.rounding, f"is off by {away:g}")
    expect("the bird's height", np.abs(bird[:, 1] - height).max() < a.rounding)


def rotation(vector):
    """exp of the cross product's matrix, by its series."""
    K = np.cross(np.eye(3), vector)
    R, term = np.eye(3), np.eye(3)
    for n in range(1, 30):
        term = term @ K / n
        R = R + term
    return R


def incline(a, q, p):
    tilt = rotation(p["slope"] * np.array([-np.sin(p["turn"]), np.cos(p["turn"]), 0]))
    way = (q - q[0]) @ tilt.T
    pose = a.pose("block")
    expect("turn of the block", np.abs(pose[:, 3:] - tilt.reshape(9)).max() < a.rounding)
    expect("way of the block", np.abs(pose[:, :3] - pose[0, :3] - way).max() < 2 * a.rounding)


def rolling_ball(a, q, p):
    pose = a.pose("ball")
    expect("place of the ball", np.abs(pose[:, :3] - q[:, :3]).max() < a.rounding)
    check_space(a, q[:, :3])
    e = q[:, 3:] / np.linalg.norm(q[:, 3:], axis=1)[:, None]
    for i in range(0, len(e), 10):  # its axis and angle
        angle = 2 * np.arctan2(np.linalg.norm(e[i, 1:]), e[i, 0])
        axis = e[i, 1:] / (np.linalg.norm(e[i, 1:]) or 1)
        expect("turn of the ball", np.abs(pose[i, 3:] - rotation(angle * axis).reshape(9)).max() < a.rounding)


def check_camera(a, centre, radius):
    """It keeps the ball in the view, and moves along an axis only if the ball is at the border."""
    way = np.array(a.scene["camera"])
    expect("a camera that follows", way.shape == centre.shape and np.ptp(way, axis=0).max() > 10 * radius)
    room = np.stack([centre - radius - way - a.scene["low"], a.scene["high"] + way - centre - radius])
    expect("the ball in view", room.min() > -2 * a.rounding, f"is out by {-room.min():g}")
    moved = np.abs(np.diff(way, axis=0)) > a.rounding
    expect("a camera at rest", np.all(room.min(axis=0)[1:][moved] < 2 * a.rounding) and not moved.all())


def check_shadow(a, drawing, centre, radius, number):
    """A point is in the shadow of a ball if the line to the light passes the centre within the radius."""
    (ball,) = [b for b in a.scene["bodies"] if not b["plane"]]
    parts = Faces(drawing.painter, ball).parts(number)
    pixels = np.concatenate([np.reshape(corners, (-1, 2)) for layer, _, _, corners, *_ in parts if layer == SHADOW])
    flat = (pixels / FINE - np.array([drawing.size[0], drawing.area[1]]) / 2) / drawing.scale * [1, -1] + (drawing.low + drawing.high) / 2
    points = flat @ drawing.axes[:2] + a.scene["camera"][number]
    points -= np.outer(points[:, 2] / drawing.axes[2, 2], drawing.axes[2])  # along the view onto the ground
    off = np.linalg.norm(np.cross(points - centre, a.scene["light"]), axis=1).max()
    expect("shadow", 0.99 * radius < off < radius + 2 * a.rounding, f"of radius {off:g}, not {radius:g}")


def check_ground(a):
    """Lines of the grid are on the surface, a round length apart."""
    (plane,) = [b for b in a.scene["bodies"] if b["plane"]]
    points, styles = np.array(plane["points"]), a.scene["styles"]
    lines = np.array([points[ends] for style, *ends in plane["parts"] if "lit" not in styles[style]])
    expect("grid on the surface", len(lines) > 20 and np.abs(lines @ a.normal).max() < 2 * a.rounding)
    middles_of = lines.mean(axis=1)
    gaps = np.linalg.norm(np.diff(middles_of, axis=0), axis=1)
    step = np.median(gaps)
    expect("round steps", min(abs(step / 10 ** np.floor(np.log10(step)) - m) for m in (1, 2, 5, 10)) < 1e-3, step)
    expect("equal steps", np.sum(np.abs(gaps - step) > 4 * a.rounding) == 1)  # from one direction to the other


def check_space(a, centre):
    (ball,) = [b for b in a.scene["bodies"] if not b["plane"]]
    radius = np.linalg.norm(ball["points"], axis=1).max()
    expect("facets enough to look smooth", len(ball["parts"]) == 24 * 48)
    a.normal = np.array([0, 0, 1])
    check_camera(a, centre, radius)
    check_ground(a)
    drawing = Drawing(a.scene, 480, "", 1)
    for number in (0, len(centre) // 2, len(centre) - 1):
        check_shadow(a, drawing, centre[number], radius, number)


def check_moving_plane():
    """It is a body: it has a colour, and what is seen contains its place."""
    table = Body("table", "plane", np.array([0, 1, 0]), np.zeros((0, 3)), np.array([[0, 0, 0], [0, 7, 0]]))
    floor = table._replace(name="floor", position=np.array([0, -9, 0]))
    styles = Styles()
    drawn = {b["name"]: b for b in drawn_bodies([table, floor], np.arange(2), False, 1.0, styles)}
    edge = styles.list()[drawn["table"]["parts"][1][0]]["edge"]
    tools.expect(not drawn["table"]["fixed"] and edge == drawn["table"]["colour"] == COLOURS[0], "moving plane", edge)
    tools.expect(drawn["floor"]["fixed"] and drawn["floor"]["colour"] not in COLOURS, "fixed plane")
    low, high = extent([table, floor])
    tools.expect((low[1], high[1]) == (0, 7), "extent with a moving plane", low, high)


def blocks(a, q, count):
    q = q.reshape(len(q), -1, 3)
    expect("number of blocks", q.shape[1] == count == len(a.scene["bodies"]) - 1)
    for i in range(count):
        a.close(f"polygon {i + 1}", "pose", q[:, i, 0], q[:, i, 1], *turn(q[:, i, 2]))


def own_points(a, i):
    (body,) = [b for b in a.scene["bodies"] if b["name"] == f"polygon {i + 1}"]
    return np.array(body["points"])


def arch(a, q, p):
    blocks(a, q, p["blocks"])
    half = np.pi / (2 * p["blocks"])
    for i in range(p["blocks"]):  # anticlockwise from the inner one on the right
        corner = own_points(a, i) + q[0, 3 * i : 3 * i + 2]
        angle = (2 * i + 1 + np.array([-1, -1, 1, 1])) * half
        radius = p["R"] + p["R"] * p["t"] / 2 * np.array([-1, 1, 1, -1])
        away = np.abs(corner - np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])).max()
        expect("corners of a block", away < a.rounding, f"are off by {away:g}")


def dominoes(a, q, p):
    blocks(a, q, p["n"])
    for i in range(p["n"]):
        away = np.abs(np.abs(own_points(a, i)) - [p["d"] / 2, p["h"] / 2]).max()
        expect("size of a domino", away < a.rounding, f"is off by {away:g}")


def wall(a, q, p):
    n, odd = p["length"], p["courses"] // 2
    blocks(a, q, p["courses"] * n + odd)
    width = [(p["width"] / (2 if course % 2 and i in (0, n) else 1) - p["gap"])
             for course in range(p["courses"]) for i in range(n + course % 2)]
    for i, w in enumerate(width):
        away = np.abs(np.abs(own_points(a, i)) - [w / 2, p["height"] / 2]).max()
        expect("size of a block", away < a.rounding, f"is off by {away:g}")


def gripper(a, q, p):
    q = q.reshape(len(q), -1, 3)
    for i in range(4):
        a.close(f"polygon {i}", "pose", q[:, i, 0], q[:, i, 1], *turn(q[:, i, 2]))


def geneva(a, q, p):
    r, arm = p["distance"] * np.cos(np.pi / p["slots"]), p["distance"] * np.sin(np.pi / p["slots"])
    for i in range(p["slots"]):
        a.close(f"polygon {i}", "pose", 0, 0, *turn(q[:, 2]))
    a.close(f"disc {p['slots'] + 1}", "pose", p["distance"] + arm * np.cos(q[:, 5]), arm * np.sin(q[:, 5]))
    expect("length of the slots", abs(np.abs(a.pose("polygon 0")).max() - 1) < a.rounding and r < p["distance"])


def cam(a, q, p):
    for i, angle in ((0, q[:, 2]), (1, q[:, 5]), (2, q[:, 5])):
        a.close(f"polygon {i}", "pose", *q[:, 3 * (i > 0):][:, :2].T, *turn(angle))


def gears(a, q, p):
    apart, first = p["module"] * (p["driver"] + p["driven"]) / 2, p["driver"] + 1
    for i in (0, p["driver"] - 1):
        a.close(f"polygon {i}", "pose", 0, 0, *turn(q[:, 2]))
    for i in (first, first + p["driven"] - 1):
        a.close(f"polygon {i}", "pose", apart, 0, *turn(q[:, 5]))


def backlash(a, q, p):
    a.close("disc 0", "pose", -0.005 * (p["pinion"] + p["gear"]), 0, *turn(q[:, 2]))
    a.close("disc 1", "pose", 0, 0, *turn(q[:, 5]))


def quaternions(e):
    """Matrices [n, 9]: what e x e* makes of the axes."""
    w, x, y, z = (e / np.linalg.norm(e, axis=1)[:, None]).T
    return np.column_stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                            2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                            2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])


def column(a, q, p):
    q = q.reshape(len(q), -1, 7)
    expect("number of balls", q.shape[1] == p["balls"] == len(a.scene["bodies"]) - 1)
    for i in range(p["balls"]):
        a.close(f"sphere {i + 1}", "pose", *q[:, i, :3].T, *quaternions(q[:, i, 3:]).T)


def heap(a, q, p):
    """So many spheres are drawn as balls: places only."""
    q = q.reshape(len(q), -1, 7)
    wide = 6 * int(np.ceil(np.cbrt(p["spheres"] / 2) - 1e-9))
    grit = wide * wide if p["rough"] else 0
    expect("number of spheres", q.shape[1] == p["spheres"] == len(a.scene["bodies"]) - 1 - grit)
    styles = [a.scene["styles"][b["parts"][0][0]] for b in a.scene["bodies"] if not b["plane"]]
    expect("balls", len(styles) == grit + p["spheres"] > 300 and all(style["radius"] == p["r"] for style in styles))
    for i in range(p["spheres"]):
        a.close(f"sphere {grit + i + 1}", "pose", *q[:, i, :3].T)
    for i in range(grit):
        x, y = ((k - (wide - 1) / 2) * 2 * p["r"] for k in (i % wide, i // wide))
        a.close(f"sphere {i + 1}", "pose", x, y, 0)


def ragdoll(a, q, p):
    q = q.reshape(len(q), -1, 7)
    expect("number of bodies", q.shape[1] == 10 and len(a.scene["bodies"]) == 12)  # with floor and stairs
    names = ("torso", "head", "left_arm", "left_hand", "right_arm", "right_hand", "left_leg", "left_foot", "right_leg", "right_foot")
    for i, name in enumerate(names):
        a.close(f"{name} capsule {2 + i}", "pose", *q[:, i, :3].T, *quaternions(q[:, i, 3:]).T)


def scene(a, q, p):
    q = q.reshape(len(q), -1, 7)
    for i in range(q.shape[1]):
        a.close(f"box {i + 5}", "pose", *q[:, i, :3].T, *quaternions(q[:, i, 3:]).T)


MODELS = {"pendulum": pendulum, "clearance-hinge": clearance_hinge, "crank-slider": crank_slider, "incline": incline,
          "bouncing-ball": bouncing_ball, "falling-rod": falling_rod, "newtons-cradle": newtons_cradle,
          "woodpecker": woodpecker, "rolling-ball": rolling_ball, "arch": arch, "dominoes": dominoes, "wall": wall,
          "column": column, "heap": heap, "shaken-ball": shaken_ball, "squeezer": squeezer, "car-axis": car_axis,
          "flexible-crank": flexible_crank, "scene": scene, "gripper": gripper,
          "geneva": geneva, "ragdoll": ragdoll, "backlash": backlash, "cam": cam, "gears": gears}


def check_strips(a, f):
    """Every record's mode is that of the strip at its time."""
    shown = iter(a.scene["strips"])
    listed = "contacts/first" in f
    for path in ("contacts/mode", "frictional_joint/mode"):
        if path not in f or listed and path == "contacts/mode":
            continue
        for mode in f[path][...].T:
            spans = np.array(next(shown)["spans"])
            time = f["time"][1:]
            expect("strip", np.array_equal(spans[1:, 0], spans[:-1, 1]) and spans[-1, 1] == time[-1])
            if len(spans) < 1500:  # else thinned out
                expect("modes", np.array_equal(spans[np.searchsorted(spans[:, 1], time), 2], mode[1:]))
    expect("strips", next(shown, None) is None)
    if listed:  # contacts of a list have no strips
        expect("impacts by list", not a.scene["impacts"])
        return
    expect("impacts", [t for t, _ in a.scene["impacts"]] == list(f["impact/time"][...]) or len(f["impact/time"]) > 2000)


class Pictures:
    """The frames of a GIF, with their durations in seconds."""

    def __init__(self, path):
        with Image.open(path) as image:
            self.size, self.n, self.frames, self.duration = image.size, image.n_frames, [], []
            for i in range(image.n_frames):
                image.seek(i)
                self.duration.append(image.info["duration"] / 1000)
                self.frames.append(np.asarray(image.convert("RGB")))


def middles(frames, colour, tolerance=12):
    """Of the pixels of a colour in each frame [n, 2]; NaN where there are none."""
    found = []
    for frame in frames:
        y, x = np.nonzero(np.all(np.abs(frame.astype(int) - colour) <= tolerance, axis=2))
        found.append((x.mean(), y.mean()) if len(x) else (np.nan, np.nan))
    return np.array(found)


def check_pixels(name, frames, time, f, pixels):
    """The middle of what is blue moves as the first moving body's does: pixels are an affine map of
    metres, the same along x and upwards. Corners and the dark line around are drawn to a pixel, each."""
    t, q = f["time"][...], f["q"][...]
    at = np.searchsorted(t, time + 1e-9, side="right") - 1
    model = f.attrs["model"]
    place = {"pendulum": q[:, :2], "bouncing-ball": np.column_stack([0 * q[:, 0], q[:, 0]])}.get(model)
    if place is None:
        return
    strips = 40  # pixels at the bottom are of the strips, whose mode "stick" is blue too
    seen = middles([frame[:-strips] for frame in frames], (0x3B, 0x6E, 0xA5))
    expect(f"{name}: a body in every frame", np.isfinite(seen).all())
    place = place[at]
    seen, place = seen - seen.mean(axis=0), (place - place.mean(axis=0)) * [1, -1]
    scale = np.sum(seen * place) / np.sum(place * place)
    error = np.abs(seen - scale * place).max()
    expect(f"{name}: pixels", scale > 20 and error < pixels, f"are off by {error:.2f} at {scale:.1f} pixels a metre")


def check_gif(f, speed):
    pictures, time = Pictures(STEM + ".gif"), f["time"][...]
    step = 0.1 * speed  # ten frames a second
    whole = int((time[-1] - time[0]) / step * (1 + 1e-12)) + 1
    due = time[0] + step * np.arange(whole)
    shown = time[np.searchsorted(time, due + 1e-9 * step, side="right") - 1]
    if shown[-1] != time[-1]:
        shown = np.append(shown, time[-1])
    # of frames that are the same GIFs hold one, for as long as all of them: the time counts
    lasts = 0.1 * len(shown) + 1
    expect("duration", abs(sum(pictures.duration) - lasts) < 1e-6, f"{sum(pictures.duration)} s, not {lasts}")
    expect("frames", pictures.n <= len(shown))
    number = np.round(np.cumsum([0, *pictures.duration[:-1]]) / 0.1).astype(int)
    check_pixels("GIF", pictures.frames, shown[number], f, 1.5)
    expect("size", pictures.size[0] == 480 and os.path.getsize(STEM + ".gif") < 1.5e6)
    return shown, pictures.size


def check_mp4(f, shown, size):
    if not os.path.exists(STEM + ".mp4"):
        return "no MP4"
    raw = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", STEM + ".mp4", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
                         stdout=subprocess.PIPE, check=True).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, size[1], size[0], 3)
    expect("frames of the MP4", len(frames) == len(shown), f"{len(frames)}, not {len(shown)}")
    check_pixels("MP4", frames, shown, f, 2.5)  # colours are of every other pixel
    return f"{len(frames)} frames in the MP4"


def check_example(stem):
    global STEM
    STEM = stem
    with h5py.File(STEM + ".h5") as f:
        page = Page(STEM + ".html", f)
        MODELS[f.attrs["model"]](page, page.q, page.p)
        check_strips(page, f)
        check_layers(page)
        if not os.path.exists(STEM + ".gif"):
            expect("a GIF", tools.QUICK and STEM not in GIFS)
            print(f"{STEM}: {len(page.time)} frames in the page")
            return
        shown, size = check_gif(f, page.scene["speed"])
        film = check_mp4(f, shown, size)
        print(f"{STEM}: {len(page.time)} frames in the page, {len(shown)} in the GIF, {film}")


def check_layers(a):
    """A frame with its still layers has the pixels of one that is drawn whole, from far to near."""
    drawing = Drawing(a.scene, 480, "", 1)
    painter, number = drawing.painter, len(a.time) // 2
    for last in (number, len(a.time) - 1):
        whole = painter.blank(BACKGROUND)
        parts = [part for one in painter.drawn_as() for part in one.parts(last)]
        paint(ImageDraw.Draw(whole), sorted(parts, key=lambda part: part[:2]) if a.scene["spatial"] else parts)
        expect("layers", np.array_equal(whole, painter.image(last)))


# earlier ends or fewer bodies where the test would last
SHORTER = {"bouncing-ball": ("--t-end", "3"), "pendulum": ("--t-end", "3"), "pendulum-fortran": ("--t-end", "3"),
           "crank-slider": ("--t-end", "3"), "woodpecker": ("--t-end", "1"), "newtons-cradle": ("--t-end", "1"),
           "dominoes": ("--t-end", "0.3"), "heap": ("--t-end", "0.3"), "scene": ("--t-end", "0.3"), "shaken-ball": ("--t-end", "0.3"),
           "ragdoll": ("--t-end", "0.5"), "column": ("--set", "balls=3")}  # each is a mesh


GIFS = ("incline", "pendulum")  # of the quick form


def check_examples(data):
    """At ten frames a second."""
    count = 0
    for example in tools.examples():
        tools.make(example, data, SHORTER.get(example, ()))
        outputs = ("-o", f"{example}.html") if tools.QUICK and example not in GIFS else ()
        tools.runs("nsdae-animate", "--fps", "10", *outputs, f"{example}.h5")
        with tools.judged(example):
            check_example(example)
        count += 1
    tools.expect(count >= (9 if tools.QUICK else 15), count, "examples")


def check_pages():
    """A browser that opens a page at a time stands at that frame; their script is one, and JavaScript."""
    program = tools.browser()
    pages = [("pendulum.html", 0.5, 100), ("rolling-ball.html", 0.25, 50)][: 1 if tools.QUICK else 2]
    for page, time, frame in pages if program else ():
        dom = tools.browse(program, page, time, "--dump-dom")
        tools.expect(f'data-frame="{frame}"' in dom, page, "at", time, "s:", re.findall('data-frame="[0-9]*"', dom), "not", frame)
        tools.expect(">Play</button>" in dom, page, "plays though a time was asked for")
        tools.expect("<option value=" in dom, page, "offers no speeds")
    pages, scripts = [name for name in os.listdir(".") if name.endswith(".html")], set()
    for name in pages:
        with open(name, encoding="utf-8") as page:
            scripts.add(re.search("^<script>$(.*?)^</script>$", page.read(), re.DOTALL | re.MULTILINE)[1])
    tools.expect(len(pages) >= (9 if tools.QUICK else 15) and len(scripts) == 1, len(pages), "pages,", len(scripts), "scripts")
    if shutil.which("node"):
        with open("page.js", "w", encoding="utf-8") as file:
            file.write(scripts.pop())
        tools.runs_plainly(["node", "--check", "page.js"])


def check_options():
    # a part of the time, slower, of another size, and what was asked for only; as users start it
    said = tools.started_by_launcher("nsdae-animate", "-o", "part.gif", "--from", "0.4", "--to", "0.6", "--speed", "0.1",
                                     "--fps", "20", "--width", "320", "pendulum.h5")
    tools.expect(said == "41 frames of 3 bodies in part.gif\n", "--from:", said)  # 2 s, 20 a second, both ends
    with h5py.File("pendulum.h5") as old, h5py.File("other.h5", "w") as new:  # points of a model that names no bodies
        for name in ("time", "q"):
            old.copy(name, new)
        new.attrs.update(old.attrs)
    said = tools.runs("nsdae-animate", "--point", "0,1,-", "--point", "2,-,-", "-o", "points.html", "other.h5")
    tools.expect(said.endswith(" frames of 2 bodies in points.html\n"), "--point:", said)


def check_errors():
    def refuses(code, words, *arguments):
        tools.refuses(code, words, "nsdae-animate", *arguments)

    refuses(1, "'other.h5' names no bodies", "other.h5")
    refuses(1, "the coordinates 0 to 2, not 3", "other.h5", "--point", "3,-,-")
    refuses(1, "cannot read 'none.h5': No such file or directory", "none.h5")
    with open("text.h5", "w", encoding="ascii") as file:
        file.write("text")
    refuses(1, "cannot read 'text.h5'", "text.h5")
    refuses(1, "no records between --from and --to", "pendulum.h5", "--from", "5")
    refuses(1, "cannot write 'no/x.gif': No such file or directory", "pendulum.h5", "--to", "0.02", "-o", "no/x.gif")
    refuses(2, "must end with .gif, .mp4, .html", "pendulum.h5", "-o", "x.png")
    refuses(2, "--fps", "pendulum.h5", "--fps", "0")
    refuses(2, "--speed", "pendulum.h5", "--speed", "-1")
    refuses(2, "--width", "pendulum.h5", "--width", "10")
    refuses(2, "X,Y,Z", "pendulum.h5", "--point", "1")
    refuses(2, "required: file")
    if not shutil.which("ffmpeg"):
        refuses(1, "cannot write 'x.mp4': it needs ffmpeg", "pendulum.h5", "-o", "x.mp4")
    with h5py.File("pendulum.h5", "r+") as f:  # a formula that has no value at some time
        f["bodies/x"][0] = "sqrt(q0-100)"
    refuses(1, "the formula 'sqrt(q0-100)' is not finite", "pendulum.h5")


def check_full_disk():
    """The reason, and the file that was there stays whole."""
    with open("incline.gif", "rb") as file:
        kept = file.read()
    done = tools.run("nsdae-animate", "--fps", "10", "incline.h5", "-o", "incline.gif", most=40 * 512)
    tools.expect(done.code == 1 and "cannot write 'incline.gif': File too large" in done.err, "full disk:", done.code, done.err)
    with open("incline.gif", "rb") as file:
        tools.expect(file.read() == kept, "the old file is lost")
    tools.expect(not os.path.exists("incline.gif.part"), "a part is left")


check_examples(sys.argv[2])
check_pages()
check_moving_plane()
check_options()
check_errors()
check_full_disk()
tools.end()
