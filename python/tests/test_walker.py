"""The walker of docs/examples: it walks, within the limits of its joints, and a kept state with its controls goes on with the
same bytes."""

import importlib.util
import os

import numpy as np

import nsdae

PATH = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "examples", "walker.py")


def module():
    spec = importlib.util.spec_from_file_location("walker", PATH)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def walk(walker, sim, t_end):
    q = []
    while sim.time < t_end:
        walker.steer(sim)
        sim.step()
        q.append(sim.record.q)
    return np.array(q)


def test_both_methods():
    """moreau and implicit agree, and the energy balance of both is closed: no warning."""
    walker, ends = module(), []
    for method in ("moreau", "implicit"):
        sim = nsdae.Sim(walker.walker(), method=method, dt=walker.DT)
        sim.init()
        ends.append(walk(walker, sim, 2)[-1])
        assert sim.stats["warnings"] == 0
    assert ends[0][0] > 0.6 and np.abs(ends[0][:3] - ends[1][:3]).max() < 0.1


def test_walker():
    walker = module()
    with open(PATH, encoding="utf-8") as file:
        assert len(file.readlines()) <= 60
    sim = nsdae.Sim(walker.walker(), method="moreau", dt=walker.DT)
    sim.init()
    q = walk(walker, sim, 1)
    kept = sim.state
    on = walk(walker, sim, 4)
    q = np.concatenate([q, on]).reshape(-1, 9, 7)
    trunk = q[:, 0]
    assert trunk[-1, 0] > 1.5 and np.abs(trunk[:, 1]).max() < 0.3 and trunk[:, 2].min() > 0.4
    assert (1 - 2 * (trunk[:, 4] ** 2 + trunk[:, 5] ** 2)).min() > 0.9  # z of its own z axis
    for leg in range(4):  # rotations about -y of thigh and shin, relative to the body above
        for above, body, low, high in ((0, 1 + 2 * leg, -1.2, 1.2), (1 + 2 * leg, 2 + 2 * leg, -0.1, 2)):
            angle = [-2 * (np.arctan2(p[5], p[3]) - np.arctan2(o[5], o[3])) for o, p in zip(q[:, above], q[:, body])]
            angle = np.remainder(np.array(angle) + np.pi, 2 * np.pi) - np.pi
            assert low - 0.05 < angle.min() and angle.max() < high + 0.05
    assert sim.stats["worst_drift"] < 1e-3 * walker.LINK
    sim.state = kept
    assert walk(walker, sim, 1.2).tobytes() == on[:200].tobytes()
