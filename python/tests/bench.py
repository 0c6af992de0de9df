"""Callbacks of Python and of numba beside the same in C, in one run: python python/tests/bench.py

The ball (one coordinate, the least that a system can be) and a rod on a hinge (three coordinates, two constraints), method
moreau, with all of their callbacks given. Time is processor time, the least of interleaved runs. C is measured
twice: with gcc's fusion of the sine and cosine of an angle into one call, and without it, as in numba's code.
"""

import statistics
import subprocess
import sys
import tempfile
import time

import numba

import nsdae

# arguments that are written, and what is written into them; the same statements in C and in Python
BALL = {"mass": "M[0] = 0.1", "force": "F[0] = -0.981", "gap": "g[0] = q[0]", "gap_normal": "W[0] = 1.0",
        "contact_bias": "w_n[0] = 0.0"}
ROD = {"mass": "M[0] = 1.0; M[4] = 1.0; M[8] = 0.083", "force": "F[0] = 0.0; F[1] = -9.81; F[2] = 0.0",
       "constraint": "phi[0] = q[0] - 0.5 * cos(q[2]); phi[1] = q[1] - 0.5 * sin(q[2])",
       "constraint_jacobian": "J[0] = 1.0; J[3] = 1.0; J[4] = 0.5 * sin(q[2]); J[5] = -0.5 * cos(q[2])",
       "constraint_bias": "phi_t[0] = 0.0; phi_t[1] = 0.0; omega[0] = 0.5 * cos(q[2]) * v[2] * v[2]; "
                          "omega[1] = 0.5 * sin(q[2]) * v[2] * v[2]"}


def in_c(system, folder, *flags):
    import ctypes
    name = f"{folder}/{len(system)}{id(system)}{len(flags)}.so"
    source = "#include <math.h>\n" + "".join(f"{nsdae.signature(name, 'c')} {{ {text}; return 0; }}\n"
                                             for name, text in system.items())
    subprocess.run(["cc", "-O2", "-w", *flags, "-shared", "-fPIC", "-x", "c", "-", "-o", name, "-lm"],
                   input=source, text=True, check=True)
    library = ctypes.CDLL(name)
    return {name: ctypes.cast(getattr(library, name), nsdae.signature(name, "ctypes")) for name in system}


def in_numba(system, compiler=nsdae.cfunc):
    made = {}
    for name, text in system.items():
        arguments = ", ".join(word.split()[-1].lstrip("*") for word in
                              nsdae.signature(name, "c").split("(")[1].rstrip(")").split(","))
        scope = {}
        exec(f"from math import sin, cos\ndef {name}({arguments}):\n    {text}\n    return 0", scope)
        made[name] = compiler(name)(scope[name])
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


def seconds(callbacks, steps, q0=(1,), **sizes):
    sim = nsdae.Sim(nsdae.System(nq=len(q0), e_n=0.5 if sizes else 0, **(sizes or {"m": 2}), **callbacks), method="moreau",
                    dt=1e-3)
    sim.init(q0)
    begin = time.thread_time()
    sim.run(steps * 1e-3)
    return time.thread_time() - begin


def compare(name, system, q0, **sizes):
    """Seconds of a step in C; numba's ratio to it is printed."""
    steps, repeats = 20000, 31
    with tempfile.TemporaryDirectory() as folder:
        kinds = (in_c(system, folder), in_c(system, folder, "-fno-builtin"), in_numba(system),
                 in_numba(system, lambda name: numba.cfunc(nsdae.signature(name))))
        rows = [[seconds(kind, steps, q0, **sizes) for kind in kinds] for _ in range(repeats)]
    joined, plain, jitted, called = zip(*rows)
    for what, of in (("least", min), ("sums", sum)):
        print(f"{name}, {what}: nsdae.cfunc to C {of(jitted) / of(joined):.3f}, to C with the calls as written "
              f"{of(jitted) / of(plain):.3f}; numba.cfunc to C {of(called) / of(joined):.3f}")
    print(f"{name}: {1e6 * min(joined) / steps:.2f} us a step with callbacks in C")
    return min(joined) / steps


def main():
    base = compare("ball", BALL, (1,), k=1)
    compare("rod on a hinge", ROD, (0.5, 0, 0))
    plain, few, calls = in_python(), 20000, [0]
    seconds(counted(plain, calls), few, k=1)
    slow = statistics.median(seconds(plain, few, k=1) for _ in range(5)) / few
    print(f"callbacks in Python: {calls[0] / few:.1f} a step, {1e6 * (slow - base) * few / calls[0]:.2f} us each")
    return 0


if __name__ == "__main__":
    sys.exit(main())
