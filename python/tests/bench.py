"""Callbacks of Python and of numba beside the same in C, in one run: python python/tests/bench.py

The ball, method moreau, with all of its callbacks given; medians of interleaved runs.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time

import numba

import nsdae

SOURCE = """
int mass(double t, const double *q, double *M, int ldm, void *user) { M[0] = 0.1; return 0; }
int force(double t, const double *q, const double *v, double *F, void *user) { F[0] = -0.981; return 0; }
int gap(double t, const double *q, double *g, void *user) { g[0] = q[0]; return 0; }
int gap_normal(double t, const double *q, double *W, int ldw, void *user) { W[0] = 1; return 0; }
int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user) { w_n[0] = 0; return 0; }
"""
NAMES = ("mass", "force", "gap", "gap_normal", "contact_bias")


def in_c(folder):
    import ctypes
    with open(os.path.join(folder, "ball.c"), "w") as file:
        file.write(SOURCE)
    built = os.path.join(folder, "ball.so")
    subprocess.run(["cc", "-O2", "-w", "-shared", "-fPIC", file.name, "-o", built], check=True)
    library = ctypes.CDLL(built)
    return {name: ctypes.cast(getattr(library, name), nsdae.signature(name, "ctypes")) for name in NAMES}


def in_numba():
    bodies = {"mass": "t, q, M, ldm, user: M[0] = 0.1", "force": "t, q, v, F, user: F[0] = -0.981",
              "gap": "t, q, g, user: g[0] = q[0]", "gap_normal": "t, q, W, ldw, user: W[0] = 1.0",
              "contact_bias": "t, q, w_n, w_t, user: w_n[0] = 0.0"}
    made = {}
    for name, text in bodies.items():
        arguments, statement = text.split(": ")
        scope = {}
        exec(f"def {name}({arguments}):\n    {statement}\n    return 0", scope)
        made[name] = numba.cfunc(nsdae.signature(name))(scope[name])
    return made


def in_python():
    def mass(t, q, M):
        M[0, 0] = 0.1

    def force(t, q, v, F):
        F[0] = -0.981

    def gap(t, q, g):
        g[0] = q[0]

    def gap_normal(t, q, W):
        W[0, 0] = 1

    def contact_bias(t, q, w_n, w_t):
        w_n[0] = 0

    return {"mass": mass, "force": force, "gap": gap, "gap_normal": gap_normal, "contact_bias": contact_bias}


def counted(callbacks, calls):
    """The same, each call counted."""
    def of(function):
        def call(*arguments):
            calls[0] += 1
            return function(*arguments)

        return call

    return {name: of(function) for name, function in callbacks.items()}


def seconds(callbacks, steps):
    sim = nsdae.Sim(nsdae.System(nq=1, k=1, e_n=0.5, **callbacks), method="moreau", dt=1e-3)
    sim.init([1])
    begin = time.perf_counter()
    sim.run(steps * 1e-3)
    return time.perf_counter() - begin


def main():
    steps, repeats = 200000, 11
    with tempfile.TemporaryDirectory() as folder:
        compiled, jitted, plain = in_c(folder), in_numba(), in_python()
        rows = [(seconds(compiled, steps), seconds(jitted, steps)) for _ in range(repeats)]
    ratio = statistics.median(b / a for a, b in rows)
    base = statistics.median(a for a, _ in rows) / steps
    few, calls = 20000, [0]
    seconds(counted(plain, calls), few)
    slow = statistics.median(seconds(plain, few) for _ in range(5)) / few
    print(f"a step of the ball, callbacks in C: {1e6 * base:.2f} us; numba to C: {ratio:.3f}")
    print(f"callbacks in Python: {calls[0] / few:.1f} a step, {1e6 * (slow - base) * few / calls[0]:.2f} us each")
    return 0


if __name__ == "__main__":
    sys.exit(main())
