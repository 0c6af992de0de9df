"""Non-smooth multibody dynamics: mechanisms with impacts, unilateral contact and Coulomb friction.

Examples
--------
>>> import nsdae
>>> def mass(t, q, M): M[0, 0] = 0.1
>>> def force(t, q, v, F): F[0] = -0.1 * 9.81
>>> def gap(t, q, g): g[0] = q[0]
>>> ball = nsdae.System(nq=1, k=1, mass=mass, force=force, gap=gap, e_n=0.5)
>>> nsdae.solve(ball, 3, q0=[1]).plot()

Notes
-----
``METHODS`` has the methods with a summary of each. Options of `solve` and `Sim`, with their ranges::
"""

import os as _os

import numpy as _numpy  # noqa: F401

# OpenBLAS starts its threads when it is loaded. NumPy's is loaded by now; _core is linked to another one.
_CHOSEN = "OPENBLAS_NUM_THREADS" in _os.environ
_os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
try:
    from . import _core
finally:
    if not _CHOSEN:
        del _os.environ["OPENBLAS_NUM_THREADS"]
from ._bodies import GROUND, Bodies, Scene, Solid, read_mesh, read_scene
from ._errors import ArgumentError, CallbackError, Error, ModelWarning, ProblemError, RunWarning
from ._lists import CONTACT, BlockList, ContactList, RowList, block_add, contact_add, row_add
from ._pointers import cfunc, signature
from ._problems import FrictionResult, LcpResult, friction, friction_local, lcp
from ._records import OPEN, SLIP, STICK, LcpProblem, Record
from ._sim import METHODS, Sim, solve
from ._sweep import Sweep, load_sweep, sweep
from ._system import Dims, System, Worst
from ._tables import Options, Status
from ._trajectory import Shape, Trajectory, load

__version__: str = _core.VERSION
build_info: str = _core.BUILD_INFO
__doc__ += "\n" + "".join(f"    {key:<18}{what}{f' [{unit}]' if unit not in ('', '1') else ''}: {values}\n"
                   for key, unit, what, values, _ in _core.OPTIONS)

__all__ = ["ArgumentError", "Bodies", "CONTACT", "CallbackError", "ContactList", "Dims", "Error", "FrictionResult",
           "GROUND", "LcpProblem", "LcpResult", "METHODS", "ModelWarning", "OPEN", "Options", "ProblemError", "Record", "RowList", "RunWarning",
           "SLIP", "STICK", "Scene", "Shape", "Sim", "Solid", "Status", "Sweep", "System", "Trajectory", "Worst", "build_info",
           "block_add", "cfunc", "contact_add", "friction", "friction_local", "lcp", "load", "load_sweep", "read_mesh", "read_scene", "row_add", "signature", "solve",
           "sweep"]
