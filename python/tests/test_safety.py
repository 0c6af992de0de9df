"""One call at a time uses a simulation; what the program keeps is released; what is not meant is refused."""

import gc
import os
import pathlib
import re
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest

import nsdae
from conftest import G, ball_callbacks
from nsdae._errors import in_python

SIM_METHODS = ["implicit", "implicit-printed", "moreau", "penalty", "event"]
STATE = b""  # a block is refused before it is read

CALLS = {
    "step": lambda sim: sim.step(),
    "run": lambda sim: sim.run(5),
    "run_to_event": lambda sim: sim.run_to_event(5),
    "steps": lambda sim: next(sim.steps(5)),
    "record_run": lambda sim: sim.record_run(5),
    "init": lambda sim: sim.init([2.0]),
    "project": lambda sim: sim.project([2.0]),
    "set_options": lambda sim: sim.set_options(dt=0.3),
    "set_contact": lambda sim: sim.set_contact(0, e_n=0.1),
    "set_frictional_joint": lambda sim: sim.set_frictional_joint(0, 0.1),
    "set_friction_bound": lambda sim: sim.set_friction_bound(0, 0.1),
    "set_control": lambda sim: sim.set_control(0, 0.1),
    "interpolate": lambda sim: sim.interpolate(0),
    "state": lambda sim: sim.state,
    "set_state": lambda sim: setattr(sim, "state", STATE),
    "record": lambda sim: sim.record,
    "stats": lambda sim: sim.stats,
    "options": lambda sim: sim.options,
}


def start(method, force=None):
    callbacks = ball_callbacks()
    sim = nsdae.Sim(nsdae.System(nq=1, k=1, e_n=0.5, **{**callbacks, "force": force or callbacks["force"]}), method=method,
                    dt=0.01)
    sim.init([1.0])
    return sim


@pytest.mark.parametrize("method", SIM_METHODS)
def test_calls_of_a_callback(method):
    """Refused, of its own thread and of another, and the run has the same bits as without."""
    refused, attack = [], [None]

    def call():
        try:
            CALLS[attack[0]](sim)
            refused.append(None)
        except nsdae.Error as error:
            refused.append(error.status)

    def force(t, q, v, F):
        F[0] = -0.1 * G
        if not attack[0]:
            return
        call()
        if len(refused) % 10 == 0:
            other = threading.Thread(target=call)
            other.start()
            other.join()

    alone = start(method)
    alone.run(0.6)
    sim = start(method, force)
    for name in CALLS:
        attack[0] = None
        sim.init([1.0])
        attack[0] = name
        sim.run(0.6)
        attack[0] = None
        assert sim.state == alone.state
    assert len(refused) > 100 and set(refused) == {nsdae.Status.E_STATE}


@pytest.mark.parametrize("method", SIM_METHODS)
def test_threads_on_one_simulation(method):
    """Each call is done or refused: the steps that were done are the run."""
    sim, before = start(method), sys.getswitchinterval()
    done, wrong = [], []

    def hammer(seed):
        draw = np.random.default_rng(seed)
        names = ["state", "record", "stats", "options", "interpolate"]
        for _ in range(150):
            step = draw.random() < 0.5
            try:
                if step:
                    sim.step()
                    done.append(1)
                else:
                    CALLS[names[draw.integers(len(names))]](sim)
            except nsdae.Error as error:
                if error.status != nsdae.Status.E_STATE and error.argument != "t":
                    wrong.append(error)

    threads = [threading.Thread(target=hammer, args=(seed,)) for seed in range(6)]
    sys.setswitchinterval(1e-5)
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(before)
    assert not wrong and sim.record.step == len(done)
    alone = start(method)
    for _ in done:
        alone.step()
    assert np.array_equal(sim.record.q, alone.record.q) and np.array_equal(sim.record.v, alone.record.v)


def test_a_recording_belongs_to_its_call():
    """A second thread that records the same simulation is refused, and the first one has every record."""
    other = []

    def force(t, q, v, F):
        F[0] = -0.1 * G
        if t > 0.2 and not other:
            def record():
                try:
                    sim.record_run(1)
                except nsdae.Error as error:
                    other.append(error.status)
            thread = threading.Thread(target=record)
            thread.start()
            thread.join()

    sim = start("moreau", force)
    run = sim.record_run(0.5)
    assert other == [nsdae.Status.E_STATE] and len(run.time) == 51 and run.time[-1] == 0.5


def test_a_callback_is_not_replaced_during_a_check():
    caught = []

    def force(t, q, v, F):
        F[0] = 1
        try:
            system.set(force=lambda t, q, v, F: None)
        except nsdae.Error as error:
            caught.append(error.status)

    system = nsdae.System(nq=1, k=1, **{**ball_callbacks(), "force": force})
    system.check([1.0])
    assert set(caught) <= {nsdae.Status.E_STATE}
    caught.clear()
    system.set(mass=lambda t, q, M: (M.fill(1), force(t, q, q, np.zeros(1)))[0])
    system.check([1.0])
    assert caught and set(caught) == {nsdae.Status.E_STATE}


@pytest.mark.parametrize("code", [2 ** 31, 2 ** 32, 2 ** 64, -2 ** 31 - 1])
def test_a_status_that_is_no_int(code):
    with pytest.raises(nsdae.CallbackError, match=re.escape(str(code))):
        nsdae.solve(nsdae.System(nq=1, k=1, **{**ball_callbacks(), "force": lambda t, q, v, F: code}), 1, [1])


@pytest.mark.parametrize("code", [2 ** 31 - 1, -2 ** 31])
def test_a_status_at_the_end_of_int(code):
    with pytest.raises(nsdae.Error) as caught:
        nsdae.solve(nsdae.System(nq=1, k=1, **{**ball_callbacks(), "force": lambda t, q, v, F: code}), 1, [1])
    assert caught.value.code == code


def test_texts_with_nul(ball):
    for options in ({"dt\0": 1}, {"method": "moreau\0"}, {"method\0x": "moreau"}):
        with pytest.raises(nsdae.ArgumentError, match="NUL"):
            nsdae.Sim(ball, **options)
    sim = nsdae.Sim(ball)
    with pytest.raises(nsdae.ArgumentError, match="NUL"):
        sim.set_options(dt="0.1\0")
    for name in ("a\0b", ("a", "m\0")):
        with pytest.raises(nsdae.ArgumentError, match="NUL"):
            nsdae.System(nq=1, k=1, names={"coordinate": [name]}, **ball_callbacks())


def test_switches(ball):
    for given, said in ((False, "no"), (True, "yes"), (np.False_, "no"), ("yes", "yes")):
        assert nsdae.Sim(ball, start_check=given).options["start_check"] == said
    with pytest.raises(nsdae.ArgumentError, match="no, yes"):
        nsdae.Sim(ball, start_check=2)


def test_unknown_keywords(ball):
    with pytest.raises(nsdae.ArgumentError, match="did you mean 'method'"):
        nsdae.Sim(ball, metod="moreau")
    for name in ("step", "timestep"):
        with pytest.raises(nsdae.ArgumentError, match=r"did you mean 'dt' \(time step\)"):
            nsdae.solve(ball, 1, [1], **{name: 0.1})
    with pytest.raises(TypeError, match="did you mean 'force'"):
        nsdae.System(nq=1, forces=ball_callbacks()["force"])


def pendulum_of_bodies():
    world = nsdae.Bodies(2, gravity=(0, -G))
    rod = world.add(mass=1, inertia=1 / 12, position=(0.5, 0), spin=1, velocity=(0, 0.5))
    world.add_joint("revolute", nsdae.GROUND, rod, point=(0, 0))
    world.add_solid(rod, nsdae.Solid("disc", 0.1))
    return world


def test_a_simulation_of_bodies():
    run = nsdae.solve(pendulum_of_bodies(), 0.3, dt=0.01)
    sim = nsdae.Sim(pendulum_of_bodies(), dt=0.01)
    sim.init()
    own = sim.record_run(0.3)
    assert np.array_equal(own.q, run.q) and np.array_equal(own.v, run.v) and np.any(run.v[0])
    assert own.shapes == run.shapes and len(own.shapes) == 1
    world = pendulum_of_bodies()
    q, v = nsdae.Sim(world).project()
    assert np.allclose(q, world.start()[0]) and np.allclose(v, world.start()[1])
    with pytest.raises(ValueError, match="q0 is missing"):
        nsdae.Sim(world.system()).init()


class Marker:
    """What is seen to be released."""


def cycle_of_a_system():
    marker, kept = Marker(), []

    def force(t, q, v, F):
        F[0] = -1
        kept.append(marker)

    kept.append(start("moreau", force))
    kept[-1].step()
    return weakref.ref(marker)


def cycle_of_bodies():
    marker, world, kept = Marker(), pendulum_of_bodies(), []

    def load(t, position, velocity, force, torque):
        kept.append((marker, world))

    world.add_load(0, load)
    kept.append(nsdae.Sim(world))
    kept[0].init()
    kept[0].step()
    return weakref.ref(marker)


@pytest.mark.parametrize("made", [cycle_of_a_system, cycle_of_bodies])
def test_cycles_are_collected(made):
    """A callback that refers to its owner."""
    gone = made()
    gc.collect()
    assert gone() is None


BEGIN = """
import sys, threading, nsdae
def mass(t, q, M): M[0, 0] = 1
def force(t, q, v, F): F[0] = -9.81
def gap(t, q, g): g[0] = q[0]
def make(**other):
    system = nsdae.System(nq=1, k=1, e_n=0.5, **{**dict(mass=mass, force=force, gap=gap), **other})
    sim = nsdae.Sim(system)
    sim.init([1.0])
    return sim
"""

ENDS = {
    "globals": ("sim = make(); sim.run(0.5); record = sim.record", 0),
    "an exception": ("sim = make(); sim.run(0.5); raise RuntimeError(sim)", 1),
    "an exception in a callback": ("def fails(t, q, v, F): 1 / 0\nsim = make(force=fails)", 1),
    "a caught one": ("def fails(t, q, v, F): 1 / 0\ntry: make(force=fails)\nexcept nsdae.Error as e: kept = e", 0),
    "sys.exit": ("def work():\n    sim = make()\n    def inner(): return sim, inner\n    sys.exit(inner() and 3)\nwork()", 3),
    "threads": ("sims = []\ndef work(): sims.append(make()); sims[-1].run(1)\n"
                "t = [threading.Thread(target=work) for _ in range(4)]\n[x.start() for x in t]; [x.join() for x in t]", 0),
    "a daemon": ("sim = make()\ndef work():\n    while True: sim.run(sim.time + 1)\n"
                 "threading.Thread(target=work, daemon=True).start()\nsim2 = make(); sim2.run(1)", 0),
    "a long run of a daemon": ("sim = make()\nthreading.Thread(target=sim.run, args=(1e9,), daemon=True).start()", 0),
    "another module": ("import types, builtins\nbuiltins.kept = sys.modules['kept'] = make()", 0),
    "bodies": ("world = nsdae.Bodies(2); ball = world.add(1, 1)\ndef load(t, x, v, F, M): F[0] = world.dimension\n"
               "world.add_load(ball, load); run = nsdae.solve(world, 0.1)", 0),
    "a child of a daemon's process": (
        "import os, time, warnings\nwarnings.simplefilter('ignore')  # of fork beside threads\nsim = make()\nthreading.Thread(target=sim.run, args=(1e9,), daemon=True).start()\n"
        "time.sleep(0.05)\nchild = os.fork()\nif child:\n    before = time.monotonic()\n"
        "    assert os.waitpid(child, 0)[1] == 0 and time.monotonic() - before < 3", 0),
    "a generator": ("sim = make(); steps = sim.steps(5); next(steps)", 0),
}


@pytest.mark.parametrize("end", ENDS)
def test_the_end_of_the_interpreter(end, tmp_path):
    program, status = ENDS[end]
    path = tmp_path / "program.py"
    path.write_text(BEGIN + program + "\n")
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, timeout=60)
    assert done.returncode == status, done.stderr
    assert "nanobind" not in done.stderr and "terminate" not in done.stderr and "leak" not in done.stderr
    if status in (0, 3):
        assert not done.stderr and not done.stdout


THREADS = """
import sys
def threads():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("Threads:"))
import numpy as np
before = threads()
import nsdae
loaded = threads()
A = np.eye(300) + 1e-3
nsdae.lcp(A, -np.ones(300))
nsdae.lcp(A, np.ones(300))
print(before, loaded, threads())
import os
print(os.environ.get("OPENBLAS_NUM_THREADS"))
"""


@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="no /proc here")
def test_import_starts_no_threads():
    """Those of NumPy's own BLAS are there already; the environment is as before."""
    for chosen in (None, "1"):
        environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
        if chosen:
            environment["OPENBLAS_NUM_THREADS"] = chosen
        done = subprocess.run([sys.executable, "-c", THREADS], capture_output=True, text=True, env=environment, check=True)
        counts, after = done.stdout.splitlines()
        assert len(set(counts.split())) == 1 and after == str(chosen), done.stdout


LIB = pathlib.Path(__file__).parents[2] / "lib"
LITERALS = re.compile(r'"(?:[^"\\]|\\.)*"(?:\s*"(?:[^"\\]|\\.)*")*')


def messages():
    """Every text of the library, but names of functions alone."""
    for path in sorted(LIB.rglob("*.c")):
        code = re.sub(r"^\s*#.*$", "", path.read_text(), flags=re.M)
        for found in LITERALS.finditer(code):
            text = re.sub(r'"\s*"', "", found[0])[1:-1]
            if re.search(r"nsdae_|NSDAE_FRICTION", text) and not re.fullmatch(r"nsdae_\w*", text):
                yield f"{path.name}: {text}"


@pytest.mark.skipif(not LIB.exists(), reason="the library's source is not here")
def test_texts_have_the_names_of_python():
    texts = list(messages())
    assert len(texts) > 15
    for text in texts:
        named = in_python(text.replace("nsdae_system_set_%s", "nsdae_system_set_force").replace("nsdae_system_%s%s", ""))
        assert "nsdae_" not in named and "NSDAE_FRICTION" not in named, named
        for owner, name in re.findall(r"\b(nsdae|Sim|System|Bodies|ContactList|RowList|Solid|Error)\.(\w+)", named):
            assert hasattr(nsdae if owner == "nsdae" else getattr(nsdae, owner), name) or (owner, name) == ("Error", "problem"), named


def test_texts_that_come(ball):
    with pytest.raises(nsdae.ArgumentError, match=r"Sim\.project corrects it"):
        nsdae.Sim(ball, method="event").init([-1])
    with pytest.raises(nsdae.Error, match=r"call Sim\.init first"):
        nsdae.Sim(ball).run(1)
    with pytest.raises(nsdae.ArgumentError, match=r"^nq = 0 is outside"):
        nsdae.System(nq=0, **ball_callbacks())
    with pytest.raises(nsdae.Error, match=r"call System\.set\(force=\.\.\.\)"):
        nsdae.Sim(nsdae.System(nq=1, mass=ball_callbacks()["mass"]))
    sim = nsdae.Sim(ball)
    with pytest.raises(nsdae.Error, match=r"change it in one of them \(Sim\.set_contact, Sim\.set_frictional_joint, Sim\.set_friction_bound\)"):
        ball.set_contact(0, e_n=0.1)
    assert sim.system is ball
