"""What the examples look like: for each model a function of its parameters and q [n, nq] that
gives its bodies. Lengths are the model's; thicknesses, which it does not have, are fractions of
them. Hanging bodies have their own frame's -y along the rod, as the models' angles count from there."""

import numpy as np

from shapes import Body, about_z, box, cylinder, planar, prism, ring, rotation_by, rotations_by, sphere, tilted


def bar(length, width):
    return box(width, length, width)


def pendulum(p, q):
    width = p["L"] / 20
    stop = [-width, -p["L"], 0]  # its right face is where the rod, hanging, has its left one
    return [
        Body("rod", bar(p["L"], width), planar(q[:, 0], q[:, 1]), about_z(q[:, 2])),
        Body("pivot", cylinder(width, 2 * width), np.zeros(3)),
        Body("stop", box(width, 2 * width, 2 * width), np.array(stop)),
    ]


def clearance_hinge(p, q):
    l, depth = p["l"], p["R"]
    turned = about_z(q[:, 2])
    end = planar(q[:, 0] - l / 2 * np.sin(q[:, 2]), q[:, 1] + l / 2 * np.cos(q[:, 2]))
    return [
        Body("rod", bar(l, p["r"]), planar(q[:, 0], q[:, 1]), turned),
        Body("shaft", cylinder(p["r"], 2 * depth), end, turned),
        Body("hole", ring(p["R"], 1.3 * p["R"], depth), np.zeros(3)),
    ]


def crank_slider(p, q):
    width = (p["L1"] + p["L2"]) / 40
    crank, rod = ([np.sin(a), -np.cos(a)] for a in (q[:, 0], q[:, 1]))
    pin = [p["L1"] * x for x in crank]
    slider = [a + p["L2"] * b for a, b in zip(pin, rod)]
    low, high = slider[1].min() - 4 * width, slider[1].max() + 4 * width
    guide = box(width, high - low, 3 * width)
    return [
        Body("crank", bar(p["L1"], width), planar(*(x / 2 for x in pin)), about_z(q[:, 0])),
        Body("rod", bar(p["L2"], width), planar(*((a + b) / 2 for a, b in zip(pin, slider))), about_z(q[:, 1])),
        Body("slider", box(3 * width, 4 * width, 3 * width), planar(*slider)),
        Body("left guide", guide, np.array([-2 * width, (low + high) / 2, 0])),
        Body("right guide", guide, np.array([2 * width, (low + high) / 2, 0])),
    ]


def incline(p, q):
    """The plane's axes are turned by the slope about the horizontal line in it, so that gravity is
    along -z: z x (the direction of the fall) = (-sin turn, cos turn, 0)."""
    tilt = rotation_by(p["slope"] * np.array([-np.sin(p["turn"]), np.cos(p["turn"]), 0]))
    low, high = q.min(axis=0), q.max(axis=0)
    size = max(0.1 * np.linalg.norm(high - low), 0.02)
    edge, middle = high - low + 4 * size, (high + low) / 2
    return [
        Body("block", box(size, size, size), (q + [0, 0, size / 2]) @ tilt.T, tilt),
        Body("plane", box(edge[0], edge[1], size / 4), tilt @ [middle[0], middle[1], -size / 8], tilt),
    ]


def rolling_ball(p, q):
    turned, r = rotations_by(q[:, 3:6]), p["r"]
    low, high = q[:, :2].min(axis=0) - 3 * r, q[:, :2].max(axis=0) + 3 * r
    middle = (low + high) / 2
    return [
        Body("ball, light", sphere(r, dark=False), q[:, :3], turned),
        Body("ball, dark", sphere(r, dark=True), q[:, :3], turned),
        Body("plane", box(high[0] - low[0], high[1] - low[1], r / 4), np.array([middle[0], middle[1], -r / 8])),
    ]


def bouncing_ball(p, q):
    """The coordinate is the height of the ball's lowest point."""
    r = p["h0"] / 20
    return [
        Body("ball", sphere(r), planar(np.zeros(len(q)), q[:, 0] + r)),
        Body("floor", box(10 * r, r, 10 * r), np.array([0, -r / 2, 0])),
    ]


def falling_rod(p, q):
    """The angle counts from the floor."""
    l, low, high = p["l"], q[:, 0].min(), q[:, 0].max()
    return [
        Body("rod", box(2 * l, l / 40, l / 20), planar(q[:, 0], q[:, 1]), about_z(q[:, 2])),
        Body("floor", box(high - low + 3 * l, l / 20, l / 2), np.array([(low + high) / 2, -l / 40, 0])),
    ]


def newtons_cradle(p, q):
    """Balls of radius L / 10, q from where they hang; they rise by q^2 / 2 L, as their potential has it."""
    r = p["L"] / 10
    rise = q**2 / (2 * p["L"]) if p["g"] > 0 else 0 * q
    return [Body(f"ball {i + 1}", sphere(r), planar(i * (2 * r + p["gap"]) + q[:, i], rise[:, i]))
            for i in range(q.shape[1])]


def woodpecker(p, q):
    """Tilts are small in the model: x + phi y stands for a rotation here too, so that what touches in
    the model touches in the picture."""
    y, sleeve, bird = q.T
    upright = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # along y what was along z
    low, high = y.min() - 6 * p["h_M"], y.max() + 6 * p["h_M"]
    spring = y + p["l_M"] * sleeve
    outline = np.array([[-1, 1], [-0.1, -1], [0.5, -0.8], [0.3, 1]]) * [p["l_S"], p["h_S"]]
    return [
        Body("pole", cylinder(p["r_0"], high - low), np.array([0, (low + high) / 2, 0]), upright),
        Body("sleeve", ring(p["r_M"], 1.5 * p["r_M"], 2 * p["h_M"]), planar(0 * y, y), tilted(sleeve) @ upright),
        Body("spring", box(p["l_G"], p["r_0"] / 2, p["r_0"] / 2),
             planar(0 * y + p["l_M"] + p["l_G"] / 2, spring + p["l_G"] / 2 * bird), tilted(bird)),
        Body("bird", prism(outline, 2 * p["r_M"]),
             planar(0 * y + p["l_M"] + p["l_G"], spring + p["l_G"] * bird), tilted(bird)),
    ]


MODELS = {
    "pendulum": pendulum,
    "clearance-hinge": clearance_hinge,
    "crank-slider": crank_slider,
    "incline": incline,
    "rolling-ball": rolling_ball,
    "bouncing-ball": bouncing_ball,
    "falling-rod": falling_rod,
    "newtons-cradle": newtons_cradle,
    "woodpecker": woodpecker,
}


def points(columns, q):
    """A ball for each triple of columns of q (None: zero), a fiftieth of where they go in size."""
    where = [np.column_stack([np.zeros(len(q)) if c is None else q[:, c] for c in xyz]) for xyz in columns]
    extent = np.ptp(np.concatenate(where), axis=0).max()
    return [Body(f"point {i + 1}", sphere(extent / 50 or 0.01), x) for i, x in enumerate(where)]
