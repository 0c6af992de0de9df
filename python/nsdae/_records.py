"""Records, impacts and statistics as a user sees them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from . import _core

# the structs of src/sim.hpp
IMPACT = np.dtype([("time", "f8"), ("contact", "i4"), ("accumulation", "i4"), ("normal_impulse", "f8"),
                   ("tangential_impulse", "f8", 2), ("velocity_before", "f8"), ("velocity_after", "f8"),
                   ("peak_force", "f8"), ("id", "i8"), ("block", "i4", 2)])
CHANGE = np.dtype({"names": ["time", "contact", "frictional_joint", "mode_before", "mode_after"],
                   "formats": ["f8", "i4", "i4", "i4", "i4"], "offsets": [0, 8, 12, 16, 20], "itemsize": 24})
CLOSED = np.dtype({"names": ["id", "block", "gap", "normal_impulse", "tangential_impulse", "mode"],
                   "formats": ["i8", ("i4", 2), "f8", "f8", ("f8", 2), "i4"], "offsets": [0, 8, 16, 24, 32, 48],
                   "itemsize": 56})
# nsdae_certificate
CERTIFICATE = np.dtype([(name, "f8") for name in (
    "pull", "cone_excess", "penetration", "constraint_drift", "constraint_rate", "complementarity",
    "energy", "work", "dissipated", "unexplained")] + [(name, "i4") for name in (
        "pull_contact", "cone_contact", "penetration_contact", "drift_constraint", "rate_constraint",
        "complementarity_contact")])
assert CERTIFICATE.itemsize == _core.CERTIFICATE_SIZE
assert IMPACT.itemsize == _core.IMPACT_SIZE and CHANGE.itemsize == _core.CHANGE_SIZE
assert CLOSED.itemsize == _core.CONTACT_ROW_SIZE

OPEN, SLIP, STICK = 0, 1, 2  # modes of contacts and frictional joints


class LcpProblem(NamedTuple):
    """Find x >= 0 with y = A x + b >= 0 and x y = 0."""

    A: np.ndarray
    b: np.ndarray


class Record:
    """The state after a step and its certificate.

    step, time [s], duration [s] of the step; q [nq], v [nv], acceleration [nv] (mean over the step);
    multiplier [m]; gap, normal_impulse, mode [k]; tangential_impulse [k, nt]; frictional_joint_impulse, frictional_joint_mode [f];
    kinetic, potential, dissipated [J]; lcp_residual, constraint_drift, penetration; impacts and changes of the step
    as structured arrays; contacts, those by list that were closed in it: id, block [2] (-1: the ground), gap,
    normal_impulse, tangential_impulse [2], mode; certificate, by name: pull, cone_excess [N s], penetration [m],
    constraint_drift, constraint_rate, complementarity [J], each with the contact or constraint of the largest
    (pull_contact, cone_contact, penetration_contact, drift_constraint, rate_constraint, complementarity_contact; -1:
    none), energy, work, dissipated, unexplained [J] (< 0: a loss of the method). Its arrays are its own.
    """

    step: int
    time: float
    duration: float
    q: np.ndarray
    v: np.ndarray
    acceleration: np.ndarray
    multiplier: np.ndarray
    gap: np.ndarray
    normal_impulse: np.ndarray
    tangential_impulse: np.ndarray
    mode: np.ndarray
    frictional_joint_impulse: np.ndarray
    frictional_joint_mode: np.ndarray
    kinetic: float
    potential: float
    dissipated: float
    lcp_residual: float
    constraint_drift: float
    penetration: float
    impacts: np.ndarray
    changes: np.ndarray
    contacts: np.ndarray
    certificate: np.void

    def __init__(self, arrays: dict[str, Any]):
        self.impacts, self.changes, self.contacts = events(arrays)
        self.certificate = certificates(arrays)[0]
        for name, values in arrays.items():
            if name not in EVENTS and name not in ("contact_count", "certificate"):
                row = values[0] if isinstance(values, np.ndarray) else values
                setattr(self, name, row.item() if isinstance(row, np.generic) else row)

    def __repr__(self) -> str:
        return f"nsdae.Record(step={self.step}, time={self.time!r}, q={self.q!r}, v={self.v!r})"


def certificates(arrays: dict[str, Any]) -> np.ndarray:
    """Of each record, from their bytes."""
    return arrays["certificate"].reshape(-1).view(CERTIFICATE)


EVENTS = ("impacts", "changes", "contacts")


def events(arrays: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Impacts, changes and contacts by list from their bytes."""
    def rows(name: str, of: np.dtype) -> np.ndarray:
        return arrays[name].reshape(-1).view(of)

    return rows("impacts", IMPACT), rows("changes", CHANGE), rows("contacts", CLOSED)
