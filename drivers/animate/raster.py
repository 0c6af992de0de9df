"""The frames of an animation as images: drawn at twice the size and scaled down, so that edges are
smooth. The page in HTML draws the same (page.html); change both."""

import os

import matplotlib
import numpy as np
from PIL import Image, ImageColor, ImageDraw, ImageFont

FINE = 2  # how much finer is drawn than shown
MARGIN = 8
TEXT = 11  # points
STRIP, STRIP_GAP, STRIPS_MAX = 7, 3, 8
INK, PALE = "#30353b", "#8b9198"
BACKGROUND = "#ffffff"
GROUND = "#dfe2e6"
FORCE, FORCE_WIDTH = "#b0161c", 3  # pixels of a strength of 1
AZIMUTH, ELEVATION = np.radians(-60), np.radians(20)
LIGHT = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])


def font(points):
    path = os.path.join(matplotlib.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf")
    try:
        return ImageFont.truetype(path, points * FINE)
    except OSError:
        return ImageFont.load_default()


def view_axes():
    """Rows: to the right, upwards, to the eye."""
    ca, sa, ce, se = np.cos(AZIMUTH), np.sin(AZIMUTH), np.cos(ELEVATION), np.sin(ELEVATION)
    return np.array([[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def shaded(colour, light):
    return tuple(int(c * light) for c in ImageColor.getrgb(colour))


class Drawing:
    """The scene's layout in pixels: title, bodies, time, strips."""

    def __init__(self, scene, width, title, speed):
        self.scene, self.title, self.speed = scene, title, speed
        self.axes = view_axes()
        self.low, self.high = self.box()
        reach = self.high - self.low
        self.top, self.bottom = TEXT + 2 * MARGIN, TEXT + 2 * MARGIN + self.strips_height()
        inner = width - 2 * MARGIN
        height = int(np.clip(inner * reach[1] / reach[0], 0.4 * inner, 1.0 * inner))
        self.size = (even(width), even(self.top + height + self.bottom))
        self.area = (inner, self.size[1] - self.top - self.bottom)
        self.scale = min(self.area[0] / reach[0], self.area[1] / reach[1])
        self.font = font(TEXT)
        self.frame_around = self.around()

    def box(self):
        """Of what is to be seen, in the picture's plane."""
        low, high = np.array(self.scene["low"]), np.array(self.scene["high"])
        if not self.scene["spatial"]:
            return low[:2], high[:2]
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        seen = corners @ self.axes[:2].T
        return seen.min(axis=0), seen.max(axis=0)

    def strips_height(self):
        return min(len(self.scene["strips"]), STRIPS_MAX) * (STRIP + STRIP_GAP)

    def pixels(self, points):
        """Of points [..., 2] in the picture's plane, from the corner of the bodies' part."""
        middle = np.array([self.size[0], self.area[1]]) / 2
        return FINE * (middle + self.scale * (points - (self.low + self.high) / 2) * [1, -1])

    def around(self):
        """What is above and below the bodies and stays: title, legend, strips."""
        image = Image.new("RGB", (self.size[0] * FINE, self.size[1] * FINE), BACKGROUND)
        draw = ImageDraw.Draw(image)
        draw.text((MARGIN * FINE, MARGIN * FINE), self.title, fill=INK, font=self.font)
        if self.scene["strips"]:
            self.legend(draw)
            self.timeline(draw)
        return image

    def frame(self, number):
        image = self.frame_around.copy()
        middle = (self.size[0] * FINE, self.area[1] * FINE)
        bodies = Image.new("RGB", middle, BACKGROUND)
        (self.spatial if self.scene["spatial"] else self.planar)(ImageDraw.Draw(bodies), number)
        if self.scene["forces"]:
            self.forces(ImageDraw.Draw(bodies), number)
        image.paste(bodies, (0, self.top * FINE))
        self.clock(ImageDraw.Draw(image), number)
        return image.reduce(FINE)

    def planar(self, draw, number):
        for body in self.scene["bodies"]:
            pose = body["pose"][min(number, len(body["pose"]) - 1)]
            {"area": self.polygon, "circle": self.circle, "ground": self.ground, "line": self.line,
             "mark": self.mark}[body["kind"]](draw, body, pose)

    def placed(self, points, pose):
        p = np.reshape(points, (-1, 2))
        x, y, a, b = pose
        return self.pixels(np.column_stack([x + a * p[:, 0] - b * p[:, 1], y + b * p[:, 0] + a * p[:, 1]]))

    def line(self, draw, body, pose):
        points = self.placed(body["points"], pose)
        width = max(body["width"] * self.scale, 1.2) * FINE
        draw.line([tuple(p) for p in points], fill=body["colour"], width=round(width), joint="curve")
        for p in points[[0, -1]]:
            disc(draw, p, width / 2, fill=body["colour"])

    def polygon(self, draw, body, pose):
        points = [tuple(p) for p in self.placed(body["points"], pose)]
        draw.polygon(points, fill=body["colour"])
        draw.line([*points, points[0]], fill=shaded(body["colour"], 0.75), width=FINE)

    def circle(self, draw, body, pose):
        (centre,) = self.placed([0, 0], pose)
        radius, hole = (body[part] * self.scale * FINE for part in ("radius", "hole"))
        radius = max(radius, FINE)
        if hole > 0:  # a ring as a thick line: what is behind its hole stays to be seen
            box = [*(centre - radius), *(centre + radius)]
            draw.ellipse(box, outline=body["colour"], width=max(round(radius - hole), 1))
            return
        disc(draw, centre, radius, fill=body["colour"], outline=shaded(body["colour"], 0.75), width=FINE)
        if body["spoke"]:
            (rim,) = self.placed([body["radius"], 0], pose)
            draw.line([tuple(centre), tuple(rim)], fill=BACKGROUND, width=2 * FINE)

    def mark(self, draw, body, pose):
        (centre,) = self.placed([0, 0], pose)
        disc(draw, centre, 4 * FINE, fill=body["colour"])

    def ground(self, draw, body, pose):
        far = 2 * float(np.linalg.norm(self.high - self.low))
        (x, y), across = body["along"], np.array([body["along"][1], -body["along"][0]])
        a, b = far * np.array([-x, -y]), far * np.array([x, y])
        corners = self.placed(np.array([a, b, b + far * across, a + far * across]), pose)
        draw.polygon([tuple(p) for p in corners], fill=GROUND)
        draw.line([tuple(p) for p in corners[:2]], fill=PALE, width=2 * FINE)

    def spatial(self, draw, number):
        """Faces that look this way, the farthest first; planes behind all."""
        faces = []
        for body in self.scene["bodies"]:
            pose = np.array(body["pose"][min(number, len(body["pose"]) - 1)])
            if body["kind"] == "ball":
                seen = self.axes @ pose
                faces.append((True, seen[2], self.pixels(seen[:2]), (body["colour"], body["radius"] * self.scale * FINE)))
                continue
            points = (pose[:3] + np.array(body["points"]) @ pose[3:].reshape(3, 3).T) @ self.axes.T
            flat = self.pixels(points[:, :2])
            for i, face in enumerate(body["faces"]):
                normal = normal_of(points[face])
                if normal[2] > 0:
                    light = 0.6 + 0.4 * max(0.0, float(normal @ (self.axes @ LIGHT)))
                    dark = 0.6 if body["dark"] and body["dark"][i] else 1.0
                    faces.append((not body["plane"], points[face, 2].mean(), flat[face], shaded(body["colour"], light * dark)))
        for _, _, corners, look in sorted(faces, key=lambda f: f[:2]):
            if np.ndim(corners) == 1:
                self.ball(draw, corners, *look)
            else:
                draw.polygon([tuple(p) for p in corners], fill=look)

    def ball(self, draw, centre, colour, radius):
        """A disc with a lighter one where the light comes from."""
        radius = max(radius, FINE)
        disc(draw, centre, radius, fill=shaded(colour, 0.75), outline=shaded(colour, 0.5))
        disc(draw, centre + 0.3 * radius * (self.axes[:2] @ LIGHT) * [1, -1], 0.55 * radius, fill=colour)

    def forces(self, draw, number):
        """Of contacts by list, over all else."""
        for *ends, weight in self.scene["forces"][number]:
            points = np.reshape(ends, (2, 3))
            flat = points @ self.axes[:2].T if self.scene["spatial"] else points[:, :2]
            width = min(max(FORCE_WIDTH * weight, 0.5), 2 * FORCE_WIDTH) * FINE
            draw.line([tuple(p) for p in self.pixels(flat)], fill=FORCE, width=round(width))

    def clock(self, draw, number):
        time = self.scene["time"]
        words = f"t = {time[number]:.3f} s"
        if self.speed != 1:
            words += f"  x 1/{1 / self.speed:g}" if self.speed < 1 else f"  x {self.speed:g}"
        draw.text((MARGIN * FINE, self.footer() * FINE), words, fill=INK, font=self.font)
        if self.scene["strips"]:
            x, top = self.along(time[number]), (self.size[1] - MARGIN / 2 - self.strips_height()) * FINE
            draw.line([x, top - 3 * FINE, x, (self.size[1] - MARGIN / 2) * FINE], fill=INK, width=2 * FINE)

    def footer(self):
        return self.size[1] - self.bottom + MARGIN / 2

    def legend(self, draw):
        x, y = (self.size[0] - MARGIN) * FINE, self.footer() * FINE
        for name, colour in list(zip(self.scene["modes"], self.scene["mode_colours"]))[::-1]:
            x -= draw.textlength(name, font=self.font)
            draw.text((x, y), name, fill=INK, font=self.font)
            x -= 11 * FINE
            draw.rectangle([x, y + 3 * FINE, x + 8 * FINE, y + 11 * FINE], fill=colour)
            x -= 9 * FINE

    def along(self, t):
        """Where a time is on the strips."""
        time, left, right = self.scene["time"], MARGIN * FINE, (self.size[0] - MARGIN) * FINE
        return left + (right - left) * (t - time[0]) / ((time[-1] - time[0]) or 1.0)

    def timeline(self, draw):
        """A strip for each contact, coloured by its mode, with its impacts as ticks."""
        top = self.size[1] - MARGIN / 2 - self.strips_height()
        for i, strip in enumerate(self.scene["strips"][:STRIPS_MAX]):
            y = (top + i * (STRIP + STRIP_GAP)) * FINE
            for a, b, mode in strip["spans"]:
                draw.rectangle([self.along(a), y, self.along(b), y + STRIP * FINE], fill=self.scene["mode_colours"][mode])
            for t, contact in self.scene["impacts"]:
                if contact == i:
                    draw.line([self.along(t), y, self.along(t), y + STRIP * FINE], fill=INK, width=1)


def even(number):
    """As the formats of films want it."""
    return int(number) + int(number) % 2


def disc(draw, centre, radius, **look):
    draw.ellipse([*(centre - radius), *(centre + radius)], **look)


def normal_of(corners):
    """Of a polygon, by Newell's sum; of length one, or zero where it has no area."""
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    length = np.linalg.norm(normal)
    return normal / length if length > 0 else normal
