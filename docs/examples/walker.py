"""A walker with four legs. Motors with a limited torque turn its hips and knees; they are steered between the steps."""
from math import cos, pi, sin

import nsdae
from nsdae import GROUND, Bodies, Solid

TRUNK = Solid("box", length=(0.5, 0.2, 0.1), exclude=-1)  # exclude: for mass and pictures alone
THIGH, SHIN = (Solid("capsule", radius=r, length=0.2, exclude=-1) for r in (0.03, 0.025))
FOOT = Solid("sphere", radius=0.025, position=(0, 0, -0.1))
DT, HEIGHT, LINK = 1e-3, 0.5, 0.24  # step [s], height of the hips and length of a link at the start [m]


def add(world, solid, position):
    mass, inertia = solid.inertia(1000)
    body = world.add(mass=mass, inertia=inertia, position=position)
    world.add_solid(body, solid)
    return body


def walker():
    """Bodies; motors 2 i and 2 i + 1 are those of hip and knee of leg i."""
    world = Bodies(3, gravity=(0, 0, -9.81))
    floor = world.add_solid(GROUND, Solid("plane"))
    trunk = add(world, TRUNK, (0, 0, HEIGHT))
    for x, y in ((0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)):
        above = trunk
        for solid, z, low, high in ((THIGH, HEIGHT, -1.2, 1.2), (SHIN, HEIGHT - LINK, -0.1, 2)):
            leg = add(world, solid, (x, y, z - LINK / 2))
            joint = world.add_joint("revolute", above, leg, point=(x, y, z), axis=(0, -1, 0))
            world.add_limit(joint, low, high)
            world.add_motor(joint, "position", limit=40, kp=200, kd=2.5)
            above = leg
        world.add_contact(floor, world.add_solid(leg, FOOT), mu=0.8)
    return world


def steer(sim):
    """Trot: two legs across swing ahead with bent knees, then the others. Longer steps on a side turn it back to yaw 0."""
    yaw, ramp = 2 * sim.record.q[6], min(sim.time / 2, 1)  # about twice the z of its quaternion
    turn = max(min(0.5 * yaw, 0.3), -0.3)
    for leg in range(4):
        phase = 6 * pi * sim.time + (0 if leg in (0, 3) else pi)
        stride = 0.15 * ramp * (1 - turn if leg % 2 else 1 + turn)
        sim.set_control(2 * leg, stride * sin(phase) - 0.25)
        sim.set_control(2 * leg + 1, 0.5 + 0.4 * ramp * max(cos(phase), 0))


if __name__ == "__main__":
    sim = nsdae.Sim(walker(), method="moreau", dt=DT)
    sim.init()
    while sim.time < 6.4:
        steer(sim)
        sim.step()
    print(f"walked {sim.record.q[0]:.0f} m, its trunk is {sim.record.q[2]:.1f} m high")
