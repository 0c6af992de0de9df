"""The exceptions, made from the library's error records."""

from __future__ import annotations

import enum
import math
import re
from typing import Any

from . import _core

Status = enum.IntEnum("Status", dict(_core.STATUS), module="nsdae")
Status.__doc__ = "What a call of the library returns: 0 done, < 0 not done, > 0 done and something to know."


class Error(Exception):
    """What the library refuses or fails at.

    status    Status
    index     entry, contact or pivot concerned, from 0; None where there is none
    time      simulated time [s]; None where there is none
    argument  argument, option or callback concerned; "" where there is none
    where     function of the C library that found it
    code      raw code of its origin
    record    Record of the state before the step that failed; None where there is no simulation
    problem   LcpProblem that was not solved; None where it was something else
    trajectory  what solve() had until then; None elsewhere
    """

    def __init__(self, text: str, status: Status, code: int = 0, index: int | None = None, time: float | None = None,
                 argument: str = "", where: str = ""):
        super().__init__(text)
        self.status, self.code, self.index, self.time = status, code, index, time
        self.argument, self.where = argument, where
        self.record: Any = None
        self.problem: Any = None
        self.trajectory: Any = None


class ArgumentError(Error, ValueError):
    """An argument, an option or a parameter is unknown, missing or out of its range."""


class ProblemError(Error):
    """A complementarity or friction problem was not solved, or has no solution; .problem has it."""


class RunWarning(UserWarning):
    """What a run is warned of: energy, overlap or drift beyond what the method explains, directions of friction that
    are not those of the gap. The run goes on."""


class CallbackError(Error):
    """A callback raised the exception in __cause__."""


_CLASSES = {Status.E_ARGUMENT: ArgumentError, Status.E_OPTION: ArgumentError, Status.E_LCP: ProblemError,
            Status.E_INFEASIBLE: ProblemError, Status.E_PAINLEVE: ProblemError}


# What the library's texts name, and what that is here; the first that fits. Else nsdae_sim_NAME is Sim.NAME, and so on.
_NAMES = [(re.compile(pattern), name) for pattern, name in (
    (r"nsdae_sim_set_user, ", ""),  # Python's callbacks have their data in themselves
    (r"nsdae_sim_create", "nsdae.Sim"),
    (r"nsdae_sim_(state_size|get_state|set_state)", "Sim.state"),
    (r"nsdae_sim_get_(record|stats|options)", r"Sim.\1"),
    (r"nsdae_sim_(get_failed_lcp)", "Error.problem"),
    (r"nsdae_sim_options_default", "nsdae.Sim"),
    (r"nsdae_system_create", "nsdae.System"),
    (r"nsdae_system_set_(contact|frictional_joint|name)\b", r"System.set_\1"),
    (r"nsdae_system_set_blocks", "nsdae.System(blocks=...)"),
    (r"nsdae_system_set_(\w+)", r"System.set(\1=...)"),
    (r"nsdae_bodies_create", "nsdae.Bodies"),
    (r"nsdae_contact_add", "ContactList.add"),
    (r"nsdae_row_add", "RowList.add"),
    (r"nsdae_solid_inertia", "Solid.inertia"),
    (r"nsdae_(sim|system|bodies)_(\w+)", lambda m: f"{m[1].capitalize()}.{m[2]}"),
    (r"enum nsdae_(name|joint)_kind", "the kinds"),
    (r"NSDAE_FRICTION_GLOBAL or NSDAE_FRICTION_LOCAL", "that of nsdae.friction or nsdae.friction_local"),
    (r"\bdims\.(?=\w)", ""),
)]


def in_python(text: str) -> str:
    """A text of the library with Python's names of functions and arguments."""
    for pattern, name in _NAMES:
        text = pattern.sub(name, text)
    return text


def of_record(status: int, code: int, index: int, time: float, argument: str, where: str, text: str) -> Exception:
    """The exception that an error record stands for."""
    text = in_python(text)
    if status == Status.E_MEMORY:
        return MemoryError(text)
    return _CLASSES.get(Status(status), Error)(text, Status(status), code, None if index < 0 else index,
                                               None if math.isnan(time) else time, argument, where)


def of_callback(cause: BaseException) -> CallbackError:
    return CallbackError(f"a callback raised {type(cause).__name__}: {cause}", Status.E_CALLBACK)
