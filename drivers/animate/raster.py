"""The frames of an animation as images: drawn at twice the size and scaled down for
smooth edges. The page in HTML draws the same scene (scene.py)."""

import os

import matplotlib
import numpy as np
from painter import FINE, Painter
from PIL import Image, ImageDraw, ImageFont
from scene import BACKGROUND, INK

MARGIN = 8
TEXT = 12  # height of the font in pixels
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


def shown_strips(strips):
    """Without names as here, of many those of contacts alone."""
    return strips if len(strips) <= STRIPS_MAX else [strip for strip in strips if strip["kind"] == "contact"][:STRIPS_MAX]


class Drawing:
    """The scene's layout in pixels: title, bodies, time, strips."""

    def __init__(self, scene, width, title, speed):
        self.scene, self.title, self.speed = scene, title, speed
        self.strips = shown_strips(scene["strips"])
        self.axes = view_axes(*scene["view"]) if scene["spatial"] else np.eye(3)
        self.low, self.high = self.box()
        reach = self.high - self.low
        self.top, self.bottom = TEXT + 2 * MARGIN, TEXT + 2 * MARGIN + self.strips_height()
        inner = width - 2 * MARGIN
        height = int(np.clip(inner * reach[1] / reach[0], 0.4 * inner, 1.0 * inner))
        self.size = (even(width), even(self.top + height + self.bottom))
        self.area = (inner, self.size[1] - self.top - self.bottom)
        self.scale = min(self.area[0] / reach[0], self.area[1] / reach[1])
        self.font = font(TEXT)
        self.painter = Painter(scene, self.axes, self.low, self.high, self.scale, (self.size[0] * FINE, self.area[1] * FINE))
        self.fine = self.around()
        self.shown = self.fine.reduce(FINE)

    def box(self):
        """Of what is to be seen, in the picture's plane."""
        low, high = self.scene["low"], self.scene["high"]
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        seen = corners @ self.axes[:2].T
        return seen.min(axis=0), seen.max(axis=0)

    def strips_height(self):
        return len(self.strips) * (STRIP + STRIP_GAP)

    def around(self):
        """What is above and below the bodies and stays: title, legend, strips."""
        image = Image.new("RGB", (self.size[0] * FINE, self.size[1] * FINE), BACKGROUND)
        draw = ImageDraw.Draw(image)
        draw.text((MARGIN * FINE, MARGIN * FINE), self.title, fill=INK, font=self.font)
        if self.strips:
            self.legend(draw)
            self.timeline(draw)
        return image

    def frame(self, number):
        """Only what changes is drawn again and scaled down: the bodies, and what is below them."""
        image = self.shown.copy()
        image.paste(self.painter.image(number).reduce(FINE), (0, self.top))
        below = self.top + self.area[1]
        foot = self.fine.crop((0, below * FINE, self.size[0] * FINE, self.size[1] * FINE))
        self.clock(ImageDraw.Draw(foot), number, below)
        image.paste(foot.reduce(FINE), (0, below))
        return image

    def clock(self, draw, number, above):
        """In an image whose top is that far below that of the frame."""
        time = self.scene["time"]
        words = f"t = {time[number]:.3f} s"
        if self.speed != 1:
            words += f"  x 1/{1 / self.speed:g}" if self.speed < 1 else f"  x {self.speed:g}"
        draw.text((MARGIN * FINE, (self.footer() - above) * FINE), words, fill=INK, font=self.font)
        if self.strips:
            x, bottom = self.along(time[number]), (self.size[1] - MARGIN / 2 - above) * FINE
            draw.line([x, bottom - (self.strips_height() + 3) * FINE, x, bottom], fill=INK, width=2 * FINE)

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
        for i, strip in enumerate(self.strips):
            y = (top + i * (STRIP + STRIP_GAP)) * FINE
            for a, b, mode in strip["spans"]:
                draw.rectangle([self.along(a), y, self.along(b), y + STRIP * FINE], fill=self.scene["mode_colours"][mode])
            for t, contact in self.scene["impacts"]:
                if contact == i:
                    draw.line([self.along(t), y, self.along(t), y + STRIP * FINE], fill=INK, width=1)


def even(number):
    """As the formats of films want it."""
    return int(number) + int(number) % 2
