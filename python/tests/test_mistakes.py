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
    "`gravity=(-9.81,)` in the plane": lambda: Bodies(2, gravity=(-9.81,)),
    '`add_joint("revolute", None, 0)`': lambda: rod().add_joint("revolute", None, 0),
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
        except (nsdae.Error, TypeError) as error:
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


NAN, BIG = math.nan, 2**31


def planar(call):
    """A call of a world with a body, a joint and a motor."""
    def made():
        world, joint = hinged()
        world.add_motor(joint, "force")
        return call(world)

    return made


def started(call):
    return planar(lambda world: (lambda sim: (sim.init(), call(sim)))(nsdae.Sim(world, start_check="no")))


# A call and the text of its exception, ArgumentError unless the text is in WRONG_TYPES.
WRONG_TYPES = {
    "add_joint: body0 = None: must be an integer from -2^31 to 2^31 - 1": planar(lambda w: w.add_joint("revolute", None, 0)),
    "add_joint: body1 = 1.0: must be an integer from -2^31 to 2^31 - 1": planar(lambda w: w.add_joint("revolute", 0, 1.0)),
    "add: mass = None: must be a number": lambda: Bodies(2).add(None, 1),
    "add_spring: stiffness = [1, 2]: must be a number": planar(
        lambda w: w.add_spring(GROUND, 0, point=(1, 1), end=(0, 0), stiffness=[1, 2])),
    "add_coupler: coordinates = (0, None): must be a sequence, each entry an integer from -2^31 to 2^31 - 1": planar(
        lambda w: w.add_coupler(0, 0, (0, 1), coordinates=(0, None))),
    "add_solid: solid = None: must be a Solid": planar(lambda w: w.add_solid(0, None)),
    "add_solid: radius = None: must be a number": planar(lambda w: w.add_solid(0, Solid("disc", radius=None))),
    "Bodies: dimension = '2': must be an integer from -2^31 to 2^31 - 1": lambda: Bodies("2"),
    "System: nq = 1.5: must be an integer from -2^31 to 2^31 - 1": lambda: nsdae.System(nq=1.5),
    "Sim: system = None: must be a System or a Bodies": lambda: nsdae.Sim(None),
    "solve: system = 3: must be a System or a Bodies": lambda: nsdae.solve(3, 1),
    "solve: every = 1.5: must be an integer from -2^31 to 2^31 - 1": planar(lambda w: nsdae.solve(w, 0.1, every=1.5)),
    "get_sensor: i = None: must be an integer from -2^31 to 2^31 - 1": started(lambda sim: sim.get_sensor(None)),
    "state: block = bytearray(b'ab'): must be bytes": started(lambda sim: setattr(sim, "state", bytearray(b"ab"))),
    "steps: t_end = 'a': must be a number": started(lambda sim: sim.steps("a")),
    "set_user_rows: k = 1.5: must be an integer from -2^31 to 2^31 - 1": lambda: Bodies(2).set_user_rows(k=1.5),
    "lcp: max_pivots = None: must be an integer from -2^31 to 2^31 - 1": lambda: nsdae.lcp([[1]], [1], max_pivots=None),
    "read_scene: path = None: must be a str or a path": lambda: nsdae.read_scene(None),
}
WRONG_VALUES = {
    f"set_control: i = {BIG}: must be an integer from -2^31 to 2^31 - 1": started(lambda sim: sim.set_control(BIG, 0)),
    "nq = -1 is outside its range: it must be 0 .. 2^20": lambda: Bodies(2).set_user_rows(nq=-1),
    "user rows: the callback gap is missing": planar(lambda w: (w.set_user_rows(k=1), w.system())),
    "every = 0: must be at least 1": planar(lambda w: nsdae.solve(w, 0.1, every=0)),
    "mu has the shape (3,); it must be (1,)": lambda: nsdae.System(nq=1, k=1, nt=1, mu=[1, 2, 3]),
    "names 'q' must be one of coordinate, velocity, constraint, contact, frictional_joint": lambda: nsdae.System(
        nq=1, names={"q": ["x"]}),
    "gravity has 1 number; in the plane it has two": lambda: Bodies(2, gravity=9.81),
    "position has 1 number; in the plane it has two": lambda: Bodies(2).add(1, 1, position=(1,)),
    "position has 1 number; in space it has three": lambda: Bodies(3).add(1, UNIT, position=3.7),
    "velocity has 1 number; in the plane it has two": lambda: Bodies(2).add(1, 1, velocity=[1]),
    "position = ['a', 'b']: must be numbers": lambda: Bodies(2).add(1, 1, position=["a", "b"]),
    "position has 2 numbers; in space it has three": lambda: Bodies(3).add_solid(GROUND, Solid("point", position=(1, 2))),
    "local has 1 number; in the plane it has two": planar(lambda w: w.locate(w.start()[0], 0, 1)),
    "q has 2 numbers; it must have 3": planar(lambda w: w.locate((1, 2), 0)),
    "torsion 0: axis (1, 1, 0) has no effect in the plane: leave it out": planar(
        lambda w: w.add_torsion(GROUND, 0, axis=(1, 1))),
    "solid 0: group = -1 is outside its range: it must be 0 .. 2^31 - 1 (bits 0 .. 30)": planar(
        lambda w: w.add_solid(0, Solid("point", group=-1))),
    "points of a height field has the shape (3,); it must be (ny, nx)": lambda: Bodies(3).add_solid(
        GROUND, Solid("height field", length=(1, 1, 1), points=(1, 2, 3))),
    "A has the shape (0,); it must be (n, n)": lambda: nsdae.lcp([], []),
    "A[1, 0] = inf: must be finite": lambda: nsdae.lcp([[1, 0], [math.inf, 1]], [1, 1]),
    "b[1] = nan: must be finite": lambda: nsdae.lcp(np.eye(2), [1, NAN]),
    "tol = nan: must be above 0 and at most 1": lambda: nsdae.friction_local(np.eye(3), UNIT, [0.1], tol=NAN),
    "budget = -1: must be at least 0 and at most inf": lambda: nsdae.friction_local(np.eye(3), UNIT, [0.1], budget=-1),
    "q[0] = nan: must be finite": lambda: nsdae.friction_local(np.eye(3), [NAN, 0, 0], [0.1]),
    "W[0, 1] = nan: must be finite": lambda: nsdae.friction_local([[1, NAN, 0], UNIT, UNIT], UNIT, [0.1]),
    "rows = 2.5: must be integers, 1, 2 or 3": lambda: nsdae.friction_local(np.eye(3), UNIT, [0.1], rows=2.5),
    "W(0, 0) = -1: must be >= 0": lambda: nsdae.friction_local(-np.eye(3), (-1, 0, 0), [0.1]),
}


@pytest.mark.parametrize("text", [*WRONG_TYPES, *WRONG_VALUES])
def test_wrong_argument(text):
    """The text has the argument, its value and what it must be."""
    with pytest.raises(TypeError if text in WRONG_TYPES else nsdae.ArgumentError) as caught:
        {**WRONG_TYPES, **WRONG_VALUES}[text]()
    assert str(caught.value) == text


def test_a_mass_of_friction_that_is_not_positive():
    with pytest.raises(nsdae.Error, match="block 0 of M is not positive definite: pivot 0, of the diagonal entry -1, "):
        nsdae.friction([[1]], [[-1]], [0], [0.1], rows=1)


# Numbers as arguments of the kit and of a simulation.
NUMBERS = {
    "position": lambda x: Bodies(2).add(1, 1, position=(0, x)), "angle": lambda x: Bodies(2).add(1, 1, angle=x),
    "spin": lambda x: Bodies(2).add(1, 1, spin=x), "mass": lambda x: Bodies(2).add(x, 1),
    "inertia": lambda x: Bodies(2).add(1, x), "gravity": lambda x: Bodies(2, gravity=(0, x)),
    "quaternion": lambda x: Bodies(3).add(1, UNIT, quaternion=(1, 0, x, 0)),
    "point": lambda x: rod().add_joint("revolute", GROUND, 0, point=(x, 0)),
    "rest": lambda x: hinged()[0].add_joint_spring(0, stiffness=1, rest=x),
    "target": lambda x: hinged()[0].add_motor(0, "force", x), "mu": lambda x: touching(mu=x), "e_n": lambda x: touching(e_n=x),
    "axis": lambda x: rod().add_torsion(GROUND, 0, axis=(x, 0)),
    "q0": lambda x: nsdae.solve(hinged()[0], 1, q0=(x, 0, 0)), "v0": lambda x: nsdae.solve(hinged()[0], 1, v0=(x, 0, 0)),
    "t0": lambda x: nsdae.solve(hinged()[0], 1, t0=x), "dt": lambda x: nsdae.solve(hinged()[0], 1, dt=x),
    "mu of friction": lambda x: nsdae.friction_local(np.eye(3), UNIT, [x]),
}


@pytest.mark.parametrize("argument", NUMBERS)
def test_an_argument_that_is_not_finite(argument):
    for number in (math.nan, math.inf, -math.inf):
        with pytest.raises(nsdae.ArgumentError, match=argument.split()[0]):
            NUMBERS[argument](number)


def test_a_callback_that_is_not_finite():
    """It is no argument: the error has the time."""
    def write(t, *arrays):
        arrays[-1][...] = math.nan

    def contacts(t, q, v, reach, found):
        found.add(1, (0, -1), math.nan, np.ones((1, 2, 1, 1)))

    mass = {"mass": lambda t, q, M: M.fill(1), "force": lambda t, q, v, F: None, "gap": lambda t, q, g: g.fill(1),
            "constraint": lambda t, q, phi: None}
    systems = [nsdae.System(nq=1, m=1, k=1, **{**mass, name: write})
               for name in ("mass", "force", "gap", "constraint", "constraint_jacobian", "gap_normal")]
    systems.append(nsdae.System(blocks=[1], mass_blocks=lambda t, q, M: M.fill(1), force=mass["force"], contacts=contacts))
    systems.append(hinged()[0])
    systems[-1].add_load(0, no_force)
    for system in systems:
        with pytest.raises(nsdae.Error) as caught:
            nsdae.solve(system, 0.1, None if system is systems[-1] else [0], start_check="no")
        assert caught.value.status == nsdae.Status.E_NONFINITE and not isinstance(caught.value, nsdae.ArgumentError)
        assert caught.value.time is not None


def test_a_sensor_with_the_name_of_a_coordinate():
    world = rod()
    world.add_sensor("kinetic_energy", "x0", body=0)
    run = nsdae.solve(world, 0.01)
    with pytest.raises(KeyError, match="'x0' is the name of a sensor and of a coordinate"):
        run["x0"]
    assert np.array_equal(run["y0"], run.q[:, 1]) and run.sensors["x0"].shape == run.time.shape


def test_defaults_of_options():
    sim = nsdae.Sim(hinged()[0])
    for key, value in sim.options.items():
        shown = re.search(rf"^    {key} .*, default (\S+)$", nsdae.__doc__, re.M)
        assert shown, key
        zero = shown[1] == "auto" and value == 0  # of a number
        assert zero or (shown[1] == value if isinstance(value, str) else float(shown[1]) == value), key


def test_a_simulation_without_a_state():
    sim = nsdae.Sim(hinged()[0])
    for call in (lambda: sim.record, sim.contact_forces, lambda: next(sim.steps(1)), lambda: sim.state, sim.step,
                 lambda: sim.get_sensor(0)):
        with pytest.raises(nsdae.Error, match=r"^the simulation has no state: call Sim\.init first"):
            call()


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


def test_spellings():
    """Words of several parts: with underscores; hyphens and spaces are the same words."""
    ball = nsdae.System(nq=1, mass=lambda t, q, M: None, force=lambda t, q, v, F: None)
    for word in ("least_norm", "least-norm"):
        assert nsdae.Sim(ball, redundant=word).options["redundant"] == "least-norm"
    for word in ("height_field", "height field", "height-field"):
        Bodies(3).add_solid(GROUND, Solid(word, length=(1, 1, 1), points=np.zeros((2, 2))))
    world = Bodies(3)
    body = world.add(1, [1, 1, 1])
    assert [world.add_sensor(word, body=body) for word in ("angular_velocity", "angular velocity", "angular-velocity")] == [0, 1, 2]
    with pytest.raises(nsdae.ArgumentError, match="one of .*angular_velocity"):
        world.add_sensor("angularvelocity", body=body)
