"""What fails is an exception that says what, where and with which state."""

import os
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest

import nsdae
from conftest import G, ball_callbacks


def failing(**other):
    return nsdae.System(nq=1, k=1, e_n=0.5, **{**ball_callbacks(), **other})


def test_an_exception_in_a_callback_is_the_cause():
    def force(t, q, v, F):
        if t > 0.2:
            raise ZeroDivisionError("no more")
        F[0] = -0.1 * G

    with pytest.raises(nsdae.CallbackError, match="no more") as caught:
        nsdae.solve(failing(force=force), 1, [1])
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    assert caught.value.status == nsdae.Status.E_CALLBACK
    assert caught.value.__cause__.__traceback__ is not None
    assert 0.15 < caught.value.record.time < 0.25
    assert caught.value.trajectory.status == "failed"
    assert caught.value.trajectory.time[-1] == caught.value.record.time


def test_a_result_that_is_returned_and_not_written():
    with pytest.raises(nsdae.CallbackError, match="writes into its last arrays"):
        nsdae.solve(failing(force=lambda t, q, v, F: [-1.0]), 1, [1])


def test_a_code_that_is_returned():
    with pytest.raises(nsdae.Error) as caught:
        nsdae.solve(failing(force=lambda t, q, v, F: -7), 1, [1])
    assert caught.value.status == nsdae.Status.E_CALLBACK and caught.value.code == -7
    assert not isinstance(caught.value, nsdae.CallbackError)


def test_not_a_number():
    def force(t, q, v, F):
        F[0] = np.nan if t > 0.1 else 0

    with pytest.raises(nsdae.Error) as caught:
        nsdae.solve(failing(force=force), 1, [1])
    assert caught.value.status == nsdae.Status.E_NONFINITE and caught.value.argument == "force"


def test_the_failed_problem_comes_along():
    """A particle between a ceiling and a floor that rises: once it touches both, v >= 1 and v <= 0."""
    def mass(t, q, M):
        M[0, 0] = 2

    def force(t, q, v, F):
        F[0] = 0

    def gap(t, q, g):
        g[:] = q[0] - t, 1 - q[0]

    press = nsdae.System(nq=1, k=2, mass=mass, force=force, gap=gap)
    with pytest.raises(nsdae.ProblemError) as caught:
        nsdae.solve(press, 2, [0.5])
    A, b = caught.value.problem
    assert np.allclose(A, [[0.5, -0.5], [-0.5, 0.5]], atol=1e-6) and b.sum() == pytest.approx(-1, abs=1e-6)
    assert caught.value.record.time == caught.value.trajectory.time[-1] < 1.01
    again = nsdae.lcp(A, b, check=False)
    assert again.outcome == "infeasible" and again.proof == "farkas"
    assert np.all(again.y >= 0) and np.all(A.T @ again.y <= 1e-15) and b @ again.y < 0


PROGRAM = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background shell may have had it ignored
sys.path.insert(0, sys.argv[2])
import nsdae
from conftest import ball_callbacks, compiled_ball
ball = compiled_ball(sys.argv[3]) if sys.argv[1] == "compiled" else ball_callbacks()
system = nsdae.System(nq=1, k=1, e_n=0.5, **ball)
print("runs", flush=True)
try:
    nsdae.solve(system, 1e6, [1], every=1000000)
except KeyboardInterrupt:
    sys.exit(5)
"""


@pytest.mark.parametrize("kind", ["python", "compiled"])
def test_ctrl_c_ends_a_run(tmp_path, library, kind):
    program = tmp_path / "long.py"
    program.write_text(PROGRAM)
    command = [sys.executable, program, kind, os.path.dirname(__file__), library._name]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as run:
        assert run.stdout.readline() == b"runs\n"
        time.sleep(0.3)
        begin = time.monotonic()
        run.send_signal(signal.SIGINT)
        assert run.wait(20) == 5
        assert time.monotonic() - begin < 5


def test_after_a_failure_the_next_run_is_as_ever(ball):
    def force(t, q, v, F):
        raise RuntimeError("once")

    with pytest.raises(nsdae.CallbackError):
        nsdae.solve(failing(force=force), 1, [1])
    assert nsdae.solve(ball, 1, [1]).status == "complete"


def test_failures_of_two_threads_stay_apart():
    said = {}

    def run(word):
        def force(t, q, v, F):
            if t > 0.3:
                raise RuntimeError(word)
            F[0] = -0.1 * G

        try:
            nsdae.solve(failing(force=force), 1, [1])
        except nsdae.CallbackError as error:
            said[word] = str(error.__cause__)

    threads = [threading.Thread(target=run, args=(word,)) for word in ("one", "two")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert said == {"one": "one", "two": "two"}


def test_what_a_run_is_warned_of():
    """A spring whose step is too long for moreau: said where the run was asked for, and never of one that is short enough."""
    def mass(t, q, M):
        M[0, 0] = 1

    def force(t, q, v, F):
        F[0] = -62500 * q[0]

    spring = nsdae.System(nq=1, mass=mass, force=force)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        nsdae.solve(spring, 0.1, [1], method="moreau", dt=1e-3)
    with pytest.warns(nsdae.RunWarning, match="numerical energy gain") as said:
        nsdae.solve(spring, 0.03, [1], method="moreau", dt=1e-2)
    with pytest.raises(nsdae.Error, match="the steps are unstable"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        nsdae.solve(spring, 0.1, [1], method="moreau", dt=1e-2)
    assert said[0].filename == __file__
    sim = nsdae.Sim(spring, method="moreau", dt=1e-2)
    sim.init([1])
    with pytest.warns(nsdae.RunWarning, match="numerical energy gain") as said:
        sim.record_run(0.03)
    assert said[0].filename == __file__
    sim.init([1])
    assert sim.run(0.03) == nsdae.Status.WARN_ENERGY
