"""The description of a system."""

from __future__ import annotations

import difflib
from typing import Any, Callable, NamedTuple, Sequence

import numpy as np

from . import _core, _lists, _pointers
from ._errors import Error, in_python

KINDS = ("coordinate", "velocity", "constraint", "contact", "frictional_joint")


class Dims(NamedTuple):
    """Sizes of a system."""

    nq: int
    nv: int
    m: int
    k: int
    nt: int
    f: int


class Worst(NamedTuple):
    """The entry of a derivative that is farthest from its difference."""

    term: str
    row: int
    column: int
    given: float
    difference: float
    error: float


def vector(name: str, values: Any, n: int) -> np.ndarray:
    """n numbers; a single one may stand for itself."""
    array = np.ascontiguousarray(values, dtype=float).reshape(-1)
    if array.size != n:
        raise ValueError(f"{name} has {array.size} numbers; it must have {n}")
    return array


class System:
    """A system M(q) v' = F + constraints, contacts, friction, by its callbacks.

    nq   coordinates; nv velocities (default nq); m bilateral constraints; k contacts; nt tangential directions of
         each, 0, 1 or 2; f bilateral constraints with friction
    user what compiled callbacks get as their last argument: an array, a number (address), a pointer of ctypes or
         cffi; default NULL
    mu, e_n, e_t   friction and restitution of the contacts: a number for all of them or one for each
    names   {"coordinate": ["x", ("theta", "rad")], ...}: names, with units where wanted, of "coordinate",
            "velocity", "constraint", "contact", "frictional_joint"
    blocks   of a large system: [blocks] sizes of each, or [nq, nv]; their sums are nq and nv, k = f = 0
    All else are callbacks by name. A function of Python gets the time, read-only arrays, and the arrays that it
    writes its results into, matrices zeroed before:

        mass(t, q, M)  [nv, nv]                    force(t, q, v, F)  [nv]
        constraint(t, q, phi)  [m]                 constraint_jacobian(t, q, J)  [m, nv]
        constraint_bias(t, q, v, phi_t, omega)     gap(t, q, g)  [k]
        gap_normal(t, q, W)  [nv, k]               gap_tangent(t, q, W)  [nv, k nt]
        contact_bias(t, q, w_n, w_t)               contact_acceleration(t, q, v, omega_n, omega_t, omega_s)
        frictional_joint_tangent(t, q, W, w_s)                kinematics(t, q, v, qdot)  [nq]
        potential(t, q) -> energy

    A large system has in place of mass, constraint_jacobian and all of gaps and contacts

        mass_blocks(t, q, M)   M[b] [nv, nv] of block b; where they are of one size M is an array [blocks, nv, nv]
        constraint_rows(t, q, rows)                rows.add(row, block, value), see RowList
        contacts(t, q, v, reach, found)            found.add(id, block, gap, direction, mu=..., e_n=...), see
                                                   ContactList: every contact with a gap of at most reach, or more

    and returns None, or a whole number: > 0 for a failure that a smaller step may avoid. The arrays are made once
    and hold until the call returns; copy what is to be kept. mass and force are needed, constraint where m > 0,
    gap where k > 0, gap_tangent where there is friction; the library fills the rest by differences. In place of a
    function of Python: a numba.cfunc, a function pointer of ctypes or cffi, a scipy.LowLevelCallable, of the
    signature that signature(name) says; they run without the GIL.
    """

    def __init__(self, nq: int = 0, nv: int = 0, m: int = 0, k: int = 0, nt: int = 0, f: int = 0, *, user: Any = None,
                 blocks: Any = None, mu: float | Sequence[float] = 0, e_n: float | Sequence[float] = 0,
                 e_t: float | Sequence[float] = 0, names: dict[str, Sequence[str | tuple[str, str]]] | None = None,
                 **callbacks: Callable[..., Any]):
        sizes = None if blocks is None else _lists.sizes_of(blocks)
        if sizes:
            nq, nv = nq or int(sizes[0].sum()), nv or int(sizes[1].sum())
        self._core = _core.System(nq, nv, m, k, nt, f)
        if sizes:
            self._core.set_blocks(*sizes)
        self._user = user
        self._kept: dict[str, Any] = {}
        self.set(**callbacks)
        for i, of in enumerate(zip(*(np.broadcast_to(c, k) for c in (mu, e_n, e_t)))):
            if any(of):
                self.set_contact(i, *of)
        for kind, rows in (names or {}).items():
            for i, row in enumerate(rows):
                self.set_name(kind, i, *((row,) if isinstance(row, str) else row))

    @classmethod
    def _of(cls, core: Any) -> System:
        made = cls.__new__(cls)
        made._core, made._user, made._kept = core, None, {}
        return made

    def set(self, **callbacks: Callable[..., Any]) -> None:
        """Sets callbacks by name; not while simulations of the system are there."""
        for name, function in callbacks.items():
            if name not in _core.CALLBACKS:
                near = difflib.get_close_matches(name, _core.CALLBACKS, 1)
                meant = f"did you mean '{near[0]}'?" if near else f"they are {', '.join(_core.CALLBACKS)}"
                raise TypeError(f"no callback is called '{name}': {meant}")
            pointer = _pointers.compiled(name, function, self._user)
            if pointer is None:
                self._core.set_function(name, _lists.wrapped(name, function, self._core.blocks()[1]))
            else:
                self._core.set_pointer(name, *pointer)
            self._kept[name] = function  # a compiled function lives as long as the system

    def set_contact(self, i: int, mu: float = 0, e_n: float = 0, e_t: float = 0) -> None:
        """Friction, normal and tangential restitution of contact i."""
        self._core.set_contact(i, float(mu), float(e_n), float(e_t))

    def set_frictional_joint(self, j: int, constraint: int, mu: float) -> None:
        """Makes frictional joint j the friction of a constraint, of coefficient mu."""
        self._core.set_frictional_joint(j, constraint, float(mu))

    def set_name(self, kind: str, i: int, name: str, unit: str = "") -> None:
        """Names number i of a kind ("coordinate", "velocity", "constraint", "contact", "frictional_joint")."""
        if kind not in KINDS:
            raise ValueError(f"kind is '{kind}'; it must be one of {', '.join(KINDS)}")
        self._core.set_name(KINDS.index(kind), i, name, unit)

    def set_size(self, kind: str, i: int, size: float) -> None:
        """The length [m] that the error of number i is measured by: of a "contact" (of contacts by
        list, of a block) the width of the smaller body, of a "constraint" the arm of its joint."""
        if kind not in KINDS:
            raise ValueError(f"kind is '{kind}'; it must be one of {', '.join(KINDS)}")
        self._core.set_size(KINDS.index(kind), i, float(size))

    def names(self, kind: str) -> list[tuple[str, str]]:
        """(name, unit) of each of a kind; "" where there is none."""
        if kind not in KINDS:
            raise ValueError(f"kind is '{kind}'; it must be one of {', '.join(KINDS)}")
        d = self.dims
        count = dict(zip(KINDS, (d.nq, d.nv, d.m, d.k, d.f)))[kind]
        return [self._core.name(KINDS.index(kind), i) for i in range(count)]

    @property
    def dims(self) -> Dims:
        """Its sizes."""
        return Dims(*self._core.dims())

    @property
    def blocks(self) -> np.ndarray | None:
        """[blocks, 2] nq and nv of each block; None where there are none."""
        sizes = np.column_stack(self._core.blocks())
        return sizes if len(sizes) else None

    @property
    def differences(self) -> list[str]:
        """The terms that are filled by differences."""
        return self._core.differences().split()

    @property
    def unseen(self) -> str:
        """What no check can see of the callbacks that are given."""
        return in_python(self._core.unseen())

    def check(self, q: Any, v: Any = None, t: float = 0, tol: float = 1e-5) -> Worst:
        """Compares every derivative with differences at (t, q, v); raises Error that names the wrong entry."""
        d = self.dims
        v = np.zeros(d.nv) if v is None else v
        return Worst(**self._core.check(t, vector("q", q, d.nq), vector("v", v, d.nv), tol))

    def __repr__(self) -> str:
        return f"nsdae.System({', '.join(f'{name}={value}' for name, value in self.dims._asdict().items() if value)})"


__all__ = ["System", "Dims", "Worst", "Error"]
