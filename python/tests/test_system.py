"""Callbacks in Python: arguments, arrays, refusals."""

import gc
import threading
import warnings
import weakref

import numpy as np
import pytest

import nsdae
from conftest import G, ball_callbacks, block


def exact_ball(t, e=0.5, h=1.0):
    """Height of a ball that falls from h and bounces with e, flight by flight."""
    fall = np.sqrt(2 * h / G)
    begin, up = -fall, G * fall
    while t - begin >= 2 * up / G and up > 1e-12:
        begin += 2 * up / G
        up *= e
    since = t - begin
    return max(since * (up - G / 2 * since), 0.0) if up > 1e-12 else 0.0


def test_event_driven_ball_is_exact(ball):
    run = nsdae.solve(ball, 1.2, [1], method="event", dt=0.01, rtol=1e-10, atol=1e-12)
    fall = np.sqrt(2 / G)
    times = fall * np.array([1, 2, 2.5])
    assert np.allclose(run.impacts["time"][:3], times, rtol=1e-8)
    assert np.allclose(run.impacts["normal_impulse"][:3], 0.1 * 1.5 * G * fall * 0.5 ** np.arange(3), rtol=1e-7)
    assert np.allclose(run.q[:, 0], [exact_ball(t) for t in run.time], atol=1e-7)
    assert run["y"] is not None and run.names["coordinate"] == [("y", "m")]


def test_size_bounds_the_overlap(ball):
    """A ball of 4 cm that sinks by 3.8 cm is warned of, one of 4 m is not."""
    ball.set_size("contact", 0, 0.04)
    with pytest.warns(nsdae.RunWarning, match="penetration"):
        nsdae.solve(ball, 0.6, [1], dt=0.02)
    ball.set_size("contact", 0, 4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        nsdae.solve(ball, 0.6, [1], dt=0.02)
    with pytest.raises(nsdae.Error, match="size"):
        ball.set_size("contact", 0, -1)


def test_implicit_converges_in_second_order(pendulum):
    """Against a fine event-driven run; between impacts implicit is of order 2."""
    fine = nsdae.solve(pendulum, 1, [1, 0], method="event", rtol=1e-11, atol=1e-12).q[-1]
    errors = [np.linalg.norm(nsdae.solve(pendulum, 1, [1, 0], dt=dt).q[-1] - fine) for dt in (0.01, 0.005, 0.0025)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 2) < 0.2), (errors, orders)


def test_energy_of_pendulum(pendulum):
    run = nsdae.solve(pendulum, 2, [1, 0], dt=1e-3)
    assert np.max(np.abs(run.kinetic + run.potential)) < 1e-4
    assert np.max(run.constraint_drift) < 1e-5


@pytest.mark.parametrize("incline, sticks", [(0.3, True), (0.7, False)])
def test_block_on_incline(incline, sticks):
    """Sticks where tan(incline) <= mu, else slides with g (sin - mu cos)."""
    mu, t = 0.5, 0.5
    run = nsdae.solve(block(mu, incline), t, [0, 0, 0], dt=0.001)
    speed = 0 if sticks else G * (np.sin(incline) - mu * np.cos(incline)) * t
    assert run.v[-1, 0] == pytest.approx(speed, abs=1e-9)
    assert run.mode[-1, 0] == (nsdae.STICK if sticks else nsdae.SLIP)
    assert run.tangential_impulse.shape == (len(run), 1, 2)


def test_arrays_are_made_once():
    seen = {}
    callbacks = ball_callbacks()

    def force(t, q, v, F):
        seen.setdefault(id(F), F)
        assert isinstance(t, float) and q.shape == v.shape == F.shape == (1,)
        assert not q.flags.writeable and not v.flags.writeable
        F[0] = -0.1 * G

    system = nsdae.System(nq=1, k=1, e_n=0.5, **{**callbacks, "force": force})
    nsdae.solve(system, 1, [1])
    assert len(seen) == 1


def test_matrices_are_column_major_and_zeroed(pendulum):
    def mass(t, q, M):
        assert M.flags.f_contiguous and not M.any() and M.shape == (2, 2)
        M[0, 0] = M[1, 1] = 1

    pendulum.set(mass=mass)
    nsdae.solve(pendulum, 0.1, [1, 0])


def test_check_names_the_wrong_entry(pendulum):
    assert pendulum.check([0.6, 0.8], [0.8, -0.6]).error < 1e-6

    def wrong(t, q, J):
        J[0] = q[0], -q[1]

    pendulum.set(constraint_jacobian=wrong)
    with pytest.raises(nsdae.Error, match="constraint_jacobian") as caught:
        pendulum.check([0.6, 0.8], [0.8, -0.6])
    assert caught.value.status == nsdae.Status.E_DERIVATIVE


def test_differences_are_named(ball):
    assert "gap_normal" in ball.differences
    assert "force" in ball.unseen


@pytest.mark.parametrize("make, what", [
    (lambda: nsdae.System(nq=0), "nq"),
    (lambda: nsdae.System(nq=1, mas=len), "mas"),
    (lambda: nsdae.System(nq=1, constraint=lambda t, q, phi: None), "constraint"),
    (lambda: nsdae.System(nq=1, mass=3), "mass"),
    (lambda: nsdae.System(nq=1, k=1, e_n=2), "e_n"),
    (lambda: nsdae.System(nq=1, k=1, mu=0.5), "mu"),
    (lambda: nsdae.System(nq=1, names={"colour": ["red"]}), "colour"),
])
def test_refusals_name_the_argument(make, what):
    with pytest.raises((ValueError, TypeError), match=what):
        make()


@pytest.mark.parametrize("options, what", [
    ({"metod": "event"}, "method"), ({"method": "moraeu"}, "moreau"), ({"dt": -1}, "dt"), ({"dt": "soon"}, "dt"),
])
def test_unknown_options_offer_the_nearest(ball, options, what):
    with pytest.raises(nsdae.ArgumentError, match=what) as caught:
        nsdae.solve(ball, 1, [1], **options)
    assert isinstance(caught.value, ValueError)


def test_sizes_of_the_start(ball):
    with pytest.raises(ValueError, match="q0 has 2 numbers"):
        nsdae.solve(ball, 1, [1, 2])
    with pytest.raises(nsdae.ArgumentError, match="floor"):
        nsdae.solve(ball, 1, [-1], method="event")
    with pytest.raises(nsdae.ArgumentError, match="overlaps by 1 at the start.*at most 0.2"):
        nsdae.solve(ball, 0.1, [-1])
    with pytest.warns(nsdae.RunWarning, match="overlaps by 1 at the start"):
        nsdae.solve(ball, 0.1, [-1], projection="none")


def test_a_system_without_cycles_is_freed():
    """Functions that refer to an owner of the system are no leak."""
    class Model:
        def __init__(self):
            self.system = nsdae.System(nq=1, k=1, **{**ball_callbacks(), "force": self.force})
            self.sim = nsdae.Sim(self.system)
            self.sim.init([1])

        def force(self, t, q, v, F):
            F[0] = -1

    model = Model()
    model.sim.run(0.1)
    gone = weakref.ref(model)
    del model
    gc.collect()
    assert gone() is None


def test_one_system_in_many_threads(ball):
    alone = nsdae.solve(ball, 2, [1])
    runs = [None] * 4

    def work(i):
        runs[i] = nsdae.solve(ball, 2, [1])

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for run in runs:
        assert np.array_equal(run.q, alone.q) and np.array_equal(run.impacts, alone.impacts)


def test_a_system_is_constant_while_it_has_simulations(ball):
    sim = nsdae.Sim(ball)
    with pytest.raises(nsdae.Error) as caught:
        ball.set_contact(0, e_n=0.1)
    assert caught.value.status == nsdae.Status.E_STATE
    with pytest.raises(nsdae.Error):
        ball.set(force=lambda t, q, v, F: None)
    sim.init([1])
    sim.run(1)
    del sim
    ball.set_contact(0, e_n=0.1)


def refuse_to_write(t, q, v, F):
    F = np.array([-1.0])  # noqa: F841


def write_in_place(t, q, v, F):
    F += 1
    F[0] -= 2
    F *= 1


def test_an_array_that_is_rebound_is_a_warning():
    """F = np.array(...) leaves the array of the library as it was: zero force."""
    with pytest.warns(nsdae.ModelWarning, match=r"force: F = \.\.\. rebinds the name and writes nothing: use F\[:\] = \.\.\."):
        nsdae.System(nq=1, k=1, **{**ball_callbacks(), "force": refuse_to_write})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        nsdae.System(nq=1, k=1, **{**ball_callbacks(), "force": write_in_place})


def test_an_exception_names_its_callback():
    def pull(t, q, F):
        F[0] = 1

    def widen(t, q, v, F):
        F[:] = np.ones(3)

    for force, text in ((pull, r"the callback .*pull\(t, q, F\) raised TypeError"), (widen, r"the callback .*widen\(t, q, v, F\) raised ValueError.*shape")):
        with pytest.raises(nsdae.CallbackError, match=text):
            nsdae.solve(nsdae.System(nq=1, k=1, **{**ball_callbacks(), "force": force}), 1, [1])


def test_a_fraction_is_no_index():
    from nsdae._lists import _whole

    with pytest.raises(nsdae.ArgumentError, match="id = 1.5 is not a whole number"):
        _whole("id", [1, 1.5], (2,))
    assert _whole("id", [1.0, 2], (2,)).tolist() == [1, 2]
