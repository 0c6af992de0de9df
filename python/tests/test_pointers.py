"""Compiled callbacks: numba, ctypes, cffi, scipy, alone and among those of Python."""

import ctypes
import threading
import time

import numpy as np
import pytest

import nsdae
from conftest import G, ball_callbacks, compiled_ball


def run(user=None, **callbacks):
    return nsdae.solve(nsdae.System(nq=1, k=1, e_n=0.5, user=user, **callbacks), 2, [1])


@pytest.fixture(scope="module")
def reference():
    return run(**ball_callbacks())


def same(a, b):
    return np.array_equal(a.q, b.q) and np.array_equal(a.impacts, b.impacts)


def numba_ball():
    numba = pytest.importorskip("numba", reason="numba is not here")

    @numba.cfunc(nsdae.signature("mass"))
    def mass(t, q, M, ldm, user):
        M[0] = 0.1
        return 0

    @numba.cfunc(nsdae.signature("force"))
    def force(t, q, v, F, user):
        F[0] = -0.1 * 9.81
        return 0

    @numba.cfunc(nsdae.signature("gap"))
    def gap(t, q, g, user):
        g[0] = q[0]
        return 0

    return {"mass": mass, "force": force, "gap": gap}


def cffi_ball(library):
    cffi = pytest.importorskip("cffi", reason="cffi is not here")
    ffi = cffi.FFI()
    names = ("mass", "force", "gap")
    ffi.cdef("".join(nsdae.signature(name, "c") + ";" for name in names))
    opened = ffi.dlopen(library._name)
    return {name: ffi.addressof(opened, name) for name in names}


def scipy_ball(library):
    scipy = pytest.importorskip("scipy", reason="scipy is not here")
    return {name: scipy.LowLevelCallable(pointer) for name, pointer in compiled_ball(library).items()}


@pytest.mark.parametrize("make", [compiled_ball, cffi_ball, scipy_ball, lambda library: numba_ball()],
                         ids=["ctypes", "cffi", "scipy", "numba"])
def test_each_kind_gives_the_same_bytes(library, reference, make):
    callbacks = make(library)
    assert same(run(**callbacks), reference)
    mixed = {**ball_callbacks(), "force": callbacks["force"]}
    assert same(run(**mixed), reference)


def test_user_is_handed_over(library, reference):
    light = np.array([0.025])
    callbacks = compiled_ball(library)
    for user in (light, ctypes.c_double(0.025), light.ctypes.data):
        got = run(user=user, **callbacks)
        assert np.allclose(got.q, reference.q, atol=1e-12)
        assert got.impacts["normal_impulse"][0] == pytest.approx(reference.impacts["normal_impulse"][0] / 4)


def test_user_of_one_callback_alone(library, reference):
    """Of a LowLevelCallable its own, among others that have none: a force of a quarter."""
    scipy = pytest.importorskip("scipy", reason="scipy is not here")
    callbacks = compiled_ball(library)
    light = ctypes.c_double(0.025)
    callbacks["force"] = scipy.LowLevelCallable(callbacks["force"], ctypes.cast(ctypes.byref(light), ctypes.c_void_p))
    got = run(**callbacks)
    assert got.v[1, 0] == pytest.approx(reference.v[1, 0] / 4)


def test_cfunc_is_that_of_numba():
    """The same run; what it makes is numba's, with its options; nothing is left changed behind it."""
    numba = pytest.importorskip("numba", reason="numba is not here")
    from numba.core import registry
    conventions = type(registry.cpu_target.target_context.call_conv)
    before, own = conventions.call_function, numba_ball()
    made = {name: nsdae.cfunc(name)(function._pyfunc) for name, function in own.items()}
    assert conventions.call_function is before
    assert all(type(made[name]) is type(function) for name, function in own.items())
    same(run(**own), run(**made))
    with pytest.raises(ValueError, match="mas"):
        nsdae.cfunc("mas")
    with pytest.raises(numba.core.errors.NumbaError):
        nsdae.cfunc("force")(lambda t, q, v, F, user: q.none)
    assert conventions.call_function is before
    fast = nsdae.cfunc("force", fastmath=True)(own["force"]._pyfunc)
    same(run(**own), run(**{**made, "force": fast}))


def test_a_numba_signature_that_differs_is_refused():
    numba = pytest.importorskip("numba", reason="numba is not here")

    @numba.cfunc("float64(float64)")
    def force(t):
        return t

    with pytest.raises(TypeError, match="signature"):
        run(**{**ball_callbacks(), "force": force})


def test_signatures():
    assert nsdae.signature("mass") == "int32(float64, CPointer(float64), CPointer(float64), int32, voidptr)"
    assert nsdae.signature("gap", "c") == "int gap(double t, const double *q, double *g, void *user)"
    with pytest.raises(ValueError, match="mas"):
        nsdae.signature("mas")
    with pytest.raises(ValueError, match="fortran"):
        nsdae.signature("mass", "fortran")


def test_compiled_callbacks_leave_the_gil_to_others(library):
    """While a run of compiled callbacks lasts, this thread goes on: no pause of it is a third of the run."""
    system = nsdae.System(nq=1, k=1, e_n=0.5, **compiled_ball(library))
    done, took = threading.Event(), []

    def work():
        begin = time.perf_counter()
        nsdae.solve(system, 2000, [1], every=1000000)
        took.append(time.perf_counter() - begin)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    longest, last = 0.0, time.perf_counter()
    while not done.is_set() and thread.is_alive():
        now = time.perf_counter()
        longest, last = max(longest, now - last), now
    thread.join()
    assert longest < took[0] / 3, (longest, took)
