"""Points and forces of contacts in trajectories: equilibrium, files, tables, and what is refused."""

import os
import subprocess

import h5py
import numpy as np
import pytest

import nsdae
from nsdae import GROUND, Bodies, Solid

BIN = os.environ.get("NSDAE_BIN")


def scene(listed):
    """Three balls of 1 kg and a box of 4 kg on a floor, by a contact list or by fixed contacts."""
    world = Bodies(3, gravity=(0, 0, -10))
    floor = world.add_solid(GROUND, Solid("plane"))
    places = [((0.5 * i, 0.1 * i, 0.1), Solid("sphere", radius=0.1)) for i in range(3)]
    for place, solid in [*places, ((0, 1, 0.2), Solid("box", length=(0.6, 0.6, 0.4)))]:
        ball = solid.shape == "sphere"
        body = world.add(1 if ball else 4, (0.01,) * 3 if ball else (0.1,) * 3, position=place)
        number = world.add_solid(body, solid)
        if not listed:
            world.add_contact(floor, number, mu=0.5)
    if listed:
        world.set_pair(0, 0, mu=0.5)
    return world


@pytest.fixture(scope="module", params=[True, False], ids=["listed", "fixed"])
def run(request):
    return nsdae.solve(scene(request.param), 0.1, method="implicit", dt=2e-3, every=5, contact_forces=True)


def test_bodies_at_rest(run):
    """The forces carry the weights, those of a ball at its foot; the moment about the box's centre is zero."""
    last = run.contacts_at(len(run) - 1)
    last = last[np.isfinite(last["point"][:, 0])]
    point, force = last["point"], last["force"]
    assert force.sum(axis=0) == pytest.approx([0, 0, 70], abs=1e-6)
    for i in range(3):
        (foot,) = np.flatnonzero(np.linalg.norm(point - [0.5 * i, 0.1 * i, 0], axis=1) < 0.05)
        assert point[foot] == pytest.approx([0.5 * i, 0.1 * i, 0], abs=1e-4) and force[foot, 2] == pytest.approx(10)
    box = point[:, 1] > 0.5
    assert np.abs(np.abs(point[box] - [0, 1, 0]) - [0.3, 0.3, 0]).max() < 1e-4
    assert np.cross(point[box] - [0, 1, 0.2], force[box]).sum(axis=0) == pytest.approx([0, 0, 0], abs=1e-3)


def test_each_record_has_those_of_its_step():
    sim = nsdae.Sim(scene(True), method="implicit", dt=2e-3)
    sim.init()
    whole = nsdae.Sim(scene(True), method="implicit", dt=2e-3)
    whole.init()
    run = whole.record_run(0.04, contact_forces=True)
    for record in range(1, len(run)):
        sim.step()
        for name, values in zip(("point", "force"), sim.contact_forces()):
            assert np.array_equal(run.contacts_at(record)[name], values, equal_nan=True)


def test_files(run, tmp_path):
    run.save(tmp_path / "run.h5")
    back = nsdae.load(tmp_path / "run.h5")
    assert back.contacts.dtype == run.contacts.dtype and back.contacts.tobytes() == run.contacts.tobytes()
    nsdae.solve(scene(run.blocks is not None), 0.1, method="implicit", dt=2e-3, every=5, contact_forces=True, output=tmp_path / "grown.h5")
    assert nsdae.load(tmp_path / "grown.h5").contacts.tobytes() == run.contacts.tobytes()
    with h5py.File(tmp_path / "run.h5", "a") as file:
        values = file["contacts/force"][..., :2]
        del file["contacts/force"]
        file["contacts/force"] = values
    with pytest.raises(ValueError, match="its /contacts/force has the shape"):
        nsdae.load(tmp_path / "run.h5")


def test_tables(run):
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    table = run.to_pandas("contacts")
    assert isinstance(table, pandas.DataFrame)
    assert np.array_equal(table[[f"force_{i}" for i in range(3)]].to_numpy(), run.contacts["force"].reshape(-1, 3))
    if run.contacts.ndim == 2:
        data = run.to_xarray()
        assert isinstance(data, xarray.Dataset) and data.force.dims == data.point.dims == ("time", "contact", "component3")
        assert data.force[-1].sum("contact").values == pytest.approx([0, 0, 70], abs=1e-6)


@pytest.mark.skipif(not BIN, reason="NSDAE_BIN does not say where the programs are")
def test_the_programs_write_the_same_datasets(tmp_path):
    (tmp_path / "ball.csv").write_text("# walls: none\n# floor: 0\n# mu: 0.5\n# e_N: 0\n# g: 10\n# dt: 0.002\n"
                                       "kind,size0,size1,size2,mass,I1,I2,I3,x,y,z,qw,qx,qy,qz,vx,vy,vz,w1,w2,w3\n"
                                       "sphere,0.1,0,0,1,0.004,0.004,0.004,0.3,0.2,0.1,1,0,0,0,0,0,0,0,0,0\n", encoding="ascii")
    subprocess.run([os.path.join(BIN, "nsdae-scene"), "--quiet", tmp_path / "ball.csv", "--set", "contact_forces=1", "--t-end", "0.1",
                    "--output", tmp_path / "ball.h5"], check=True)
    theirs = nsdae.load(tmp_path / "ball.h5")
    theirs.save(tmp_path / "ours.h5")
    with h5py.File(tmp_path / "ball.h5") as one, h5py.File(tmp_path / "ours.h5") as other:
        for name in ("contacts/point", "contacts/force"):
            for attribute in ("units", "description"):
                assert nsdae._file._str(one[name].attrs[attribute]) == other[name].attrs[attribute]
            assert [dim.keys() for dim in one[name].dims] == [dim.keys() for dim in other[name].dims]
            assert np.array_equal(one[name], other[name], equal_nan=True)
    assert theirs.contacts_at(-1)["point"] == pytest.approx(np.array([[0.3, 0.2, 0]]), abs=1e-4)


def test_a_system_of_callbacks_is_refused():
    def contacts(t, q, found):
        pass

    plain = nsdae.System(nq=1, mass=lambda t, q, M: M.fill(1), force=lambda t, q, v, F: None)
    with pytest.raises(nsdae.ArgumentError, match="has no solids"):
        nsdae.solve(plain, 0.1, q0=[1], contact_forces=True)
