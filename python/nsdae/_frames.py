"""Results as tables of pandas and xarray, and for notebooks."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any, Iterable

import numpy as np

from ._file import CHANGES, IMPACTS, RECORDS

if TYPE_CHECKING:
    import pandas
    import xarray

    from ._sweep import Sweep
    from ._trajectory import Trajectory

TABLES = ("records", "impacts", "changes", "contacts")


def _columns(name: str, values: np.ndarray, parts: Iterable[str] | None = None) -> dict[str, np.ndarray]:
    """Columns of an array: itself, or one for each of its parts, by default numbered."""
    if values.ndim == 1:
        return {name: values}
    flat = values.reshape(len(values), -1)
    return {f"{name}_{part}": column for part, column in zip(parts or map(str, range(flat.shape[1])), flat.T)}


def _rows(table: np.ndarray) -> dict[str, np.ndarray]:
    return {column: values for name in table.dtype.names or () for column, values in _columns(name, table[name]).items()}


def _records(run: Trajectory) -> dict[str, np.ndarray]:
    def names(kind: str) -> list[str]:
        return [name for name, _ in run.names[kind]]

    columns = dict(zip(names("coordinate"), run.q.T))
    columns.update((f"v_{name}" if name in columns else name, v) for name, v in zip(names("velocity"), run.v.T))
    columns.update(_columns("multiplier", run.multiplier, names("constraint")))
    for name in ("frictional_joint_impulse", "frictional_joint_mode"):
        columns.update(_columns(name, getattr(run, name), names("frictional_joint")))
    for _, name, _, _, axes in RECORDS:
        if axes == ("time",) and getattr(run, name) is not None:
            columns[name] = getattr(run, name)
    for name, values in run.sensors.items():
        columns.update(_columns(f"sensor_{name}", values))
    return columns


def pandas_of(run: Trajectory, table: str) -> pandas.DataFrame:
    """A table of a trajectory."""
    import pandas
    if table not in TABLES:
        raise ValueError(f"no table is called '{table}': they are {', '.join(TABLES)}")
    if table == "records":
        return pandas.DataFrame(_records(run), index=pandas.Index(run.time, name="time"))
    if table == "contacts":
        index = pandas.Index(np.repeat(run.time, run.contact_count), name="time")
        return pandas.DataFrame(_rows(run.contacts.reshape(-1)), index=index)
    return pandas.DataFrame(_rows(getattr(run, table))).set_index("time")


def _variables(run: Trajectory) -> dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]]:
    """Dimensions, values and attributes of each variable."""
    made: dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]] = {}
    for _, name, unit, said, axes in RECORDS:
        values = getattr(run, name)
        if values is not None and all(values.shape[1:]):
            made[name] = tuple(axis.rpartition("/")[2] for axis in axes), values, {"units": unit, "description": said}
    units = dict(run.names.get("sensor", []))
    for name, values in run.sensors.items():
        axes = ("time",) if values.ndim == 1 else ("time", f"component{values.shape[1]}")
        made[f"sensor_{name}"] = axes, values, {"units": units.get(name, ""), "description": "sensor of the model"}
    if run.contacts.ndim == 2 and run.contacts.shape[1]:
        for name in (run.contacts.dtype.names or ())[2:]:
            last = "component3" if name in ("point", "force") else "tangent"
            made[name] = (("time", "contact", last)[: run.contacts[name].ndim], run.contacts[name],
                          {"units": {"gap": "m", "mode": "1", "point": "m", "force": "N"}.get(name, "N s")})
    for group, rows, fields in (("impact", run.impacts, IMPACTS), ("change", run.changes, CHANGES)):
        for name, unit, said in (("time", "s", "its time"), *fields):
            values = rows[name]
            made[f"{group}_{name}"] = (group, f"{group}_{name}_part")[: values.ndim], values, {"units": unit, "description": said}
    return made


def xarray_of(run: Trajectory) -> xarray.Dataset:
    """A trajectory as labelled arrays."""
    import xarray
    kinds = (("coordinate", run.q.shape[1]), ("velocity", run.v.shape[1]), ("constraint", run.multiplier.shape[1]),
             ("contact", run.contacts.shape[1] if run.contacts.ndim == 2 else 0),
             ("frictional_joint", run.frictional_joint_impulse.shape[1]))
    coords: dict[str, Any] = {kind: [name for name, _ in run.names[kind]] for kind, n in kinds if n}
    coords["time"] = ("time", run.time, {"units": "s"})
    return xarray.Dataset(_variables(run), coords=coords, attrs={"model": run.model, "method": run.method, "status": run.status})


def sweep_to_pandas(sweep: Sweep) -> pandas.DataFrame:
    """A row for each run: its parameters, its status, its results."""
    import pandas
    columns: dict[str, np.ndarray] = {}
    for i, dimension in enumerate(sweep.dimensions):
        for name, values in dimension.items():
            shape = [1] * sweep.status.ndim
            shape[i] = len(values)
            columns[name] = np.broadcast_to(values.reshape(shape), sweep.status.shape).reshape(-1)
    columns["status"] = sweep.status.reshape(-1)
    for name, values in sweep.results.items():
        columns.update(_columns(name, values.reshape(sweep.status.size, *values.shape[sweep.status.ndim:])))
    return pandas.DataFrame(columns)


def sweep_to_xarray(sweep: Sweep) -> xarray.Dataset:
    """Results over the parameters. A dimension of several parameters, as of random ones, has the name of all."""
    import xarray
    axes = ["_".join(dimension) for dimension in sweep.dimensions]
    coords = {name: (axis, values) for axis, dimension in zip(axes, sweep.dimensions) for name, values in dimension.items()}
    made: dict[str, Any] = {"status": (axes, sweep.status)}
    for name, values in sweep.results.items():
        inner = [f"{name}_{i}" for i in range(values.ndim - len(axes))]
        made[name] = ([*axes, *inner], values)
    return xarray.Dataset(made, coords=coords)


def page(title: str, rows: Iterable[tuple[str, Any]]) -> str:
    """A table of names and values for notebooks."""
    def cell(value: Any) -> str:
        return html.escape(f"{value:.6g}" if isinstance(value, float) else str(value))

    lines = "".join(f"<tr><th style='text-align:left'>{cell(name)}</th><td>{cell(value)}</td></tr>" for name, value in rows)
    return f"<table><caption>{html.escape(title)}</caption>{lines}</table>"
