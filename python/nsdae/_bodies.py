"""Rigid bodies, joints, loads and contacts between shapes, as a system."""

from __future__ import annotations

import dataclasses
import math
import operator
import os
import warnings
from typing import Any, Callable, NamedTuple, Sequence

import numpy as np

from . import _core
from ._arguments import named, numbers, refused
from ._copies import Callback, Recorded
from ._errors import ModelWarning, in_python
from ._lists import _array
from ._system import System, vector
from ._trajectory import Shape

GROUND = -1
_BODY, _SOLID = 0, 1  # enum nsdae_named
MOTORS = ("force", "speed", "position")
SENSORS = ("coordinate", "rate", "reaction_force", "reaction_moment", "contact_force", "pair_force", "position",
           "orientation", "velocity", "angular_velocity", "acceleration", "kinetic_energy", "potential_energy")
JOINTS = ("revolute", "prismatic", "weld", "distance", "slot", "gear", "spherical", "cylindrical", "universal",
          "screw")
_USER_CALLBACKS = ("mass", "force", "constraint", "constraint_jacobian", "constraint_bias", "gap", "gap_normal", "gap_tangent",
                   "contact_bias", "contact_acceleration", "frictional_joint_tangent", "kinematics", "constraint_rows",
                   "contacts", "potential")
SHAPES = ("point", "disc", "segment", "polygon", "path", "sphere", "capsule", "box", "plane",
          "polyhedron", "cylinder", "cone", "ellipsoid", "mesh", "height_field")


def _numbers(name: str, values: Any, n: int) -> list[float]:
    """Returns n numbers, padded with zeros."""
    row = numbers(name, values).reshape(-1).tolist()
    if len(row) > n:
        raise refused(name, f"{name} has {len(row)} numbers; it has at most {n}")
    return row + [0.0] * (n - len(row))


def _point(name: str, values: Any, dimension: int) -> list[float]:
    """Returns three numbers, zero without any; in the plane the third is zero, too."""
    size = np.size(values)
    if size not in ((0, 3) if dimension == 3 else (0, 2, 3)):
        raise refused(name, f"{name} has {size} number{'s' * (size != 1)}; "
                            f"in {'space it has three' if dimension == 3 else 'the plane it has two'}")
    return _numbers(name, values, 3)


def _quaternion(values: Any) -> list[float]:
    if np.size(values) not in (0, 4):
        raise refused("quaternion", f"quaternion has {np.size(values)} numbers; it has four: w, x, y, z")
    return _numbers("quaternion", values, 4)


def _spelled(word: str) -> str:
    """A word of several parts with underscores, in place of hyphens or spaces."""
    return word.replace("-", "_").replace(" ", "_") if isinstance(word, str) else word


def _one_of(name: str, word: str, words: Sequence[str]) -> int:
    if _spelled(word) not in words:
        raise refused(name, f"{name} is '{word}'; it must be one of {', '.join(words)}")
    return words.index(_spelled(word))


@named
class Solid(NamedTuple):
    """Shape of a body, or a part of it; see nsdae/bodies.h.

    Parameters
    ----------
    shape : str
        Planar: "segment", "polygon". Spatial: "sphere", "capsule", "box", "polyhedron", "cylinder", "cone",
        "ellipsoid". Of the ground: "mesh", "height_field". Both: "point", "disc", "plane".
    radius : float
        Radius of a disc, sphere, capsule, cylinder or base of a cone; half the thickness of a segment
        [m]. A segment of radius 0 is a floor: there is material below it (y < 0 in its frame).
    length : float or array_like
        Length of a segment or cylinder; height of a cone; distance of the centres of a capsule; three edges of a box,
        axes (diameters) of an ellipsoid [m]. Depth of the material beneath a mesh; edges along x and y of a height field,
        and that depth.
    hollow : bool
        The solid is outside the disc.
    points : array_like, shape (p, 2) or (p, 3)
        Corners of a polygon, anticlockwise; points of a polyhedron, which is their convex hull; points of a mesh;
        of a height field the heights, shape (ny, nx) [m].
    triangle : array_like, shape (t, 3)
        Of a mesh: numbers of points from 0, anticlockwise seen from outside.
    position : array_like
        Position in the frame of the body [m].
    angle : float
        Planar: angle in the frame of the body [rad].
    quaternion : array_like, shape (4,)
        Spatial: orientation w, x, y, z in the frame of the body.
    material : int or str
        A name, or 0 to 63, for `Bodies.set_pair`.
    group, exclude : int
        Bits of the groups of the solid, and of the groups that it does not touch by `Bodies.set_pair`. exclude = -1: it
        touches nothing, as a shape for pictures alone.
    name : str
        In messages, pictures and files: letters, digits, "_", "-", ".".
    colour : str
        In pictures and files: "#rrggbb". The default is that of its body.
    """

    shape: str
    radius: float = 0
    length: Any = ()
    hollow: bool = False
    points: Any = ()
    position: Any = ()
    angle: float = 0
    quaternion: Any = ()
    material: int | str = 0
    group: int = 0
    exclude: int = 0
    name: str = ""
    colour: str = ""
    triangle: Any = ()

    def _given(self) -> dict[str, Any]:
        length = self.length
        if not len(np.shape(length)):  # a segment's is along x, a capsule's along z
            length = [0, 0, length] if self.shape in ("capsule", "cylinder", "cone", "mesh") else [length]
        points = np.ascontiguousarray(numbers("points", self.points))
        field = _spelled(self.shape) == "height_field"
        wide = 3 if self.shape in ("polyhedron", "mesh") else 2
        if points.size and (points.ndim != 2 or not field and points.shape[1] != wide):
            wanted = "must be (ny, nx)" if field else f"has {wide} numbers in each row"
            raise refused("points", f"points of a {self.shape} has the shape {points.shape}; it {wanted}")
        return {"shape": _one_of("shape", self.shape, SHAPES), "radius": float(self.radius), "hollow": bool(self.hollow),
                "angle": float(self.angle), "material": 0 if isinstance(self.material, str) else int(self.material), "group": int(self.group),
                "exclude": int(self.exclude), "length": _numbers("length", length, 3),
                "position": _numbers("position", self.position, 3),
                "quaternion": _quaternion(self.quaternion),
                "points": points.reshape(-1), "triangle": self._corners(),
                "grid": points.shape[::-1] if field and points.size else (0, 0)}

    def _corners(self) -> np.ndarray:
        given = np.asarray(self.triangle)
        if given.size and (given.ndim != 2 or given.shape[1] != 3 or given.dtype.kind not in "iu"):
            raise refused("triangle", f"triangle has the shape {given.shape} of {given.dtype}; it has three whole numbers in each row")
        if given.size and (given.min() < 0 or given.max() > 2**31 - 1):
            raise refused("triangle", f"triangle has the numbers {given.min()} to {given.max()}; a point has a number from 0")
        return np.ascontiguousarray(given.reshape(-1), dtype=np.intc)

    def inertia(self, density: float) -> tuple[float, list[float]]:
        """Computes mass and inertia for a uniform density.

        Parameters
        ----------
        density : float
            [kg/m^3]; planar [kg/m^2].

        Returns
        -------
        mass : float
            [kg]
        inertia : list of float
            About the centre, principal axes [kg m^2].

        Raises
        ------
        ArgumentError
            The shape has no inertia, or a value is out of range.
        """
        return _core.solid_inertia(self._given(), float(density))

    def triangles(self) -> np.ndarray:
        """Returns the surface of a polyhedron, mesh or height field in its frame, for pictures.

        Returns
        -------
        ndarray, shape (t, 3, 3)
            Corners of each triangle, anticlockwise seen from outside [m].
        """
        return np.array(_core.solid_triangles(self._given())).reshape(-1, 3, 3)


class Scene(NamedTuple):
    """Settings of a scene file.

    Parameters
    ----------
    wall : tuple of float
        x and y of the walls [m]; infinite: none.
    floor : float
        z of the floor [m].
    mu, e_n : float
        Coefficient of friction and normal restitution of all contacts.
    g : float
        Gravity along -z [m/s^2].
    dt : float
        Time step for the scene [s].
    """

    wall: tuple[float, float]
    floor: float
    mu: float
    e_n: float
    g: float
    dt: float


@named
class Bodies:
    """Mechanism of rigid bodies, joints, springs, loads and contacts.

    Points and axes are given in space, at the start. The equations of motion need no derivation.

    Parameters
    ----------
    dimension : int
        2: q is x, y, theta of each body. 3: q is x, y, z and a quaternion of each body.
    gravity : array_like
        [m/s^2]

    Notes
    -----
    `GROUND` stands for the ground in place of the number of a body. The attribute `scene` has the settings of a file of
    `read_scene`, else it is None. `Bodies` can be pickled, if their callbacks can (see `System`).

    Examples
    --------
    >>> world = nsdae.Bodies(2, gravity=(0, -9.81))
    >>> rod = world.add(mass=1, inertia=1 / 12, position=(0.5, 0))
    >>> world.add_joint("revolute", nsdae.GROUND, rod, point=(0, 0))
    >>> nsdae.solve(world, 2)
    """

    def __init__(self, dimension: int = 2, gravity: Sequence[float] = ()):
        self._core = Recorded("Bodies", dimension)
        self.dimension = dimension
        self._solids: list[tuple[int, Solid]] = []
        self._system: System | None = None
        self._changes: list[Any] | None = None  # of the system that was copied
        self._user_rows: Any = None
        self._names: dict[int, str] = {}
        self._colours: dict[int, str] = {}
        self.scene: Scene | None = None
        if np.size(gravity):
            self._core.set_gravity(self._vector("gravity", gravity))

    def _vector(self, name: str, values: Any) -> list[float]:
        return _point(name, values, self.dimension)

    def _inertia(self, values: Any) -> tuple[list[float], list[float]]:
        """Returns the diagonal of the tensor, and its entries (0, 1), (0, 2), (1, 2)."""
        array = numbers("inertia", values)
        if self.dimension == 2:
            # three of a plane figure: (0, 0, J), or those of a disc, by the perpendicular axis theorem J_z = J_x + J_y
            flat = array.size == 3 and any(np.isclose(array.reshape(-1)[:2].sum(), J) for J in (0, array.reshape(-1)[2]))
            if array.size != 1 and not flat:
                raise refused("inertia", f"inertia has {array.size} numbers; in the plane it has one")
            return [0.0, 0.0, float(array.reshape(-1)[-1])], [0.0] * 3
        if array.shape == (3, 3):
            if not np.allclose(array, array.T, rtol=1e-9, atol=0):
                raise refused("inertia", "inertia is not symmetric")
            return list(map(float, np.diag(array))), [float(array[0, 1]), float(array[0, 2]), float(array[1, 2])]
        if array.size != 3:
            raise refused("inertia", f"inertia has {array.size} number(s); in space it has three, or is a matrix of 3 x 3")
        return list(map(float, array.reshape(-1))), [0.0] * 3

    def add(self, mass: float, inertia: Any, position: Any = (), *, angle: float = 0, quaternion: Any = (),
            velocity: Any = (), spin: Any = (), name: str = "", colour: str = "") -> int:
        """Adds a body.

        Parameters
        ----------
        mass : float
            [kg]
        inertia : float or array_like
            About the centre of mass in body axes: one number in the plane, three principal moments or the tensor, shape
            (3, 3), in space [kg m^2].
        position : array_like
            Centre of mass at the start [m].
        angle : float
            Planar: angle at the start [rad].
        quaternion : array_like, shape (4,)
            Spatial: orientation w, x, y, z at the start.
        velocity : array_like
            Of the centre of mass at the start [m/s].
        spin : float or array_like
            Angular velocity at the start, in space about the body's own axes [rad/s].
        name : str
            In messages, pictures and files: letters, digits, "_", "-", ".".
        colour : str
            In pictures and files: "#rrggbb".

        Returns
        -------
        int
            Number of the body.
        """
        if self.dimension == 2 and np.size(quaternion):
            raise refused("quaternion", "quaternion is given in the plane: give angle")
        planar = self.dimension == 2 and np.size(spin) == 1
        turning = [0.0, 0.0, *_numbers("spin", spin, 1)] if planar else self._vector("spin", spin)
        number = self._core.add(float(mass), *self._inertia(inertia), self._vector("position", position), float(angle),
                                _quaternion(quaternion), self._vector("velocity", velocity), turning)
        if name:
            self._core.set_name(_BODY, number, name)
            self._names[number] = name
        if colour:
            self._core.set_colour(_BODY, number, colour)
            self._colours[number] = colour
        return number

    def add_from_solids(self, solids: Sequence[Solid], density: Any, position: Any = (), *, angle: float = 0,
                        quaternion: Any = (), velocity: Any = (), spin: Any = (), name: str = "") -> int:
        """Adds a body with its solids; its mass and inertia follow from their density.

        The body is moved to its centre of mass: q has the place of the centre, and the solids keep their place in space.

        Parameters
        ----------
        solids : sequence of Solid
            All planar or all spatial; mass counts twice where they overlap.
        density : float or sequence of float
            Of all, or of each [kg/m^3]; planar [kg/m^2].
        position, angle, quaternion : array_like
            Place of the frame of the solids at the start, as in `add`.
        velocity, spin, name
            As in `add`.

        Returns
        -------
        int
            Number of the body.
        """
        solids = list(solids)
        densities = _array("density", numbers("density", density), (len(solids),)).tolist()
        mass, inertia, product, centre, places = _core.body_from_solids(
            [{**s._given(), "material": 0, "position": self._vector("position", s.position)} for s in solids], densities, self._vector("position", position), float(angle),
            _quaternion(quaternion))
        J, (xy, xz, yz) = np.diag(inertia), product
        tensor = J + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])
        number = self.add(mass, inertia[2] if self.dimension == 2 else tensor, centre[: self.dimension], angle=angle,
                          quaternion=quaternion, velocity=velocity, spin=spin, name=name)
        for solid, place in zip(solids, places):
            self.add_solid(number, solid._replace(position=tuple(place)))
        return number

    def _material(self, material: int | str) -> int:
        return self._core.material(material) if isinstance(material, str) else int(material)

    def add_joint(self, kind: str, body0: int, body1: int, *, point: Any = (), end: Any = (), axis: Any = (),
                  cross: Any = (), ratio: float = 0, mu: float = 0, radius: float = 0,
                  collide_connected: bool = False, drive: Callable[..., Any] | None = None, user: Any = None) -> int:
        """Adds a joint between two bodies.

        Parameters
        ----------
        kind : str
            "revolute", "prismatic", "weld", "distance", "slot", "gear", "spherical", "cylindrical", "universal" or
            "screw".
        body0, body1 : int
            Numbers of the bodies, or `GROUND`.
        point : array_like
            Point of the joint in space at the start [m].
        end : array_like
            Joint "distance": point of body1 [m].
        axis, cross : array_like
            Axes of the joint in space at the start.
        ratio : float
            Joint "gear": theta of body1 per theta of body0. Joint "screw": pitch, displacement per turn [m].
        mu : float
            Joints "slot" and "revolute": coefficient of friction by the load (a frictional joint).
        radius : float
            Joint "revolute" with mu: radius of its pin [m].
        collide_connected : bool
            The two bodies touch by `set_pair`. The default is that they do not.
        drive : callable, optional
            ``drive(t, f)`` writes the prescribed motion and its two rates to f, shape (3,). Also a compiled function of
            ``signature("drive")``.
        user : object, optional
            Last argument of a compiled drive.

        Returns
        -------
        int
            Number of the joint.
        """
        return self._core.add_joint(_one_of("kind", kind, JOINTS), body0, body1, self._vector("point", point),
                                    self._vector("end", end), self._vector("axis", axis), self._vector("cross", cross),
                                    float(ratio), float(mu), float(radius), bool(collide_connected),
                                    Callback("drive", drive, user))

    def add_limit(self, joint: int, low: float = -math.inf, high: float = math.inf, *, coordinate: int = 0,
                  e_n: float = 0) -> int:
        """Adds the ends of a coordinate of a joint, as contacts without friction.

        Parameters
        ----------
        joint : int
            Number of the joint.
        low, high : float
            Ends [m or rad]. In space a rotation needs both, with high - low < 2 pi. A step of time stepping then needs
            a rotation of less than pi - (high - low) / 2.
        coordinate : int
            0: rotation of "revolute", displacement of "prismatic", "slot", "cylindrical", "screw", rotation about
            axis of "universal". 1: rotation of "slot", "cylindrical", "screw", rotation about cross of "universal".
        e_n : float
            Restitution.

        Returns
        -------
        int
            Number of the first of its contacts among all limits and ropes.
        """
        return self._core.add_limit(joint, coordinate, float(low), float(high), float(e_n))

    def add_rope(self, body0: int, body1: int, *, point: Any, end: Any, length: float, e_n: float = 0) -> int:
        """Adds a rope: the distance of two points is at most its length.

        Parameters
        ----------
        body0, body1 : int
            Numbers of the bodies, or `GROUND`.
        point, end : array_like
            Its ends on body0 and body1, in space at the start [m].
        length : float
            [m]
        e_n : float
            Restitution.

        Returns
        -------
        int
            Number of its contact among all limits and ropes.
        """
        return self._core.add_rope(body0, body1, self._vector("point", point), self._vector("end", end), float(length),
                                   float(e_n))

    def add_coupler(self, joint0: int, joint1: int, p: Sequence[float], *, coordinates: Sequence[int] = (0, 0)) -> int:
        """Couples coordinates of two joints: s1 = p[0] + p[1] s0 + p[2] s0**2 + ...

        Parameters
        ----------
        joint0, joint1 : int
            Numbers of the joints.
        p : array_like
            At most six coefficients. Two rotations: gears of ratio p[1], in space a fraction of numbers of teeth. A
            displacement s1 and a rotation s0: rack and pinion of radius p[1].
        coordinates : (int, int)
            Coordinate of each joint, see `add_limit`.

        Returns
        -------
        int
            Number of the coupler.
        """
        return self._core.add_coupler((joint0, joint1), tuple(coordinates), _numbers("p", p, 6))

    def add_motor(self, joint: int, kind: str, target: Any = 0, *, coordinate: int = 0, limit: Any = math.inf,
                  kp: float = 0, kd: float = 0) -> int:
        """Adds a motor along a coordinate s of a joint.

        Parameters
        ----------
        joint : int
            Number of the joint.
        kind : str
            "force": the force or torque is the target. "speed": s' is the target. "position": the force is
            kp (target - s) + kd (target' - s').
        target : float or callable
            A number, until `Sim.set_control` sets another, or ``target(t, f)``, which writes it and its two rates to f,
            shape (3,).
        coordinate : int
            See `add_limit`.
        limit : float or callable
            Largest force or torque. "speed" needs one, and may have ``limit(t, f)``, which writes it to f[0].
            `Sim.set_friction_bound` adds to that. With the target 0 it is dry friction or a brake, and a clutch if the
            limit varies.
        kp, kd : float
            Gains of "position", not both 0.

        Returns
        -------
        int
            Number of the motor.
        """
        return self._core.add_motor(joint, coordinate, _one_of("kind", kind, MOTORS),
                                    0.0 if callable(target) else float(target),
                                    0.0 if callable(limit) else float(limit), float(kp), float(kd),
                                    Callback("drive", target if callable(target) else None),
                                    Callback("drive", limit if callable(limit) else None))

    def add_joint_spring(self, joint: int, *, coordinate: int = 0, stiffness: float = 0, damping: float = 0,
                         rest: float = 0) -> int:
        """Adds a spring with damper along a coordinate of a joint.

        Parameters
        ----------
        joint : int
            Number of the joint. "spherical" has damping only.
        coordinate : int
            See `add_limit`.
        stiffness : float
            [N/m or N m/rad]
        damping : float
            [N s/m or N m s/rad]
        rest : float
            Coordinate without force [m or rad]. In space a rotation has it in -pi .. pi: its turns are not counted.

        Returns
        -------
        int
            Number of the spring.
        """
        return self._core.add_joint_spring(joint, coordinate, float(stiffness), float(damping), float(rest))

    def add_sensor(self, kind: str, name: str = "", *, body: int = 0, joint: int = 0, coordinate: int = 0,
                   solids: Sequence[int] = (0, 0), point: Any = ()) -> int:
        """Adds a sensor, which `Sim.get_sensor` reads.

        Parameters
        ----------
        kind : str
            Of a coordinate of a joint: "coordinate" (turns are counted), "rate". Of a joint: "reaction_force",
            "reaction_moment", on its second body. Of a body: "contact_force", "position", "orientation", "velocity",
            "angular_velocity", "acceleration", "kinetic_energy", "potential_energy". Of two solids: "pair_force", of
            the first on the second.
        name : str
            One with a name is also in `Trajectory.sensors` and in trajectory files.
        body, joint, coordinate : int
            What it is of.
        solids : (int, int)
            Numbers of two solids.
        point : array_like
            Point of the body, in space at the start [m].

        Returns
        -------
        int
            Number of the sensor.
        """
        return self._core.add_sensor(name, _one_of("kind", kind, SENSORS), body, joint, coordinate, tuple(solids),
                                     self._vector("point", point))

    def add_spring(self, body0: int, body1: int, *, point: Any, end: Any, stiffness: float = 0, damping: float = 0,
                   rest: float = 0) -> int:
        """Adds a spring with damper between two points.

        Parameters
        ----------
        body0, body1 : int
            Numbers of the bodies, or `GROUND`.
        point, end : array_like
            Its ends on body0 and body1, in space at the start [m].
        stiffness : float
            [N/m]
        damping : float
            [N s/m]
        rest : float
            Length without force [m].

        Returns
        -------
        int
            Number of the spring.
        """
        return self._core.add_spring(body0, body1, self._vector("point", point), self._vector("end", end),
                                     float(stiffness), float(damping), float(rest))

    def add_torsion(self, body0: int, body1: int, *, axis: Any = (), stiffness: float = 0, damping: float = 0,
                    rest: float = 0) -> int:
        """Adds a torsion spring with damper.

        Parameters
        ----------
        body0, body1 : int
            Numbers of the bodies, or `GROUND`.
        axis : array_like
            Spatial: axis in space at the start.
        stiffness : float
            [N m/rad]
        damping : float
            [N m s/rad]
        rest : float
            Angle without torque [rad], in space in -pi .. pi.

        Returns
        -------
        int
            Number of the spring.
        """
        return self._core.add_torsion(body0, body1, self._vector("axis", axis), float(stiffness), float(damping),
                                      float(rest))

    def add_load(self, body: int, load: Callable[..., Any], point: Any = (), user: Any = None) -> int:
        """Adds a load on a point of a body.

        Parameters
        ----------
        body : int
            Number of the body.
        load : callable
            ``load(t, position, velocity, force, torque)`` writes to force [N] and torque [N m], shape (3,) each. Also a
            compiled function of ``signature("load")``.
        point : array_like
            The point in space at the start [m].
        user : object, optional
            Last argument of a compiled load.

        Returns
        -------
        int
            Number of the load.
        """
        return self._core.add_load(body, self._vector("point", point), Callback("load", load, user))

    def add_solid(self, body: int, solid: Solid) -> int:
        """Adds a solid to a body or to `GROUND`.

        Parameters
        ----------
        body : int
            Number of the body.
        solid : Solid
            The shape.

        Returns
        -------
        int
            Number of the solid.
        """
        number = self._core.add_solid(body, {**solid._given(), "material": self._material(solid.material),
                                             "position": self._vector("position", solid.position)})
        if solid.name:
            self._core.set_name(_SOLID, number, solid.name)
        if solid.colour:
            self._core.set_colour(_SOLID, number, solid.colour)
        self._solids.append((body, solid))
        return number

    def add_contact(self, solid0: int, solid1: int, *, mu: float = 0, e_n: float = 0, e_t: float = 0) -> int:
        """Adds the contacts of two solids.

        They are fixed contacts. In a system with a contact list (`set_pair`) they are entries of the list, and their
        numbers are the ids.

        Parameters
        ----------
        solid0, solid1 : int
            Numbers of the solids.
        mu, e_n, e_t : float
            Coefficient of friction, normal and tangential restitution.

        Returns
        -------
        int
            Number of the first of these contacts.
        """
        return self._core.add_contact(solid0, solid1, float(mu), float(e_n), float(e_t))

    def set_pair(self, material0: int | str, material1: int | str, *, mu: float = 0, e_n: float = 0, e_t: float = 0) -> None:
        """Adds contacts between all solids of two materials on different bodies.

        The contacts are detected in every step and form a contact list (`Record.contacts`). Two solids of `add_contact`
        keep the coefficients of that call. Two bodies with a joint do not touch unless it has `collide_connected`; a
        body touches the ground that it is joined to. A solid does not touch those in a group that it excludes.

        Parameters
        ----------
        material0, material1 : int or str
            Materials of the solids: names, or 0 to 63.
        mu, e_n, e_t : float
            Coefficient of friction, normal and tangential restitution.
        """
        self._core.set_pair(self._material(material0), self._material(material1), float(mu), float(e_n), float(e_t))

    def set_user_rows(self, nq: int = 0, nv: int | None = None, m: int = 0, k: int = 0, f: int = 0, *, user: Any = None,
                      **callbacks: Callable[..., Any]) -> None:
        """Adds your own coordinates, constraints, contacts and frictional joints, behind those of the bodies.

        Parameters
        ----------
        nq, nv, m, k, f : int
            Your coordinates, velocities (default nq), constraints, fixed contacts and frictional joints.
        user : object, optional
            Last argument of compiled callbacks, as of `System`.
        **callbacks
            Callbacks as of `System`: mass, force, constraint, constraint_jacobian, constraint_bias, gap, gap_normal,
            gap_tangent, contact_bias, contact_acceleration, frictional_joint_tangent, kinematics, potential,
            constraint_rows, contacts. Inputs are q and v of the whole mechanism. Outputs are your rows over all
            velocities; ``mass`` is the block of your velocities, and ``force`` adds to F of the bodies.

        Raises
        ------
        TypeError
            A callback is unknown.
        ArgumentError
            From `system`: a callback is missing or never called.

        Examples
        --------
        >>> world.set_user_rows(nq=1, m=1, mass=drum_mass, constraint=rope)
        """
        if self._user_rows:
            raise RuntimeError("the user rows are set once")
        for name in callbacks:
            if name not in _USER_CALLBACKS:
                raise TypeError(f"no callback of user rows is called '{name}': they are {', '.join(_USER_CALLBACKS)}")
        sizes = {"nq": nq, "nv": nq if nv is None else nv, "m": m, "k": k, "f": f}
        for name, size in sizes.items():
            if not 0 <= operator.index(size) <= 2**20:
                raise refused(name, f"{name} = {size} is outside its range: it must be 0 .. 2^20")
        self._user_rows = (tuple(sizes.values()),
                           [Callback(name, function, user) for name, function in callbacks.items()])

    def system(self) -> System:
        """Builds the system. Nothing can be added afterwards.

        Returns
        -------
        System

        Warns
        -----
        ModelWarning
            The model may have a mistake, such as a body whose solids touch nothing.
        """
        if self._system is None:
            if self._user_rows:  # with the sizes of all bodies, which are known at the end
                sizes, callbacks = self._user_rows
                self._core.core.set_user_rows(sizes, [(c.name, *c.core()) for c in callbacks])
            core, note = self._core.system()
            if note and self._changes is None:
                warnings.warn(in_python(note), ModelWarning, stacklevel=2)
            made = System._of(core, self)
            made._core.replay(self._changes or ())
            self._system = made
        return self._system

    def __getstate__(self) -> dict[str, Any]:
        changes = self._changes if self._system is None else self._system._core.calls()
        return {**self.__dict__, "_system": None, "_changes": changes}

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Returns the state at the start.

        Returns
        -------
        q : ndarray, shape (nq,)
        v : ndarray, shape (nv,)
        """
        self.system()
        return self._core.start()

    def locate(self, q: Any, body: int, local: Any = ()) -> np.ndarray:
        """Computes the position of a point of a body.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Coordinates.
        body : int
            Number of the body.
        local : array_like
            The point in the frame of the body [m].

        Returns
        -------
        ndarray, shape (3,)
            The point in space [m].
        """
        q = vector("q", q, len(self.start()[0]))
        return np.array(self._core.locate(q, body, self._vector("local", local)))

    def shapes(self) -> list[Shape]:
        """Returns the solids for animations.

        Returns
        -------
        list of Shape
        """
        place = _planar if self.dimension == 2 else _spatial
        def name(i: int, body: int, solid: Solid) -> str:
            return solid.name or f"{self._names.get(body, '')} {solid.shape} {i}".lstrip()

        made = [place(name(i, body, solid), body, solid) for i, (body, solid) in enumerate(self._solids)]
        return [dataclasses.replace(shape, colour=solid.colour or self._colours.get(body, ""))
                for shape, (body, solid) in zip(made, self._solids)]


@named
def read_mesh(path: str | os.PathLike[str], scale: float = 1, **fields: Any) -> Solid:
    """Reads the triangles of an OBJ or STL file, text or binary.

    Parameters
    ----------
    path : str or path-like
        The file; its name ends in .obj or .stl.
    scale : float
        Metres in a unit of the file, > 0.
    **fields
        Further fields of the `Solid`. A mesh of the ground needs a `length`, the depth of the material beneath it.

    Returns
    -------
    Solid
        A "mesh" with the arrays `points`, shape (p, 3), and `triangle`, shape (t, 3). Equal coordinates are one point. The
        points also serve a "polyhedron", their convex hull.

    Raises
    ------
    Error
        The file cannot be read.
    ArgumentError
        The text names file, line or triangle, and the cause.

    Examples
    --------
    >>> stairs = nsdae.read_mesh("stairs.stl", scale=0.001, length=0.2)
    >>> world.add_solid(nsdae.GROUND, stairs)
    """
    points, triangle = _core.solid_read(os.fspath(path), float(scale))
    return Solid("mesh", points=points, triangle=triangle, **fields)


@named
def read_scene(path: str | os.PathLike[str]) -> Bodies:
    """Reads bodies, floor and walls from a CSV file, see "Scenes" in the documentation.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Bodies
        In space; its attribute `scene` has the settings of the file.

    Raises
    ------
    Error
        The file cannot be read.
    ArgumentError
        The text names file, line, column, value and bound.

    Examples
    --------
    >>> world = nsdae.read_scene("scene_boxes.csv")
    >>> nsdae.solve(world, 1, method="moreau", dt=world.scene.dt)
    """
    world = Bodies(3)
    read = world._core.add_scene(os.fspath(path))
    solids = read.pop("solids")
    world.scene = scene = Scene(**read)
    half = math.sqrt(0.5)
    planes = [((0, 0, scene.floor), (1, 0, 0, 0))]
    planes += [((at, 0, 0), (half, 0, way * half, 0)) for at, way in zip(scene.wall, (1, -1))]
    planes += [((0, at, 0), (half, -way * half, 0, 0)) for at, way in zip(scene.wall, (1, -1))]
    world._solids = [(GROUND, Solid("plane", position=position, quaternion=turn)) for position, turn in planes
                     if all(map(math.isfinite, position))]
    world._solids += [(i, Solid(SHAPES[shape], radius, length, position=position, points=points, material=material))
                      for i, (shape, radius, length, position, points, material) in enumerate(solids)]
    return world


def _planar(name: str, body: int, solid: Solid) -> Shape:
    fields = solid._given()
    position, angle, length = fields["position"], fields["angle"], fields["length"][0]

    def place(x: float, y: float) -> list[str]:
        """Of a point in the body's frame."""
        if body == GROUND:
            return [repr(x), repr(y)]
        return [f"x{body}+({x!r})*cos(theta{body})-({y!r})*sin(theta{body})",
                f"y{body}+({x!r})*sin(theta{body})+({y!r})*cos(theta{body})"]

    turn = repr(angle) if body == GROUND else f"theta{body}+({angle!r})"
    if solid.shape == "segment":
        half = [length / 2 * math.cos(angle), length / 2 * math.sin(angle)]
        ends = [place(position[0] + s * half[0], position[1] + s * half[1]) for s in (-1, 1)]
        return Shape(name, "segment", (2 * solid.radius,), ends[0], end=ends[1])
    if solid.shape == "plane":
        return Shape(name, "plane", (0, 1, 0), place(*position[:2]), turn if body != GROUND or angle else "") \
            if body != GROUND else Shape(name, "plane", (-math.sin(angle), math.cos(angle)), place(*position[:2]))
    size = (1.15 * solid.radius, solid.radius) if solid.hollow else (solid.radius,)
    points = np.reshape(fields["points"], (-1, 2)).tolist()
    return Shape(name, solid.shape, size, place(*position[:2]), turn, points=points)


def _product(a: Sequence[str], b: Sequence[float]) -> list[str]:
    """Product of the quaternions a (formulas) and b."""
    w, x, y, z = (f"({c!r})" for c in b)
    return [f"{a[0]}*{w}-{a[1]}*{x}-{a[2]}*{y}-{a[3]}*{z}", f"{a[0]}*{x}+{a[1]}*{w}+{a[2]}*{z}-{a[3]}*{y}",
            f"{a[0]}*{y}-{a[1]}*{z}+{a[2]}*{w}+{a[3]}*{x}", f"{a[0]}*{z}+{a[1]}*{y}-{a[2]}*{x}+{a[3]}*{w}"]


def _turned(q: Sequence[str], p: Sequence[float]) -> list[str]:
    """Point p rotated by the unit quaternion q (formulas): p + 2 w (u x p) + 2 u x (u x p)."""
    w, x, y, z = q
    a, b, c = (f"({number!r})" for number in p)
    return [f"(1-2*{y}*{y}-2*{z}*{z})*{a}+2*({x}*{y}-{w}*{z})*{b}+2*({x}*{z}+{w}*{y})*{c}",
            f"2*({x}*{y}+{w}*{z})*{a}+(1-2*{x}*{x}-2*{z}*{z})*{b}+2*({y}*{z}-{w}*{x})*{c}",
            f"2*({x}*{z}-{w}*{y})*{a}+2*({y}*{z}+{w}*{x})*{b}+(1-2*{x}*{x}-2*{y}*{y})*{c}"]


def _spatial(name: str, body: int, solid: Solid) -> Shape:
    fields = solid._given()
    position, own = fields["position"], fields["quaternion"]
    own = own if any(own) else [1.0, 0.0, 0.0, 0.0]
    quaternion = [f"q{axis}{body}" for axis in "wxyz"] if body != GROUND else ["1", "0", "0", "0"]
    place = [repr(p) for p in position]
    if body != GROUND:
        moved = _turned(quaternion, position) if any(position) else ["0", "0", "0"]
        place = [f"{axis}{body}+{way}" for axis, way in zip("xyz", moved)]
    size = {"sphere": (solid.radius,), "capsule": (solid.radius, fields["length"][2]), "box": fields["length"],
            "cylinder": (solid.radius, fields["length"][2]), "cone": (solid.radius, fields["length"][2]),
            "ellipsoid": fields["length"], "disc": (solid.radius,), "plane": (0, 0, 1)}.get(solid.shape, ())
    surface = _spelled(solid.shape) in ("polyhedron", "mesh", "height_field")
    points = solid.triangles().reshape(-1, 3) if surface else ()
    return Shape(name, "polyhedron" if surface else solid.shape, size, place, quaternion=_product(quaternion, own), points=points)
