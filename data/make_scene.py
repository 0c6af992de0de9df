#!/usr/bin/env python3
"""Writes a scene for nsdae-scene to standard output: bodies that fall from a grid, or a wall of bricks.

The scenes of this folder:

    make_scene.py grid --count 64 --shapes box --seed 1 > scene_boxes.csv
    make_scene.py grid --count 64 --shapes sphere,capsule,box --seed 2 > scene_mixed.csv
    make_scene.py grid --count 64 --shapes tetrahedron,octahedron,icosahedron,dodecahedron,cylinder,cone,ellipsoid --seed 3 > scene_shapes.csv
    make_scene.py wall --length 6 --courses 7 --ball 8 > scene_wall.csv
"""
import argparse
import math
import random

HEADER = "kind,size0,size1,size2,mass,I1,I2,I3,x,y,z,qw,qx,qy,qz,vx,vy,vz,w1,w2,w3"


GOLDEN = (1 + math.sqrt(5)) / 2

# Of regular polyhedra with edges of 1: radius of the sphere through the corners, volume, and a moment of inertia per mass.
REGULAR = {
    "tetrahedron": (math.sqrt(3 / 8), math.sqrt(2) / 12, 1 / 20),
    "octahedron": (math.sqrt(1 / 2), math.sqrt(2) / 3, 1 / 10),
    "icosahedron": (math.sqrt(GOLDEN * math.sqrt(5)) / 2, 5 * GOLDEN**2 / 6, GOLDEN**2 / 10),
    "dodecahedron": (math.sqrt(3) * GOLDEN / 2, (15 + 7 * math.sqrt(5)) / 4, (39 * GOLDEN + 28) / 150),
}

# Sizes of each kind within a ball of radius 1.
SIZES = {"sphere": [0.8, 0, 0], "capsule": [0.6, 0.8, 0], "box": [1.3, 1.1, 0.95], "cylinder": [0.6, 1.2, 0],
         "cone": [0.7, 1.2, 0], "ellipsoid": [1.8, 1.4, 1.0], **{kind: [1, 0, 0] for kind in REGULAR}}


def inertia(kind, size, density):
    """Mass and principal moments about the centre of mass; a capsule's are those of its cylinder and of two half balls."""
    if kind in REGULAR:
        radius, volume, moment = REGULAR[kind]
        edge = size[0] / radius
        mass = density * volume * edge**3
        return mass, [mass * moment * edge**2] * 3
    if kind == "ellipsoid":
        a, b, c = (x / 2 for x in size)
        mass = density * 4 / 3 * math.pi * a * b * c
        return mass, [mass * (b * b + c * c) / 5, mass * (a * a + c * c) / 5, mass * (a * a + b * b) / 5]
    if kind in ("cylinder", "cone"):
        r, h = size[0], size[1]
        mass = density * math.pi * r**2 * h / (1 if kind == "cylinder" else 3)
        across = (3 * r**2 + h**2) / 12 if kind == "cylinder" else 3 * (4 * r**2 + h**2) / 80
        return mass, [mass * across, mass * across, mass * r**2 * (0.5 if kind == "cylinder" else 0.3)]
    if kind == "box":
        a, b, c = size
        mass = density * a * b * c
        return mass, [mass * (b * b + c * c) / 12, mass * (a * a + c * c) / 12, mass * (a * a + b * b) / 12]
    r, length = size[0], size[1]
    rod, ball = density * math.pi * r**2 * length, density * 4 / 3 * math.pi * r**3
    along = rod * r**2 / 2 + 0.4 * ball * r**2
    # a half ball: its centre of mass is 3 r / 8 from its plane
    across = rod * (r**2 / 4 + length**2 / 12) + ball * (0.4 * r**2 + length**2 / 4 + 3 * length * r / 8)
    return rod + ball, [across, across, along]


def turned(rng):
    """Uniform unit quaternion: Shoemake, Uniform random rotations, Graphics Gems III, 1992."""
    u, a, b = rng.random(), 2 * math.pi * rng.random(), 2 * math.pi * rng.random()
    s, c = math.sqrt(1 - u), math.sqrt(u)
    return [c * math.cos(b), s * math.sin(a), s * math.cos(a), c * math.sin(b)]


def grid(count, shapes, seed):
    """Bodies with random sizes and rotations in cells that hold them; walls around the grid."""
    rng = random.Random(seed)
    widest = 0.05  # radius of the sphere around a body
    cell, side = 2.2 * widest, math.ceil((count / 2) ** (1 / 3))
    half = side * cell / 2
    rows = []
    for i in range(count):
        kind, r = shapes[int(len(shapes) * rng.random())], widest * (0.8 + 0.2 * rng.random())
        size = [r * part for part in SIZES[kind]]
        place = [i % side, i // side % side, i // side**2]
        position = [-half + cell * (place[0] + 0.5), -half + cell * (place[1] + 0.5), cell * (place[2] + 0.6)]
        rows.append((kind, size, *inertia(kind, size, 1000), position, turned(rng), [0, 0, 0]))
    return half, 0.5, rows


def wall(length, courses, ball):
    """Bricks in running bond, along y; a ball flies towards them."""
    long, deep, high, gap = 0.2, 0.1, 0.08, 0.001
    rows = []
    for k in range(courses):
        edges = [long * (i + 0.5 * (k % 2)) for i in range(length + 1 - k % 2)]
        edges = sorted({0, length * long, *edges})
        for low, up in zip(edges, edges[1:]):
            size = [deep, up - low - gap, high]
            position = [0, (low + up - length * long) / 2, high * (k + 0.5)]
            rows.append(("box", size, *inertia("box", size, 1800), position, [1, 0, 0, 0], [0, 0, 0]))
    if ball > 0:
        size = [0.12, 0, 0]
        position = [-0.6, 0, 0.6 * courses * high]
        rows.append(("sphere", size, *inertia("sphere", size, 1800), position, [1, 0, 0, 0], [ball, 0, 0]))
    return None, 0.6, rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    falling = commands.add_parser("grid", help="bodies that fall between walls")
    falling.add_argument("--count", type=int, default=64, help="number of bodies")
    falling.add_argument("--shapes", default="sphere,capsule,box", help="some of " + ", ".join(SIZES))
    falling.add_argument("--seed", type=int, default=1, help="of sizes, shapes and rotations")
    bricks = commands.add_parser("wall", help="bricks in running bond")
    bricks.add_argument("--length", type=int, default=6, help="bricks of a course")
    bricks.add_argument("--courses", type=int, default=7, help="number of courses")
    bricks.add_argument("--ball", type=float, default=0, help="speed of a ball that hits the wall [m/s]; 0: none")
    given = parser.parse_args()
    if given.command == "grid":
        what, made = f"{given.count} bodies fall from a grid", grid(given.count, given.shapes.split(","), given.seed)
    else:
        what, made = "a wall in running bond", wall(given.length, given.courses, given.ball)
    half, mu, rows = made
    print(f"# {what}: make_scene.py {' '.join(f'{k}={v}' for k, v in vars(given).items() if k != 'command')}")
    print("# walls: none" if half is None else f"# walls: at x, y = {-half:.9g} and {half:.9g}")
    print(f"# floor: 0\n# mu: {mu}\n# e_N: 0\n# g: 9.81\n# dt: 0.002\n{HEADER}")
    for kind, size, mass, moments, position, quaternion, velocity in rows:
        print(kind, *(f"{x:.9g}" for x in [*size, mass, *moments, *position, *quaternion, *velocity, 0, 0, 0]), sep=",")


if __name__ == "__main__":
    main()
