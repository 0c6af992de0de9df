"""Mechanisms of bodies from Python."""

import gc
import math
import os
import warnings

import h5py
import numpy as np
import pytest

import nsdae
from nsdae import GROUND, Bodies, Shape, Solid

G = 9.81


def test_physical_pendulum_against_its_equation():
    """A rod on a hinge: theta'' = -3 g / (2 l) cos(theta), integrated by the classical Runge-Kutta method."""
    world = Bodies(2, gravity=(0, -G))
    rod = world.add(mass=1, inertia=1 / 12, position=(0.5, 0))
    world.add_joint("revolute", GROUND, rod, point=(0, 0))
    run = nsdae.solve(world, 1, method="event", rtol=1e-10, atol=1e-12)

    def rate(y):
        return np.array([y[1], -1.5 * G * math.cos(y[0])])

    y, h = np.zeros(2), 1e-3
    for _ in range(1000):
        k1 = rate(y)
        k2, k3 = rate(y + h / 2 * k1), None
        k3 = rate(y + h / 2 * k2)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + h * k3))
    assert run["theta0"][-1] == pytest.approx(y[0], abs=1e-7)


@pytest.mark.parametrize("compiled", [False, True])
def test_a_driven_crank(library, compiled):
    """The angle that is prescribed is the angle that comes out."""
    def turn(t, f):
        f[:] = 2 * t, 2, 0

    import ctypes
    drive = ctypes.cast(library.drive, nsdae.signature("drive", "ctypes")) if compiled else turn
    world = Bodies(2)
    crank = world.add(mass=1, inertia=0.1, position=(1, 0), spin=2, velocity=(0, 2))
    world.add_joint("revolute", GROUND, crank, point=(0, 0), drive=drive)
    run = nsdae.solve(world, 1, dt=0.001)
    assert run["theta0"][-1] == pytest.approx(2, abs=1e-5)


def test_limits_couplers_and_ropes():
    """A rack on a pinion up to its stop; a mass that hangs on a rope; an exponential decay."""
    world = Bodies(2, gravity=(6, 0))
    pinion = world.add(mass=2, inertia=1)
    rack = world.add(mass=2, inertia=1)
    hinge = world.add_joint("revolute", GROUND, pinion)
    rail = world.add_joint("prismatic", GROUND, rack, axis=(1, 0))
    assert world.add_coupler(hinge, rail, (0, 0.5)) == 0
    assert world.add_limit(rail, high=0.9) == 0
    run = nsdae.solve(world, 2, dt=0.001)
    assert run["x1"][500] == pytest.approx(0.25, abs=1e-2)  # 2 g / (2 + 1 / 0.25) t^2 / 2
    assert run["x1"][-1] == pytest.approx(0.9, abs=5e-3)
    assert run["theta0"][-1] == pytest.approx(1.8, abs=1e-2)

    world = Bodies(3, gravity=(0, 0, -10))
    ball = world.add(mass=1, inertia=(1, 1, 1), position=(0, 0, -1))
    world.add_rope(GROUND, ball, point=(0, 0, 0), end=(0, 0, -1), length=2)
    assert nsdae.solve(world, 1, dt=0.001)["z0"][-1] == pytest.approx(-2, abs=1e-2)

    world = Bodies(3)
    wheel = world.add(mass=1, inertia=(1, 1, 0.5), spin=(0, 0, 2))
    axle = world.add_joint("cylindrical", GROUND, wheel, axis=(0, 0, 1))
    world.add_joint_spring(axle, coordinate=1, damping=0.5)
    run = nsdae.solve(world, 1, method="event", rtol=1e-10, atol=1e-12)
    assert run["wz0"][-1] == pytest.approx(2 * math.exp(-1), abs=1e-8)
    with pytest.raises(nsdae.ArgumentError, match="2 pi"):
        world = Bodies(3)
        wheel = world.add(mass=1, inertia=(1, 1, 1))
        world.add_limit(world.add_joint("revolute", GROUND, wheel, axis=(0, 0, 1)), low=-1)


def test_motors():
    """A wheel by torque, by speed and by a brake; a clutch that engages; a position."""
    def wheel(world, spin=0.0):
        body = world.add(mass=1, inertia=0.5, spin=spin)
        return world.add_joint("revolute", GROUND, body)

    def turn(world, t=1.0):
        run = nsdae.solve(world, t, method="event", rtol=1e-11, atol=1e-12)
        return run["theta0"][-1]

    world = Bodies(2)
    world.add_motor(wheel(world), "force", 5, limit=3)
    assert turn(world) == pytest.approx(3, abs=1e-9)
    world = Bodies(2)
    world.add_motor(wheel(world), "speed", 2, limit=4)  # after 0.25 s
    assert turn(world) == pytest.approx(0.25 + 1.5, abs=1e-9)
    world = Bodies(2)
    world.add_motor(wheel(world, 2), "speed", limit=4)
    assert turn(world) == pytest.approx(0.25, abs=1e-9)
    world = Bodies(2, gravity=(0, -10))  # the weight on a pin: 0.5 theta'' = -0.2 * 0.05 * 10
    world.add_joint("revolute", GROUND, world.add(mass=1, inertia=0.5, spin=2), mu=0.2, radius=0.05)
    assert turn(world) == pytest.approx(2 - 0.1, abs=1e-9)
    world = Bodies(2)

    def ramp(t, f):
        f[0] = 6 * t * t

    world.add_motor(wheel(world, 2), "speed", limit=ramp)  # 2 - 4 t^3 to t_1^3 = 1/2
    assert turn(world) == pytest.approx(1.5 * 0.5 ** (1 / 3), abs=1e-9)

    def sine(t, f):
        f[:] = math.sin(t), math.cos(t), -math.sin(t)

    world = Bodies(2)
    world.add_motor(wheel(world, 1), "position", sine, kp=100, kd=10)
    assert turn(world) == pytest.approx(math.sin(1), abs=0.01)
    with pytest.raises(nsdae.ArgumentError, match="limit"):
        world = Bodies(2)
        world.add_motor(wheel(world), "speed", 2)


def test_controls():
    """The torque 1 for 1 s, then -2: 4 (0.5 + 1 - 1) rad; part of the state; a drive is no control."""
    world = Bodies(2)
    joint = world.add_joint("revolute", GROUND, world.add(mass=1, inertia=0.25))
    world.add_motor(joint, "force", 1)
    world.add_motor(joint, "force", lambda t, f: None)
    sim = nsdae.Sim(world, method="event", rtol=1e-11, atol=1e-12)
    sim.init()
    sim.run(1)
    sim.set_control(0, -2)
    assert sim.get_control(0) == -2
    state = sim.state
    sim.run(2)
    assert sim.record.q[2] == pytest.approx(2, abs=1e-9)
    other = nsdae.Sim(world, method="event", rtol=1e-11, atol=1e-12)
    other.state = state
    other.run(2)
    assert other.state == sim.state
    for i, value, words in ((2, 0, "there are 2"), (0, math.nan, "finite"), (1, 0, "its drive")):
        with pytest.raises(nsdae.ArgumentError, match=words):
            sim.set_control(i, value)


def test_sensors(tmp_path):
    """A wheel of 40 rad/s over ten turns in space, its rim, and its weight; kept by solve and in a file."""
    world = Bodies(3, gravity=(0, 0, -10))
    joint = world.add_joint("revolute", GROUND, world.add(mass=2, inertia=(1, 1, 1), spin=(0, 0, 40)), axis=(0, 0, 1))
    world.add_sensor("coordinate", "turned", joint=joint)
    force = world.add_sensor("reaction_force", joint=joint)
    world.add_sensor("velocity", "rim", point=(0.5, 0, 0))
    run = nsdae.solve(world, 2, method="event", dt=0.1)
    assert run["turned"] == pytest.approx(40 * run.time, abs=1e-6)
    assert run["rim"][:, 1] == pytest.approx(20 * np.cos(40 * run.time), abs=1e-5)
    assert list(run.sensors) == ["turned", "rim"]
    assert run.names["sensor"] == [("turned", "rad"), ("rim", "m/s")]
    run.save(tmp_path / "run.h5")
    again = nsdae.load(tmp_path / "run.h5")
    assert dict(again.names["sensor"]) == dict(run.names["sensor"])
    for name, values in run.sensors.items():
        np.testing.assert_array_equal(again[name], values)
    sim = nsdae.Sim(world, method="event", dt=0.1)
    sim.init(*world.start())
    sim.run(1)
    assert sim.get_sensor(force) == pytest.approx([0, 0, 20])
    with pytest.raises(nsdae.ArgumentError, match="there are 3 sensors"):
        sim.get_sensor(3)
    with pytest.raises(ValueError, match="kind"):
        world.add_sensor("colour")


def test_a_load_of_python():
    """A constant thrust on the centre: x = F t^2 / (2 m)."""
    def thrust(t, position, velocity, force, torque):
        assert position.shape == velocity.shape == (3,)
        force[0] = 3

    world = Bodies(2)
    cart = world.add(mass=2, inertia=1)
    world.add_load(cart, thrust)
    assert nsdae.solve(world, 2, dt=0.01)["x0"][-1] == pytest.approx(3.0, abs=1e-9)


def test_a_disc_rolls_down():
    """Rolling without slip: s'' = 2/3 g sin(a)."""
    slope = 0.2
    solid = Solid("disc", radius=0.1)
    mass, inertia = solid.inertia(density=100)
    world = Bodies(2, gravity=(G * math.sin(slope), -G * math.cos(slope)))
    disc = world.add(mass=mass, inertia=inertia, position=(0, 0.1))
    ground = world.add_solid(GROUND, Solid("plane"))
    world.add_contact(ground, world.add_solid(disc, solid), mu=0.5)
    run = nsdae.solve(world, 1, dt=0.001)
    assert run["x0"][-1] == pytest.approx(G * math.sin(slope) / 3, rel=2e-3)
    assert run["theta0"][-1] == pytest.approx(-run["x0"][-1] / 0.1, rel=2e-3)


def test_a_sphere_in_space_falls_and_bounces():
    world = Bodies(3, gravity=(0, 0, -G))
    solid = Solid("sphere", radius=0.1)
    mass, inertia = solid.inertia(1000)
    ball = world.add(mass=mass, inertia=inertia, position=(0, 0, 1.1))
    world.add_contact(world.add_solid(GROUND, Solid("plane")), world.add_solid(ball, solid), e_n=0.5)
    run = nsdae.solve(world, 1, method="event", rtol=1e-9, atol=1e-11)
    assert run.impacts["time"][0] == pytest.approx(math.sqrt(2 / G), rel=1e-7)
    q, _ = world.start()
    assert np.allclose(world.locate(q, ball, (0, 0, 0.5)), [0, 0, 1.6])


def test_polyhedra():
    """A cube as the hull of its corners and of points in it: mass, inertia, triangles, and it lies still on a floor."""
    corners = np.array([[x, y, z] for x in (0, 0.2) for y in (0, 0.2) for z in (0, 0.2)])
    points = np.vstack([corners, np.random.default_rng(1).uniform(0.01, 0.19, (50, 3))])
    cube = Solid("polyhedron", points=points)
    world = Bodies(3, gravity=(0, 0, -G))
    world.add_solid(GROUND, Solid("plane"))
    body = world.add_from_solids([cube], 500, (1, 2, 0), spin=(0, 0, 1))
    with pytest.raises(nsdae.ArgumentError, match="Bodies.add_from_solids"):
        cube.inertia(500)
    mass, inertia = cube._replace(points=points - 0.1).inertia(500)
    assert mass == pytest.approx(4) and np.allclose(inertia, 4 * 0.04 / 6)
    triangles = cube.triangles()
    assert triangles.shape == (12, 3, 3)
    assert np.linalg.det(triangles).sum() / 6 == pytest.approx(0.008)
    world.set_pair(0, 0, mu=0.5)
    run = nsdae.solve(world, 1, method="implicit", dt=0.002)
    assert np.allclose(world.start()[0][:3], (1.1, 2.1, 0.1))
    assert run["z0"][-1] == pytest.approx(0.1, abs=1e-6) and abs(run.v[-1]).max() < 1e-9
    place, turn = pose(world.shapes()[1], run, -1)
    ends = place + world.shapes()[1].points @ turn.T
    assert ends[:, 2].min() == pytest.approx(0, abs=1e-6) and np.ptp(ends[:, 2]) == pytest.approx(0.2)
    with pytest.raises(ValueError, match="3 numbers in each row"):
        Solid("polyhedron", points=[[0, 0]]).triangles()
    with pytest.raises(nsdae.ArgumentError, match="plane"):
        world.add_from_solids([Solid("polyhedron", points=corners[:4])], 1)


def test_a_cylinder_rolls_down():
    """s'' = 2/3 g sin(a), by event to rounding."""
    slope, radius = 0.2, 0.1
    world = Bodies(3, gravity=(G * math.sin(slope), 0, -G * math.cos(slope)))
    ground = world.add_solid(GROUND, Solid("plane"))
    body = world.add_from_solids([Solid("cylinder", radius=radius, length=0.3)], 1000, (0, 0, radius),
                                 quaternion=(math.sqrt(0.5), -math.sqrt(0.5), 0, 0))
    world.add_contact(ground, 1, mu=0.5)
    run = nsdae.solve(world, 1, method="event", dt=0.01)
    assert run["x0"][-1] == pytest.approx(G * math.sin(slope) / 3, abs=1e-8)
    assert world.shapes()[1].size == (radius, 0.3) and body == 0
    world = Bodies(3)
    world.add_solid(world.add(1, (1, 1, 1)), Solid("cylinder", radius=1, length=1))
    world.add_contact(0, world.add_solid(GROUND, Solid("box", length=(1, 1, 1), position=(0, 0, -2))))
    with pytest.raises(nsdae.ArgumentError, match="contacts for time stepping alone"):
        nsdae.solve(world, 0.01, method="event")
    nsdae.solve(world, 0.01, method="moreau")


def test_refusals():
    world = Bodies(2)
    with pytest.raises(ValueError, match="kind"):
        world.add_joint("hinge", GROUND, 0)
    with pytest.raises(ValueError, match="shape"):
        Solid("blob").inertia(1)
    with pytest.raises(ValueError, match="position"):
        world.add(1, 1, position=(1, 2, 3, 4))
    with pytest.raises(nsdae.ArgumentError, match="mass"):
        world.add(mass=-1, inertia=1)
    with pytest.raises(ValueError, match="inertia has 1"):
        Bodies(3).add(mass=1, inertia=1)
    with pytest.raises(nsdae.Error):
        Bodies(4)


def pose(shape, run, record):
    """Place and turn of a shape as the formulas of its file say."""
    from nsdae.pictures import bodies
    with run._opened() as file:
        named = bodies.named(file, run.time, run.q)
    body = next(b for b in named if b.name == shape.name)
    return body.position[record], body.rotation[record]


def test_shapes_are_where_the_bodies_are():
    """The formulas for animations against locate(), of a solid that is off its body's frame in place and turn."""
    random = np.random.default_rng(1)
    world = Bodies(3, gravity=(0, 0, -G))
    q = random.normal(size=4)
    own = random.normal(size=4)
    own /= np.linalg.norm(own)
    body = world.add(mass=1, inertia=(1, 2, 3), position=(1, 2, 3), quaternion=q, spin=(1, -2, 0.5), velocity=(1, 0, 2))
    world.add_solid(body, Solid("box", length=(0.1, 0.2, 0.3), position=(0.3, -0.2, 0.1), quaternion=own))
    run = nsdae.solve(world, 0.5)
    (shape,) = world.shapes()
    for record in (0, len(run) // 2, len(run) - 1):
        place, turn = pose(shape, run, record)
        assert np.allclose(place, world.locate(run.q[record], body, (0.3, -0.2, 0.1)), atol=1e-12)
        w, x, y, z = own
        axis = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])  # own x in the body
        end = world.locate(run.q[record], body, np.array([0.3, -0.2, 0.1]) + axis)
        assert np.allclose(turn[:, 0], end - place, atol=1e-12)


def test_planar_shapes_are_where_the_bodies_are():
    world = Bodies(2)
    body = world.add(mass=1, inertia=1, position=(1, 2), angle=0.3, spin=2, velocity=(1, -1))
    world.add_solid(body, Solid("disc", radius=0.1, position=(0.4, 0.2), angle=0.5))
    run = nsdae.solve(world, 0.5)
    place, turn = pose(world.shapes()[0], run, -1)
    assert np.allclose(place, world.locate(run.q[-1], body, (0.4, 0.2)), atol=1e-12)
    assert math.atan2(turn[1, 0], turn[0, 0]) == pytest.approx(run["theta0"][-1] + 0.5)


__all__ = ["Shape"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_blocks_side_by_side_start(dimension):
    """Their edges are equally near; the start check does not compare formulas of the kit."""
    width, height = 0.1, 0.5
    corners = [(-width / 2, -height / 2), (width / 2, -height / 2), (width / 2, height / 2), (-width / 2, height / 2)]
    world = Bodies(dimension, gravity=(0, -G) if dimension == 2 else (0, 0, -G))
    floor, solids = world.add_solid(GROUND, Solid("plane")), []
    for i in range(2):
        if dimension == 2:
            body = world.add(mass=1, inertia=0.02, position=(0.3 * i, height / 2))
            solids.append(world.add_solid(body, Solid("polygon", points=corners)))
        else:
            body = world.add(mass=1, inertia=(0.02, 0.02, 0.02), position=(0.3 * i, 0, height / 2))
            solids.append(world.add_solid(body, Solid("box", length=(width, width, height))))
        world.add_contact(floor, solids[-1], mu=0.4)
    world.add_contact(*solids, mu=0.2)
    run = nsdae.solve(world, 0.05, method="event")
    assert run.q[-1] == pytest.approx(world.start()[0], abs=1e-12)


def test_errors_name_elements():
    world = Bodies(2)
    hole = world.add_solid(GROUND, Solid("disc", radius=0.11, hollow=True))
    pin = world.add_solid(world.add(mass=1, inertia=1), Solid("disc", radius=0.1))
    world.add_contact(hole, pin)
    with pytest.raises(nsdae.ArgumentError, match=r"hole 0 of the ground, disc 1 of body 0\): the centres coincide"):
        nsdae.solve(world, 1)
    world = Bodies(2)
    with pytest.raises(nsdae.Error, match=r"spring 0: point and end coincide at \(0, 0, 0\)"):
        world.add_spring(GROUND, world.add(mass=1, inertia=1), point=(0, 0), end=(0, 0), stiffness=1, rest=1)


def test_overlap_at_the_start():
    """event starts at gap 0, or refuses; time stepping reports it."""
    def falling(overlap):
        world = Bodies(2, gravity=(0, -G))
        floor = world.add_solid(GROUND, Solid("plane"))
        world.add_contact(floor, world.add_solid(world.add(mass=1, inertia=1, position=(0, 0.1 - overlap)),
                                                 Solid("disc", radius=0.1)))
        return world

    assert nsdae.solve(falling(9e-7), 0.1, method="event").q[:, 1] == pytest.approx(0.1, abs=1e-15)
    with pytest.raises(nsdae.ArgumentError, match="overlaps by 0.01"):
        nsdae.solve(falling(0.01), 0.1, method="event")
    with pytest.warns(nsdae.RunWarning, match="overlaps by 0.01 at the start"):
        nsdae.solve(falling(0.01), 0.1, method="moreau", dt=1e-3)


def test_user_rows():
    """A load of 2 kg on a rope around a drum of 0.5 kg m^2, radius 1: a = g 2 / 2.5; with a motor torque of 5 on the drum and
    its energy as potential: 2 a = 2 g - T, 0.5 a = T - 5."""
    def mass(t, q, M):
        M[0, 0] = 0.5

    def rope(t, q, phi):
        phi[0] = q[1] + q[3]

    def torque(t, q, v, F):
        assert F[1] == pytest.approx(-2 * G)
        F[3] += -5

    def hung(**more):
        world = Bodies(2, gravity=(0, -G))
        world.set_user_rows(1, m=1, mass=mass, constraint=rope, **more)
        world.add(mass=2, inertia=1)
        return world

    run = nsdae.solve(hung(), 1, method="event", rtol=1e-10, atol=1e-12)
    assert run.q[-1, 3] == pytest.approx(G * 2 / 2.5 / 2, abs=1e-8)
    run = nsdae.solve(hung(force=torque, potential=lambda t, q: 5 * q[3]), 1, method="event", rtol=1e-10, atol=1e-12)
    assert run.q[-1, 3] == pytest.approx((2 * G - 5) / 2.5 / 2, abs=1e-8)
    energy = run.kinetic + run.potential
    assert energy == pytest.approx(energy[0], abs=1e-7)
    with pytest.raises(TypeError, match="no callback of user rows is called 'forces'"):
        hung(forces=torque)
    world = Bodies(2)
    world.set_user_rows(1, m=1, constraint=rope)
    world.add(mass=1, inertia=1)
    with pytest.raises(nsdae.ArgumentError, match="mass is missing"):
        world.system()


def test_user_contacts():
    """A bead on a vertical guide, of one's own, falls onto a body at rest on the floor; by formulas and by blocks."""
    def mass(t, q, M):
        M[0, 0] = 1

    def weight(t, q, v, F):
        F[3] -= G

    def gap(t, q, g):
        g[0] = q[3] - q[1]

    def tangent(t, q, W):
        W[0, 0] = 1

    world = Bodies(2, gravity=(0, -G))
    floor = world.add_solid(GROUND, Solid("plane"))
    ball = world.add(mass=1, inertia=0.1, position=(0, 0.5))
    world.add_contact(world.add_solid(ball, Solid("disc", radius=0.5)), floor)
    world.set_user_rows(1, k=1, mass=mass, force=weight, gap=gap, gap_tangent=tangent)
    system = world.system()
    system.set_contact(1, e_n=0)
    q, v = world.start()
    q[3] = 1
    run = nsdae.solve(system, 2, q, v, dt=1e-3)
    assert run.q[-1, 3] == pytest.approx(0.5, abs=1e-4)
    assert run.contacts["normal_impulse"][-1] == pytest.approx(G * 1e-3) or run.q[-1, 1] == pytest.approx(0.5, abs=1e-4)


DROPPED = """
import nsdae
world = nsdae.Bodies(2, gravity=(0, -9.81))
ball = world.add(mass=1, inertia=1, position=(0, 1))
rod = world.add(mass=1, inertia=1 / 12, position=(5.5, 0))
hinge = world.add_joint("revolute", nsdae.GROUND, rod, point=(5, 0))
floor = world.add_solid(nsdae.GROUND, nsdae.Solid("plane"))
round = world.add_solid(ball, nsdae.Solid("disc", radius=0.1, material=1))
world.add_sensor("coordinate", "angle", joint=hinge)
world.add_sensor("position", "ball", body=ball)
world.set_pair(0, 1, e_n=0.9) if listed else world.add_contact(floor, round, e_n=0.9)
"""


@pytest.mark.parametrize("listed", (False, True))
def test_output_of_a_killed_run(tmp_path, listed):
    """The file is there while the run goes on, and after it was killed; it has all records but those of the last second."""
    import signal
    import subprocess
    import sys
    import time
    path = tmp_path / "run.h5"
    code = f"listed = {listed}" + DROPPED + f"nsdae.solve(world, 1e9, output={str(path)!r}, dt=1e-3, every=10)"
    run = subprocess.Popen([sys.executable, "-c", code])
    try:
        end = time.monotonic() + 60
        while time.monotonic() < end and not (path.exists() and len(nsdae.load(path).time) > 1):
            time.sleep(0.05)
        for _ in range(12):  # whole at any time
            time.sleep(0.1)
            assert nsdae.load(path).status == "running"
    finally:
        run.send_signal(signal.SIGKILL)
        killed = time.time()
        run.wait()
    left = nsdae.load(path)
    assert killed - path.stat().st_mtime < 1.5 and left.status == "running" and len(left.time) > 100
    namespace = {"listed": listed}
    exec(DROPPED, namespace)
    run = nsdae.solve(namespace["world"], left.time[-1], dt=1e-3, every=10)
    assert len(run.time) == len(left.time)
    for name in ("time", "q", "v", "multiplier", "kinetic", "dissipated", "contact_count"):
        assert np.array_equal(getattr(left, name), getattr(run, name))
    for name in ("angle", "ball"):
        assert np.array_equal(left[name], run[name])
    for name in ("impacts", "contacts"):
        assert len(getattr(left, name)) > 0 and np.array_equal(getattr(left, name), getattr(run, name))


def test_output_is_replaced(tmp_path):
    path = tmp_path / "run.h5"
    path.write_bytes(b"of another program")
    (tmp_path / "run.h5.part").write_bytes(b"of a run that was killed")
    whole = Bodies(2, gravity=(0, -G))
    whole.add_joint("revolute", GROUND, whole.add(mass=1, inertia=1 / 12, position=(0.5, 0)))
    run = nsdae.solve(whole, 0.1, dt=1e-3, output=path)
    again = nsdae.load(path)
    assert again.status == "complete" and np.array_equal(again.q, run.q)
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]
    other = Bodies(2)
    other.add(1, 1)
    with pytest.raises(OSError):
        nsdae.solve(other, 1, output=tmp_path / "no/such/folder/run.h5")


def test_output_replaces_names_alone(tmp_path, monkeypatch):
    """Files that had the names of an output keep their content under other names, however often the output grows."""
    monkeypatch.setattr("nsdae._sim._PAUSE", 0.0)
    old = [tmp_path / "old.h5", tmp_path / "linked.h5", tmp_path / "old.part"]
    for file in old:
        file.write_bytes(b"of another program")
    os.link(old[0], tmp_path / "run.h5")
    os.link(old[2], tmp_path / "run.h5.part")
    os.symlink(old[1], tmp_path / "link.h5")
    for name in ("run.h5", "link.h5"):
        world = Bodies(2, gravity=(0, -G))
        world.add(mass=1, inertia=1)
        nsdae.solve(world, 0.01, dt=1e-3, output=tmp_path / name)
        assert len(nsdae.load(tmp_path / name).time) == 11
    assert all(file.read_bytes() == b"of another program" for file in old)


def test_names():
    """In messages and files; materials by name, and a name that is misspelt."""
    world = Bodies(2, gravity=(0, -G))
    floor = world.add_solid(GROUND, Solid("plane", material="ice", name="lake"))
    rod = world.add(mass=1, inertia=1 / 12, position=(0, 0.1), name="puck")
    world.add_solid(rod, Solid("disc", radius=0.1, material="rubber"))
    world.set_pair("ice", "rubber", mu=0.1)
    run = nsdae.solve(world, 0.1)
    assert floor == 0 and [shape.name for shape in run.shapes] == ["lake", "puck disc 1"]
    assert run.contact_count[-1] == 1
    with pytest.raises(nsdae.ArgumentError, match="prismatic joint") as told:
        world = Bodies(2)
        puck = world.add(mass=1, inertia=1, name="puck")
        world.add_joint("prismatic", GROUND, puck, axis=(1, 0))
        q, v = world.start()
        nsdae.solve(world, 1, q + (0, 1, 0), v)
    assert 'prismatic joint 0 of body 0 "puck" and the ground' in str(told.value)
    world = Bodies(2)
    world.add_solid(GROUND, Solid("plane", material="steel"))
    world.add_solid(world.add(1, 1), Solid("disc", radius=1, material="ice"))
    world.set_pair("stel", "ice")
    with pytest.warns(nsdae.ModelWarning, match="material 'stel' has no solid; did you mean 'steel'?"):
        world.system()
    for wrong in ("two words", "", "x" * 24, "puck"):
        world = Bodies(2)
        world.add(1, 1, name="puck")
        if wrong:
            with pytest.raises(nsdae.ArgumentError, match="name"):
                world.add(1, 1, name=wrong)


def test_colours(tmp_path):
    """Of bodies and solids, in the shapes, in files of both writers, and in pictures."""
    from nsdae.pictures.bodies import colours_of, read_motion

    def world(listed):
        made = Bodies(2, gravity=(0, -10))
        first = made.add(mass=1, inertia=1, colour="#c23b22")
        made.add_solid(first, Solid("disc", radius=0.1))
        made.add_solid(first, Solid("disc", radius=0.1, position=(1, 0), colour="#0000FF"))
        made.add_solid(made.add(mass=1, inertia=1, position=(5, 0)), Solid("disc", radius=0.1))
        made.add_solid(GROUND, Solid("plane", position=(0, -9)))
        if listed:
            made.set_pair(0, 0)
        return made

    expected = ["#c23b22", "#0000FF", "", ""]
    for listed in (False, True):
        path = tmp_path / f"{listed}.h5"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", nsdae.ModelWarning)
            run = nsdae.solve(world(listed), 0.1)
            nsdae.solve(world(listed), 0.1, output=path)
        saved = tmp_path / "saved.h5"
        run.save(saved)
        for file in (saved, path):
            shapes = {shape.name: shape.colour for shape in nsdae.load(file).shapes}
            assert [shapes[shape.name] for shape in run.shapes] == expected
            with h5py.File(file) as data:
                bodies = read_motion(data, str(file), None, np.arange(2))
            assert [colour for colour in colours_of(bodies) if colour in expected] == expected[:2] or listed
            assert {body.colour for body in bodies} == set(expected)
    with pytest.raises(nsdae.ArgumentError, match="six hexadecimal digits"):
        Bodies(2).add(mass=1, inertia=1, colour="red")


def test_a_mesh_and_a_height_field():
    """Balls come to rest on a floor of triangles, and one in a bowl; a closed mesh has the inertia of its box."""
    floor = Solid("mesh", points=[[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], triangle=[[0, 1, 2], [0, 2, 3]], length=0.1)
    x = np.linspace(-1, 1, 21)
    bowl = Solid("height_field", points=0.2 * (x[None, :]**2 + x[:, None]**2), length=(2, 2, 0.1), position=(5, 0, 0))
    world = nsdae.Bodies(3, gravity=(0, 0, -9.81))
    for ground in (floor, bowl):
        world.add_solid(GROUND, ground)
    for place in ((0.3, 0.2, 0.1), (5.0, 0, 0.12)):
        world.add_from_solids([Solid("sphere", radius=0.1, material=1)], 700, place)
    world.set_pair(0, 1, mu=0.5)
    run = nsdae.solve(world, 0.5, method="moreau", dt=1e-3)
    assert abs(run.q[-1, 2] - 0.1) < 1e-4 and abs(run.q[-1, 9] - 0.1) < 2e-3
    assert floor.triangles().shape == (2, 3, 3) and bowl.triangles().shape == (800, 3, 3)
    assert [shape.shape for shape in world.shapes()][:2] == ["polyhedron"] * 2
    corner = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)]) - 0.5
    side = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6],
            [1, 3, 5], [3, 7, 5]]
    mass, inertia = Solid("mesh", points=corner, triangle=side, length=1).inertia(6)
    assert mass == pytest.approx(6) and inertia == pytest.approx([1, 1, 1])
    with pytest.raises(nsdae.ArgumentError, match="a body is a closed surface"):
        Solid("mesh", points=corner, triangle=side[:-1], length=1).inertia(6)
    with pytest.raises(ValueError, match="three whole numbers in each row"):
        Solid("mesh", points=corner, triangle=[[0, 1]], length=1).inertia(6)


def test_mesh_files(tmp_path):
    """A cube of each format has the inertia of its box and eight points; errors name the file."""
    corner = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    side = np.array([[f[0], f[i], f[i + 1]] for f in faces for i in (1, 2)])
    obj, text, binary = tmp_path / "a.obj", tmp_path / "b.stl", tmp_path / "c.stl"
    obj.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corner) + "".join("f " + " ".join(str(i + 1) for i in f) + "\n" for f in faces))
    loops = ("".join(f" vertex {x} {y} {z}\n" for x, y, z in corner[t]) for t in side)
    text.write_text("solid\n" + "".join(f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops) + "endsolid\n")
    record = np.zeros(len(side), dtype=[("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("", "<u2")])
    record["corner"] = corner[side]
    binary.write_bytes(bytes(80) + np.uint32(len(side)).tobytes() + record.tobytes())
    for path in (obj, text, str(binary)):
        mesh = nsdae.read_mesh(path, scale=0.5, length=0.1, material="stone")
        assert mesh.points.shape == (8, 3) and mesh.triangle.shape == (12, 3) and mesh.material == "stone"
        np.testing.assert_array_equal(mesh.points[mesh.triangle], 0.5 * corner[side])
        mass, inertia = mesh.inertia(6)
        assert mass == pytest.approx(6, rel=1e-14) and inertia == pytest.approx([1, 1, 1], rel=1e-14)
    obj.write_text("v 0 0 0\nv 0 x 0\n")
    with pytest.raises(nsdae.ArgumentError, match="a.obj' line 2: 'x' instead of a coordinate"):
        nsdae.read_mesh(obj)
    with pytest.raises(nsdae.ArgumentError, match="0.001 for millimetres"):
        nsdae.read_mesh(text, scale=0)
    with pytest.raises(nsdae.Error, match="none.obj"):
        nsdae.read_mesh(tmp_path / "none.obj")
    obj.write_bytes(b"v \xff\xfe 0 0\n")
    with pytest.raises(nsdae.ArgumentError, match="a.obj' line 1: '\ufffd\ufffd' instead of a coordinate"):
        nsdae.read_mesh(obj)
    for end in (".obj", "a.obj"):  # in one of both the text begins within a character
        with pytest.raises(nsdae.Error, match="'\ufffd?é+a?.obj'"):
            nsdae.read_mesh(tmp_path / ("é" * 100 + end))


def test_mesh_files_of_trimesh(tmp_path):
    """Surfaces that trimesh writes; their coordinates are multiples of 1/64, exact in each format."""
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not here")
    random = np.random.default_rng(7)
    for count in (4, 10, 100):
        points = random.integers(-4096, 4096, size=(count, 3)) / 64
        made = trimesh.Trimesh(points, [random.permutation(count)[:3] for _ in range(2 * count)])
        for name, kind in (("a.obj", "obj"), ("b.stl", "stl_ascii"), ("c.stl", "stl")):
            made.export(tmp_path / name, file_type=kind)
            read = nsdae.read_mesh(tmp_path / name)
            np.testing.assert_array_equal(read.points[read.triangle], made.triangles)


def test_a_simulation_keeps_what_it_reads():
    """The natural order of a builder. Free fall is exact: z = 1 - g/2 after 1 s."""

    def build():
        world = Bodies(3, gravity=(0, 0, -G))
        world.add(mass=1, inertia=(1, 1, 1), position=(0, 0, 1))
        sim = nsdae.Sim(world.system())
        sim.init(*world.start())
        return sim

    sim = build()
    gc.collect()
    sim.run(1)
    assert sim.record.q[2] == pytest.approx(1 - G / 2, abs=1e-11)


def test_a_name_that_is_not_there_lists_each_once():
    world = Bodies(2, gravity=(0, -G))
    world.add(mass=1, inertia=1)
    with pytest.raises(KeyError) as caught:
        nsdae.solve(world, 0.1)["zz"]
    assert str(caught.value).count("x0") == 1


def test_a_picture_of_an_unknown_kind_says_why(tmp_path):
    pytest.importorskip("PIL")
    world = Bodies(2, gravity=(0, -G))
    world.add(mass=1, inertia=1)
    with pytest.raises(ValueError, match=r"x\.avi'\): .*\.gif"):
        nsdae.solve(world, 0.1).animate(str(tmp_path / "x.avi"))
