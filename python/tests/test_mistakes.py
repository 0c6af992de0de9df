"""The mistakes of docs/guide/mistakes.md with the kit, in Python."""

import math
import pathlib
import re

import numpy as np
import pytest

import nsdae
from nsdae import GROUND, Bodies, Solid
from nsdae._errors import in_python

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/guide/mistakes.md"
UNIT = (1.0, 1.0, 1.0)


def drive(t, f):
    f[:] = 0.1 * math.sin(2 * t), 0.1 * math.cos(2 * t), -0.4 * math.sin(2 * t)


def no_force(t, position, velocity, force, torque):
    force[1] = math.nan


def rod(dimension=2, inertia=None, gravity=True, **given):
    """A rod of 1 m that hangs from the origin."""
    down = () if not gravity else (0, -9.81) if dimension == 2 else (0, 0, -9.81)
    world = Bodies(dimension, gravity=down)
    if inertia is None:
        inertia = 1 if dimension == 2 else UNIT
    world.add(**{"mass": 1, "position": (0.5, 0) if dimension == 2 else (0.5, 0, 0), "inertia": inertia, **given})
    return world


def hinged(dimension=2, **given):
    world = rod(dimension, gravity=dimension == 2, **given)
    return world, world.add_joint("revolute", GROUND, 0, axis=(0, 0, 1))


def touching(ball=Solid("disc", radius=0.1), **law):
    world = rod()
    floor = world.add_solid(GROUND, Solid("plane", position=(0, -1)))
    world.add_contact(floor, world.add_solid(0, ball), **{"mu": 0.3, "e_n": 0.5, **law})
    return world


def in_degrees():
    hinged(angle=90)[0].system()


def upright():
    world = Bodies(3, gravity=(0, -9.81, 0))
    world.add(1, UNIT, (0.5, 0, 0))
    world.add_joint("revolute", GROUND, 0, axis=(0, 0, 1))
    world.system()


def apart(name, change):
    world, _ = hinged()
    q0, v0 = world.start()
    {"q": q0, "v": v0}[name][0] += change
    nsdae.solve(world, 0.1, q0, v0)


def driven():
    world = rod(spin=0.1, velocity=(0, 0.05))
    world.add_joint("revolute", GROUND, 0, drive=drive)
    nsdae.solve(world, 0.1)


def loaded():
    world, _ = hinged()
    world.add_load(0, no_force, (0.5, 0))
    nsdae.solve(world, 0.1)


def no_contact():
    world = rod()
    world.add_solid(GROUND, Solid("plane", position=(0, -1)))
    world.add_solid(0, Solid("disc", radius=0.1))
    world.system()


def same_body():
    world = rod()
    world.add_solid(GROUND, Solid("plane", position=(0, -1)))
    disc = world.add_solid(0, Solid("disc", radius=0.1))
    world.add_contact(world.add_solid(0, Solid("disc", radius=0.1)), disc)


def late():
    world = touching()
    world.system()
    world.add(1, 1)


def same_centre():
    world = rod()
    world.add_solid(GROUND, Solid("plane", position=(0, -1)))
    first = world.add_solid(0, Solid("disc", radius=0.1))
    second = world.add_solid(world.add(1, 1, (0.5, 0)), Solid("disc", radius=0.1))
    world.add_contact(second, first)
    nsdae.solve(world, 0.1)


def turned(values, **given):
    hinged(3, quaternion=values, **given)[0].system()


# The beginning of a row of the table, and the mistake. Rows that Python refuses by itself are below.
ROWS = {
    "an inertia that no body has": lambda: rod(3, (1, 1, 5)),
    "products of inertia": lambda: rod(3, ((1, 2, 0), (2, 1, 0), (0, 0, 1))),
    "no mass": lambda: rod(mass=0),
    "a quaternion with the entries x": lambda: turned((0, 0, 0, 1)),
    "gravity of a planar model": upright,
    "90 for an angle": in_degrees,
    "a joint of a body that does not": lambda: rod().add_joint("revolute", GROUND, 1),
    "a joint of a body with itself": lambda: rod().add_joint("revolute", 0, 0),
    "a prismatic joint": lambda: rod().add_joint("prismatic", GROUND, 0),
    "a start at which": lambda: apart("q", 0.1),
    "velocities at which": lambda: apart("v", 1),
    "a drive whose": driven,
    "a spring of length zero": lambda: hinged()[0].add_spring(GROUND, 0, point=(0, 0), end=(0, 0), stiffness=1),
    "a load that": loaded,
    "limits in the wrong": lambda: hinged()[0].add_limit(0, -1, -2),
    "one limit of a rotation": lambda: hinged(3)[0].add_limit(0, -1),
    "corners of a polygon": lambda: touching(Solid("polygon", points=((0, 0), (0, 1), (1, 0)))),
    "a box in the plane": lambda: touching(Solid("box", length=(1, 1, 1))),
    "no contact at all": no_contact,
    "a contact of two solids": same_body,
    "restitution above one": lambda: touching(e_n=1.5),
    "a material of the number": lambda: touching(Solid("disc", radius=0.1, material=64)),
    "a body that is added": late,
    "two discs that start": same_centre,
}

WRONG_SIZES = {
    "`inertia=(1, 1, 1)` in the plane": lambda: rod(inertia=UNIT),
    "`inertia=1` in space": lambda: rod(3, 1),
    "`quaternion=(0.1, 0.2, 0.3)`": lambda: rod(3, quaternion=(0.1, 0.2, 0.3)),
    "`quaternion=(1, 0, 0, 0)` in the plane": lambda: rod(quaternion=(1, 0, 0, 0)),
    "`gravity=(0, -9.81)` in space": lambda: Bodies(3, gravity=(0, -9.81)),
    "`solve(world, 1, timestep=0.01)`": lambda: nsdae.solve(touching(), 1, timestep=0.01),
}


def rows(heading):
    """Answers of a table of the page by the first column."""
    if not PAGE.exists():
        pytest.skip("the page is not here")
    text = PAGE.read_text().split(heading, 1)[1]
    table = re.search(r"\|---\|---\|\n((?:\|.*\n)+)", text)[1]
    return dict(row.strip("| ").split(" | ", 1) for row in table.splitlines())


def answer(mistake):
    with pytest.warns(nsdae.ModelWarning) as told:
        try:
            mistake()
        except (nsdae.Error, ValueError) as error:
            import warnings
            warnings.warn("the error counts", nsdae.ModelWarning)
            return str(error)
    return str(told[0].message)


@pytest.mark.parametrize("begins", ROWS)
def test_row(begins):
    found = [text for name, text in rows("| mistake | answer |").items() if name.startswith(begins)]
    assert len(found) == 1
    assert answer(ROWS[begins]) == in_python(found[0].strip("`").split(": ", 1)[1])


@pytest.mark.parametrize("name", WRONG_SIZES)
def test_size(name):
    assert answer(WRONG_SIZES[name]) == rows("| mistake | answer in Python |")[name]


def test_a_shape_for_pictures_alone():
    world = rod()
    world.add_solid(0, Solid("disc", radius=0.1, exclude=-1))
    import warnings
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.system()


def test_tensor():
    """A box whose axes are not principal has the motion of the same box with principal axes."""
    def spin(turn):
        c, s = math.cos(turn), math.sin(turn)
        R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        world = Bodies(3)
        world.add(2, R.T @ np.diag((0.5, 0.8, 1.1)) @ R, quaternion=(math.cos(turn / 2), 0, 0, math.sin(turn / 2)),
                  spin=R.T @ (0.3, 2, 0.1))
        run = nsdae.solve(world, 1, method="event", rtol=1e-11, atol=1e-13)
        return R @ run.v[-1, 3:]

    assert spin(0.7) == pytest.approx(spin(0), abs=1e-9)
