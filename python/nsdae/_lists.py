"""Block-sparse systems: blocks of q and v, contact lists, block-sparse Jacobians."""

from __future__ import annotations

import ctypes
from typing import Any, Callable

import numpy as np

from . import _core
from ._arguments import refused

# nsdae_contact, for compiled callbacks; wide: addresses, of blocks of more than 6 velocities
CONTACT = np.dtype([("id", "i8"), ("block", "i4", 2), ("gap", "f8"), ("mu", "f8"), ("e_n", "f8"), ("e_t", "f8"),
                    ("w", "f8", 3), ("omega", "f8", 3), ("omega_given", "i4"), ("direction", "f8", (2, 3, 6)),
                    ("wide", "u8", 2)], align=True)
assert CONTACT.itemsize == _core.CONTACT_SIZE

# the library's functions, for numba and compiled callbacks
contact_add = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(_core.contact_add())
_ADD = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_int, ctypes.c_void_p)
row_add, block_add = _ADD(_core.row_add()), _ADD(_core.block_add())


def _array(name: str, values: Any, shape: tuple[int, ...], kind: Any = float) -> np.ndarray:
    try:
        return np.ascontiguousarray(np.broadcast_to(np.asarray(values, dtype=kind), shape))
    except ValueError:
        raise refused(name, f"{name} has the shape {np.shape(values)}; it must be {shape}") from None


def _whole(name: str, values: Any, shape: tuple[int, ...]) -> np.ndarray:
    """An array of integers; a fraction is not cut."""
    given = np.asarray(values)
    if given.dtype.kind == "f":
        wrong = given[~(given == np.rint(given))]
        if wrong.size:
            raise refused(name, f"{name} = {wrong.flat[0]:g} is not a whole number")
    return _array(name, values, shape, np.int64)


class ContactList:
    """Contact list, filled by the callback ``contacts``. It is valid until the callback returns."""

    __slots__ = ("_core",)

    def __init__(self, core: Any):
        self._core = core

    def add(self, id: Any, block: Any, gap: Any, direction: Any, *, mu: Any = 0, e_n: Any = 0, e_t: Any = 0,
            w: Any = 0, omega: Any = None) -> None:
        """Adds n contacts, or one contact without the dimension n.

        Values that are equal for all contacts can be given once.

        Parameters
        ----------
        id : array_like of int, shape (n,)
            Identifier of the pair of features, unique and constant in time.
        block : array_like of int, shape (n, 2)
            The two blocks; -1 is the ground.
        gap : array_like, shape (n,)
            Normal distance, negative in overlap [m].
        direction : array_like, shape (n, 2, 1 + nt, nv)
            ``direction[i, s, 0]`` maps the velocities of block s to the rate of the gap. ``direction[i, s, 1]`` and
            ``[i, s, 2]`` map them to the slip velocities. nv is that of the largest block.
        mu, e_n, e_t : array_like, shape (n,)
            Coefficient of friction, normal and tangential restitution.
        w : array_like, shape (n, 1 + nt)
            Velocities along the directions at v = 0 [m/s].
        omega : array_like, shape (n, 1 + nt), optional
            Accelerations along the directions at v' = 0 [m/s^2], for method event. By default they are computed by
            differences.

        Raises
        ------
        ValueError
            A shape is wrong.

        Notes
        -----
        Values out of range fail the step. The error names the contact and the field.
        """
        id = _whole("id", id, np.shape(np.atleast_1d(id)))
        n, rows, direction = len(id), 1 + self._core.nt, np.asarray(direction, dtype=float)
        width = direction.shape[-1] if direction.ndim else 1
        law = np.empty((n, 3))
        law[:, 0], law[:, 1], law[:, 2] = mu, e_n, e_t
        given = omega is not None
        self._core.add(id, _whole("block", block, (n, 2)), _array("gap", gap, (n,)), law,
                       _array("w", w, (n, rows)), given, _array("omega", omega if given else 0, (n, rows)),
                       _array("direction", direction, (n, 2, rows, width)))


class RowList:
    """Rows of the block-sparse Jacobian Phi_q, filled by ``constraint_rows``, or of W_S^T, filled by ``joint_friction_rows``. It is
    valid until the callback returns."""

    __slots__ = ("_core",)

    def __init__(self, core: Any):
        self._core = core

    def add(self, row: Any, block: Any, value: Any) -> None:
        """Adds n entries, or one entry without the dimension n.

        Rows must be in ascending order, and each block occurs once per row.

        Parameters
        ----------
        row : array_like of int, shape (n,)
            Rows.
        block : array_like of int, shape (n,)
            Blocks.
        value : array_like, shape (n, nv)
            Entries of the rows for the velocities of the blocks.
        """
        row = _whole("row", row, np.shape(np.atleast_1d(row)))
        value = np.asarray(value, dtype=float)
        width = value.shape[-1] if value.ndim else 1
        self._core.add(row, _whole("block", block, row.shape), _array("value", value, (len(row), width)))


class BlockList:
    """Blocks of D = -dF/dv or K = -(dF/dq) H, filled by ``force_damping_blocks`` and ``force_stiffness_blocks``. It is valid until
    the callback returns."""

    __slots__ = ("_core",)

    def __init__(self, core: Any):
        self._core = core

    def add(self, row: Any, column: Any, value: Any) -> None:
        """Adds n blocks, or one block without the dimension n. Blocks that come again are summed.

        Parameters
        ----------
        row, column : array_like of int, shape (n,)
            The blocks of velocities.
        value : array_like, shape (n, nv, nv)
            Entries [velocity of row, velocity of column].
        """
        row = _whole("row", row, np.shape(np.atleast_1d(row)))
        value = np.asarray(value, dtype=float)
        shape = value.shape[-2:] if value.ndim > 1 else (1, 1)
        self._core.add(row, _whole("column", column, row.shape), _array("value", value, (len(row), *shape)))


def sizes_of(blocks: Any) -> tuple[np.ndarray, np.ndarray]:
    """Returns nq and nv of each block, from shape (blocks,) or (blocks, 2)."""
    sizes = np.asarray(blocks)
    if sizes.dtype.kind not in "iu" or sizes.ndim not in (1, 2) or sizes.ndim == 2 and sizes.shape[1] != 2:
        raise refused("blocks", "blocks must be whole numbers: a size for each block, or [nq, nv]")
    sizes = sizes.astype(np.int32)
    pairs = sizes if sizes.ndim == 2 else np.column_stack([sizes, sizes])
    return np.ascontiguousarray(pairs[:, 0]), np.ascontiguousarray(pairs[:, 1])


class _Mass:
    """Shows the diagonal blocks as M[b], shape (nv, nv); as one array if all have the same size."""

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
    """Returns the function with the arguments of the extension module."""
    if name == "mass_blocks":
        return _Mass(function, nv)
    if name == "constraint_rows":
        return lambda t, q, rows: function(t, q, RowList(rows))
    if name == "joint_friction_rows":
        return lambda t, q, rows, w_s: function(t, q, RowList(rows), w_s)
    if name in ("force_damping_blocks", "force_stiffness_blocks"):
        return lambda t, q, v, blocks: function(t, q, v, BlockList(blocks))
    if name == "contacts":
        return lambda t, q, v, reach, found: function(t, q, v, reach, ContactList(found))
    return function
