"""Copies of systems and bodies, for pickle: the calls that made them, and callbacks by the names of their code."""

from __future__ import annotations

import ctypes
import functools
import itertools
import os
import tempfile
import warnings
from typing import Any, Iterable, NamedTuple

import numpy as np

from . import _core, _lists, _pointers
from ._errors import ModelWarning

# calls of the extension module that change nothing
_READS = ("blocks", "check", "differences", "dims", "locate", "name", "simulations", "start", "system", "unseen")


class Recorded:
    """An object of the extension module and the calls that made it: a copy is made by the same calls.

    A later call of a setter replaces an earlier one of the same entry.
    """

    def __init__(self, kind: str, *sizes: int):
        self._made = (kind, sizes)
        self._calls: dict[Any, tuple[str, tuple[Any, ...]]] = {}
        self._number = itertools.count()
        self.core = getattr(_core, kind)(*sizes)

    @classmethod
    def of(cls, core: Any) -> Recorded:
        """Of a system of bodies; the bodies make its copy."""
        made = cls.__new__(cls)
        made._calls, made._number, made.core = {}, itertools.count(), core
        return made

    def calls(self) -> list[tuple[str, tuple[Any, ...]]]:
        """Name and arguments of each call, in their order."""
        return list(self._calls.values())

    def replay(self, calls: Iterable[tuple[str, tuple[Any, ...]]]) -> Recorded:
        """Makes the calls."""
        for name, arguments in calls:
            getattr(self, name)(*arguments)
        return self

    def __getattr__(self, name: str) -> Any:
        method = getattr(self.core, name)
        return method if name in _READS else functools.partial(self._call, name, method)

    def _call(self, name: str, method: Any, *arguments: Any) -> Any:
        result = method(*itertools.chain.from_iterable(a.core() if isinstance(a, Callback) else (a,) for a in arguments))
        entry = itertools.takewhile(lambda a: isinstance(a, (int, str)), arguments)
        key = (name, *entry) if name.startswith("set_") else next(self._number)
        self._calls.pop(key, None)
        self._calls[key] = (name, arguments)
        return result

    def add_scene(self, path: str, content: bytes | None = None) -> Any:
        """Adds a scene. A copy has the content of its file."""
        if content is None:
            read = self.core.add_scene(path)
            if os.path.isfile(path):  # not of a pipe, which is read once
                with open(path, "rb") as file:
                    content = file.read()
        else:
            with tempfile.NamedTemporaryFile(suffix=".csv") as copy:
                copy.write(content)
                copy.flush()
                read = self.core.add_scene(copy.name)
        self._calls[next(self._number)] = ("add_scene", (path, content))
        return read

    def __reduce__(self) -> Any:
        return _again, (*self._made, self.calls())


def _again(kind: str, sizes: tuple[int, ...], calls: list[tuple[str, tuple[Any, ...]]]) -> Recorded:
    return Recorded(kind, *sizes).replay(calls)


class Callback:
    """A callback by its name, with the last argument of a compiled one. function None: there is none.

    nv has the velocities of the blocks of a block-sparse system.
    """

    def __init__(self, name: str, function: Any, user: Any = None, nv: Any = ()):
        self.name, self.function, self.user, self.nv = name, function, user, nv

    def core(self) -> tuple[Any, int, int]:
        """Returns the arguments of the extension module: a function of Python or None, address, user."""
        if self.function is None:
            return None, 0, 0
        pointer = _pointers.compiled(self.name, self.function, self.user)
        if pointer is None:
            lost = _pointers.rebound(self.name, self.function)
            if lost:
                warnings.warn(f"{self.name}: {lost} = ... rebinds the name and writes nothing: use {lost}[:] = ...", ModelWarning,
                              stacklevel=4)
            return _lists.wrapped(self.name, self.function, np.asarray(self.nv, dtype=int)), 0, 0
        return None, *pointer

    def __reduce__(self) -> Any:
        if self.function is None or _pointers.compiled(self.name, self.function, None) is None:
            return Callback, (self.name, self.function, None, self.nv)  # Python's have no user
        own = getattr(self.function, "user_data", None)
        user = _user(self.name, self.user if own is None else own)
        return _loaded, (self.name, _code(self.name, self.function), user, self.nv)


def _loaded(name: str, code: Any, user: Any, nv: Any) -> Callback:
    return Callback(name, code.load(), user, nv)


class _Symbol(NamedTuple):
    """A function of a shared library."""

    name: str
    path: str
    symbol: str

    def load(self) -> Any:
        function = getattr(ctypes.CDLL(self.path), self.symbol)
        return ctypes.cast(function, _pointers.signature(self.name, "ctypes"))


class _Source(NamedTuple):
    """A function that numba compiles where it is loaded, once in a process."""

    name: str
    function: bytes
    options: tuple[tuple[str, Any], ...]

    def load(self) -> Any:
        return _compile(self)


@functools.lru_cache
def _compile(source: _Source) -> Any:
    from numba import cloudpickle
    return _pointers.cfunc(source.name, **dict(source.options))(cloudpickle.loads(source.function))


class _Found(ctypes.Structure):
    """Dl_info of dladdr (POSIX.1-2024)."""

    _fields_ = [("path", ctypes.c_char_p), ("base", ctypes.c_void_p), ("symbol", ctypes.c_char_p), ("at", ctypes.c_void_p)]


def _code(name: str, function: Any) -> Any:
    """The code of a compiled function, by names that hold in another process."""
    if hasattr(function, "native_name"):
        from numba import cloudpickle
        compiler = function._compiler
        options = {**compiler.targetoptions, **({"locals": compiler.locals} if compiler.locals else {})}
        return _Source(name, cloudpickle.dumps(function._pyfunc), tuple(sorted(options.items())))
    address, _ = _pointers.compiled(name, function, None) or (0, 0)
    found = _Found()
    dladdr = getattr(ctypes.CDLL(None), "dladdr", None) if os.name == "posix" else None
    if dladdr is None or not dladdr(ctypes.c_void_p(address), ctypes.byref(found)) or found.at != address:
        raise TypeError(f"{name} cannot be pickled: its address is no exported symbol of a shared library; export it, or give "
                        "the function of Python or a numba.cfunc")
    return _Symbol(name, os.path.abspath(os.fsdecode(found.path)), found.symbol.decode())


def _user(name: str, user: Any) -> Any:
    """The last argument of a compiled callback, if it is data and no address."""
    pointer = isinstance(user, (int, ctypes._Pointer, ctypes.c_void_p)) or type(user).__name__ == "PyCapsule"
    if pointer or type(user).__module__ == "_cffi_backend":
        raise TypeError(f"{name} cannot be pickled: user is an address ({type(user).__name__}), which means nothing in "
                        "another process; give an array of NumPy or a structure of ctypes")
    return user
