"""Pickle: a copy in this or another process continues with the same bytes."""

import copy
import ctypes
import multiprocessing
import os
import pickle
import shutil

import numpy as np
import pytest

import nsdae
from conftest import G, compiled_ball
from test_pointers import cffi_ball, numba_ball, scipy_ball
from test_scenes import DATA


def mass(t, q, M):
    M[0, 0] = 0.1


def force(t, q, v, F):
    F[0] = -0.1 * G


def gap(t, q, g):
    g[0] = q[0]


def python_ball(library):
    return {"mass": mass, "force": force, "gap": gap}


def drive(t, f):
    f[:] = np.sin(3 * t), 3 * np.cos(3 * t), -9 * np.sin(3 * t)


def load(t, position, velocity, force, torque):
    force[0] = -position[0]


def drum_mass(t, q, M):
    M[0, 0] = 2


def again(thing):
    return pickle.loads(pickle.dumps(thing))


def mechanism():
    """Every element of the kit that has a callback or a number of its own."""
    world = nsdae.Bodies(3, gravity=(0, 0, -G))
    for i in range(4):
        body = world.add(1 + 0.1 * i, (0.1, 0.2, 0.15), (0, 0, 0.6 + 1.1 * i), spin=(0.1 * i, 0.2, 0), name=f"body{i}")
        world.add_solid(body, nsdae.Solid("sphere", radius=0.5, material="rubber", colour="#112233"))
    world.add_solid(nsdae.GROUND, nsdae.Solid("plane", material="floor"))
    world.set_pair("rubber", "floor", mu=0.3, e_n=0.1)
    world.set_pair("rubber", "rubber", mu=0.9)
    world.set_pair("rubber", "rubber", mu=0.4, e_n=0.2)
    arm = world.add(1, (1, 1, 1), (3, 0, 0))
    hinge = world.add_joint("revolute", nsdae.GROUND, arm, point=(2, 0, 0), axis=(0, 1, 0))
    world.add_motor(hinge, "position", drive, kp=10, kd=1)
    world.add_motor(hinge, "force", 0.5)
    world.add_limit(hinge, -1, 1)
    world.add_load(0, load)
    world.add_sensor("coordinate", "angle", joint=hinge)
    world.set_user_rows(nq=1, mass=drum_mass)
    return world


def run(system, start=(1.0,), **options):
    return nsdae.solve(system, 1, start, **options)


def same(a, b):
    return all(getattr(a, name).tobytes() == getattr(b, name).tobytes()
               for name in ("time", "q", "v", "contacts", "impacts", "dissipated"))


@pytest.mark.parametrize("make", [python_ball, compiled_ball, cffi_ball, scipy_ball, lambda library: numba_ball()],
                         ids=["python", "ctypes", "cffi", "scipy", "numba"])
def test_a_system_of_each_kind_of_callback(library, make):
    system = nsdae.System(nq=1, k=1, names={"coordinate": [("y", "m")]}, **make(library))
    system.set_contact(0, e_n=0.9)
    system.set_contact(0, e_n=0.5)
    copied = again(system)
    assert copied.dims == system.dims and copied.names("coordinate") == [("y", "m")]
    assert same(run(copied), run(system))
    assert same(run(again(copied)), run(copy.deepcopy(system)))


def test_user_goes_along(library):
    mine = np.array([0.025])
    system = nsdae.System(nq=1, k=1, e_n=0.5, user=mine, **compiled_ball(library))
    before = run(system)
    copied = again(system)
    mine[0] = 7
    assert same(run(copied), before)
    with pytest.raises(TypeError, match="mass cannot be pickled: user is an address"):
        pickle.dumps(nsdae.System(nq=1, k=1, user=mine.ctypes.data, **compiled_ball(library)))


def test_code_without_a_name_is_refused():
    made = nsdae.signature("mass", "ctypes")(lambda t, q, M, ldm, user: 0)
    with pytest.raises(TypeError, match="mass cannot be pickled: its address is no exported symbol"):
        pickle.dumps(nsdae.System(nq=1, mass=made, force=force))


def test_bodies_and_their_system():
    world = mechanism()
    draft = again(world)  # before its system is built
    system = world.system()
    options = {"method": "moreau", "dt": 1e-2}
    whole = nsdae.solve(world, 1, **options)
    assert len(whole.contacts) and np.ptp(whole.sensors["angle"]) > 0.1
    for copied in (draft, again(world), again(again(world))):
        assert same(nsdae.solve(copied, 1, **options), whole)
        assert copied.shapes() == world.shapes()
    assert same(nsdae.solve(again(system), 1, *world.start(), **options), whole)


def test_a_scene_without_its_file(tmp_path):
    path = tmp_path / "scene.csv"
    shutil.copy(os.path.join(DATA, "scene_mixed.csv"), path)
    world = nsdae.read_scene(path)
    block = pickle.dumps(world)
    path.unlink()
    options = {"method": "moreau", "dt": world.scene.dt, "contact_tol": 1e-4}
    assert same(nsdae.solve(pickle.loads(block), 0.02, **options), nsdae.solve(world, 0.02, **options))


def finished(sim):
    """In another process."""
    return sim.record_run(1.5), sim.state


def started(**options):
    sim = nsdae.Sim(mechanism(), method="moreau", dt=1e-2, **options)
    sim.set_control(1, 0.25)
    sim.init()
    sim.run(0.7)
    sim.set_options(dt=5e-3)
    sim.set_control(1, -0.5)
    return sim


def test_a_simulation_continues_in_another_process():
    sim = started()
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        there, state = pool.map(finished, [sim, sim])[1]
    assert same(there, sim.record_run(1.5)) and state == sim.state


def test_a_simulation_that_was_never_started():
    sim = again(nsdae.Sim(nsdae.System(nq=1, k=1, e_n=0.5, **python_ball(None)), dt=2e-3, method="event"))
    with pytest.raises(nsdae.Error):
        sim.state
    sim.init([1])
    assert sim.options["dt"] == 2e-3 and sim.run(0.1) == nsdae.Status.OK


def test_coefficients_of_a_simulation():
    system = nsdae.System(nq=1, k=1, e_n=0.5, **python_ball(None))
    sim = nsdae.Sim(system)
    sim.set_contact(0, e_n=0.8)
    sim.init([1])
    assert same(again(sim).record_run(1.2), sim.record_run(1.2))


@pytest.mark.parametrize("make", [compiled_ball, lambda library: numba_ball()], ids=["ctypes", "numba"])
def test_joblib(library, make):
    joblib = pytest.importorskip("joblib", reason="joblib is not here")
    system = nsdae.System(nq=1, k=1, e_n=0.5, user=ctypes.c_double(0.1), **make(library))
    runs = joblib.Parallel(n_jobs=2)(joblib.delayed(nsdae.solve)(system, 1, [height]) for height in (1, 2))
    assert all(same(got, run(system, [height])) for got, height in zip(runs, (1, 2)))


def test_results_and_errors():
    whole = nsdae.solve(mechanism(), 0.5, method="moreau", dt=1e-2)
    assert same(again(whole), whole) and again(whole).shapes == whole.shapes
    with pytest.raises(nsdae.Error) as caught:
        nsdae.solve(nsdae.System(nq=1, mass=mass, force=load), 1, [0])
    assert str(again(caught.value)) == str(caught.value) and again(caught.value).status == caught.value.status
