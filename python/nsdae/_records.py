"""Records, impacts and statistics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _core

# the structs of src/sim.hpp
IMPACT = np.dtype([("time", "f8"), ("contact", "i4"), ("accumulation", "i4"), ("normal_impulse", "f8"),
                   ("tangential_impulse", "f8", 2), ("velocity_before", "f8"), ("velocity_after", "f8"),
                   ("peak_force", "f8"), ("id", "i8"), ("block", "i4", 2)])
CHANGE = np.dtype([("time", "f8"), ("contact", "i4"), ("frictional_joint", "i4"), ("mode_before", "i4"),
                   ("mode_after", "i4"), ("id", "i8"), ("block", "i4", 2)])


def contact_row(nt: int, forces: bool = False) -> np.dtype:
    """A contact of a record with nt tangential directions, possibly with its point and force."""
    n = 8 if forces else 6
    return np.dtype({"names": ["id", "block", "gap", "normal_impulse", "tangential_impulse", "mode", "point", "force"][:n],
                     "formats": ["i8", ("i4", (2,)), "f8", "f8", ("f8", (nt,)), "i4", ("f8", (3,)), ("f8", (3,))][:n],
                     "offsets": [0, 8, 16, 24, 32, 48, 56, 80][:n], "itemsize": 104 if forces else 56})


# nsdae_certificate
CERTIFICATE = np.dtype([(name, "f8") for name in (
    "pull", "cone_excess", "penetration", "constraint_drift", "constraint_rate", "complementarity",
    "energy", "work", "dissipated", "unexplained")] + [(name, "i4") for name in (
        "pull_contact", "cone_contact", "penetration_contact", "drift_constraint", "rate_constraint",
        "complementarity_contact")])
assert CERTIFICATE.itemsize == _core.CERTIFICATE_SIZE
assert IMPACT.itemsize == _core.IMPACT_SIZE and CHANGE.itemsize == _core.CHANGE_SIZE
assert contact_row(2).itemsize == _core.CONTACT_ROW_SIZE
assert contact_row(2, True).itemsize == _core.CONTACT_FORCE_ROW_SIZE

_core.set_types(dict(frombuffer=np.frombuffer, number=np.dtype("f8"), whole=np.dtype("i4"), impact=IMPACT, change=CHANGE,
                     certificate=CERTIFICATE, contact0=contact_row(0), contact1=contact_row(1), contact2=contact_row(2)))

OPEN, SLIP, STICK = 0, 1, 2  # modes of contacts and frictional joints


class LcpProblem(NamedTuple):
    """Linear complementarity problem x >= 0, y = A x + b >= 0, x y = 0."""

    A: np.ndarray
    b: np.ndarray


class ContactColumns:
    """The fields of the contacts as attributes."""

    contacts: np.ndarray

    @property
    def gap(self) -> np.ndarray:
        """``contacts["gap"]``"""
        return self.contacts["gap"]

    @property
    def normal_impulse(self) -> np.ndarray:
        """``contacts["normal_impulse"]``"""
        return self.contacts["normal_impulse"]

    @property
    def tangential_impulse(self) -> np.ndarray:
        """``contacts["tangential_impulse"]``"""
        return self.contacts["tangential_impulse"]

    @property
    def mode(self) -> np.ndarray:
        """``contacts["mode"]``"""
        return self.contacts["mode"]


class Record(ContactColumns):
    """State after a step, with its certificate. It stays as it is during further steps.

    An array is made when it is read for the first time, from the numbers of the record: it is a copy, which may be changed.

    Attributes
    ----------
    step : int
        Number of the step.
    time, duration : float
        Time, and length of the step [s].
    q : ndarray, shape (nq,)
        Coordinates.
    v, acceleration : ndarray, shape (nv,)
        Velocities, and mean accelerations of the step.
    multiplier : ndarray, shape (m,)
        Mean bilateral forces of the step.
    contacts : structured ndarray, shape (c,)
        Contacts, see Notes. All k fixed contacts, or those of a contact list that were closed in the step.
    gap, normal_impulse : ndarray, shape (c,)
        Fields of the contacts: gaps [m] and normal impulses [N s].
    tangential_impulse : ndarray, shape (c, nt)
        Tangential impulses [N s].
    mode : ndarray of int, shape (c,)
        `OPEN`, `SLIP` or `STICK`.
    frictional_joint_impulse, frictional_joint_mode : ndarray, shape (f,)
        Friction impulses [N s] and modes of the frictional joints.
    kinetic, potential, dissipated : float
        Energies [J].
    projection_energy : float
        Potential energy that projection="slop" added since the start [J], a part of `dissipated`, which it decreases.
    lcp_residual : float
        Scaled natural residual of the contact problem.
    contact_tol : float
        The largest tolerance of the contact problems, 0 without one.
    constraint_drift : float
        max abs(Phi).
    penetration : float
        Largest overlap [m].
    impacts, changes : structured ndarray
        Impacts and mode transitions of the step, with the fields of those of `Trajectory`.
    certificate : structured scalar
        Residuals of the laws and the energy balance, see Notes.

    Notes
    -----
    Fields of the contacts: id (fixed contacts: the number), block [2] (of a contact list; -1: the ground), gap, normal_impulse,
    tangential_impulse [nt], mode.

    Fields of the certificate:

    - pull, cone_excess [N s], penetration [m], constraint_drift, constraint_rate, complementarity [J];
    - pull_contact, cone_contact, penetration_contact, complementarity_contact, drift_constraint, rate_constraint: their
      contact or constraint, or -1;
    - energy, work, dissipated, unexplained [J]. unexplained < 0 is energy lost by the method.
    """

    step: int
    time: float
    duration: float
    q: np.ndarray
    v: np.ndarray
    acceleration: np.ndarray
    multiplier: np.ndarray
    frictional_joint_impulse: np.ndarray
    frictional_joint_mode: np.ndarray
    kinetic: float
    potential: float
    dissipated: float
    projection_energy: float
    lcp_residual: float
    contact_tol: float
    constraint_drift: float
    penetration: float
    impacts: np.ndarray
    changes: np.ndarray
    certificate: np.void

    def __init__(self, kept: Any):
        self._kept = kept

    if not TYPE_CHECKING:  # so that a type checker knows the names above alone
        def __getattr__(self, name):
            """Reads a field for the first time; later it is an attribute."""
            if name not in FIELDS or "_kept" not in self.__dict__:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            value = self.__dict__[name] = getattr(self._kept, name)
            return value

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in FIELDS}

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *FIELDS})

    def __repr__(self) -> str:
        return f"nsdae.Record(step={self.step}, time={self.time!r}, q={self.q!r}, v={self.v!r})"


FIELDS = frozenset(("contacts", *Record.__annotations__))


def certificates(arrays: dict[str, Any]) -> np.ndarray:
    """Certificates of the records, from their bytes."""
    return arrays["certificate"].reshape(-1).view(CERTIFICATE)


EVENTS = ("impacts", "changes", "contacts")


def events(arrays: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Impacts, mode transitions and contacts, from their bytes."""
    def rows(name: str, of: np.dtype) -> np.ndarray:
        return arrays[name].view(of)[..., 0]

    contact = contact_row(arrays["nt"], arrays["contacts"].shape[-1] == _core.CONTACT_FORCE_ROW_SIZE)
    return rows("impacts", IMPACT), rows("changes", CHANGE), rows("contacts", contact)


def joined(parts: list[dict[str, Any]]) -> dict[str, Any]:
    """Arrays of a run from those of its parts in time."""
    def join(values: Any) -> Any:
        if isinstance(values[0], list):
            return [np.concatenate(of) for of in zip(*values)]
        return np.concatenate(values) if isinstance(values[0], np.ndarray) else values[0]

    return parts[0] if len(parts) == 1 else {name: join([part[name] for part in parts]) for name in parts[0]}
