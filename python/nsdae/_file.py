"""Trajectory files, as docs/trajectory.md describes them: the layout is a table."""

from __future__ import annotations

import contextlib
import datetime
from typing import TYPE_CHECKING, Any, Iterator

import numpy as np

from . import _core

if TYPE_CHECKING:
    from ._trajectory import Trajectory

TEXTS = {"format": "nsdae-trajectory", "library_version": _core.VERSION}

# dataset, attribute of Trajectory, unit, description, scales of its dimensions
RECORDS = (
    ("q", "q", "of the model", "coordinates", ("time", "coordinate")),
    ("v", "v", "of the model", "velocities", ("time", "velocity")),
    ("multiplier", "multiplier", "of the model: force of each constraint",
     "mean bilateral force over the step that ends here", ("time", "constraint")),
    ("contact/gap", "gap", "m", "normal gap; negative where bodies overlap", ("time", "contact/contact")),
    ("contact/normal_impulse", "normal_impulse", "N s", "normal impulse of the step that ends here",
     ("time", "contact/contact")),
    ("contact/tangential_impulse", "tangential_impulse", "N s", "tangential impulse of the step that ends here",
     ("time", "contact/contact", "tangent")),
    ("contact/mode", "mode", "1", "0 open, 1 slide, 2 stick", ("time", "contact/contact")),
    ("slide/impulse", "slide_impulse", "N s",
     "friction impulse on each bilateral constraint with friction, of the step that ends here", ("time", "slide/slide")),
    ("slide/mode", "slide_mode", "1", "0 frictionless, 1 slide, 2 stick", ("time", "slide/slide")),
    ("energy/kinetic", "kinetic", "J", "v^T M v / 2", ("time",)),
    ("energy/potential", "potential", "J", "potential energy of the model", ("time",)),
    ("energy/dissipated", "dissipated", "J", "work taken by contact and friction impulses so far", ("time",)),
    ("certificate/lcp_residual", "lcp_residual", "1",
     "scaled natural residual of the step's complementarity problem", ("time",)),
    ("certificate/constraint_drift", "constraint_drift", "of the model", "max |Phi|", ("time",)),
    ("certificate/penetration", "penetration", "m", "largest overlap over the contacts", ("time",)),
)
IMPACTS = (
    ("contact", "1", "contact, from 0"), ("normal_impulse", "N s", "normal impulse"),
    ("tangential_impulse", "N s", "tangential impulse"), ("velocity_before", "m/s", "normal velocity before"),
    ("velocity_after", "m/s", "normal velocity after"),
    ("peak_force", "N", "largest normal force of a continuous contact; 0 for a rigid one"),
    ("accumulation", "1", "1 where the entry stands for infinitely many impacts that end at its time in rest"),
)
CHANGES = (
    ("contact", "1", "contact, from 0; -1: a slide"), ("slide", "1", "slide, from 0; -1: a contact"),
    ("mode_before", "1", "0 open, 1 slide, 2 stick"), ("mode_after", "1", "0 open, 1 slide, 2 stick"),
)
NAMES = {"coordinate": "coordinate", "velocity": "velocity", "constraint": "constraint", "contact": "contact/contact",
         "slide": "slide/slide"}


@contextlib.contextmanager
def in_memory() -> Iterator[Any]:
    """An HDF5 file that is on no disk."""
    import h5py
    with h5py.File("nsdae", "w", driver="core", backing_store=False) as file:
        yield file


def write(trajectory: Trajectory, path: str) -> None:
    """A new file."""
    import h5py
    with h5py.File(path, "w") as file:
        fill(trajectory, file)


def _text(values: Any) -> Any:
    return np.array([str(value) for value in values], dtype=object)


def _put(file: Any, path: str, values: Any, unit: str, description: str, scales: tuple[str, ...] = ()) -> Any:
    import h5py
    values = np.asarray(values)
    kind = h5py.string_dtype() if values.dtype == object else values.dtype
    grows = scales and scales[0].endswith("time")
    made = file.create_dataset(path, data=values, dtype=kind,
                               maxshape=(None,) + values.shape[1:] if grows else None,
                               chunks=(1024,) + values.shape[1:] if grows else None)
    made.attrs["units"], made.attrs["description"] = unit, description
    for dimension, scale in enumerate(scales):
        if scale != path:
            made.dims[dimension].attach_scale(file[scale])
    if scales and scales[0] == path:
        made.make_scale(path.split("/")[-1] if "/time" not in path else path.replace("/", " "))
    return made


def _put_names(trajectory: Trajectory, file: Any) -> None:
    for kind, path in NAMES.items():
        rows = trajectory.names.get(kind, [])
        if not rows:
            continue
        _put(file, path, _text(name for name, _ in rows), "", f"names of the {kind}s", (path,))
        if "/" not in path:
            _put(file, f"{path}_unit", _text(unit for _, unit in rows), "", "units of these", (path,))
    nt = trajectory.tangential_impulse.shape[2]
    if nt:
        _put(file, "tangent", _text(f"tangent{i}" for i in range(nt)), "", "names of the tangential directions",
             ("tangent",))


def _put_events(file: Any, group: str, rows: np.ndarray, table: Any, said: str, nt: int) -> None:
    time = f"{group}/time"
    _put(file, time, rows["time"], "s", said, (time,))
    for name, unit, description in table:
        values = rows[name]
        if name == "tangential_impulse":
            values = values[:, :nt]
            if not nt:
                continue
        made = _put(file, f"{group}/{name}", np.ascontiguousarray(values), unit, description, (time,))
        if values.ndim == 2:
            made.dims[1].attach_scale(file["tangent"])


def _put_shapes(file: Any, shapes: list[Any]) -> None:
    def formulas(name: str, number: int) -> Any:
        return _text((list(getattr(s, name)) + [""] * 4)[number] for s in shapes)

    def padded(values: Any, what: str) -> np.ndarray:
        row = [float(v) for v in values]
        if len(row) > 3:
            raise ValueError(f"{what} has {len(row)} numbers; it has at most 3")
        return np.array(row + [0.0] * (3 - len(row)))

    said = "formula of the place of the body's origin"
    _put(file, "bodies/name", _text(s.name for s in shapes), "", "names of the bodies")
    _put(file, "bodies/shape", _text(s.shape for s in shapes), "", "their shapes")
    for i, axis in enumerate("xyz"):
        _put(file, f"bodies/{axis}", formulas("position", i), "m", said)
        _put(file, f"bodies/end_{axis}", formulas("end", i), "m", "formula of a segment's other end; empty: none")
    for i, axis in enumerate("wxyz"):
        _put(file, f"bodies/quaternion_{axis}", formulas("quaternion", i), "1",
             "formula: the quaternion that turns the body's frame; empty: none")
    _put(file, "bodies/angle", _text(s.angle for s in shapes), "rad",
         "formula of the angle of the body's frame about z; empty: none")
    _put(file, "bodies/size", np.array([padded(s.size, "size") for s in shapes]), "m", "by the shape")
    points = [padded(p, "a point") for s in shapes for p in s.points]
    _put(file, "bodies/points", np.array([len(s.points) for s in shapes], dtype="i4"), "1",
         "rows of /bodies/point that each body has, in order")
    if points:
        _put(file, "bodies/point", np.array(points), "m", "corners of polygons and paths in their bodies' frames")


def _put_values(file: Any, group: str, values: dict[str, Any]) -> None:
    file.create_group(group)
    for name, value in values.items():
        file[group].create_dataset(name, data=value)


def fill(trajectory: Trajectory, file: Any) -> None:
    """All of it, into an empty file."""
    now = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    for name, text in {**TEXTS, "status": trajectory.status, "model": trajectory.model, "method": trajectory.method,
                       "created": now}.items():
        file.attrs[name] = text
    file.attrs["format_version"] = np.int32(1)
    _put_values(file, "options", trajectory.options)
    _put_values(file, "parameters", trajectory.parameters)
    _put(file, "time", trajectory.time, "s", "simulated time", ("time",))
    _put_names(trajectory, file)
    for path, name, unit, description, scales in RECORDS:
        values = getattr(trajectory, name)
        if values is not None and all(values.shape[1:]):
            _put(file, path, values, unit, description, scales)
    nt = trajectory.tangential_impulse.shape[2]
    _put_events(file, "impact", trajectory.impacts, IMPACTS, "time of the impact; with a time-stepping method the end "
                "of its step", nt)
    _put_events(file, "change", trajectory.changes, CHANGES, "instant of a change of mode", nt)
    if trajectory.shapes:
        _put_shapes(file, trajectory.shapes)


def _str(value: Any) -> Any:
    return value.decode() if isinstance(value, bytes) else value


def _read_values(file: Any, group: str) -> dict[str, Any]:
    def plain(value: Any) -> Any:
        return value.item() if isinstance(value, np.generic) else _str(value)

    return {name: plain(value[()]) for name, value in file.get(group, {}).items()}


def _read_names(file: Any, counts: dict[str, int]) -> dict[str, list[tuple[str, str]]]:
    names = {}
    for kind, path in NAMES.items():
        has = [str(_str(name)) for name in file[path][...]] if path in file else []
        units = [_str(unit) for unit in file[f"{path}_unit"][...]] if f"{path}_unit" in file else []
        has += [f"{kind} {i}" for i in range(len(has), counts[kind])]
        names[kind] = list(zip(has, units + [""] * (len(has) - len(units))))
    return names


def _read_events(file: Any, group: str, of: np.dtype) -> np.ndarray:
    n = len(file[f"{group}/time"]) if f"{group}/time" in file else 0
    rows = np.zeros(n, dtype=of)
    for name in of.names or ():
        if f"{group}/{name}" in file:
            values = file[f"{group}/{name}"][:n]
            if values.ndim == 2:
                rows[name][:, : values.shape[1]] = values
            else:
                rows[name] = values
    return rows


def _read_shapes(file: Any, shape: Any) -> list[Any]:
    if "bodies" not in file:
        return []
    group = file["bodies"]

    def texts(name: str) -> list[str]:
        return [str(_str(value)) for value in group[name][...]]

    def several(*names: str) -> list[list[str]]:
        rows = zip(*(texts(name) for name in names))
        return [[] if not any(row) else list(row) for row in rows]

    first = np.concatenate([[0], np.cumsum(group["points"][...])])
    point = group["point"][...] if "point" in group else np.zeros((0, 3))
    columns = zip(texts("name"), texts("shape"), group["size"][...].tolist(), several("x", "y", "z"), texts("angle"),
                  several(*(f"quaternion_{a}" for a in "wxyz")), several(*(f"end_{a}" for a in "xyz")))
    return [shape(*row, points=point[first[i] : first[i + 1]].tolist()) for i, row in enumerate(columns)]


def read(file: Any, shape: Any) -> dict[str, Any]:
    """The fields of Trajectory."""
    from ._records import CHANGE, IMPACT
    n = len(file["time"])
    columns = {"time": file["time"][:n]}
    nt = file["tangent"].shape[0] if "tangent" in file else 0
    k = file["contact/gap"].shape[1] if "contact/gap" in file else 0
    for path, name, _, _, _ in RECORDS:
        kind = "i4" if name.endswith("mode") else "f8"
        if path in file:
            columns[name] = file[path][:n]
        else:
            columns[name] = np.zeros((n, k, nt) if name == "tangential_impulse" else (n, 0), dtype=kind)
    if "energy/potential" not in file:
        columns["potential"] = None
    counts = {kind: columns[name].shape[1] for kind, name in
              (("coordinate", "q"), ("velocity", "v"), ("constraint", "multiplier"), ("contact", "gap"),
               ("slide", "slide_impulse"))}
    return {**columns, "impacts": _read_events(file, "impact", IMPACT),
            "changes": _read_events(file, "change", CHANGE), "names": _read_names(file, counts),
            "options": _read_values(file, "options"), "parameters": _read_values(file, "parameters"),
            "model": _str(file.attrs.get("model", "")), "status": _str(file.attrs.get("status", "")),
            "shapes": _read_shapes(file, shape)}
