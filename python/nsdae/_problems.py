"""Linear complementarity problems and friction problems."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np

from . import _core
from ._arguments import finite, named, numbers, refused
from ._errors import ProblemError, Status
from ._lists import _array
from ._records import LcpProblem
from ._system import vector


class LcpResult(NamedTuple):
    """Solution of a linear complementarity problem.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Solution, with y = A x + b. With a Farkas proof y is the vector that proves infeasibility.
    outcome : str
        "solved" (residual evaluated afresh, at most tol), "infeasible" (proved) or "unsolved".
    residual : float
        Scaled natural residual.
    stage : str
        Final stage of the chain.
    proof : str
        "none", "farkas" or "enumerated".
    ray : str
        Property of A that the ray of Lemke's method proves.
    pivots : int
        Pivots of all stages.
    """

    x: np.ndarray
    y: np.ndarray
    outcome: str
    residual: float
    stage: str
    proof: str
    ray: str
    pivots: int


class FrictionResult(NamedTuple):
    """Solution of a friction problem.

    Attributes
    ----------
    r : ndarray, shape (m,)
        Impulses [N s]. With the outcome "infeasible" the vector that proves it.
    u : ndarray, shape (m,)
        Velocities [m/s].
    outcome : str
        "solved" (residual evaluated afresh, at most tol), "infeasible" (proved) or "unsolved".
    residual : float
        Natural residual, dimensionless.
    stage : str
        Final solver.
    proof : str
        "none" or "farkas".
    islands : int
        Independent subproblems.
    sweeps, iterations, factorisations : int
        Work of the solvers.
    low : ndarray or None, shape (m,)
        Trailing part of a double-double solution r + low, with ``twice=True``. It is at most half a digit of r, and zero if r
        alone is a solution. u and residual are those of the sum.
    """

    r: np.ndarray
    u: np.ndarray
    outcome: str
    residual: float
    stage: str
    proof: str
    islands: int
    sweeps: int
    iterations: int
    factorisations: int
    low: Optional[np.ndarray] = None


def _judge(result: Any, problem: Any, check: bool) -> Any:
    if not check or result.outcome == "solved":
        return result
    infeasible = result.outcome == "infeasible"
    error = ProblemError(f"the problem has no solution: proved ({result.proof})" if infeasible else
                         f"no solution was found: residual {result.residual:.1e}",
                         Status.E_INFEASIBLE if infeasible else Status.E_LCP)
    error.problem, error.result = problem, result  # type: ignore[attr-defined]
    raise error


_MOST = 2**31 - 1  # of an int


def _dense(name: str, matrix: Any) -> np.ndarray:
    return matrix.toarray() if hasattr(matrix, "toarray") else numbers(name, matrix)


def _limits(tol: float, **limits: tuple[float, float]) -> None:
    """Checks a tolerance, and limits with the largest of each."""
    if not 0 < tol <= 1:
        raise refused("tol", f"tol = {tol}: must be above 0 and at most 1")
    for name, (value, most) in limits.items():
        if not 0 <= value <= most:
            raise refused(name, f"{name} = {value}: must be at least 0 and at most {most}")


@named
def lcp(A: Any, b: Any, x0: Any = None, *, tol: float = 1e-10, max_pivots: int = 0, enumerate_max: int = 12,
        check: bool = True) -> LcpResult:
    """Solves a linear complementarity problem: x >= 0, y = A x + b >= 0, x y = 0.

    Parameters
    ----------
    A : array_like or sparse matrix, shape (n, n)
    b : array_like, shape (n,)
    x0 : array_like, optional
        Guess; its positive entries are the first active set.
    tol : float
        Bound on the residual.
    max_pivots : int
        Pivots of one run of Lemke's method; 0: the default of the library.
    enumerate_max : int
        Largest n for the enumeration of active sets.
    check : bool
        False: return the outcome instead of an exception.

    Returns
    -------
    LcpResult

    Raises
    ------
    ProblemError
        The problem has no solution, or none was found.

    Examples
    --------
    >>> nsdae.lcp([[2, 1], [1, 2]], [-1, 1]).x
    array([0.5, 0. ])
    """
    A = np.asfortranarray(finite("A", _dense("A", A)), dtype=float)
    if A.ndim != 2 or A.shape[0] != A.shape[1]:
        raise refused("A", f"A has the shape {A.shape}; it must be (n, n)")
    b = finite("b", vector("b", b, len(A)))
    guess = None if x0 is None else vector("x0", x0, len(A))
    _limits(tol, max_pivots=(max_pivots, _MOST), enumerate_max=(enumerate_max, 24))
    x, y, how = _core.lcp(A, b, guess, float(tol), max_pivots, enumerate_max)
    return _judge(LcpResult(x, y, **how), LcpProblem(A, b), check)


def _entries(name: str, matrix: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[int, int]]:
    """Rows, columns, values and shape; repeated entries are summed."""
    if hasattr(matrix, "tocoo"):
        coo = matrix.tocsr().tocoo()
        row, column, value, shape = coo.row.astype(np.int64), coo.col.astype(np.int64), coo.data.astype(float), coo.shape
    else:
        dense = np.atleast_2d(numbers(name, matrix))
        if dense.ndim > 2:
            raise refused(name, f"{name} has the shape {dense.shape}; it must be a matrix")
        row, column = np.nonzero(dense)
        value, shape = dense[row, column], dense.shape
    return row, column, finite(name, value, row, column), shape


def _components(n: int, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Connected component of each of n nodes with these edges.

    Each node takes the least label of its neighbours, and the label of that node, until nothing changes.
    """
    label = np.arange(n)
    while True:
        before = label.copy()
        least = np.minimum(label[row], label[column])
        np.minimum.at(label, row, least)
        np.minimum.at(label, column, least)
        label = label[label]
        if np.array_equal(label, before):
            return np.unique(label, return_inverse=True)[1]


def _spans(sizes: np.ndarray) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _by_items(rows_block: np.ndarray, rows_at: np.ndarray, size: np.ndarray, entries: Any,
              items: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A matrix [., m] by items: first, block and value of nsdae_friction_problem.

    rows_block and rows_at are the block of each row and its place there; items are the numbers of columns of each item.
    """
    row, column, value, _ = entries
    start = _spans(items)
    item = np.searchsorted(start, column, side="right") - 1
    key = item * len(size) + rows_block[row]
    parts, part = np.unique(key, return_inverse=True)
    owner, block = parts // max(len(size), 1), parts % max(len(size), 1)
    at = _spans(size[block] * items[owner])
    dense = np.zeros(at[-1])
    np.add.at(dense, at[part] + (column - start[item]) * size[block[part]] + rows_at[row], value)
    first = np.searchsorted(owner, np.arange(len(items) + 1))
    return first.astype(np.intc), block.astype(np.intc), dense


def _within(label: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Size of each block, the place of each row in its block, and the rows block by block."""
    size = np.bincount(label, minlength=count)
    order = np.argsort(label, kind="stable")
    place = np.empty(len(label), dtype=np.int64)
    place[order] = np.arange(len(label)) - np.repeat(_spans(size)[:-1], size)
    return size, place, order


def _counts(mu: np.ndarray, rows: Any, m: int) -> tuple[np.ndarray, int]:
    """Rows of each contact, and the number of bilateral rows after them."""
    if np.asarray(rows).dtype.kind not in "iu":
        raise refused("rows", f"rows = {rows}: must be integers, 1, 2 or 3")
    rows = _array("rows", rows, mu.shape, np.intc)
    bilateral = m - int(rows.sum())
    if bilateral < 0:
        raise refused("rows", f"{len(mu)} contacts have {int(rows.sum())} rows, more than the {m} of the problem")
    return np.ascontiguousarray(rows), bilateral


def _solve_friction(arrays: dict[str, Any], problem: Any, r0: Any, tol: float, max_sweeps: int, max_iterations: int,
                    budget: float, progress: Any, check: bool, twice: bool) -> FrictionResult:
    guess = None if r0 is None else vector("r0", r0, len(arrays["w"]))
    _limits(tol, max_sweeps=(max_sweeps, _MOST), max_iterations=(max_iterations, _MOST), budget=(budget, np.inf))
    r, u, how = _core.friction(arrays, guess, float(tol), max_sweeps, max_iterations, float(budget), progress,
                              bool(twice))
    return _judge(FrictionResult(r, u, **how), problem, check)


def _vector(name: str, values: Any, n: int) -> np.ndarray:
    return np.zeros(n) if values is None else finite(name, vector(name, values, n))


@named
def friction(H: Any, M: Any, f: Any, mu: Any, w: Any = None, *, rows: Any = 3, compliance: Any = None, r0: Any = None,
             tol: float = 1e-10, max_sweeps: int = 0, max_iterations: int = 0, budget: float = 0, progress: Any = None,
             check: bool = True, twice: bool = False) -> FrictionResult:
    """Solves a friction problem in the global form.

    The equations are M v = f + H r and u = H^T v + w + C r. For each contact r is in the cone |r_T| <= mu r_N, u + mu |u_T| e_N is
    in the dual cone, and both are orthogonal. In bilateral rows u = 0.

    Parameters
    ----------
    H : array_like or sparse matrix, shape (nv, m)
        One column per direction. Each contact has its normal direction first; bilateral directions follow all contacts.
    M : array_like or sparse matrix, shape (nv, nv)
        Symmetric positive definite; its diagonal blocks are detected.
    f : array_like, shape (nv,)
    mu : array_like, shape (contacts,)
        Coefficients of friction.
    w : array_like, shape (m,), optional
        Default zero.
    rows : int or array_like of int
        Rows of each contact: 1 (frictionless), 2 (planar) or 3 (spatial).
    compliance : array_like, shape (m,), optional
        Diagonal of C >= 0, default zero.
    r0 : array_like, shape (m,), optional
        Guess.
    tol : float
        Bound on the residual.
    max_sweeps, max_iterations : int
        Limits of the solvers; 0: by the budget.
    budget : float
        Multiplications by J = L^-1 H for an island, or the equivalent time; 0: about a minute at most.
    progress : callable, optional
        Called about ten times per second with a dict: stage, island, islands, contacts, residual, share (of the budget),
        sweeps, iterations. A true result interrupts the solver, and the best iterate is "unsolved".
    check : bool
        False: return the outcome instead of an exception.
    twice : bool
        True: compute a double-double solution r + low.

    Returns
    -------
    FrictionResult

    Raises
    ------
    ProblemError
        The problem has no solution, or none was found.

    Notes
    -----
    Use ``twice`` if masses of bodies in contact differ by about 1e6. The impulses on a light body then differ by its weight, which
    is below their rounding. An array with the sum r + low is rounded to r. Apply r and low one after the other, or use
    ``fractions.Fraction``.
    """
    of_H, of_M = _entries("H", H), _entries("M", M)
    nv, m = of_H[3]
    if of_M[3] != (nv, nv):
        raise refused("M", f"M is {of_M[3][0]} x {of_M[3][1]}; H has {nv} rows, so it must be {nv} x {nv}")
    mu = np.ascontiguousarray(np.atleast_1d(finite("mu", numbers("mu", mu))))
    count, bilateral = _counts(mu, rows, m)
    label = _components(nv, of_M[0], of_M[1])
    size, place, order = _within(label, label.max(initial=-1) + 1)
    dense = np.zeros(int(np.sum(size * size)))
    at = _spans(size * size)[:-1][label[of_M[0]]]
    np.add.at(dense, at + place[of_M[1]] * size[label[of_M[1]]] + place[of_M[0]], of_M[2])
    items = np.concatenate([count, np.ones(bilateral, dtype=np.intc)]).astype(np.int64)
    first, block, value = _by_items(label, place, size, of_H, items)
    arrays = {"form": 0, "contacts": len(mu), "bilateral": bilateral, "rows": count, "mu": mu,
              "w": _vector("w", w, m), "compliance": _vector("compliance", compliance, m),
              "size": size.astype(np.intc), "M": dense, "f": _vector("f", f, nv)[order],
              "first": first, "block": block, "value": value}
    return _solve_friction(arrays, (H, M, f, mu, w), r0, tol, max_sweeps, max_iterations, budget, progress, check, twice)


@named
def friction_local(W: Any, q: Any, mu: Any, *, rows: Any = 3, compliance: Any = None, r0: Any = None, tol: float = 1e-10,
                   max_sweeps: int = 0, max_iterations: int = 0, budget: float = 0, progress: Any = None,
                   check: bool = True, twice: bool = False) -> FrictionResult:
    """Solves a friction problem in the local form u = W r + q + C r.

    Contact laws, results and exceptions are those of `friction`.

    Parameters
    ----------
    W : array_like or sparse matrix, shape (m, m)
        Symmetric positive semidefinite (Delassus operator).
    q : array_like, shape (m,)
        Free velocities.
    mu : array_like, shape (contacts,)
        Coefficients of friction.
    rows, compliance, r0, tol, max_sweeps, max_iterations, budget, progress, check, twice
        As for `friction`.

    Returns
    -------
    FrictionResult
    """
    of_W = _entries("W", W)
    m = of_W[3][0]
    if of_W[3] != (m, m):
        raise refused("W", f"W is {m} x {of_W[3][1]}; it must be square")
    mu = np.ascontiguousarray(np.atleast_1d(finite("mu", numbers("mu", mu))))
    count, bilateral = _counts(mu, rows, m)
    items = np.concatenate([count, np.ones(bilateral, dtype=np.intc)]).astype(np.int64)
    item_of_row = np.repeat(np.arange(len(items)), items)
    place = np.arange(m) - _spans(items)[:-1][item_of_row]
    first, block, value = _by_items(item_of_row, place, items, of_W, items)
    arrays = {"form": 1, "contacts": len(mu), "bilateral": bilateral, "rows": count, "mu": mu, "w": _vector("q", q, m),
              "compliance": _vector("compliance", compliance, m), "size": np.zeros(0, dtype=np.intc), "M": np.zeros(0),
              "f": np.zeros(0), "first": first, "block": block, "value": value}
    return _solve_friction(arrays, (W, q, mu), r0, tol, max_sweeps, max_iterations, budget, progress, check, twice)
