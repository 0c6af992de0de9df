"""Description of a system."""

from __future__ import annotations

import difflib
from typing import Any, Callable, NamedTuple, Sequence

import numpy as np

from . import _core, _lists
from ._arguments import named, numbers, refused
from ._copies import Callback, Recorded
from ._errors import Error, in_python

KINDS = ("coordinate", "velocity", "constraint", "contact", "frictional_joint")


class Dims(NamedTuple):
    """Sizes of a system.

    Attributes
    ----------
    nq, nv : int
        Coordinates, velocities.
    m : int
        Bilateral constraints.
    k : int
        Fixed contacts.
    nt : int
        Tangential directions of a contact.
    f : int
        Frictional joints.
    """

    nq: int
    nv: int
    m: int
    k: int
    nt: int
    f: int


class Worst(NamedTuple):
    """Entry of a derivative with the largest error against difference quotients.

    Attributes
    ----------
    term : str
        The callback.
    row, column : int
        The entry, from 0.
    given, difference, error : float
        Value of the callback, difference quotient, relative error.
    """

    term: str
    row: int
    column: int
    given: float
    difference: float
    error: float


def vector(name: str, values: Any, n: int) -> np.ndarray:
    """Returns an array of n numbers."""
    array = np.ascontiguousarray(numbers(name, values)).reshape(-1)
    if array.size != n:
        raise refused(name, f"{name} has {array.size} numbers; it must have {n}")
    return array


def _kind(word: str, argument: str = "kind") -> int:
    if word not in KINDS:
        raise refused(argument, f"{argument} '{word}' must be one of {', '.join(KINDS)}")
    return KINDS.index(word)


@named
class System:
    """System M(q) v' = F with constraints, contacts and friction, given by callbacks.

    Parameters
    ----------
    nq, nv : int
        Coordinates, velocities (default nq).
    m : int
        Bilateral constraints.
    k : int
        Fixed contacts.
    nt : int
        Tangential directions of each contact: 0, 1 or 2.
    f : int
        Frictional joints.
    user : object, optional
        Last argument of compiled callbacks: an array, an address, a pointer of ctypes or cffi; default NULL.
    blocks : array_like of int, optional
        Block-sparse system: sizes, shape (blocks,), or nq and nv of each, shape (blocks, 2). k and f are 0.
    mu, e_n, e_t : float or array_like
        Coefficient of friction, normal and tangential restitution of all contacts or of each.
    names : dict, optional
        ``{"coordinate": ["x", ("theta", "rad")], ...}``: names, with optional units, of "coordinate", "velocity",
        "constraint", "contact" and "frictional_joint".
    **callbacks
        Callbacks by name, see Notes.

    Raises
    ------
    ArgumentError
        A size or coefficient is out of range.
    TypeError
        A callback is unknown or has a wrong signature.

    Notes
    -----
    A callback gets the time, read-only arrays, and the arrays for its results. Matrices are zeroed before.

    - ``mass(t, q, M)``: M [nv, nv]
    - ``force(t, q, v, F)``: F [nv]
    - ``force_damping(t, q, v, D)``: D [nv, nv] = -dF/dv
    - ``force_stiffness(t, q, v, K)``: K [nv, nv] = -(dF/dq) H, dq/dt = H v
    - ``constraint(t, q, phi)``: phi [m]
    - ``constraint_jacobian(t, q, J)``: J [m, nv]
    - ``constraint_bias(t, q, v, phi_t, omega)``: phi_t [m], omega [m]
    - ``gap(t, q, g)``: g [k]
    - ``gap_normal(t, q, W)``: W [nv, k]
    - ``gap_tangent(t, q, W)``: W [nv, k nt]
    - ``contact_bias(t, q, w_n, w_t)``: w_n [k], w_t [k nt]
    - ``contact_acceleration(t, q, v, omega_n, omega_t, omega_s)``: omega_n [k], omega_t [k nt], omega_s [f]
    - ``frictional_joint_tangent(t, q, W, w_s)``: W [nv, f], w_s [f]
    - ``joint_friction_bound(t, q, v, bound)``: bound [f], added to the constant bounds
    - ``kinematics(t, q, v, qdot)``: qdot [nq]
    - ``potential(t, q)`` returns the energy
    - ``contact_speed(t, q, v)`` returns a bound of the rates of all gaps of ``contacts``

    A block-sparse system has ``mass_blocks``, ``force_damping_blocks`` and ``force_stiffness_blocks`` in place of ``mass``,
    ``force_damping`` and ``force_stiffness``. It may have ``constraint_rows`` in place of ``constraint_jacobian``,
    ``joint_friction_rows`` in place of ``frictional_joint_tangent``, and ``contacts`` in place of k and its callbacks:

    - ``mass_blocks(t, q, M)``: M[b] [nv, nv]; one array [blocks, nv, nv] if all blocks have the same size
    - ``constraint_rows(t, q, rows)``: calls ``rows.add(row, block, value)``, see `RowList`
    - ``joint_friction_rows(t, q, rows, w_s)``: the same, and w_s [f]
    - ``force_damping_blocks(t, q, v, blocks)``, ``force_stiffness_blocks``: call ``blocks.add(row, column, value)``, see `BlockList`
    - ``contacts(t, q, v, reach, found)``: calls ``found.add(id, block, gap, direction, ...)``, see `ContactList`

    ``contacts`` adds every contact with a gap of at most ``reach``, see `ContactList`.

    - A callback returns None or an integer. A value > 0 is a failure that a smaller step may avoid.
    - The arrays are valid until the callback returns.
    - ``mass`` and ``force`` are required, ``constraint`` if m > 0, ``gap`` if k > 0, ``gap_tangent`` with friction. The library
      fills the others by difference quotients.
    - A compiled callback runs without the GIL: a ``numba.cfunc``, a function pointer of ctypes or cffi, or a
      ``scipy.LowLevelCallable``, with the signature of `signature`.
    - A system can be pickled, as for ``multiprocessing`` and joblib, if its callbacks can: functions of a module, functions of
      numba, exported functions of shared libraries. ``user`` is then an array or a structure of ctypes, not an address.
    """

    def __init__(self, nq: int = 0, nv: int = 0, m: int = 0, k: int = 0, nt: int = 0, f: int = 0, *, user: Any = None,
                 blocks: Any = None, mu: float | Sequence[float] = 0, e_n: float | Sequence[float] = 0,
                 e_t: float | Sequence[float] = 0, names: dict[str, Sequence[str | tuple[str, str]]] | None = None,
                 **callbacks: Callable[..., Any]):
        sizes = None if blocks is None else _lists.sizes_of(blocks)
        if sizes:
            nq, nv = nq or int(sizes[0].sum()), nv or int(sizes[1].sum())
        self._core = Recorded("System", nq, nv, m, k, nt, f)
        if sizes:
            self._core.set_blocks(*sizes)
        self._user = user
        self._bodies: Any = None
        self._listed = False
        self.set(**callbacks)
        law = {"mu": mu, "e_n": e_n, "e_t": e_t}
        for i, of in enumerate(zip(*(_lists._array(name, numbers(name, c), (k,)) for name, c in law.items()))):
            if any(of):
                self.set_contact(i, *of)
        for kind, rows in (names or {}).items():
            _kind(kind, "names")
            for i, row in enumerate(rows):
                self.set_name(kind, i, *((row,) if isinstance(row, str) else row))

    @classmethod
    def _of(cls, core: Any, bodies: Any) -> System:
        made = cls.__new__(cls)
        made._core, made._user, made._bodies = Recorded.of(core), None, bodies  # whose functions live as long
        made._listed = made.blocks is not None
        return made

    def __reduce_ex__(self, protocol: Any) -> Any:
        return super().__reduce_ex__(protocol) if self._bodies is None else (type(self._bodies).system, (self._bodies,))

    def set(self, **callbacks: Callable[..., Any]) -> None:
        """Sets callbacks by name. Not allowed while simulations of the system exist.

        Parameters
        ----------
        **callbacks
            See `System`.

        Raises
        ------
        TypeError
            A callback is unknown or has a wrong signature.
        """
        for name, function in callbacks.items():
            if name not in _core.CALLBACKS:
                near = difflib.get_close_matches(name, _core.CALLBACKS, 1)
                meant = f"did you mean '{near[0]}'?" if near else f"they are {', '.join(_core.CALLBACKS)}"
                raise TypeError(f"no callback is called '{name}': {meant}")
            self._core.set_callback(name, Callback(name, function, self._user, self._core.blocks()[1]))
            self._listed |= name == "contacts"

    def set_contact(self, i: int, mu: float = 0, e_n: float = 0, e_t: float = 0) -> None:
        """Sets the coefficients of a contact.

        Parameters
        ----------
        i : int
            Contact.
        mu, e_n, e_t : float
            Coefficient of friction, normal and tangential restitution.
        """
        self._core.set_contact(i, float(mu), float(e_n), float(e_t))

    def set_frictional_joint(self, j: int, constraint: int, mu: float) -> None:
        """Defines a frictional joint.

        Parameters
        ----------
        j : int
            Frictional joint.
        constraint : int
            Its constraint, scaled as a length.
        mu : float
            Coefficient of friction.
        """
        self._core.set_frictional_joint(j, constraint, float(mu))

    def set_friction_bound(self, j: int, bound: float) -> None:
        """Sets a bound of the friction of a frictional joint: dry friction, a brake, a clutch or a motor.

        Parameters
        ----------
        j : int
            Frictional joint.
        bound : float
            Largest friction force [N] or torque [N m] without a load.
        """
        self._core.set_friction_bound(j, float(bound))

    def set_friction_circle(self, j: int, constraint: int, rows: int, radius: float) -> None:
        """Adds friction by the load of a pin to a frictional joint: radius abs(lambda).

        Parameters
        ----------
        j : int
            Frictional joint; its slip velocity is a rate of angle.
        constraint, rows : int
            First and number of the constraints of the pin, 1 to 3 lengths at right angles.
        radius : float
            Coefficient of friction times the radius of the pin [m].
        """
        self._core.set_friction_circle(j, constraint, rows, float(radius))

    def set_name(self, kind: str, i: int, name: str, unit: str = "") -> None:
        """Names a coordinate, velocity, constraint, contact or frictional joint.

        Parameters
        ----------
        kind : str
            "coordinate", "velocity", "constraint", "contact" or "frictional_joint".
        i : int
            Its number.
        name, unit : str
            Name and unit.
        """
        self._core.set_name(_kind(kind), i, name, unit)

    def set_size(self, kind: str, i: int, size: float) -> None:
        """Sets the length that scales the bound of an error.

        Parameters
        ----------
        kind : str
            "contact": width of the smaller body; with a contact list, of a block. "constraint": arm of the joint.
        i : int
            Its number.
        size : float
            Length [m].
        """
        self._core.set_size(_kind(kind), i, float(size))

    def names(self, kind: str) -> list[tuple[str, str]]:
        """Returns the names of a kind.

        Parameters
        ----------
        kind : str
            "coordinate", "velocity", "constraint", "contact" or "frictional_joint".

        Returns
        -------
        list of (str, str)
            Name and unit of each, or "".
        """
        d = self.dims
        number = _kind(kind)
        return [self._core.name(number, i) for i in range((d.nq, d.nv, d.m, d.k, d.f)[number])]

    @property
    def dims(self) -> Dims:
        """Sizes, `Dims`."""
        return Dims(*self._core.dims())

    @property
    def blocks(self) -> np.ndarray | None:
        """nq and nv of each block, shape (blocks, 2); None without blocks."""
        sizes = np.column_stack(self._core.blocks())
        return sizes if len(sizes) else None

    @property
    def differences(self) -> list[str]:
        """Terms that are filled by difference quotients."""
        return self._core.differences().split()

    @property
    def unseen(self) -> str:
        """Properties of the callbacks that no check can verify."""
        return in_python(self._core.unseen())

    def check(self, q: Any, v: Any = None, t: float = 0, tol: float = 1e-5) -> Worst:
        """Compares every derivative with difference quotients.

        Parameters
        ----------
        q : array_like, shape (nq,)
        v : array_like, shape (nv,), optional
        t : float
            State of the check.
        tol : float
            Relative bound.

        Returns
        -------
        Worst
            The entry with the largest error.

        Raises
        ------
        Error
            An entry exceeds the bound; the text names it.
        """
        d = self.dims
        v = np.zeros(d.nv) if v is None else v
        return Worst(**self._core.check(float(t), vector("q", q, d.nq), vector("v", v, d.nv), float(tol)))

    def __repr__(self) -> str:
        return f"nsdae.System({', '.join(f'{name}={value}' for name, value in self.dims._asdict().items() if value)})"


__all__ = ["System", "Dims", "Worst", "Error"]
