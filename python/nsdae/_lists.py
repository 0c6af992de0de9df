"""Large systems: blocks of q and v, contacts by list, rows of Phi_q by blocks."""

from __future__ import annotations

import ctypes
from typing import Any, Callable

import numpy as np

from . import _core

# nsdae_contact, for compiled callbacks; wide: addresses, of blocks of more than 6 velocities
CONTACT = np.dtype([("id", "i8"), ("block", "i4", 2), ("gap", "f8"), ("mu", "f8"), ("e_n", "f8"), ("e_t", "f8"),
                    ("w", "f8", 3), ("omega", "f8", 3), ("direction", "f8", (2, 3, 6)), ("wide", "u8", 2)])
assert CONTACT.itemsize == _core.CONTACT_SIZE

# the library's functions, for numba and for what gets their addresses
contact_add = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(_core.CONTACT_ADD)
row_add = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_int, ctypes.c_void_p)(_core.ROW_ADD)


def _array(name: str, values: Any, shape: tuple[int, ...], kind: Any = float) -> np.ndarray:
    try:
        return np.ascontiguousarray(np.broadcast_to(np.asarray(values, dtype=kind), shape))
    except ValueError:
        raise ValueError(f"{name} has the shape {np.shape(values)}; it must be {shape}") from None


class ContactList:
    """The contacts that are near, filled by the callback contacts; it ends with the call."""

    __slots__ = ("_core",)

    def __init__(self, core: Any):
        self._core = core

    def add(self, id: Any, block: Any, gap: Any, direction: Any, *, mu: Any = 0, e_n: Any = 0, e_t: Any = 0,
            w: Any = 0) -> None:
        """Adds n contacts, or one: then without the dimension n. What is the same for all may be given once.

        id         [n] the same pair of features has the same at all times, no two at once the same one
        block      [n, 2] the two blocks, -1: the ground
        gap        [n] negative where they overlap
        direction  [n, 2, 1 + nt, nv]: direction[i, s, 0] is what the velocities of block s add to the rate of the gap,
                   direction[i, s, 1], [i, s, 2] to those of sliding; nv of the largest block
        mu, e_n, e_t   [n] friction and restitution;  w [n, 1 + nt] velocities along the directions with v = 0
        What is out of range fails the step; the error names the contact and the field.
        """
        id = np.atleast_1d(np.ascontiguousarray(id, dtype=np.int64))
        n, rows, direction = len(id), 1 + self._core.nt, np.asarray(direction, dtype=float)
        width = direction.shape[-1] if direction.ndim else 1
        law = np.empty((n, 3))
        law[:, 0], law[:, 1], law[:, 2] = mu, e_n, e_t
        self._core.add(id, _array("block", block, (n, 2), np.int64), _array("gap", gap, (n,)), law,
                       _array("w", w, (n, rows)), _array("direction", direction, (n, 2, rows, width)))


class RowList:
    """The rows of Phi_q, filled by the callback constraint_rows; it ends with the call."""

    __slots__ = ("_core",)

    def __init__(self, core: Any):
        self._core = core

    def add(self, row: Any, block: Any, value: Any) -> None:
        """value [n, nv]: the entries of rows [n] over the velocities of blocks [n]; or one, without the dimension n.
        Rows come in ascending order, each block of a row once."""
        row = np.atleast_1d(np.ascontiguousarray(row, dtype=np.int64))
        value = np.asarray(value, dtype=float)
        width = value.shape[-1] if value.ndim else 1
        self._core.add(row, _array("block", block, row.shape, np.int64), _array("value", value, (len(row), width)))


def sizes_of(blocks: Any) -> tuple[np.ndarray, np.ndarray]:
    """nq and nv of each: from [blocks] where they are the same, or [blocks, 2]."""
    sizes = np.asarray(blocks)
    if sizes.dtype.kind not in "iu" or sizes.ndim not in (1, 2) or sizes.ndim == 2 and sizes.shape[1] != 2:
        raise ValueError("blocks must be whole numbers: a size for each block, or [nq, nv]")
    sizes = sizes.astype(np.int32)
    pairs = sizes if sizes.ndim == 2 else np.column_stack([sizes, sizes])
    return np.ascontiguousarray(pairs[:, 0]), np.ascontiguousarray(pairs[:, 1])


class _Mass:
    """Shows the diagonal blocks one behind the other as M[b] [nv, nv]: where they are of one size as one array."""

    def __init__(self, function: Callable[..., Any], nv: np.ndarray):
        self.function, self.nv, self.kept = function, nv.tolist(), (None, None)

    def of(self, flat: np.ndarray) -> Any:
        if len(set(self.nv)) == 1:
            return flat.reshape(-1, self.nv[0], self.nv[0])
        first = np.cumsum([0, *(n * n for n in self.nv)])
        return [flat[a:b].reshape(n, n) for a, b, n in zip(first, first[1:], self.nv)]

    def __call__(self, t: float, q: np.ndarray, flat: np.ndarray) -> Any:
        of, shown = self.kept
        if of is not flat:  # the first time, or another thread's
            shown = self.of(flat)
            self.kept = flat, shown
        return self.function(t, q, shown)


def wrapped(name: str, function: Callable[..., Any], nv: np.ndarray) -> Callable[..., Any]:
    """The function as the library's half calls it."""
    if name == "mass_blocks":
        return _Mass(function, nv)
    if name == "constraint_rows":
        return lambda t, q, rows: function(t, q, RowList(rows))
    if name == "contacts":
        return lambda t, q, v, reach, found: function(t, q, v, reach, ContactList(found))
    return function
