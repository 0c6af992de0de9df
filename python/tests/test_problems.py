"""lcp() and friction() against what they solve."""

from fractions import Fraction

import numpy as np
import pytest

import nsdae


def natural(x, y):
    return np.max(np.abs(np.minimum(x, y)), initial=0)


@pytest.mark.parametrize("seed", range(20))
def test_lcp_of_a_positive_definite_matrix(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 30))
    B = random.normal(size=(n, n))
    A, b = B @ B.T + np.eye(n), random.normal(size=n)
    found = nsdae.lcp(A, b)
    assert found.outcome == "solved" and natural(found.x, A @ found.x + b) < 1e-9 * np.abs(A).max()
    warm = nsdae.lcp(A, b, found.x)
    assert warm.stage in ("trivial", "warm") and np.allclose(warm.x, found.x)


def test_lcp_without_a_solution_is_proved():
    A, b = [[0, 0], [0, 0]], [1, -1]
    with pytest.raises(nsdae.ProblemError, match="no solution") as caught:
        nsdae.lcp(A, b)
    assert caught.value.status == nsdae.Status.E_INFEASIBLE and caught.value.result.proof == "farkas"
    assert np.array_equal(caught.value.problem.b, b)
    assert nsdae.lcp(A, b, check=False).outcome == "infeasible"


def test_lcp_refusals():
    with pytest.raises(ValueError, match="b has 2 numbers; it must have 3"):
        nsdae.lcp(np.eye(3), [1, 2])
    with pytest.raises(nsdae.Error) as caught:
        nsdae.lcp([[np.nan]], [1])
    assert caught.value.status == nsdae.Status.E_NONFINITE
    with pytest.raises(nsdae.Error):
        nsdae.lcp([[1]], [1], tol=-1)
    assert nsdae.lcp(np.zeros((0, 0)), []).outcome == "solved"


def cone_residual(r, u, mu, scale_r, scale_u):
    """|x - P_K(x - y)| of one contact, P_K computed here."""
    x = r / scale_r
    y = np.array([u[0] + mu * np.hypot(u[1], u[2]), u[1], u[2]]) / scale_u
    n, t = (x - y)[0], (x - y)[1:]
    s = np.hypot(*t)
    if s <= mu * n:
        p = x - y
    elif mu * s <= -n:
        p = np.zeros(3)
    else:
        along = (n + mu * s) / (1 + mu * mu)
        p = np.concatenate([[along], mu * along * t / s])
    return np.max(np.abs(x - p))


def random_problem(seed, bodies=4, contacts=6):
    random = np.random.default_rng(seed)
    blocks = []
    for _ in range(bodies):
        B = random.normal(size=(3, 3))
        blocks.append(B @ B.T + np.eye(3))
    order = random.permutation(3 * bodies)  # the blocks of M are not in sight
    M = np.zeros((3 * bodies, 3 * bodies))
    for i, block in enumerate(blocks):
        M[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = block
    M = M[np.ix_(order, order)]
    H = np.zeros((3 * bodies, 3 * contacts))
    for c in range(contacts):
        for body in random.choice(bodies, 2, replace=False):
            H[3 * body : 3 * body + 3, 3 * c : 3 * c + 3] = random.normal(size=(3, 3))
    return M, H[order], random.normal(size=3 * bodies), random.uniform(0.1, 1, contacts), np.abs(random.normal(size=3 * contacts))


@pytest.mark.parametrize("seed", range(10))
def test_friction_global_and_local(seed):
    M, H, f, mu, w = random_problem(seed)
    found = nsdae.friction(H, M, f, mu, w)
    W, q = H.T @ np.linalg.solve(M, H), H.T @ np.linalg.solve(M, f) + w
    assert found.outcome == "solved" and np.allclose(found.u, W @ found.r + q, atol=1e-8)
    local = nsdae.friction_local(W, q, mu)
    for result in (found, local):
        u = W @ result.r + q
        for c in range(len(mu)):
            part = slice(3 * c, 3 * c + 3)
            scale = np.max(np.abs(q))
            worst = cone_residual(result.r[part], u[part], mu[c], scale / np.mean(np.diag(W)[part]), scale)
            assert worst < 1e-7, (seed, c, worst)


def test_friction_of_sparse_matrices():
    sparse = pytest.importorskip("scipy.sparse", reason="scipy is not here")
    M, H, f, mu, w = random_problem(3)
    dense = nsdae.friction(H, M, f, mu, w)
    for kind in ("csr_matrix", "csc_matrix", "coo_matrix"):
        make = getattr(sparse, kind)
        assert np.array_equal(nsdae.friction(make(H), make(M), f, mu, w).r, dense.r)


def test_planar_frictionless_and_bilateral_rows():
    """A block of mass 2 on a table (planar, slides), a wall without friction, and a bar that holds it upright."""
    M = np.diag([2.0, 2.0, 2.0])
    H = np.zeros((3, 4))
    H[1, 0] = H[0, 1] = 1  # table: normal y, tangent x
    H[0, 2] = -1           # wall to the right: normal -x
    H[2, 3] = 1            # z is held
    found = nsdae.friction(H, M, [4, -6, 1], [0.5, 0.0], [0, 0, 10, 0], rows=[2, 1])
    assert np.allclose(found.r, [6, -3, 0, -1], atol=1e-9)  # normal 6, friction mu 6, no wall, bar against f
    assert np.allclose(found.u, [0, 0.5, 9.5, 0], atol=1e-9)


def test_friction_without_a_solution():
    """A contact whose normal velocity nothing can change."""
    with pytest.raises(nsdae.ProblemError):
        nsdae.friction(np.zeros((1, 3)), [[1.0]], [0], [0.3], [-1, 0, 0])


LIGHT, WEIGHT, WIND = 3e-7, 0.1, 0.03


def light_under_heavy():
    """H, M, f, mu, rows: a body of mass 1 on one of LIGHT on the ground, planar, pushed from the side. Their impulses
    differ by what the light one takes, which is no multiple of their last digit."""
    H = np.array([[1, 0, -1, 0], [0, 1, 0, -1], [0, 0, 1, 0], [0, 0, 0, 1]], dtype=float)
    f = [-LIGHT * WEIGHT, LIGHT * WIND, -WEIGHT, WIND]
    return H, np.diag([LIGHT, LIGHT, 1.0, 1.0]), f, [0.5, 0.5], 2


def standing(H, M, f, r, low):
    """max |u| / s in exact arithmetic, the residual where all contacts stick and r is inside the cones."""
    n, m = H.shape
    total = [Fraction(r[c]) + Fraction(low[c]) for c in range(m)]
    assert all(abs(total[c + 1]) < total[c] / 2 for c in range(0, m, 2))
    v = [(Fraction(f[i]) + sum(Fraction(H[i, c]) * total[c] for c in range(m))) / Fraction(M[i, i]) for i in range(n)]
    return float(max(abs(sum(Fraction(H[i, c]) * v[i] for i in range(n))) for c in range(m))) / WEIGHT


def test_friction_in_two_parts():
    H, M, f, mu, rows = light_under_heavy()
    alone = nsdae.friction(H, M, f, mu, rows=rows, tol=1e-12, check=False)
    assert alone.outcome == "unsolved" and alone.low is None
    assert alone.residual > 1e-12 and standing(H, M, f, alone.r, np.zeros(4)) > 1e-12
    both = nsdae.friction(H, M, f, mu, rows=rows, tol=1e-12, twice=True)
    assert both.outcome == "solved" and both.residual <= 1e-12
    assert both.low.shape == (4,) and np.any(both.low) and np.array_equal(both.r + both.low, both.r)
    assert standing(H, M, f, both.r, both.low) <= 1e-12 < standing(H, M, f, both.r, np.zeros(4))
    again = nsdae.friction(H, M, f, mu, rows=rows, tol=1e-12, twice=True)
    assert np.array_equal(again.r, both.r) and np.array_equal(again.low, both.low)


def test_the_least_residual_of_doubles():
    """Upright and without friction, as docs/friction.md has it: impulses near 0.1 are multiples of 2**-56, and what the
    weight of the light one lacks to the nearest one accelerates it."""
    H, f = np.array([[1, -1], [0, 1]], dtype=float), [-3e-8, -0.1]
    digit, weight = Fraction(1, 2**56), Fraction(3e-8)
    lacks = abs(weight - round(weight / digit) * digit)
    least = float(lacks / Fraction(3e-7) / Fraction(0.1))
    alone = nsdae.friction(H, np.diag([3e-7, 1]), f, [0, 0], rows=1, tol=1e-12, check=False)
    assert f"{least:.1e}" == "6.4e-11" and f"{float(lacks):.1e}" == "1.9e-18"
    assert alone.outcome == "unsolved" and least * (1 - 1e-9) <= alone.residual < 1e-9
    both = nsdae.friction(H, np.diag([3e-7, 1]), f, [0, 0], rows=1, tol=1e-12, twice=True)
    assert both.residual < 1e-15 and np.all(np.abs(both.low) <= np.spacing(both.r) / 2)


def test_friction_local_in_two_parts():
    """The same with masses that are powers of two: W is that of the bodies to the last bit."""
    light = 2.0**-22
    H, _, _, mu, rows = light_under_heavy()
    M, f = np.diag([light, light, 1, 1]), np.array([-light * WEIGHT, light * WIND, -WEIGHT, WIND])
    W, q = H.T @ np.diag(1 / np.diag(M)) @ H, H.T @ (f / np.diag(M))
    assert nsdae.friction_local(W, q, mu, rows=rows, tol=1e-12, check=False).low is None
    both = nsdae.friction_local(W, q, mu, rows=rows, tol=1e-12, twice=True)
    assert both.outcome == "solved" and both.low.shape == (4,)
    total = [Fraction(r) + Fraction(low) for r, low in zip(both.r, both.low)]
    u = [Fraction(q[i]) + sum(Fraction(W[i, j]) * total[j] for j in range(4)) for i in range(4)]
    assert float(max(map(abs, u))) <= 1e-12 * np.max(np.abs(q))


def test_friction_in_two_parts_where_one_is_enough():
    M, H, f, mu, w = random_problem(3)
    one, both = nsdae.friction(H, M, f, mu, w), nsdae.friction(H, M, f, mu, w, twice=True)
    assert np.array_equal(both.low, np.zeros(len(w)))
    assert np.array_equal(one.r, both.r) and np.array_equal(one.u, both.u)
    assert (one.stage, one.sweeps, one.iterations) == (both.stage, both.sweeps, both.iterations)
    assert one.residual <= 1e-10 and both.residual <= 1e-10  # that of two parts is rounded less
    assert nsdae.friction(np.zeros((1, 0)), [[1.0]], [0], [], twice=True).low.shape == (0,)
    none = nsdae.friction(np.zeros((1, 3)), [[1.0]], [0], [0.3], [-1, 0, 0], twice=True, check=False)
    assert none.outcome == "infeasible" and np.array_equal(none.low, np.zeros(3))


def test_friction_progress_and_interruption():
    M, H, f, mu, w = random_problem(3)
    seen = []

    def stop(now):
        seen.append(now)
        return True

    best = nsdae.friction(H, M, f, mu, w, progress=stop, check=False)
    assert best.outcome == "unsolved" and len(seen) == 1 and np.all(best.r == 0)
    assert set(seen[0]) == {"stage", "island", "islands", "contacts", "residual", "share", "sweeps", "iterations"}
    assert nsdae.friction(H, M, f, mu, w, progress=seen.append).outcome == "solved"

    def fail(now):
        raise KeyError(now["stage"])

    with pytest.raises(KeyError):
        nsdae.friction(H, M, f, mu, w, progress=fail)
    short = nsdae.friction(H, M, f, mu, w, tol=1e-14, budget=1, check=False)
    assert short.outcome == "unsolved" and short.iterations == 0


@pytest.mark.parametrize("change, what", [({"f": [1]}, "f has"), ({"w": [1]}, "w has"), ({"rows": 4}, "rows|more than"),
                                          ({"mu": [-1]}, "mu")])
def test_friction_refusals(change, what):
    told = {"H": np.eye(3), "M": np.eye(3), "f": [0, 0, 0], "mu": [0.5], **change}
    with pytest.raises(ValueError, match=what):
        nsdae.friction(**told)
    with pytest.raises(nsdae.Error) as caught:
        nsdae.friction(np.eye(3), -np.eye(3), [0, 0, 0], [0.5])
    assert caught.value.status == nsdae.Status.E_MASS
