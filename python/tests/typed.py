"""A program with types, as its author checks it with mypy --strict and pyright."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import nsdae

Array = npt.NDArray[np.float64]


def mass(t: float, q: Array, M: Array) -> None:
    M[0, 0] = 0.1


def force(t: float, q: Array, v: Array, F: Array) -> None:
    F[0] = -0.981


def gap(t: float, q: Array, g: Array) -> None:
    g[0] = q[0]


def pile(count: int) -> nsdae.Bodies:
    world = nsdae.Bodies(2, gravity=(0, -9.81))
    for i in range(count):
        body: int = world.add(mass=1, inertia=0.1, position=(0, 1.5 * i + 0.5), name=f"disc{i}")
        world.add_solid(body, nsdae.Solid("disc", radius=0.5, material="disc"))
    world.add_solid(nsdae.GROUND, nsdae.Solid("plane", material="floor"))
    world.set_pair("disc", "floor", mu=0.3, e_n=0.2)
    return world


options: nsdae.Options = {"method": "moreau", "dt": 1e-2, "start_check": True}
ball = nsdae.System(nq=1, k=1, mass=mass, force=force, gap=gap, e_n=0.5)
worst: nsdae.Worst = ball.check([1.0])
run: nsdae.Trajectory = nsdae.solve(ball, 0.5, q0=[1], dt=1e-3, integrator="auto")
highest = float(run["q0"].max())
piled = nsdae.solve(pile(3), 0.1, **options)
sim = nsdae.Sim(pile(2), method="implicit")
status: nsdae.Status = sim.init()
if status == nsdae.Status.OK:
    for record in sim.steps(0.05):
        height: float = float(record.q[1]) + record.time
sim.set_options(contact_tol=1e-8)
state: bytes = sim.state
try:
    nsdae.lcp(np.eye(2), np.array([-1.0, 1.0]))
except nsdae.ProblemError as error:
    print(error.status is nsdae.Status.E_LCP, error.index)
done = nsdae.sweep(lambda r: r * r, {"r": [1, 2]}, progress=False)
