"""Systems that several tests use."""

import ctypes
import os
import shutil
import subprocess

import numpy as np
import pytest

import nsdae

G = 9.81


def ball_callbacks(m=0.1):
    def mass(t, q, M):
        M[0, 0] = m

    def force(t, q, v, F):
        F[0] = -m * G

    def gap(t, q, g):
        g[0] = q[0]

    return {"mass": mass, "force": force, "gap": gap}


@pytest.fixture
def ball():
    return nsdae.System(nq=1, k=1, e_n=0.5, names={"coordinate": [("y", "m")], "contact": ["floor"]}, **ball_callbacks())


@pytest.fixture
def pendulum():
    """A point of mass 1 on a rod of length 1: Phi = (x^2 + y^2 - 1) / 2."""
    def mass(t, q, M):
        M[0, 0] = M[1, 1] = 1

    def force(t, q, v, F):
        F[1] = -G

    def constraint(t, q, phi):
        phi[0] = (q[0] ** 2 + q[1] ** 2 - 1) / 2

    def constraint_jacobian(t, q, J):
        J[0] = q

    def constraint_bias(t, q, v, phi_t, omega):
        phi_t[0] = 0
        omega[0] = v @ v

    def potential(t, q):
        return G * q[1]

    return nsdae.System(nq=2, m=1, mass=mass, force=force, constraint=constraint, potential=potential,
                        constraint_jacobian=constraint_jacobian, constraint_bias=constraint_bias)


def block(mu, incline):
    """A block in space on an incline: q = x, y, z along it; two directions of friction."""
    def mass(t, q, M):
        np.fill_diagonal(M, 1)

    def force(t, q, v, F):
        F[:] = G * np.sin(incline), 0, -G * np.cos(incline)

    def gap(t, q, g):
        g[0] = q[2]

    def gap_tangent(t, q, W):
        W[0, 0] = W[1, 1] = 1

    return nsdae.System(nq=3, k=1, nt=2, mu=mu, mass=mass, force=force, gap=gap, gap_tangent=gap_tangent)


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """callbacks.c as a shared library of ctypes."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if not compiler:
        pytest.skip("no C compiler is here")
    built = tmp_path_factory.mktemp("compiled") / "libball.so"
    source = os.path.join(os.path.dirname(__file__), "callbacks.c")
    subprocess.run([compiler, "-O2", "-shared", "-fPIC", source, "-o", built], check=True)
    return ctypes.CDLL(str(built))


def compiled_ball(library):
    """Its callbacks as function pointers of ctypes."""
    if isinstance(library, str):
        library = ctypes.CDLL(library)
    return {name: ctypes.cast(getattr(library, name), nsdae.signature(name, "ctypes")) for name in ("mass", "force", "gap")}
