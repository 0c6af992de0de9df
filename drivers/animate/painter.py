"""The bodies of a frame as an image, from far to near (painter's algorithm).

All faces of a body are turned, culled and shaded at once. Parts that do not move are computed once, and are an image. In
space a frame differs from it within rectangles about the moving bodies and their shadows. What is there is drawn anew: the
ground and its shadows, the moving shadows, an image of the grid and the faces behind all moving bodies, the other faces.

A part to draw is (layer, depth, function, coordinates in pixels, look...). In space parts are drawn by layer and depth,
in the plane in the order of the bodies."""

from itertools import chain, compress, repeat
from operator import itemgetter

import numpy as np
from PIL import Image, ImageChops, ImageDraw
from scene import BACKGROUND
from shapes import faces_by_corners, normals_of_loops

FINE = 2  # how much finer is drawn than shown
GROUND, SHADOW, GRID, BODY = range(4)  # the layers, in the order in which they are drawn
RIM = 2  # pixels around coordinates: they are rounded to a pixel, which is drawn


def rgb(colour):
    return tuple(int(colour[i : i + 2], 16) for i in (1, 3, 5))


def polygon(draw, corners, fill):
    draw.polygon(corners, fill=fill)


def line(draw, points, edge, width, round_ends):
    draw.line(points, fill=edge, width=width, joint="curve" if round_ends else None)
    for x, y in (points[:2], points[-2:]) if round_ends else ():
        draw.ellipse([x - width / 2, y - width / 2, x + width / 2, y + width / 2], fill=edge)


def disc(draw, box, fill, edge, width):
    draw.ellipse(box, fill=fill, outline=edge, width=width)


def discs(layer, depths, centres, radii, look):
    """Discs [n, 2] about their centres, of these radii [n] in pixels; look: fill, edge, width of the edge."""
    boxes = np.concatenate([centres - radii[:, None], centres + radii[:, None]], axis=1)
    return zip(repeat(layer), depths, repeat(disc), boxes.tolist(), *map(repeat, look))


def paint(draw, parts):
    for _, _, function, *what in parts:
        function(draw, *what)


def rectangle(parts):
    """Left, top, right, bottom of the pixels of polygons and discs."""
    points = np.reshape(list(chain.from_iterable(part[3] for part in parts)), (-1, 2))
    return [*(points.min(axis=0) - RIM), *(points.max(axis=0) + RIM)]


class Faces:
    """A body in space: faces, and a grid on the surface of a plane."""

    def __init__(self, painter, body):
        self.painter, self.plane, self.points = painter, body["plane"], np.array(body["points"])
        self.pose = np.array(body["pose"])
        parts = [(painter.styles[style], points) for style, *points in body["parts"]]
        lit = [(style, face) for style, face in parts if "lit" in style]
        self.surface = lit[1][1]  # of a plane
        self.groups = [(faces, np.array([rgb(lit[i][0]["fill"]) for i in mine]))
                       for mine, faces in faces_by_corners([face for _, face in lit])]
        grid = [(style, ends) for style, ends in parts if "lit" not in style]
        self.grid = np.array([ends for _, ends in grid])
        self.grid_look = (rgb(grid[0][0]["edge"]), round(grid[0][0]["width"] * FINE), False) if grid else ()

    def nearest(self):
        """Smallest depth of a point over all frames."""
        matrix = self.pose[:, 3:].reshape(-1, 3, 3)
        depth = self.points @ np.einsum("nij,i->jn", matrix, self.painter.axes[2])
        return (depth + self.pose[:, :3] @ self.painter.axes[2]).min()

    def parts(self, number):
        painter = self.painter
        seen = painter.seen(self, number)
        flat = painter.pixels(seen[:, :2])
        layer = GROUND if self.plane else BODY
        for faces, colours in self.groups:
            loops = seen[faces]
            normals = normals_of_loops(loops)
            front = normals[:, 2] > 0
            light = 0.6 + 0.4 * np.maximum(0, normals[front] @ painter.light)
            yield from zip(repeat(layer), loops[front, :, 2].mean(axis=1).tolist(), repeat(polygon),
                           flat[faces[front]].reshape(-1, 2 * faces.shape[1]).tolist(),
                           map(tuple, (colours[front] * light[:, None]).astype(int).tolist()))
            if not self.plane:
                yield from self.shadows(seen, faces[normals @ painter.light > 0], number)
        if len(self.grid) and normals_of_loops(seen[[self.surface]])[0, 2] > 0:
            for ends in flat[self.grid].reshape(-1, 4).tolist():
                yield GRID, 0.0, line, ends, *self.grid_look

    def shadows(self, seen, faces, number):
        """Of faces that look at the light, along it onto each plane."""
        painter = self.painter
        for normal, point in painter.scene["shadows"]:
            normal, point = painter.axes @ normal, painter.turned(np.array(point), number)
            way = np.outer((seen - point) @ normal / (normal @ painter.light), painter.light)
            flat = painter.pixels((seen - way)[:, :2])
            for corners in flat[faces].reshape(len(faces), -1).tolist():
                yield SHADOW, 0.0, polygon, corners, painter.shadow


class Balls:
    """Balls of one size and colour among many: a disc each, with a lighter one in it."""

    def __init__(self, painter, bodies):
        self.painter, self.points = painter, np.array(bodies[0]["points"])
        frames = max(len(body["pose"]) for body in bodies)
        self.pose = np.stack([np.broadcast_to(body["pose"], (frames, 3)) for body in bodies], axis=1)
        styles = [painter.styles[part[0]] for part in bodies[0]["parts"]]
        self.looks = [(rgb(style["fill"]), rgb(style["edge"]) if "edge" in style else None,
                       round(style.get("width", 0) * FINE)) for style in styles]
        self.radii = [max(style["radius"] * painter.scale, style["least"]) * FINE for style in styles]

    def nearest(self):
        return ((self.pose @ self.painter.axes[2]).min() + (self.points @ self.painter.axes[2]).min())

    def parts(self, number):
        centres = self.pose[min(number, len(self.pose) - 1)]
        rows = []
        for point, radius, look in zip(self.points, self.radii, self.looks):
            seen = self.painter.turned(centres + point, number)
            depths = seen[:, 2] if not rows else depths  # the disc in it belongs to it
            rows.append(discs(BODY, depths.tolist(), self.painter.pixels(seen[:, :2]), np.full(len(seen), radius), look))
        for of_one in zip(*rows):
            yield from of_one


class Outline:
    """A planar body: areas, lines and discs."""

    def __init__(self, painter, body):
        self.painter, self.points, self.pose = painter, np.array(body["points"]), np.array(body["pose"])
        self.styled = [(painter.styles[style], points) for style, *points in body["parts"]]

    def parts(self, number):
        flat = self.painter.pixels(self.painter.seen(self, number)[:, :2])
        for style, points in self.styled:
            yield from self.part(style, flat[points])

    def part(self, style, points):
        scale, fill, edge = self.painter.scale, style.get("fill"), style.get("edge")
        fill, edge = fill and rgb(fill), edge and rgb(edge)
        width = round(max(style.get("metres", 0) * scale, style.get("width", 0)) * FINE)
        if "radius" in style:
            radius, hole = max(style["radius"] * scale, style["least"]) * FINE, style["hole"] * scale * FINE
            if hole > 0:  # a ring as a thick line: what is behind its hole stays to be seen
                fill, edge, width = None, fill, max(round(radius - hole), 1)
            yield from discs(BODY, (0.0,), points[:1], np.array([radius]), (fill, edge, width))
            return
        corners = points.ravel().tolist()
        if fill:
            yield BODY, 0.0, polygon, corners, fill
        if edge:
            yield BODY, 0.0, line, corners + corners[: 2 if fill else 0], edge, width, style.get("round")


class Painter:
    """Of the scene: axes to the right, upwards, to the eye; low, high: what is seen of the picture's plane; size in
    pixels."""

    def __init__(self, scene, axes, low, high, scale, size):
        self.scene, self.styles, self.axes, self.scale, self.size = scene, scene["styles"], axes, scale, size
        self.light, self.shadow, self.middle = axes @ scene["light"], rgb(scene["shadow"]), (low + high) / 2
        self.painted = self.drawn_as()
        still = [len(one.pose) == 1 and not scene["camera"] for one in self.painted]
        self.moving = [one for one, at_rest in zip(self.painted, still) if not at_rest]
        self.still = {one: list(one.parts(0)) for one, at_rest in zip(self.painted, still) if at_rest}
        self.kept, self.ground, self.between = self.blank(BACKGROUND), None, []
        if scene["spatial"]:
            self.lay_out()
        else:
            first = still.index(False) if False in still else len(still)
            for one in self.painted[:first]:
                paint(ImageDraw.Draw(self.kept), self.still[one])
            self.painted = self.painted[first:]

    def drawn_as(self):
        """The bodies by how they are drawn, in their order; in space equal balls together."""
        if not self.scene["spatial"]:
            return [Outline(self, body) for body in self.scene["bodies"]]
        painted, balls = [], {}
        for body in self.scene["bodies"]:
            if "lit" in self.styles[body["parts"][0][0]]:
                painted.append(Faces(self, body))
            else:
                balls.setdefault((tuple(part[0] for part in body["parts"]), len(body["pose"])), []).append(body)
        return painted + [Balls(self, equal) for equal in balls.values()]

    def lay_out(self):
        """What is still: all of it, below the shadows, behind all moving bodies, and between these."""
        parts = sorted((part for one in self.still.values() for part in one), key=itemgetter(0, 1))
        if any(one.plane for one in self.moving if isinstance(one, Faces)):
            self.between = parts
            return
        nearest = min((one.nearest() for one in self.moving), default=np.inf)
        paint(ImageDraw.Draw(self.kept), parts)
        self.ground, self.anew = self.blank(BACKGROUND), self.blank(BACKGROUND)
        paint(ImageDraw.Draw(self.ground), [part for part in parts if part[0] <= SHADOW])
        self.behind = self.cut_out([part for part in parts if part[0] == GRID or part[0] == BODY and part[1] < nearest])
        self.between = [part for part in parts if part[0] == BODY and part[1] >= nearest]
        self.places = np.reshape([rectangle([part]) for part in self.between], (-1, 4))

    def cut_out(self, parts):
        """Image of the parts, and where they are in it: where it does not depend on the ground."""
        images = [self.blank(colour) for colour in ("#000000", "#ffffff")]
        for image in images:
            paint(ImageDraw.Draw(image), parts)
        bands = ImageChops.difference(*images).split()
        return images[0], bands[0].point([255] + 255 * [0])

    def blank(self, colour):
        return Image.new("RGB", self.size, rgb(colour))

    def pixels(self, points):
        """Of points [..., 2] in the picture's plane, from the corner of the image."""
        return np.array(self.size) / 2 + FINE * self.scale * (points - self.middle) * [1, -1]

    def turned(self, points, number):
        """Of points [..., 3] in space: to the right, upwards, to the eye, from where the camera is."""
        return (points - (self.scene["camera"][number] if self.scene["camera"] else 0)) @ self.axes.T

    def seen(self, body, number):
        """Its points [p, 3]: to the right, upwards, to the eye."""
        pose, points = body.pose[min(number, len(body.pose) - 1)], body.points
        if not self.scene["spatial"]:
            x, y, a, b = pose
            return points[:, :2] @ [[a, b], [-b, a]] + [x, y]
        return self.turned(pose[:3] + points @ pose[3:].reshape(3, 3).T, number)

    def image(self, number):
        image = self.kept.copy()
        draw = ImageDraw.Draw(image)
        if not self.scene["spatial"]:
            for one in self.painted:
                paint(draw, self.still[one] if one in self.still else one.parts(number))
        elif self.ground:
            self.renew(image, [list(one.parts(number)) for one in self.moving])
        else:
            parts = self.between + [part for one in self.moving for part in one.parts(number)]
            paint(draw, sorted(parts, key=itemgetter(0, 1)))
        paint(draw, self.forces(number))
        return image

    def renew(self, image, moving):
        """The rectangles about the parts of each moving body."""
        layers = [[part for part in parts if part[0] == layer] for parts in moving for layer in (SHADOW, BODY)]
        places = np.reshape([rectangle(parts) for parts in layers if parts], (-1, 4)).round().astype(int).clip(0, self.size * 2)
        places = [place for place in map(tuple, places.tolist()) if place[0] < place[2] and place[1] < place[3]]
        near = np.zeros(len(self.between), dtype=bool)
        for place in places:
            near |= np.all(self.places[:, :2] < place[2:], axis=1) & np.all(self.places[:, 2:] > place[:2], axis=1)
            self.anew.paste(self.ground.crop(place), place)
        draw = ImageDraw.Draw(self.anew)
        paint(draw, chain.from_iterable(layers[::2]))
        for place in places:
            self.anew.paste(self.behind[0].crop(place), place, self.behind[1].crop(place))
        paint(draw, sorted(chain(compress(self.between, near), *layers[1::2]), key=itemgetter(0, 1)))
        for place in places:
            image.paste(self.anew.crop(place), place)

    def forces(self, number):
        """Lines on top of all."""
        look = self.scene["force"]
        for *ends, weight in self.scene["forces"][number] if self.scene["forces"] else ():
            width = min(max(look["width"] * weight, 0.5), 2 * look["width"])
            points = self.pixels(self.turned(np.reshape(ends, (2, 3)), number)[:, :2])
            yield BODY, 0.0, line, points.ravel().tolist(), rgb(look["edge"]), round(width * FINE), False
