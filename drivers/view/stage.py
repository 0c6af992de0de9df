"""Bodies in a browser, drawn by viser (https://viser.studio): meshes with light and shadows, ground, names and forces.

Lengths are in units of a UNITS-th of the scene's diagonal: the renderer's light and shadows are made for a scene of some metres."""

import contextlib
import os
import socket

import numpy as np
import viser
import viser.transforms

from bodies import colours_of, extent, is_fixed, is_spatial, is_thread, normal_of
from meshes import batches_of, facets_of, poses_of
from scene import BACKGROUND, FAR_AWAY, GRID, GROUND, LIGHT, REACH, VIEW, colour_of, grid, shaded
from shapes import slab, solids_of
from trajectory import Problem

UNITS = 4.0  # of the scene's diagonal
HOST, PORTS = "127.0.0.1", 100  # ports that are tried
FOV = np.radians(35)  # vertical angle of view
ASPECT = 1.5  # width by height of the part of a usual window that the controls leave free
PLANAR_VIEW = np.radians([90, 8]).tolist()
PLANAR_LIGHT = [0.35, 0.8, 0.9]
BEHIND = UNITS / 20  # from bodies to the plane behind them; planar bodies are a thirtieth thick
LINE = UNITS / 800  # width of a line of the ground: a pixel or two
NAMES_MAX = 200  # labels at a time
GLASS = 0.3  # opacity of bodies when forces are shown
FORCE, HEAD = (176, 22, 28), 0.2  # colour of forces; length of the heads by that of long arrows


def port_from(first):
    """The first free port."""
    for port in range(first, min(first + PORTS, 65536)):
        with contextlib.suppress(OSError), socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((HOST, port))
            return port
    raise Problem(f"the ports {first} to {min(first + PORTS, 65536) - 1} are in use: name another with port")


def quaternions(rotations):
    return viser.transforms.SO3.from_matrix(rotations).wxyz


def rgb(colour):
    return tuple(bytes.fromhex(colour[1:]))


def frame_of(azimuth, elevation, up):
    """Unit vectors to the right, upwards and to the eye. Azimuth and elevation are about the axis `up`, 1 (y) or 2 (z)."""
    eye = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    if up == 1:  # y upwards: z is at the azimuth of 90 degrees
        eye = eye[[0, 2, 1]]
    right = np.cross(np.eye(3)[up], eye)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(eye, right), eye])


def feet(bodies, low, high):
    """The box, extended to the fixed planes below its middle that are not farther away than FAR_AWAY of its sizes."""
    middle, size = (low + high) / 2, np.max(high - low)
    for body in bodies:
        if body.shape == "plane" and is_fixed(body):
            normal = normal_of(body)
            foot = middle - normal * ((middle - body.position) @ normal)
            if np.linalg.norm(foot - middle) <= FAR_AWAY * size:
                low, high = np.minimum(low, foot), np.maximum(high, foot)
    return low, high


class Stage:
    """A server with the bodies at some records, of which one is drawn at a time."""

    def __init__(self, bodies, title, port):
        port = port_from(port)
        with open(os.devnull, "w", encoding="utf-8") as nowhere, contextlib.redirect_stdout(nowhere):  # it tells where it is
            self.server = viser.ViserServer(host=HOST, port=port, label=title, verbose=False)
        self.url = f"http://{HOST}:{self.server.get_port()}"
        self.bodies, self.spatial = bodies, is_spatial(bodies)
        self.up = 2 if self.spatial else 1
        self.low, self.high = feet(bodies, *extent(bodies))
        self.size = np.linalg.norm(self.high - self.low) or 1.0
        self.unit = self.size / UNITS
        self.names, self.selected, self.arrows = {}, None, None
        self.draw_light()
        self.draw_bodies()
        self.set_camera(self.server.initial_camera)

    # ---- what does not change
    def draw_light(self):
        scene, light = self.server.scene, np.array(LIGHT if self.spatial else PLANAR_LIGHT)
        scene.set_up_direction(np.eye(3)[self.up])
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map("warehouse", environment_intensity=0.4)
        scene.add_light_directional("/light", color=(255, 255, 255), intensity=1.7, cast_shadow=True, position=tuple(10 * light))
        scene.add_light_directional("/fill", color=(255, 255, 255), intensity=0.3, position=tuple(-10 * light[[1, 0, 2]] * [1, 1, -1]))
        self.world = scene.add_frame("/world", show_axes=False)

    def draw_bodies(self):
        bodies = self.bodies
        ground = [i for i, b in enumerate(bodies) if b.shape == "plane" and is_fixed(b)]
        solids = solids_of(bodies, facets_of(len(bodies)), REACH)
        for i in ground:
            self.draw_ground(f"/world/ground {i}", bodies[i])
        if not ground or not self.spatial:
            self.draw_backdrop()
        rest = [i for i in range(len(bodies)) if i not in set(ground)]
        self.batches = batches_of(solids, sorted(rest, key=lambda i: not is_fixed(bodies[i])))
        self.colours = [colour_of(body, own) for body, own in zip(bodies, colours_of(bodies))]
        self.layers = self.layers_of(rest)
        self.nodes = [[self.node(f"/world/body {i} {part.dark}", batch, part) for part in batch.parts]
                      for i, batch in enumerate(self.batches)]
        self.poses = [None] * len(self.batches)

    def layers_of(self, numbers):
        """Offsets along z, which keep the faces of planar bodies apart that overlap: what is drawn later is in front."""
        offset = np.zeros(len(self.bodies))
        if not self.spatial:
            order = sorted(numbers, key=lambda i: not is_fixed(self.bodies[i]))
            offset[order] = np.arange(len(order)) / max(len(order), 20)
        return np.column_stack([0 * offset, 0 * offset, offset * UNITS / 30])  # within the thickness of one

    def draw_ground(self, name, body):
        scale = np.max(self.high - self.low) or 1.0
        shape = slab(body, self.low, self.high, scale / 100, REACH)
        rotation = np.eye(3) if body.rotation is None else body.rotation
        points = (body.position + shape.points @ rotation.T) / self.unit
        if not self.spatial:
            points[:, 2] = np.clip(points[:, 2], -BEHIND, 2 * BEHIND)
        self.draw_plane(name, points[4:], GROUND, self.spatial)

    def draw_plane(self, name, corners, colour, has_grid=True):
        """A square [4, 3], possibly with a grid of round lengths, seen from its front; bodies cast shadows on it."""
        size = np.max(self.high - self.low) / self.unit
        points, pairs = grid(corners, size)
        along = points[[b for _, b in pairs]] - points[[a for a, _ in pairs]]
        normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
        normal /= np.linalg.norm(normal)
        across = np.cross(normal, along / np.linalg.norm(along, axis=1)[:, None]) * LINE / 2
        starts, lift = points[[a for a, _ in pairs]], normal * LINE
        lines = np.stack([starts - across, starts + along - across, starts + along + across, starts + across], axis=1) + lift
        for part, quads, paint in (("", corners[None], colour), (" grid", lines, GRID))[: 1 + has_grid]:
            first = 4 * np.arange(len(quads))[:, None]
            self.server.scene.add_mesh_simple(
                name + part, quads.reshape(-1, 3), np.concatenate([first + [0, 1, 2], first + [0, 2, 3]]), color=rgb(paint),
                side="front", cast_shadow=False)

    def draw_backdrop(self):
        """A plane behind planar bodies; in space, where there is no ground, one below."""
        middle = (self.low + self.high) / 2 / self.unit
        middle[2] = self.low[2] / self.unit - BEHIND
        half = REACH * UNITS / 2
        corners = middle + half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        self.draw_plane("/world/backdrop", corners, BACKGROUND)

    def node(self, name, batch, part):
        poses = poses_of(self.bodies, batch, self.unit)
        colours = [rgb(shaded(self.colours[i], 0.6) if part.dark else self.colours[i]) for i in batch.members]
        node = self.server.scene.add_batched_meshes_simple(
            name, part.vertices, part.triangles, quaternions(poses.rotations[0]), poses.positions[0] + self.layers[batch.members],
            batched_scales=poses.scales[0], batched_colors=np.array(colours, np.uint8), lod="off")
        node.on_click(lambda event: self.select(batch.members[event.instance_index or 0]))
        return node

    # ---- the record that is drawn
    def set_bodies(self, bodies):
        """The same bodies at other records."""
        self.bodies, self.poses = bodies, [None] * len(self.batches)

    def show(self, record, forces=None, shift=None):
        """Draws the record; shift: where the camera has followed the bodies to."""
        with self.server.atomic():
            for i, (batch, nodes) in enumerate(zip(self.batches, self.nodes)):
                if self.poses[i] is None:
                    self.poses[i] = poses_of(self.bodies, batch, self.unit)
                self.place(self.poses[i], nodes, record, self.layers[batch.members])
            if shift is not None:
                self.world.position = -np.asarray(shift) / self.unit
            self.show_forces(forces)
            self.show_names(record)

    def place(self, poses, nodes, record, layers):
        record = min(record, len(poses.positions) - 1)
        for node in nodes:
            node.batched_positions = (poses.positions[record] + layers).astype(np.float32)
            node.batched_wxyzs = quaternions(poses.rotations[record]).astype(np.float32)
            node.batched_scales = poses.scales[record].astype(np.float32)

    def show_forces(self, arrows):
        """Arrows [f, 2, 3], tails and heads."""
        for nodes in self.nodes:
            for node in nodes:
                node.opacity = None if arrows is None else GLASS
        if self.arrows is not None:
            self.arrows.remove()
            self.arrows = None
        if arrows is None or not len(arrows):
            return
        points = np.asarray(arrows) / self.unit + [0, 0, 0 if self.spatial else UNITS / 20]
        length = np.quantile(np.linalg.norm(points[:, 1] - points[:, 0], axis=1), 0.95)
        self.arrows = self.server.scene.add_arrows("/world/forces", points, FORCE, shaft_radius=0.04 * length,
                                                   head_radius=0.1 * length, head_length=HEAD * length)

    # ---- names
    def place_of(self, number, record):
        position = self.bodies[number].position
        position = position if position.ndim == 1 else position[min(record, len(position) - 1)]
        return position / self.unit + self.layers[number] + (0 if self.spatial else [0, 0, UNITS / 20])

    def select(self, number):
        self.selected = number

    def label(self, shown):
        """Names of the moving bodies."""
        moving = [i for i, b in enumerate(self.bodies) if shown and not is_fixed(b) and not is_thread(b)]
        wanted = set(moving[:NAMES_MAX]) | ({self.selected} if self.selected is not None else set())
        for i in set(self.names) - wanted:
            self.names.pop(i).remove()
        for i in sorted(wanted - set(self.names)):
            self.names[i] = self.server.scene.add_label(f"/world/name {i}", self.bodies[i].name, anchor="bottom-center")

    def show_names(self, record):
        for i, label in self.names.items():
            label.position = self.place_of(i, record)

    # ---- the camera
    def set_camera(self, camera):
        """So that the box is seen."""
        axes = frame_of(*(VIEW if self.spatial else PLANAR_VIEW), self.up)
        low, high = self.low / self.unit, self.high / self.unit
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        middle = (low + high) / 2
        x, y, depth = np.abs((corners - middle) @ axes[:2].T).max(axis=0).tolist() + [((corners - middle) @ axes[2]).max()]
        tangent = np.tan(FOV / 2)
        distance = 1.15 * max(x / (ASPECT * tangent), y / tangent) + depth
        camera.position = tuple(middle + distance * axes[2])
        camera.look_at = tuple(middle)
        camera.fov = float(FOV)

    def close(self):
        with open(os.devnull, "w", encoding="utf-8") as nowhere, contextlib.redirect_stdout(nowhere):
            self.server.stop()
