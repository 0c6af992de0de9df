"""python -m nsdae demo: a row of dominoes, as a page that plays in any browser."""

from __future__ import annotations

import argparse
import colorsys
import math
import os
import sys
import time
import webbrowser

from . import GROUND, Bodies, Solid, Trajectory, __version__, solve

COUNT, DISTANCE = 36, 0.38  # of dominoes; between two [m]
DOMINO = (0.08, 0.4, 0.8)  # [m]
DENSITY = 600.0  # of wood [kg/m^3]
BALL, RADIUS = 20.0, 0.15  # [kg], [m]


def dominoes() -> Bodies:
    """Dominoes on a spiral r = 1.2 + 0.16 angle, and a ball that meets the first at 4 m/s."""
    world = Bodies(3, gravity=(0, 0, -9.81))
    world.add_solid(GROUND, Solid("plane", material="ground"))
    angle = 0.0
    for i in range(COUNT):
        r, half = 1.2 + 0.16 * angle, angle % math.pi / 2 - math.pi / 4  # turned to the tangent: a domino has two fronts
        red, green, blue = (round(255 * c) for c in colorsys.hls_to_rgb(0.58 - 0.5 * i / COUNT, 0.5, 0.6))
        piece = Solid("box", length=DOMINO, material="domino", colour=f"#{red:02x}{green:02x}{blue:02x}")
        world.add_from_solids([piece], DENSITY, (r * math.cos(angle), r * math.sin(angle), DOMINO[2] / 2),
                              quaternion=(math.cos(half), 0, 0, math.sin(half)))
        angle += DISTANCE / r
    ball = world.add(BALL, [0.4 * BALL * RADIUS**2] * 3, (1.2, -1, 0.75), velocity=(0, 4, 0), name="ball")
    world.add_solid(ball, Solid("sphere", radius=RADIUS, material="ball", colour="#444444"))
    world.set_pair("domino", "domino", mu=0.2)
    world.set_pair("domino", "ground", mu=0.6)
    world.set_pair("ball", "domino", mu=0.3, e_n=0.3)
    world.set_pair("ball", "ground", mu=0.3, e_n=0.5)
    return world


def demo() -> Trajectory:
    """The run of the demonstration: 5 s, in 1 s; with 50 records a second."""
    return solve(dominoes(), 5, method="moreau", dt=2e-3, every=10, model="dominoes")


def has_screen() -> bool:
    """Whether a browser with pictures can open."""
    return sys.platform in ("darwin", "win32") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m nsdae", description="nsdae, non-smooth multibody dynamics")
    parser.add_argument("--version", action="version", version=f"nsdae {__version__}")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="demo")
    shown = verbs.add_parser("demo", help="a row of dominoes: writes a page that plays in any browser, without network")
    shown.add_argument("-o", "--output", default="nsdae-demo.html", metavar="FILE", help=".html, or .gif with nsdae[plot] (default %(default)s)")
    shown.add_argument("--no-browser", action="store_true", help="do not open it")
    told = parser.parse_args()
    begin = time.perf_counter()
    run = demo()
    print(f"{len(run.shapes)} shapes, {run.time[-1]:g} s simulated in {time.perf_counter() - begin:.1f} s", flush=True)
    try:
        run.animate(told.output)
    except (ImportError, OSError, ValueError) as error:
        print(f"python -m nsdae: error: {error}", file=sys.stderr)
        return 1
    page = os.path.abspath(told.output)
    print(f"open {page}")
    if not told.no_browser and has_screen():
        webbrowser.open(f"file://{page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
