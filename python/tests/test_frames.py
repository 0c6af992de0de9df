"""Results as tables of pandas and xarray, and in notebooks."""

import io

import numpy as np
import pytest

import nsdae
from test_copies import mechanism

pandas = pytest.importorskip("pandas", reason="pandas is not here")
xarray = pytest.importorskip("xarray", reason="xarray is not here")


@pytest.fixture(scope="module")
def listed():
    return nsdae.solve(mechanism(), 0.5, method="moreau", dt=1e-2, model="<pile>")


def test_records_of_pandas(ball):
    run = nsdae.solve(ball, 1, [1])
    table = run.to_pandas()
    assert table.index.name == "time" and np.array_equal(table.index, run.time)
    assert np.array_equal(table["y"], run.q[:, 0]) and np.array_equal(table["v_y"], run.v[:, 0])
    assert np.array_equal(table["kinetic"], run.kinetic) and "potential" not in table
    impacts = run.to_pandas("impacts")
    assert np.array_equal(impacts["normal_impulse"], run.impacts["normal_impulse"])
    assert np.array_equal(impacts["tangential_impulse_1"], run.impacts["tangential_impulse"][:, 1])
    with pytest.raises(ValueError, match="no table is called 'impact'"):
        run.to_pandas("impact")


def test_contacts_of_a_list_of_pandas(listed):
    table = listed.to_pandas("contacts")
    for i in range(0, len(listed), 10):
        of = table.loc[listed.time[i]:listed.time[i]]
        assert np.array_equal(of["gap"], listed.contacts_at(i)["gap"])
        assert np.array_equal(of["block_1"], listed.contacts_at(i)["block"][:, 1])
    assert np.array_equal(listed.to_pandas()["sensor_angle"], listed["angle"])
    assert np.array_equal(listed.to_pandas()["z1"], listed["z1"])


@pytest.mark.parametrize("fixed", [True, False])
def test_xarray_has_the_arrays_of_the_file(fixed, ball, listed, tmp_path):
    """Against HDF5's file, which xarray reads by other code."""
    pytest.importorskip("h5netcdf", reason="h5netcdf is not here")
    run = nsdae.solve(ball, 1, [1]) if fixed else listed
    run.save(tmp_path / "run.h5")
    made = run.to_xarray()
    with xarray.open_dataset(tmp_path / "run.h5", engine="h5netcdf", phony_dims="sort") as file:
        for name in ("q", "v"):
            assert made[name].dims == file[name].dims and np.array_equal(made[name], file[name])
            assert made[name].attrs["description"] == file[name].attrs["description"]
        assert [str(c) for c in made["coordinate"].values] == [str(c) for c in file["coordinate"].values]
    assert ("gap" in made) == fixed
    assert np.array_equal(made["impact_normal_impulse"], run.impacts["normal_impulse"])
    assert made["q"].sel(time=0).shape == (run.q.shape[1],)
    made.to_netcdf(io.BytesIO(), engine="h5netcdf")


def test_sweeps():
    done = nsdae.sweep(lambda r, mu: {"sum": r + mu, "pair": [r, mu]}, {"r": [1, 2, 3], "mu": [0.5, 0.25]})
    table = done.to_pandas()
    assert np.array_equal(table["result/sum"], table["r"] + table["mu"]) and len(table) == 6
    assert np.array_equal(table["result/pair_1"], table["mu"])
    made = done.to_xarray()
    assert made["result/sum"].sel(r=2, mu=0.25) == 2.25 and made["result/pair"].shape == (3, 2, 2)
    drawn = nsdae.sweep(lambda a, b: a * b, {"a": (0, 1), "b": (1, 2)}, random=4).to_xarray()
    assert np.array_equal(drawn["result/value"], drawn["a"] * drawn["b"])
    assert "6 of 6" in done._repr_html_()


def test_notebooks(listed):
    page = listed._repr_html_()
    assert "&lt;pile&gt;" in page and "moreau" in page and f"<td>{len(listed)}</td>" in page
