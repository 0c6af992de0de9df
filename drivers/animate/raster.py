"""The frames of an animation as images: drawn at twice the size and scaled down for
smooth edges. The page in HTML draws the same scene (scene.py)."""

import os

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont
from scene import BACKGROUND, INK, shaded
from shapes import normals_of

FINE = 2  # how much finer is drawn than shown
MARGIN = 8
TEXT = 12  # height of the font in pixels
GROUND, SHADOW, GRID, BODY = range(4)  # the order in which they are drawn
STRIP, STRIP_GAP, STRIPS_MAX = 7, 3, 8


def font(pixels):
    path = os.path.join(matplotlib.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf")
    try:
        return ImageFont.truetype(path, pixels * FINE)
    except OSError:
        return ImageFont.load_default()


def view_axes(azimuth, elevation):
    """Rows: to the right, upwards, to the eye."""
    ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    return np.array([[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


class Drawing:
    """The scene's layout in pixels: title, bodies, time, strips."""

    def __init__(self, scene, width, title, speed):
        self.scene, self.title, self.speed = scene, title, speed
        self.axes = view_axes(*scene["view"]) if scene["spatial"] else np.eye(3)
        self.light = self.axes @ scene["light"]
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
        low, high = self.scene["low"], self.scene["high"]
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
        self.bodies(ImageDraw.Draw(bodies), number)
        image.paste(bodies, (0, self.top * FINE))
        self.clock(ImageDraw.Draw(image), number)
        return image.reduce(FINE)

    def bodies(self, draw, number):
        """Planes first, their shadows and grids, then bodies from far to near; forces of a contact list on top."""
        drawn = []
        for body in self.scene["bodies"]:
            seen = self.seen(body, number)
            flat = self.pixels(seen[:, :2])
            parts = [(self.scene["styles"][style], points) for style, *points in body["parts"]]
            if "lit" in parts[0][0]:
                drawn += self.faces(body, parts, seen, flat)
                drawn += [] if body["plane"] else self.shadows(parts, seen, number)
            else:
                drawn.append((BODY, seen[0, 2], [(style, flat[points]) for style, points in parts]))
        for *_, parts in sorted(drawn, key=lambda d: d[:2]) if self.scene["spatial"] else drawn:
            for style, points in parts:
                self.part(draw, style, points)
        force = self.scene["force"]
        for *ends, weight in self.scene["forces"][number] if self.scene["forces"] else ():
            width = min(max(force["width"] * weight, 0.5), 2 * force["width"])
            self.part(draw, {**force, "width": width, "round": 0}, self.pixels(self.turned(np.reshape(ends, (2, 3)), number)[:, :2]))

    def turned(self, points, number):
        """Of points [..., 3] in space: to the right, upwards, to the eye, from where the camera is."""
        return (points - (self.scene["camera"][number] if self.scene["camera"] else 0)) @ self.axes.T

    def seen(self, body, number):
        """Its points [p, 3]: to the right, upwards, to the eye."""
        pose = body["pose"][min(number, len(body["pose"]) - 1)]
        points = np.array(body["points"])
        if not self.scene["spatial"]:
            x, y, a, b = pose
            return np.column_stack([points @ [[a, b], [-b, a]] + [x, y], np.zeros(len(points))])
        pose = np.array(pose)
        return self.turned(pose[:3] + (points @ pose[3:].reshape(3, 3).T if len(pose) > 3 else points), number)

    def faces(self, body, parts, seen, flat):
        """Those that look this way; a plane's lines if its surface, the second face, does."""
        normals = normals_of(seen, [face if "lit" in style else parts[1][1] for style, face in parts])
        lights = 0.6 + 0.4 * np.maximum(0, normals @ self.light)
        for i in np.flatnonzero(normals[:, 2] > 0):
            (style, face), light = parts[i], lights[i]
            if "lit" not in style:
                yield GRID, 0.0, [(style, flat[face])]
            else:
                yield GROUND if body["plane"] else BODY, seen[face, 2].mean(), [({"fill": shaded(style["fill"], light)}, flat[face])]

    def shadows(self, parts, seen, number):
        """Of the faces that look at the light, along it onto each plane."""
        faces = [face for _, face in parts]
        faces = [faces[i] for i in np.flatnonzero(normals_of(seen, faces) @ self.light > 0)]
        for normal, point in self.scene["shadows"]:
            normal, point = self.axes @ normal, self.turned(np.array(point), number)
            flat = self.pixels((seen - np.outer((seen - point) @ normal / (normal @ self.light), self.light))[:, :2])
            yield SHADOW, 0.0, [({"fill": self.scene["shadow"]}, flat[face]) for face in faces]

    def part(self, draw, style, points):
        fill, edge, corners = style.get("fill"), style.get("edge"), [tuple(p) for p in points]
        width = round(max(style.get("metres", 0) * self.scale, style.get("width", 0)) * FINE)
        if "radius" in style:
            radius, hole = max(style["radius"] * self.scale, style["least"]) * FINE, style["hole"] * self.scale * FINE
            if hole > 0:  # a ring as a thick line: what is behind its hole stays to be seen
                fill, edge, width = None, fill, max(round(radius - hole), 1)
            disc(draw, points[0], radius, fill=fill, outline=edge, width=width)
            return
        if fill:
            draw.polygon(corners, fill=fill)
        if edge:
            draw.line(corners + corners[: 1 if fill else 0], fill=edge, width=width, joint="curve" if style.get("round") else None)
            for end in points[[0, -1]] if style.get("round") else ():
                disc(draw, end, width / 2, fill=edge)

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
