"""What xarray makes of trajectories, against h5py. usage: xarray_check.py "FILE.h5 NAME...": each with the names of its
coordinates. Exit 77 if xarray or an engine of it is not installed."""

import importlib.util
import os
import sys

for module in ("h5py", "numpy", "xarray", "h5netcdf", "netCDF4"):
    if importlib.util.find_spec(module) is None:
        print(f"skipped: no Python module {module}")
        sys.exit(77)

import h5py
import numpy as np
import xarray


def look(engine, path, names, file):
    root = xarray.open_dataset(path, engine=engine)
    assert root.q.dims == ("time", "coordinate") and root.v.dims == ("time", "velocity"), root
    assert list(root.coordinate.values) == names, root.coordinate.values
    assert root.coordinate_unit.dims == ("coordinate",)
    for i, name in enumerate(names):
        assert np.array_equal(root.q.sel(coordinate=name).values, file["q"][:, i])
    half = file["time"][len(file["time"]) // 2]
    assert np.array_equal(root.q.sel(time=half).values, file["q"][len(file["time"]) // 2])
    assert np.array_equal(root.time.values, file["time"][:])
    if "multiplier" in file:
        assert root.multiplier.dims == ("time", "constraint")
    for group, dims in (("energy", ("time",)), ("certificate", ("time",)), ("impact", ("time",)), ("change", ("time",))):
        data = xarray.open_dataset(path, engine=engine, group=group)
        for name, variable in data.data_vars.items():
            assert variable.dims[0] == dims[0] and np.array_equal(variable.values, file[group][name][:]), name
    fixed = "contacts" if "contacts/contact" in file else "contact"  # of version 1
    if f"{fixed}/contact" in file:
        contact = xarray.open_dataset(path, engine=engine, group=fixed)
        assert contact.gap.dims == ("time", "contact")
        first = contact.contact.values[0]
        assert np.array_equal(contact.gap.sel(contact=first).values, file[f"{fixed}/gap"][:, 0])
        if "tangential_impulse" in contact:
            assert contact.tangential_impulse.dims == ("time", "contact", "tangent")
        if "id" in contact:
            assert contact.id.dims == ("contact",) and contact.id.values.tolist() == list(range(contact.sizes["contact"]))
    if "contacts/first" in file:  # by list: one row for each contact of each record
        contacts = xarray.open_dataset(path, engine=engine, group="contacts")
        assert contacts.gap.dims == ("id",) and contacts.block.dims == ("id", "side"), contacts
        assert contacts["count"].dims == ("time",) and contacts.tangential_impulse.dims == ("id", "tangent")
        assert np.array_equal(contacts.gap.values, file["contacts/gap"][:])
        last = slice(int(contacts["first"][-1]), int(contacts["first"][-1] + contacts["count"][-1]))
        assert np.array_equal(contacts.id.values[last], file["contacts/id"][last]) and contacts.sizes["id"] > 0


ENGINES = ("h5netcdf", "netcdf4")
for number, argument in enumerate(sys.argv[1:]):
    path, *names = argument.split()
    with h5py.File(path) as file:
        # the quick form: one after the other
        for engine in ENGINES if os.environ.get("NSDAE_TEST_SHARE") == "1" else (ENGINES[number % 2],):
            look(engine, path, names, file)
            print(f"{path} by {engine}: q by {', '.join(names)}")
