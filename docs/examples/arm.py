"""A robot arm with three position motors pushes a box over the floor."""
import nsdae
from nsdae import GROUND, Bodies, Solid

LINK = Solid("capsule", radius=0.04, length=0.42, exclude=-1)  # exclude: for mass and pictures alone


def add(world, solid, position, quaternion=(1, 0, 0, 0)):
    mass, inertia = solid.inertia(1000)
    body = world.add(mass=mass, inertia=inertia, position=position, quaternion=quaternion)
    world.add_solid(body, solid)
    return body


def arm():
    """A column that turns, upper arm and forearm, which stand up at the start; a hand at the end touches the box."""
    world = Bodies(3, gravity=(0, 0, -9.81))
    world.add_solid(GROUND, Solid("plane"))
    column = add(world, Solid("cylinder", radius=0.08, length=0.3, exclude=-1), (0, 0, 0.15))
    upper, fore = add(world, LINK, (0, 0, 0.55)), add(world, LINK, (0, 0, 1.05))
    hand = Solid("sphere", radius=0.06, position=(0, 0, 0.25), material=1)
    world.add_solid(fore, hand)
    for parent, body, z, axis, target, kd in ((GROUND, column, 0, (0, 0, 1), 1.4, 400),
                                              (column, upper, 0.3, (0, 1, 0), 1.15, 60), (upper, fore, 0.8, (0, 1, 0), 1.1, 60)):
        joint = world.add_joint("revolute", parent, body, point=(0, 0, z), axis=axis)
        world.add_motor(joint, "position", limit=150, target=target, kp=400, kd=kd)
    mass, inertia = Solid("box", length=(0.2, 0.2, 0.2)).inertia(200)
    box = world.add(mass=mass, inertia=inertia, position=(0.62, 0.52, 0.1), name="box")
    world.add_solid(box, Solid("box", length=(0.2, 0.2, 0.2), material=2))
    world.set_pair(0, 2, mu=0.3)
    world.set_pair(1, 2, mu=0.3)
    return world, box


if __name__ == "__main__":
    world, box = arm()
    run = nsdae.solve(world, 3, method="moreau", dt=1e-3)
    start, end = run.q[0, 7 * box : 7 * box + 2], run.q[-1, 7 * box : 7 * box + 2]
    print(f"the box moved from ({start[0]:.2f}, {start[1]:.2f}) to ({end[0]:.2f}, {end[1]:.2f}) m")
