"""Exceptions, made from the library's error records."""

from __future__ import annotations

import contextlib
import importlib
import inspect
import math
import re
from typing import Any

from ._tables import Status


class Error(Exception):
    """Error of the library.

    Attributes
    ----------
    status : Status
        Status of the failed call.
    index : int or None
        Entry, contact or pivot concerned, from 0.
    time : float or None
        Simulated time [s].
    argument : str
        Argument, option or callback concerned, or "".
    where : str
        Function of the C library that detected the error.
    code : int
        Raw code of its origin.
    record : Record or None
        State before the failed step.
    problem : LcpProblem or None
        The problem that was not solved.
    trajectory : Trajectory or None
        Result of `solve` up to the error.
    """

    def __init__(self, text: str, status: Status, code: int = 0, index: int | None = None, time: float | None = None,
                 argument: str = "", where: str = ""):
        super().__init__(text)
        self.status, self.code, self.index, self.time = status, code, index, time
        self.argument, self.where = argument, where
        self.record: Any = None
        self.problem: Any = None
        self.trajectory: Any = None

    def __reduce__(self) -> Any:
        return type(self), (str(self), self.status), self.__dict__


class ArgumentError(Error, ValueError):
    """An argument, option or parameter is unknown, missing or out of range."""


class ProblemError(Error):
    """A complementarity or friction problem was not solved or has no solution; see its attribute ``problem``."""


class RunWarning(UserWarning):
    """Warning of a run, which continues.

    Energy, penetration or drift exceed the bound of the method, or directions of friction are not tangential to the gap.
    """


class ModelWarning(UserWarning):
    """Warning of `Bodies.system`: the model may have a mistake."""


class CallbackError(Error):
    """A callback raised the exception in ``__cause__``."""


_CLASSES = {Status.E_ARGUMENT: ArgumentError, Status.E_OPTION: ArgumentError, Status.E_LCP: ProblemError,
            Status.E_INFEASIBLE: ProblemError, Status.E_PAINLEVE: ProblemError}


# C names in the library's texts and their Python names; the first match counts. Else nsdae_sim_NAME is Sim.NAME, etc.
_NAMES = [(re.compile(pattern), name) for pattern, name in (
    (r"nsdae_sim_set_user, ", ""),  # Python's callbacks have their data in themselves
    (r"nsdae_sim_create", "nsdae.Sim"),
    (r"nsdae_sim_(state_size|get_state|set_state)", "Sim.state"),
    (r"nsdae_sim_get_(record|stats|options)", r"Sim.\1"),
    (r"nsdae_sim_(get_failed_lcp)", "Error.problem"),
    (r"nsdae_sim_options_default", "nsdae.Sim"),
    (r"nsdae_system_create", "nsdae.System"),
    (r"nsdae_system_set_(contact|frictional_joint|friction_bound|friction_circle|name)\b", r"System.set_\1"),
    (r"nsdae_system_set_blocks", "nsdae.System(blocks=...)"),
    (r"nsdae_system_set_(\w+)", r"System.set(\1=...)"),
    (r"nsdae_bodies_create", "nsdae.Bodies"),
    (r"nsdae_contact_add", "ContactList.add"),
    (r"nsdae_row_add", "RowList.add"),
    (r"nsdae_block_add", "BlockList.add"),
    (r"nsdae_solid_inertia", "Solid.inertia"),
    (r"nsdae_body_from_solids", "Bodies.add_from_solids"),
    (r"nsdae_solid_triangles", "Solid.triangles"),
    (r"nsdae_(sim|system|bodies)_(\w+)", lambda m: f"{m[1].capitalize()}.{m[2]}"),
    (r"nsdae_bodies\b", "nsdae.Bodies"),
    (r"enum nsdae_((name|joint|motor|sensor)_kind|named)", "the kinds"),
    (r"NSDAE_FRICTION_GLOBAL or NSDAE_FRICTION_LOCAL", "that of nsdae.friction or nsdae.friction_local"),
    (r"\bdims\.(?=\w)", ""),
)]


def in_python(text: str) -> str:
    """Translates the names of C functions and arguments in a text to those of Python."""
    for pattern, name in _NAMES:
        text = pattern.sub(name, text)
    return text


def of_record(status: int, code: int, index: int, time: float, argument: str, where: str, text: str) -> Exception:
    """Returns the exception of an error record."""
    text = in_python(text)
    if status == Status.E_MEMORY:
        return MemoryError(text)
    argued = status == Status.E_NONFINITE and math.isnan(time)  # at no time of a run: an argument
    return (ArgumentError if argued else _CLASSES.get(Status(status), Error))(text, Status(status), code, None if index < 0 else index,
                                               None if math.isnan(time) else time, argument, where)


def of_callback(cause: BaseException, function: Any = None) -> CallbackError:
    """Returns the exception of a callback, which names the function and its arguments."""
    name = getattr(function, "__qualname__", None)
    signature = ""
    with contextlib.suppress(TypeError, ValueError):  # of a compiled function
        signature = str(inspect.signature(function)) if name else ""
    by = f"the callback {name}{signature}" if name else "a callback"
    return CallbackError(f"{by} raised {type(cause).__name__}: {cause}", Status.E_CALLBACK)


def needed(module: str, extra: str) -> Any:
    """A module of an optional part of the package."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"{module} is not installed: pip install 'nsdae[{extra}]'") from error
