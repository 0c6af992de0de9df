"""Large systems: blocks, contacts by list, rows by blocks; beside the same with everything dense and numbered."""

import threading

import h5py
import numpy as np
import pytest

import nsdae
from conftest import G
from test_files import layout, needs_programs, program, same

N = 7  # balls on one another, of diameter 1


def masses(n=N):
    return np.where(np.arange(n) % 2, 10.0, 1.0)


def column(n=N, contacts=None, **told):
    """Balls that move along one line, one block each."""
    below = np.column_stack([np.arange(n), np.arange(n) - 1])
    direction = np.zeros((2, 1, 1))
    direction[:, 0, 0] = 1, -1

    def mass_blocks(t, q, M):
        M[:, 0, 0] = masses(n)

    def force(t, q, v, F):
        F[:] = -G * masses(n)

    def near(t, q, v, reach, found):
        gap = np.diff(q, prepend=-0.5) - 1
        near = gap <= reach
        found.add(100 + np.flatnonzero(near), below[near], gap[near], direction, e_n=0.3)

    return nsdae.System(blocks=np.ones(n, dtype=int), mass_blocks=mass_blocks, force=force, contacts=contacts or near, **told)


def numbered_column():
    def mass(t, q, M):
        np.fill_diagonal(M, masses())

    def force(t, q, v, F):
        F[:] = -G * masses()

    def gap(t, q, g):
        g[:] = np.diff(q, prepend=-0.5) - 1

    return nsdae.System(nq=N, k=N, e_n=0.3, mass=mass, force=force, gap=gap)


def numbered_blocks():
    def mass_blocks(t, q, M):
        M[:, 0, 0] = masses()

    def force(t, q, v, F):
        F[:] = -G * masses()

    def gap(t, q, g):
        g[:] = np.diff(q, prepend=-0.5) - 1

    return nsdae.System(blocks=np.ones(N, dtype=int), k=N, e_n=0.3, mass_blocks=mass_blocks, force=force, gap=gap)


HIGH = np.arange(N) * 1.05 + 0.6  # each falls on the one below


@pytest.mark.parametrize("method", ["moreau", "implicit", "penalty"])
def test_fixed_contacts_by_blocks(method):
    """The motion of the dense system, by methods without contact lists too; a contact list is refused."""
    blocks = nsdae.solve(numbered_blocks(), 0.2, HIGH, method=method, dt=1e-3)
    dense = nsdae.solve(numbered_column(), 0.2, HIGH, method=method, dt=1e-3)
    assert np.allclose(blocks.q, dense.q, atol=1e-9) and len(blocks.impacts) == len(dense.impacts) > 0
    assert blocks.blocks is None and numbered_blocks().blocks.shape == (N, 2)
    with pytest.raises(nsdae.Error, match="k must be 0"):
        numbered_blocks().set(contacts=lambda t, q, v, reach, found: None)


@pytest.mark.parametrize("method", ["moreau", "implicit"])
def test_a_list_is_as_good_as_numbers(method):
    """The same motion; and what a record says of its contacts is what the arrays say of the numbered ones."""
    listed = nsdae.solve(column(), 0.6, HIGH, method=method, dt=1e-3)
    dense = nsdae.solve(numbered_column(), 0.6, HIGH, method=method, dt=1e-3)
    assert np.allclose(listed.q, dense.q, atol=1e-9) and np.allclose(listed.v, dense.v, atol=1e-7)
    assert len(listed.impacts) == len(dense.impacts) > 10
    assert (listed.impacts["contact"] == -1).all() and (dense.impacts["block"] == -1).all()
    order = np.lexsort((listed.impacts["id"], listed.impacts["time"]))
    assert np.array_equal(listed.impacts["id"][order] - 100,
                          dense.impacts["contact"][np.lexsort((dense.impacts["contact"], dense.impacts["time"]))])
    assert np.array_equal(listed.impacts["block"], np.column_stack([listed.impacts["id"] - 100, listed.impacts["id"] - 101]))
    got = np.zeros_like(dense.normal_impulse)
    for i in range(len(listed)):
        at = listed.contacts_at(i)
        got[i, at["id"] - 100] = at["normal_impulse"]
    assert np.allclose(got, dense.normal_impulse, atol=1e-8)
    assert len(listed.contacts) == listed.contact_count.sum() and listed.contact_count[0] == 0
    assert dense.contacts.shape == (len(dense), N) and (dense.contact_count == N).all()
    assert np.array_equal(dense.contacts_at(-1), dense.contacts[-1]) and (dense.contacts["block"] == -1).all()
    assert np.array_equal(dense.contacts["id"], np.tile(np.arange(N), (len(dense), 1)))
    assert np.array_equal(listed.gap, listed.contacts["gap"]) and listed.tangential_impulse.shape == (len(listed.contacts), 0)


def test_event_on_a_list(tmp_path):
    """Impacts and mode transitions are those of fixed contacts, by id; the file has them."""
    listed = nsdae.solve(column(), 0.6, HIGH, method="event", dt=1e-2)
    fixed = nsdae.solve(numbered_column(), 0.6, HIGH, method="event", dt=1e-2)
    for one, other in ((listed.impacts, fixed.impacts), (listed.changes, fixed.changes)):
        assert len(one) == len(other) > 5 and (one["contact"] == -1).all() and (one["block"][:, 0] >= 0).all()
        assert np.allclose(one["time"], other["time"], rtol=1e-9)
        a, b = (np.lexsort((rows["id"], np.round(rows["time"], 8))) for rows in (one, other))
        assert np.array_equal(one["id"][a] - 100, other["id"][b])
    listed.save(tmp_path / "listed.h5")
    same(nsdae.load(tmp_path / "listed.h5"), listed)


def test_a_column_at_rest_carries_its_weight():
    system = column()
    assert system.dims[:4] == (N, N, 0, 0) and system.blocks.tolist() == [[1, 1]] * N
    sim = nsdae.Sim(system, method="moreau", dt=1e-3)
    sim.init(np.arange(N) + 0.5)
    for record in sim.steps(0.02):
        contacts = record.contacts
    carried = np.cumsum(masses()[::-1])[::-1] * G
    assert contacts["id"].tolist() == [100 + i for i in range(N)] and (contacts["mode"] == nsdae.SLIP).all()
    assert np.allclose(contacts["normal_impulse"] / record.duration, carried, rtol=1e-9)
    assert sim.stats["islands"] == 1 and sim.stats["island_contacts"] == N and sim.stats["contact_capacity"] >= N
    one = nsdae.System(nq=1, mass=lambda t, q, M: M.fill(1), force=lambda t, q, v, F: None)
    assert one.blocks is None and nsdae.solve(one, 0.01, [0]).contacts.size == 0


def test_check_and_unequal_blocks():
    """Blocks of 1, 2 and 8 velocities: directions of the widest, one mass matrix each, in the order of the blocks."""
    sizes = [1, 2, 8]
    matrix = [np.diag(np.arange(1.0, n + 1)) + 0.1 for n in sizes]
    weight = np.arange(1.0, 9) / 8
    seen = []

    def mass_blocks(t, q, M):
        seen.append([m.shape for m in M])
        for m, value in zip(M, matrix):
            m[...] = value

    def force(t, q, v, F):
        F[3:] = -weight

    def contacts(t, q, v, reach, found):
        direction = np.zeros((2, 1, 8))
        direction[0, 0] = weight
        direction[1, 0, :2] = 1, 2
        found.add(5, (2, 1), weight @ q[3:] + q[1] + 2 * q[2] + 1, direction)
        found.add(6, (0, -1), q[0] + 1, [[[1]], [[0]]])

    system = nsdae.System(blocks=sizes, mass_blocks=mass_blocks, force=force, contacts=contacts)
    assert system.check(np.linspace(0, 1, 11)).error < 1e-6 and seen[0] == [(n, n) for n in sizes]
    sim = nsdae.Sim(system, method="moreau", dt=1e-2)
    sim.init(np.zeros(11))
    sim.run(6)
    # the contact's impulse is what makes its velocity zero: W^T M^-1 (F t + W p) = 0
    W = np.concatenate([[0], [1, 2], weight])
    M = np.zeros((11, 11))
    for at, m in zip([0, 1, 3], matrix):
        M[at : at + len(m), at : at + len(m)] = m
    v = np.linalg.solve(M, np.concatenate([np.zeros(3), -6 * weight]))
    p = -(W @ v) / (W @ np.linalg.solve(M, W))
    assert np.allclose(sim.record.v, v + np.linalg.solve(M, W) * p, atol=1e-9) and p > 0


def test_rows_of_constraints_by_blocks():
    """A chain of points on rods of length 1: rows of two blocks, beside the dense Jacobian."""
    n = 4

    def ends(q):
        p = q.reshape(n, 2)
        return np.diff(p, axis=0, prepend=np.zeros((1, 2)))

    def constraint(t, q, phi):
        phi[:] = ((ends(q) ** 2).sum(axis=1) - 1) / 2

    def constraint_bias(t, q, v, phi_t, omega):
        omega[:] = (ends(v) ** 2).sum(axis=1)
        phi_t[:] = 0

    def rows(t, q, rows):
        d = ends(q)
        for i in range(n):
            if i > 0:
                rows.add(i, i - 1, -d[i])
            rows.add([i], [i], [d[i]])

    def jacobian(t, q, J):
        for i, d in enumerate(ends(q)):
            J[i, 2 * i : 2 * i + 2] = d
            if i > 0:
                J[i, 2 * i - 2 : 2 * i] = -d

    def mass_blocks(t, q, M):
        M[:] = np.eye(2)

    def force(t, q, v, F):
        F[1::2] = -G

    common = {"force": force, "constraint": constraint, "constraint_bias": constraint_bias}
    start = np.column_stack([np.arange(1, n + 1), np.zeros(n)]).reshape(-1)
    chain = nsdae.System(blocks=[[2, 2]] * n, m=n, mass_blocks=mass_blocks, constraint_rows=rows, **common)
    assert chain.check(start + 0.1).error < 1e-6
    dense = nsdae.System(nq=2 * n, m=n, mass=lambda t, q, M: np.fill_diagonal(M, 1), constraint_jacobian=jacobian, **common)
    a, b = (nsdae.solve(s, 0.5, start, method="moreau", dt=1e-3) for s in (chain, dense))
    assert np.allclose(a.q, b.q, atol=1e-9) and np.allclose(a.multiplier, b.multiplier, atol=1e-6)


def test_rows_of_frictional_joints():
    """A body in a slot: x, y are blocks, y = 0 carries the weight. v = v_0 - mu g t until it moves with the slot."""
    def joint_friction_rows(t, q, rows, w_s):
        w_s[:] = 0.5
        rows.add(0, 0, [1.0])

    def force(t, q, v, F):
        F[1] = -2 * G

    slot = nsdae.System(blocks=[1, 1], m=1, f=1, mass_blocks=lambda t, q, M: M.__setitem__(slice(None), 2), force=force,
                        constraint=lambda t, q, phi: phi.__setitem__(0, q[1]),
                        constraint_rows=lambda t, q, rows: rows.add(0, 1, [1.0]), joint_friction_rows=joint_friction_rows)
    slot.set_frictional_joint(0, 0, 0.25)
    run = nsdae.solve(slot, 1, [0, 0], [1, 0], method="moreau", dt=0.01)
    assert np.allclose(run.v[:, 0], np.maximum(1 - 0.25 * G * run.time, -0.5), atol=1e-12)


def test_bounds_of_frictional_joints():
    """A clutch of two discs: bound 2 t, then the common speed; opened, both keep their speed."""
    def tangent(t, q, W, w_s):
        W[:, 0] = 1, -1

    def bound(t, q, v, bound):
        bound[0] = 2 * t

    discs = nsdae.System(nq=2, f=1, mass=lambda t, q, M: np.fill_diagonal(M, (1, 3)), force=lambda t, q, v, F: None,
                         frictional_joint_tangent=tangent, joint_friction_bound=bound)
    run = nsdae.solve(discs, 3, [0, 0], [4, 0], method="implicit", dt=0.01)
    t = np.minimum(run.time, np.sqrt(3))
    assert np.allclose(run.v, np.stack([4 - t**2, t**2 / 3], 1), atol=1e-2) and np.allclose(run.v[-1], 1, atol=1e-12)
    plain = nsdae.System(nq=2, f=1, mass=lambda t, q, M: np.fill_diagonal(M, (1, 3)), force=lambda t, q, v, F: None,
                         frictional_joint_tangent=tangent)
    plain.set_friction_bound(0, 0.5)
    sim = nsdae.Sim(plain, method="moreau", dt=0.01)
    sim.init([0, 0], [4, 0])
    sim.run(1)
    sim.set_friction_bound(0, 0)
    sim.run(2)
    assert np.allclose(sim.record.v, [3.5, 0.5 / 3], atol=1e-12)


def springs(n, **given):
    """Balls on a line, each with a spring and a damper to the next one, of different stiffness."""
    k, d = 100.0 + np.arange(n - 1), 1.0 + np.arange(n - 1)

    def force(t, q, v, F):
        f = k * np.diff(q) + d * np.diff(v)
        F[:-1] += f
        F[1:] -= f

    def add(blocks, c):
        i = np.arange(n - 1)
        value = np.asarray(c)[:, None, None]
        for r, s, sign in ((i, i, 1), (i + 1, i + 1, 1), (i, i + 1, -1), (i + 1, i, -1)):
            blocks.add(r, s, sign * value)

    given = {"force_damping_blocks": lambda t, q, v, blocks: add(blocks, d),
             "force_stiffness_blocks": lambda t, q, v, blocks: add(blocks, k), **given}
    return nsdae.System(blocks=np.ones(n, dtype=int), force=force,
                        mass_blocks=lambda t, q, M: M.__setitem__((slice(None), 0, 0), 1), **given)


def test_derivatives_of_the_force_by_blocks():
    rng = np.random.default_rng(1)
    q, v = rng.normal(size=(2, 6))
    assert springs(6).check(q, v).error < 1e-6
    with pytest.raises(nsdae.Error, match="force_stiffness_blocks"):
        springs(6, force_stiffness_blocks=lambda t, q, v, blocks: blocks.add(2, 3, [[1.0]])).check(q, v)
    for bad, match in (((6, 0, [[1.0]]), "no such block"), ((0, 1, [[np.nan]]), "not finite")):
        with pytest.raises(nsdae.Error, match=match):
            springs(6, force_damping_blocks=lambda t, q, v, blocks: blocks.add(*bad)).check(q, v)
    with pytest.raises(nsdae.CallbackError) as caught:
        springs(6, force_damping_blocks=lambda t, q, v, blocks: blocks.add(0, 1, np.ones((1, 0)))).check(q, v)
    assert "value has the shape" in str(caught.value.__cause__)
    kept = []
    with pytest.raises(nsdae.Error):
        springs(6, force_damping_blocks=lambda t, q, v, blocks: kept.append(blocks)).check(q, v)
    with pytest.raises(ValueError, match="until the callback returns"):
        kept[0].add(0, 0, [[1.0]])


def test_derivatives_of_the_force():
    def force(t, q, v, F):
        F[:] = [-q[0] * v[1], -q[1] ** 2 - v[0] ** 2]

    def force_damping(t, q, v, D):
        D[0, 1], D[1, 0] = q[0], 2 * v[0]

    def force_stiffness(t, q, v, K):
        K[0, 0], K[1, 1] = v[1], 2 * q[1]

    mass = lambda t, q, M: np.fill_diagonal(M, 1)  # noqa: E731
    system = nsdae.System(nq=2, mass=mass, force=force, force_damping=force_damping, force_stiffness=force_stiffness)
    assert system.check([1, 2], [3, 4]).error < 1e-6
    wrong = nsdae.System(nq=2, mass=mass, force=force, force_damping=lambda t, q, v, D: None)
    with pytest.raises(nsdae.Error, match=r"force_damping: entry \(1, 0\)"):
        wrong.check([1, 2], [3, 4])


def test_compiled_blocks():
    pytest.importorskip("numba")
    block_add = nsdae.block_add

    @nsdae.cfunc("force_damping_blocks")
    def damping(t, q, v, blocks, user):
        value = np.full(1, 2.0)
        return block_add(blocks, 0, 0, value.ctypes.data)

    system = nsdae.System(blocks=[1], mass_blocks=lambda t, q, M: M.fill(1), force_damping_blocks=damping,
                          force=lambda t, q, v, F: F.__setitem__(0, -2 * v[0]))
    assert system.check([0], [1]).error < 1e-6


def with_contacts(add):
    def contacts(t, q, v, reach, found):
        add(found)

    return column(1, contacts)


@pytest.mark.parametrize("told, match", [
    ({"mu": -1}, "id 4: mu = -1"), ({"mu": 1}, "tangential"), ({"e_n": 2}, "id 4: e_n = 2"), ({"gap": np.nan}, "gap"),
    ({"block": (0, 0)}, "block"), ({"block": (2**40, 0)}, "block"), ({"direction": [[[np.inf]], [[0]]]}, "direction")])
def test_a_contact_that_is_out_of_range_is_named(told, match):
    given = {"id": 4, "block": (0, -1), "gap": 0.0, "direction": [[[1]], [[0]]], **told}
    with pytest.raises(nsdae.Error, match=match):
        nsdae.solve(with_contacts(lambda found: found.add(**given)), 0.01, [0.5])


@pytest.mark.parametrize("told, match", [
    ({"direction": np.zeros((3, 1, 1))}, "direction has the shape"), ({"block": (1, 2, 3)}, "block has the shape"),
    ({"direction": np.zeros((2, 1, 0))}, "direction has 0 columns")])
def test_a_wrong_shape_is_an_error_of_the_callback(told, match):
    given = {"id": 4, "block": (0, -1), "gap": 0.0, "direction": [[[1]], [[0]]], **told}
    with pytest.raises(nsdae.CallbackError) as caught:
        nsdae.solve(with_contacts(lambda found: found.add(**given)), 0.01, [0.5])
    assert match in str(caught.value.__cause__)


def test_a_list_ends_with_its_call():
    kept = []
    nsdae.solve(with_contacts(kept.append), 0.01, [0.5])
    with pytest.raises(ValueError, match="until the callback returns"):
        kept[0].add(1, (0, -1), 0, [[[1]], [[0]]])


def test_descriptions_that_do_not_fit():
    given = {"mass_blocks": lambda t, q, M: None, "force": lambda t, q, v, F: None}
    with pytest.raises(nsdae.ArgumentError, match="blocks have"):
        nsdae.System(nq=3, blocks=[1, 1], **given)
    with pytest.raises(nsdae.ArgumentError, match="contact list"):
        nsdae.System(blocks=[1, 1], k=1, contacts=lambda t, q, v, reach, found: None, **given)
    with pytest.raises(ValueError, match="whole numbers"):
        nsdae.System(blocks=[1.5], **given)
    with pytest.raises(nsdae.Error, match=r"nsdae.System\(blocks=...\)"):
        nsdae.Sim(nsdae.System(nq=1, mass=lambda t, q, M: None, **given))


def test_files_and_pictures(tmp_path):
    run = nsdae.solve(column(), 0.3, HIGH, method="moreau", every=7, model="column",
                      shapes=[nsdae.Shape(f"ball{i}", "disc", (0.5,), (0, f"q{i}")) for i in range(N)])
    run.save(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as file:
        assert file.attrs["format_version"] == 3 and file["contacts"].attrs["fixed"] == 0
        assert np.array_equal(file["contacts/first"][:] + file["contacts/count"][:], np.cumsum(run.contact_count))
    back = nsdae.load(tmp_path / "run.h5")
    same(back, run)
    assert np.array_equal(back.contacts_at(-1), run.contacts_at(-1)) and back.blocks.tolist() == run.blocks.tolist()
    assert any("contact" in axes.get_ylabel() for axes in run.plot().axes)
    run.animate(tmp_path / "run.gif", width=200)
    assert (tmp_path / "run.gif").read_bytes()[:6] == b"GIF89a"
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        file["contacts/first"][3] += 1
    with pytest.raises(ValueError, match="run.h5.*contacts"):
        nsdae.load(tmp_path / "run.h5")


@needs_programs
@pytest.mark.parametrize("name", ["column", "arch", "heap"])
def test_files_of_the_programs_survive(tmp_path, name):
    path = tmp_path / "c.h5"
    program(f"nsdae-{name}", "--t-end", 0.05, "--quiet", "--output", path)
    theirs = nsdae.load(path)
    assert theirs.contact_count.sum() == len(theirs.contacts) > 0 and len(theirs.blocks) > 20
    theirs.save(tmp_path / "python.h5")
    same(nsdae.load(tmp_path / "python.h5"), theirs)
    mine, given = layout(tmp_path / "python.h5")[0], layout(path)[0]
    assert mine == given
    assert "picture" in program("nsdae-plot", tmp_path / "python.h5", "-o", tmp_path / "p.png").stdout
    theirs.animate(tmp_path / "p.gif", width=160, fps=5, speed=0.1, forces=True)


def test_bodies_by_their_materials():
    """Discs in a row fall on a floor; what carries them is their weight, and nothing overlaps."""
    world = nsdae.Bodies(2, gravity=(0, -G))
    world.set_pair(0, 0, mu=0.3)
    world.set_pair(0, 1, mu=0.3)
    world.add_solid(nsdae.GROUND, nsdae.Solid("plane", material=1))
    for i in range(3):
        disc = world.add(mass=1 + i, inertia=0.01, position=(0, 0.2 + 0.21 * i))
        world.add_solid(disc, nsdae.Solid("disc", radius=0.1))
    run = nsdae.solve(world, 1, method="moreau", dt=2e-3)
    assert run.blocks.tolist() == [[3, 3]] * 3 and run.gap.shape == (run.contact_count.sum(),)
    last = run.contacts_at(-1)
    floor = last[(last["block"] < 0).any(axis=1)]
    assert len(floor) == 1 and np.isclose(floor["normal_impulse"][0] / 2e-3, 6 * G, rtol=1e-6)
    assert run.penetration.max() < 0.02 and np.allclose(run.q[-1][1::3], [0.1, 0.3, 0.5], atol=0.02)


@pytest.mark.parametrize("joint, solid, touch", [
    (None, {}, True), ({}, {}, False), ({"collide_connected": True}, {}, True),
    (None, {"group": 6, "exclude": 4}, False), (None, {"group": 3, "exclude": 4}, True)])
def test_neighbours_and_groups(joint, solid, touch):
    """Two discs that move towards each other stop, or pass through each other."""
    world = nsdae.Bodies(2)
    for i in range(2):
        disc = world.add(mass=1, inertia=1, position=(i - 0.5, 0), velocity=(1 - 2 * i, 0))
        world.add_solid(disc, nsdae.Solid("disc", radius=0.25, **solid))
    if joint is not None:
        world.add_joint("prismatic", 0, 1, axis=(1, 0), **joint)
    world.set_pair(0, 0)
    run = nsdae.solve(world, 1, method="moreau", dt=0.01)
    assert np.isclose(run.v[-1][0], 0 if touch else 1, atol=1e-12)


def test_compiled_lists(library):
    """The column in C, which gets the address of nsdae_contact_add, in two threads at once."""
    import ctypes
    user = (ctypes.c_void_p * 2)(ctypes.cast(nsdae.contact_add, ctypes.c_void_p).value, N)
    given = {name: ctypes.cast(getattr(library, f"column_{name}"), nsdae.signature(name, "ctypes"))
             for name in ("mass_blocks", "force", "contacts")}
    system = nsdae.System(blocks=[1] * N, user=user, **given)
    runs = [None, None]

    def go(i):
        runs[i] = nsdae.solve(system, 0.6, HIGH, method="moreau", dt=1e-3)

    threads = [threading.Thread(target=go, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    same(*runs)
    python = nsdae.solve(column(), 0.6, HIGH, method="moreau", dt=1e-3)
    same(runs[0], python)


def test_lists_in_numba():
    numba = pytest.importorskip("numba")
    add = nsdae.contact_add

    @numba.cfunc(nsdae.signature("contacts"))
    def contacts(t, q, v, reach, found, user):
        contact = np.zeros(1, dtype=nsdae.CONTACT)
        for i in range(N):
            gap = q[i] - (q[i - 1] if i > 0 else -0.5) - 1
            if gap <= reach:
                contact[0].id = 100 + i
                contact[0].block[0] = i
                contact[0].block[1] = i - 1
                contact[0].gap = gap
                contact[0].e_n = 0.3
                contact[0].direction[0, 0, 0] = 1
                contact[0].direction[1, 0, 0] = -1
                add(found, contact.ctypes)
        return 0

    same(*(nsdae.solve(column(contacts=c), 0.3, HIGH, method="moreau") for c in (contacts, None)))


@pytest.mark.parametrize("seed", range(12))
def test_random_columns(seed):
    """Balls of random masses, starts and restitutions: a contact list and fixed contacts give the same result.

    Each ball has up to eight velocities, of which a random combination is its height.
    """
    draw = np.random.default_rng(seed)
    n = int(draw.integers(2, 7))
    size = draw.integers(1, 9, n)
    first = np.concatenate([[0], np.cumsum(size)])
    part = [draw.uniform(-1, 1, s) + np.eye(s)[0] * 2 for s in size]  # height = part . q of the block
    matrix = [np.diag(draw.uniform(0.5, 5, s)) + 0.2 * np.outer(p, p) for s, p in zip(size, part)]
    e_n, mass = draw.uniform(0, 0.9, n), draw.uniform(0.5, 5, n)

    def heights(q):
        return np.array([p @ q[a : a + len(p)] for p, a in zip(part, first)])

    def force(t, q, v, F):
        for p, a, m in zip(part, first, mass):
            F[a : a + len(p)] = -G * m * p

    def gaps(q):
        return np.diff(heights(q), prepend=-0.5) - 1

    def mass_blocks(t, q, M):
        if size.min() == size.max():
            M[:] = matrix
        else:
            for m, value in zip(M, matrix):
                m[...] = value

    def dense_mass(t, q, M):
        for a, m in zip(first, matrix):
            M[a : a + len(m), a : a + len(m)] = m

    def contacts(t, q, v, reach, found):
        gap, direction = gaps(q), np.zeros((n, 2, 1, size.max()))
        for i in range(n):
            direction[i, 0, 0, : size[i]] = part[i]
            if i > 0:
                direction[i, 1, 0, : size[i - 1]] = -part[i - 1]
        near = gap <= reach
        block = np.column_stack([np.arange(n), np.arange(n) - 1])
        found.add(np.flatnonzero(near) * 7 - 3, block[near], gap[near], direction[near], e_n=e_n[near])

    def gap_normal(t, q, W):
        for i in range(n):
            W[first[i] : first[i + 1], i] = part[i]
            if i > 0:
                W[first[i - 1] : first[i], i] = -part[i - 1]

    def gap(t, q, g):
        g[:] = gaps(q)

    high = np.cumsum(1 + draw.uniform(0, 0.2, n)) - 0.5
    q0 = np.concatenate([h * p / (p @ p) for h, p in zip(high, part)])
    v0 = draw.uniform(-1, 1, len(q0))
    listed = nsdae.System(blocks=size, mass_blocks=mass_blocks, force=force, contacts=contacts)
    dense = nsdae.System(nq=len(q0), k=n, e_n=e_n, mass=dense_mass, force=force, gap=gap, gap_normal=gap_normal)
    assert listed.check(q0).error < 1e-6
    # projection = slop ends when an island is within a tenth of the slop, and dense is one island
    a, b = (nsdae.solve(s, 0.3, q0, v0, method="moreau", dt=2e-3, projection="none") for s in (listed, dense))
    assert np.allclose(a.q, b.q, atol=1e-8) and np.allclose(a.v, b.v, atol=1e-6)
    assert len(a.impacts) == len(b.impacts) and (a.contacts["mode"] > 0).sum() == (b.mode > 0).sum()
