"""Wrong arguments: exceptions that name the argument, its value and what it must be."""

from __future__ import annotations

import functools
import inspect
import operator
import os
import reprlib
from typing import Any, Callable, TypeVar

import numpy as np

from ._errors import ArgumentError, Error
from ._tables import Status

T = TypeVar("T")


def refused(argument: str, why: str, status: Status = Status.E_ARGUMENT) -> ArgumentError:
    """The exception for an argument."""
    return ArgumentError(why, status, argument=argument)


def numbers(name: str, values: Any) -> np.ndarray:
    """Returns an array of numbers."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise refused(name, f"{name} = {reprlib.repr(values)}: must be numbers") from None


def finite(name: str, values: np.ndarray, *index: np.ndarray) -> np.ndarray:
    """Returns the values, all finite; index: their indices, of each dimension."""
    wrong = np.flatnonzero(~np.isfinite(values))
    if wrong.size:
        at = [int(of[wrong[0]]) for of in index] or [int(i) for i in np.unravel_index(wrong[0], values.shape)]
        raise refused(name, f"{name}{at} = {values.flat[wrong[0]]}: must be finite", Status.E_NONFINITE)
    return values


def _is_integer(value: Any) -> bool:
    try:
        return -2**31 <= operator.index(value) < 2**31
    except TypeError:
        return False


def _is_number(value: Any) -> bool:
    try:
        return np.ndim(value) == 0 and float(value) is not None
    except (TypeError, ValueError, OverflowError):
        return False


# Annotation: what the argument must be, and whether a value is that. All values are of an annotation that is not here.
_KINDS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "int": ("an integer from -2^31 to 2^31 - 1", _is_integer),
    "float": ("a number", _is_number),
    "bool": ("True or False", lambda value: True),
    "str": ("a str", lambda value: isinstance(value, str)),
    "bytes": ("bytes", lambda value: isinstance(value, bytes)),
    "os.PathLike[str]": ("a path", lambda value: isinstance(value, os.PathLike)),
    "None": ("None", lambda value: value is None),
}
_CLASSES = ("Bodies", "Solid", "System")  # by name: their modules import this one


def _kind(annotation: str) -> tuple[str, Callable[[Any], bool]]:
    if annotation in _CLASSES:
        return f"a {annotation}", lambda value: any(c.__name__ == annotation for c in type(value).__mro__)
    if annotation in ("Sequence[int]", "Sequence[float]"):
        text, fits = _kind(annotation[9:-1])
        return f"a sequence, each entry {text}", lambda value: np.iterable(value) and all(map(fits, value))
    return _KINDS.get(annotation, ("", lambda value: True))


def _fault(name: str, value: Any, annotation: Any) -> ArgumentError | TypeError | None:
    """What is wrong with a value."""
    annotation = getattr(annotation, "__forward_arg__", annotation)  # of the fields of a NamedTuple
    kinds = [_kind(part) for part in annotation.split(" | ")]
    if any(fits(value) for _, fits in kinds):
        fields = inspect.signature(type(value)).parameters if annotation == "Solid" else {}
        faults = (_fault(field, getattr(value, field), of.annotation) for field, of in fields.items())
        return next(filter(None, faults), None)
    text = f"{name} = {reprlib.repr(value)}: must be {' or '.join(text for text, _ in kinds)}"
    too_large = "int" in annotation.split(" | ") and hasattr(value, "__index__")
    return refused(name, text) if too_large else TypeError(text)


def _named(function: Callable[..., Any]) -> Callable[..., Any]:
    signature = inspect.signature(function)
    of = {name: p.annotation for name, p in signature.parameters.items()
          if p.kind is not p.VAR_KEYWORD and isinstance(p.annotation, str)}
    if not of:
        return function
    title = function.__qualname__.split(".")[0] if function.__name__ == "__init__" else function.__name__

    @functools.wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        try:
            return function(*args, **named)
        except (TypeError, ValueError, OverflowError, AttributeError) as error:
            if isinstance(error, Error):
                raise
            try:
                given = signature.bind(*args, **named).arguments
            except TypeError:
                raise error from None
            faults = (_fault(name, value, of[name]) for name, value in given.items() if name in of)
            fault = next(filter(None, faults), None)
            if fault is None:
                raise
            fault.args = (f"{title}: {fault}",)
            raise fault from None

    return call


def named(owner: T) -> T:
    """Decorates a function, or the public methods of a class: if a call fails by the type of an argument, as in the extension
    module, the exception names the argument.

    The annotations are compared with the arguments after the failure only.
    """
    if not isinstance(owner, type):
        return _named(owner)  # type: ignore[arg-type, return-value]
    for name, member in list(vars(owner).items()):
        if inspect.isfunction(member) and (name == "__init__" or not name.startswith("_")):
            setattr(owner, name, _named(member))
        elif isinstance(member, property) and member.fset:
            setattr(owner, name, member.setter(_named(member.fset)))
    return owner
