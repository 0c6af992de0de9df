"""Trajectory files, as described in docs/trajectory.md: the layout is a table."""

from __future__ import annotations

import contextlib
import datetime
import io
import os
from typing import TYPE_CHECKING, Any, Iterator

import numpy as np

from . import _core
from ._errors import needed
from ._records import CERTIFICATE as CERTIFICATE_ROW

if TYPE_CHECKING:
    from ._trajectory import Trajectory

TEXTS = {"format": "nsdae-trajectory", "library_version": _core.VERSION}

WHICH = ", from 0; -1: the figure is 0"

JOINT = "frictional_joint/frictional_joint"
# dataset, attribute of Trajectory, unit, description, scales of its dimensions
RECORDS = (
    ("q", "q", "of the model", "coordinates", ("time", "coordinate")),
    ("v", "v", "of the model", "velocities", ("time", "velocity")),
    ("multiplier", "multiplier", "of the model: force of each constraint",
     "mean bilateral force over the step that ends here", ("time", "constraint")),
    ("frictional_joint/impulse", "frictional_joint_impulse", "N s|N m s",
     "friction impulse of each frictional joint, of the step that ends here", ("time", JOINT)),
    ("frictional_joint/mode", "frictional_joint_mode", "1", "0 frictionless, 1 slip, 2 stick", ("time", JOINT)),
    ("energy/kinetic", "kinetic", "J", "v^T M v / 2", ("time",)),
    ("energy/potential", "potential", "J", "potential energy of the model", ("time",)),
    ("energy/dissipated", "dissipated", "J", "work taken by contact and friction impulses so far", ("time",)),
    ("energy/projection", "projection_energy", "J",
     "potential energy that projection = slop added so far; a part of dissipated, < 0 there", ("time",)),
    ("certificate/lcp_residual", "lcp_residual", "1",
     "scaled natural residual of the step's complementarity problem", ("time",)),
    ("certificate/contact_tol", "contact_tol", "1", "largest tolerance of the step's contact problems; 0: it had none",
     ("time",)),
    ("certificate/constraint_drift", "constraint_drift", "of the model", "max |Phi|", ("time",)),
    ("certificate/penetration", "penetration", "m|rad", "largest overlap over the contacts", ("time",)),
)
# dataset, field of the certificate, unit, description, axis without which it is left out
CERTIFICATE = (
    ("energy/work", "work", "J", "work so far of forces outside the potential, moving constraints and contacts", ""),
    ("energy/unexplained", "unexplained", "J",
     "change of energy + dissipated - work so far: < 0 is a loss of the method, > 0 a gain", ""),
    ("certificate/penetration_contact", "penetration_contact", "1", "contact of the largest overlap" + WHICH, "contact"),
    ("certificate/pull", "pull", "N s|N m s", "largest impulse by which a contact pulls", "contact"),
    ("certificate/pull_contact", "pull_contact", "1", "that contact" + WHICH, "contact"),
    ("certificate/cone_excess", "cone_excess", "N s", "largest friction impulse beyond mu times the normal impulse",
     "contact"),
    ("certificate/cone_contact", "cone_contact", "1", "contact of that excess" + WHICH, "contact"),
    ("certificate/complementarity", "complementarity", "J",
     "largest product of a normal impulse and the velocity that it should make zero", "contact"),
    ("certificate/complementarity_contact", "complementarity_contact", "1", "contact of that product" + WHICH, "contact"),
    ("certificate/drift_constraint", "drift_constraint", "1", "constraint of max |Phi|" + WHICH, "constraint"),
    ("certificate/constraint_rate", "constraint_rate", "of the model", "max |dPhi/dt|", "constraint"),
    ("certificate/rate_constraint", "rate_constraint", "1", "constraint of max |dPhi/dt|" + WHICH, "constraint"),
)
IMPACTS = (
    ("id", "1", "id of the contact"), ("block", "1", "blocks of the contact; -1: the ground"),
    ("normal_impulse", "N s|N m s", "normal impulse"),
    ("tangential_impulse", "N s", "tangential impulse"), ("velocity_before", "m/s|rad/s", "normal velocity before"),
    ("velocity_after", "m/s|rad/s", "normal velocity after"),
    ("peak_force", "N|N m", "largest normal force of a continuous contact; 0 for a rigid one"),
    ("accumulation", "1", "1 where the entry stands for infinitely many impacts that end at its time in rest"),
)
CHANGES = (
    ("id", "1", "id of the contact; -1: a frictional joint"), ("block", "1", "blocks of the contact; -1: the ground"),
    ("frictional_joint", "1", "frictional joint, from 0; -1: a contact"),
    ("mode_before", "1", "0 open, 1 slip, 2 stick"), ("mode_after", "1", "0 open, 1 slip, 2 stick"),
)
# field, unit, description, scale of its last dimension
CONTACTS = (
    ("block", "1", "blocks of the contact; -1: the ground", ("side",)),
    ("gap", "m|rad", "normal distance, negative in overlap; of a contact list at the last evaluation",
     ()),
    ("normal_impulse", "N s|N m s", "normal impulse of the step that ends here", ()),
    ("tangential_impulse", "N s", "tangential impulse of the step that ends here", ("tangent",)),
    ("mode", "1", "0 open, 1 slip, 2 stick", ()),
    ("point", "m", "midway between the surfaces; NaN of a contact without an impulse or of no solids", ("component3",)),
    ("force", "N", "on the body of the larger number, mean over the step that ends here", ("component3",)),
)
NAMES = {"coordinate": "coordinate", "velocity": "velocity", "constraint": "constraint", "contact": "contacts/contact",
         "frictional_joint": JOINT}


class Arrays:
    """The arrays of a file by their paths, without HDF5: for pictures, which read it like a file of h5py."""

    filename = ""

    def __init__(self, of: dict[str, Any] | None = None, group: str = "", attributes: dict[str, dict[str, Any]] | None = None):
        self.of, self.group, self.name = {} if of is None else of, group, f"/{group[:-1]}"
        self.attributes = {} if attributes is None else attributes
        self.attrs = self.attributes.setdefault(group, {})

    def __contains__(self, path: str) -> bool:
        whole = self.group + path
        return whole in self.of or any(known.startswith(f"{whole}/") for known in self.of)

    def __getitem__(self, path: str) -> Any:
        if path not in self:
            raise KeyError(path)
        whole = self.group + path
        return self.of[whole] if whole in self.of else Arrays(self.of, f"{whole}/", self.attributes)

    def get(self, path: str, default: Any = None) -> Any:
        return self[path] if path in self else default

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys(path[len(self.group):].split("/")[0] for path in self.of if path.startswith(self.group)))

    def items(self) -> list[tuple[str, Any]]:
        return [(name, self[name]) for name in self]

    def put(self, path: str, values: Any, unit: str, description: str) -> None:
        self.of[self.group + path] = np.asarray(values).view(_Column)
        self.of[self.group + path].attrs = {"units": unit, "description": description}


class _Column(np.ndarray):
    """An array with attributes, as a dataset of h5py that may grow has them."""

    attrs: dict[str, str]
    maxshape = (None,)


def write(trajectory: Trajectory, path: str) -> None:
    """Writes a new file. It is made in memory, because HDF5 crashes after a failed write on a full disk."""
    h5py = needed("h5py", "hdf5")
    from .pictures import trajectory as tool
    whole = io.BytesIO()
    with h5py.File(whole, "w") as file:
        fill(trajectory, file)
    tool.put(path, whole.getbuffer())


class _Image(io.BytesIO):
    """A file in memory that lists where it was written."""

    def __init__(self) -> None:
        super().__init__()
        self.written: list[tuple[int, int]] = []

    def write(self, content: Any) -> int:
        self.written.append((self.tell(), memoryview(content).nbytes))
        return super().write(content)


def _is(path: str, file: tuple[int, Any] | None) -> bool:
    """Whether the file of this number on the disk has the name."""
    return file is not None and os.path.lexists(path) and os.lstat(path).st_ino == file[0]


class Growing:
    """A file that grows during a run and is whole at any time.

    HDF5 writes to memory, as in `write`. Two files on the disk take the bytes that changed, in turn, and exchange their names.
    """

    def __init__(self, path: str):
        self.path, self.part, self.spare = path, f"{path}.part", f"{path}.spare"
        self.image = _Image()
        self.file: Any = None
        # each file: its number on the disk, and the places of bytes that it does not have
        self.shown: tuple[int, list[tuple[int, int]]] | None = None
        self.other: tuple[int, list[tuple[int, int]]] | None = None

    def append(self, trajectory: Trajectory) -> None:
        """Writes the next records of the run."""
        h5py = needed("h5py", "hdf5")
        if self.file is None:
            self.file = h5py.File(self.image, "w")
            fill(trajectory, self.file)
        else:
            self._extend(trajectory)
        self.file.flush()
        for of in (self.shown, self.other):
            if of:
                of[1].extend(self.image.written)
        self.image.written.clear()
        number = self._update()
        self.shown, self.other = (number, []), self.shown if self._exchange() else None

    def close(self) -> None:
        """Removes the second file."""
        if self.file is not None:
            self.file.close()
        with contextlib.suppress(OSError):
            os.remove(self.part)

    def _extend(self, trajectory: Trajectory) -> None:
        h5py = needed("h5py", "hdf5")
        with h5py.File("nsdae", "w", driver="core", backing_store=False) as part:
            fill(trajectory, part)
            before = len(self.file["contacts/id"]) if trajectory.blocks is not None else 0

            def add(path: str, rows: Any) -> None:
                if getattr(rows, "maxshape", ())[:1] == (None,) and len(rows) > 0:
                    to = self.file[path]
                    to.resize(len(to) + len(rows), axis=0)
                    to[-len(rows):] = rows[...] + before if path == "contacts/first" else rows[...]

            part.visititems(add)

    def _update(self) -> int:
        """Brings the file `part` up to date; a file of someone else is replaced."""
        known = _is(self.part, self.other)
        if not known:
            with contextlib.suppress(FileNotFoundError):
                os.remove(self.part)
        with open(self.part, "r+b" if known else "wb") as file, self.image.getbuffer() as whole:
            for at, size in self.other[1] if self.other and known else [(0, len(whole))]:
                file.seek(at)
                file.write(whole[at:at + size])
            file.truncate(len(whole))
            return os.fstat(file.fileno()).st_ino

    def _exchange(self) -> bool:
        """False if the file under the name is lost, is of someone else or cannot have two names."""
        with contextlib.suppress(FileNotFoundError):
            os.remove(self.spare)
        try:
            if not _is(self.path, self.shown):
                raise FileNotFoundError(self.path)
            os.link(self.path, self.spare)
        except OSError:
            os.replace(self.part, self.path)
            return False
        os.replace(self.part, self.path)
        os.replace(self.spare, self.part)
        return True


def _text(values: Any) -> Any:
    return np.array([str(value) for value in values], dtype=object)


def _unit(file: Any, path: str, unit: str) -> str:
    """The unit "A|B" of a dataset is A of displacements, B of rotations, "A, B" of both."""
    length, _, turn = unit.partition("|")
    names = f"{JOINT if path.startswith('frictional_joint/') else 'contacts/contact'}_unit"
    turns = {_str(text) == "rad" for text in file[names][...]} if turn and names in file else {False}
    return ", ".join(text for text, is_turn in ((length, False), (turn, True)) if is_turn in turns)


def _put(file: Any, path: str, values: Any, unit: str, description: str, scales: tuple[str, ...] = ()) -> Any:
    if isinstance(file, Arrays):
        return file.put(path, values, _unit(file, path, unit), description)
    h5py = needed("h5py", "hdf5")
    values = np.asarray(values)
    kind = h5py.string_dtype() if values.dtype == object else values.dtype
    rows = 1024 if scales and scales[0].endswith("time") else 16384 if scales[:1] == ("contacts/id",) else 0
    made = file.create_dataset(path, data=values, dtype=kind,
                               maxshape=(None,) + values.shape[1:] if rows else None,
                               chunks=(rows,) + values.shape[1:] if rows else None)
    made.attrs["units"], made.attrs["description"] = _unit(file, path, unit), description
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
        _put(file, f"{path}_unit", _text(unit for _, unit in rows), "", "units of these", (path,))
    nt = trajectory.tangential_impulse.shape[-1]
    if nt:
        _put(file, "tangent", _text(f"tangent{i}" for i in range(nt)), "", "names of the tangential directions",
             ("tangent",))


def _put_events(file: Any, group: str, rows: np.ndarray, table: Any, said: str, nt: int) -> None:
    time = f"{group}/time"
    _put(file, time, rows["time"], "s", said, (time,))
    for name, unit, description in table:
        values = rows[name][:, :nt] if name == "tangential_impulse" else rows[name]
        if name == "block" and "side" not in file or not all(values.shape[1:]):
            continue
        made = _put(file, f"{group}/{name}", np.ascontiguousarray(values), unit, description, (time,))
        if values.ndim == 2 and made is not None:
            made.dims[1].attach_scale(file["side" if name == "block" else "tangent"])


def _put_certificate(file: Any, trajectory: Trajectory, listed: bool) -> None:
    has = {"": True, "contact": listed or trajectory.contacts.shape[1] > 0,
           "constraint": trajectory.multiplier.shape[1] > 0}
    for path, name, unit, description, axis in CERTIFICATE:
        if trajectory.certificate is not None and has[axis]:
            _put(file, path, np.ascontiguousarray(trajectory.certificate[name]), unit, description, ("time",))


def _rows(file: Any, path: str, n: int) -> Any:
    """The first n rows of a dataset."""
    values = file[path][:n]
    if len(values) < n:
        raise ValueError(f"its /{path} has {len(values)} of {n} rows")
    return values


def _read_certificate(file: Any, columns: dict[str, Any]) -> np.ndarray | None:
    """None if the file has no certificate; omitted figures are 0."""
    if "energy/unexplained" not in file:
        return None
    rows = np.zeros(len(columns["time"]), dtype=CERTIFICATE_ROW)
    for name in CERTIFICATE_ROW.names or ():
        rows[name] = -1 if CERTIFICATE_ROW[name].kind == "i" else 0
    for path, name, *_ in CERTIFICATE:
        if path in file:
            rows[name] = _rows(file, path, len(rows))
    for name in ("penetration", "constraint_drift", "dissipated"):
        rows[name] = columns[name]
    rows["energy"] = columns["kinetic"] + (0 if columns["potential"] is None else columns["potential"])
    return rows


def _put_list(file: Any, trajectory: Trajectory) -> None:
    """Where the contacts of each record are in the list of all, and their ids."""
    count = np.asarray(trajectory.contact_count, dtype="i4")
    _put(file, "contacts/first", np.cumsum(count, dtype="i8") - count, "1",
         "row of the lists below at which the contacts of this record begin", ("time",))
    _put(file, "contacts/count", count, "1", "number of these contacts, which were closed in the step that ends here",
         ("time",))
    _put(file, "contacts/id", trajectory.contacts["id"], "1", "id of the contact, constant in time", ("contacts/id",))
    _put(file, "side", _text(["first", "second"]), "", "sides of a contact", ("side",))


def _put_contacts(file: Any, trajectory: Trajectory, listed: bool) -> None:
    """A row is one contact of a list, or all fixed contacts of a record."""
    rows = trajectory.contacts
    if listed:
        _put_list(file, trajectory)
    elif rows.shape[1] > 0:
        _put(file, "contacts/id", np.arange(rows.shape[1]), "1", "number of the contact", ("contacts/contact",))
    else:
        return
    file["contacts"].attrs["fixed"] = np.int32(0 if listed else rows.shape[1])
    if "point" in (rows.dtype.names or ()):
        _put_components(file, 3)
    for name, unit, description, last in CONTACTS:
        if name not in (rows.dtype.names or ()):
            continue
        scales = (("contacts/id",) if listed else ("time", "contacts/contact")) + last
        if all(rows[name].shape[1:]) and (listed or name != "block"):
            _put(file, f"contacts/{name}", np.ascontiguousarray(rows[name]), unit, description, scales)


def _put_blocks(file: Any, blocks: np.ndarray) -> None:
    first = np.cumsum(blocks, axis=0, dtype="i4") - blocks
    _put(file, "blocks/q", first[:, 0].astype("i4"), "1", "first coordinate of each block")
    _put(file, "blocks/v", first[:, 1].astype("i4"), "1", "first velocity of each block")


def _place_of(shape: Any, number: dict[str, int]) -> tuple[int, int, int] | None:
    """(dimension, first coordinate of the position, of the rotation or -1) of a shape placed by coordinates alone."""
    def first(formulas: Any) -> int:
        found = [number.get(str(f), -9) for f in formulas]
        return found[0] if found == list(range(found[0], found[0] + len(found))) else -9

    position = [f for f in shape.position if f != ""]
    at, turn = first(position) if len(position) in (2, 3) else -9, -1
    if shape.angle != "":
        turn = first([shape.angle]) if len(position) == 2 else -9
    elif any(shape.quaternion):
        turn = first(shape.quaternion) if len(position) == 3 else -9
    return None if shape.shape == "segment" or at < 0 or turn < -1 else (len(position), at, turn)


def _put_placed(file: Any, shapes: list[Any], places: list[tuple[int, int, int]]) -> None:
    from .pictures.bodies import SHAPES
    _put(file, "shapes/name", _text(s.name for s in shapes), "", "names of what is placed by coordinates alone")
    _put(file, "shapes/shape", np.array([SHAPES.index(s.shape) for s in shapes], dtype="i4"), "1",
         "0 point, 1 disc, 3 polygon, 4 path, 5 sphere, 6 capsule, 7 box, 8 plane, 9 polyhedron, 10 cylinder, "
         "11 cone, 12 ellipsoid")
    for i, (name, said) in enumerate((
            ("dimension", "2: in the plane, 3: in space"),
            ("position", "coordinate, from 0, that is x of the origin; y, z come after it"),
            ("turn", "coordinate, from 0, that is the angle about z, or in space w of the quaternion, whose x, y, z come "
             "after it; -1: not turned"))):
        _put(file, f"shapes/{name}", np.array([place[i] for place in places], dtype="i4"), "1", said)
    _put_sizes(file, "shapes", shapes)


def _put_sizes(file: Any, group: str, shapes: list[Any]) -> None:
    def padded(values: Any, what: str) -> np.ndarray:
        row = [float(v) for v in values]
        if len(row) > 3:
            raise ValueError(f"{what} has {len(row)} numbers; it has at most 3")
        return np.array(row + [0.0] * (3 - len(row)))

    if any(s.colour for s in shapes):
        _put(file, f"{group}/colour", _text(s.colour for s in shapes), "", "#rrggbb; empty: none")
    _put(file, f"{group}/size", np.array([padded(s.size, "size") for s in shapes]), "m", "by the shape")
    points = [padded(p, "a point") for s in shapes for p in s.points]
    _put(file, f"{group}/points", np.array([len(s.points) for s in shapes], dtype="i4"), "1",
         "rows of point in this group that each has, in order")
    if points:
        _put(file, f"{group}/point", np.array(points), "m", "corners of polygons, paths and triangles of polyhedra in their bodies' frames")


def _put_shapes(file: Any, shapes: list[Any]) -> None:
    def formulas(name: str, number: int) -> Any:
        return _text((list(getattr(s, name)) + [""] * 4)[number] for s in shapes)

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
    _put_sizes(file, "bodies", shapes)


def _put_values(file: Any, group: str, values: dict[str, Any]) -> None:
    if isinstance(file, Arrays):
        for name, value in values.items():
            file.put(f"{group}/{name}", value, "", "")
        return
    file.create_group(group)
    for name, value in values.items():
        file[group].create_dataset(name, data=value)


def _put_components(file: Any, count: int) -> str:
    """The scale of vectors with `count` components."""
    axis = f"component{count}"
    if axis not in file:
        _put(file, axis, _text(f"component{i}" for i in range(count)), "", "components of a vector", (axis,))
    return axis


def _put_sensors(file: Any, trajectory: Trajectory) -> None:
    units = dict(trajectory.names.get("sensor", []))
    for name, values in trajectory.sensors.items():
        axis = _put_components(file, values.shape[1]) if values.ndim > 1 else ""
        _put(file, f"sensor/{name}", values, units.get(name, ""), "sensor of the model", ("time", axis) if axis else ("time",))


def _read_sensors(file: Any, n: int) -> tuple[dict[str, np.ndarray], list[tuple[str, str]]]:
    """Values of the sensors; (name, unit) of each."""
    group = file.get("sensor", {})
    return ({name: _rows(file, f"sensor/{name}", n) for name in group},
            [(name, str(_str(group[name].attrs.get("units", "")))) for name in group])


def fill(trajectory: Trajectory, file: Any) -> None:
    """Writes everything to an empty file."""
    now = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    for name, text in {**TEXTS, "status": trajectory.status, "model": trajectory.model, "method": trajectory.method,
                       "created": now}.items():
        file.attrs[name] = text
    listed = trajectory.blocks is not None
    file.attrs["format_version"] = np.int32(3)
    _put_values(file, "options", trajectory.options)
    _put_values(file, "parameters", trajectory.parameters)
    _put(file, "time", trajectory.time, "s", "simulated time", ("time",))
    _put_names(trajectory, file)
    for path, name, unit, description, scales in RECORDS:
        values = getattr(trajectory, name)
        if values is not None and all(values.shape[1:]):
            _put(file, path, values, unit, description, scales)
    _put_certificate(file, trajectory, listed)
    _put_sensors(file, trajectory)
    nt = trajectory.tangential_impulse.shape[-1]
    if listed:
        _put_blocks(file, trajectory.blocks)
    _put_contacts(file, trajectory, listed)
    _put_events(file, "impact", trajectory.impacts, IMPACTS,
                "time of the impact; with a time-stepping method the end of its step", nt)
    _put_events(file, "change", trajectory.changes, CHANGES, "instant of a change of mode", nt)
    number = {name: i for i, (name, _) in enumerate(trajectory.names["coordinate"])} if listed else {}
    number.update({f"q{i}": i for i in range(trajectory.q.shape[1])} if listed else {})
    places = [_place_of(s, number) for s in trajectory.shapes]
    if any(place is None for place in places):
        _put_shapes(file, [s for s, place in zip(trajectory.shapes, places) if place is None])
    if any(places):
        _put_placed(file, [s for s, place in zip(trajectory.shapes, places) if place], [place for place in places if place])


def _str(value: Any) -> Any:
    return value.decode() if isinstance(value, bytes) else value


def _read_values(file: Any, group: str) -> dict[str, Any]:
    def plain(value: Any) -> Any:
        return value.item() if isinstance(value, np.generic) else _str(value)

    return {name: plain(value[()]) for name, value in file.get(group, {}).items()}


def _read_names(file: Any, counts: dict[str, int]) -> dict[str, list[tuple[str, str]]]:
    names, numbered = {}, {"coordinate": "q", "velocity": "v"}
    for kind, path in NAMES.items():
        has = [str(_str(name)) for name in file[path][...]] if path in file else []
        if path in file and file[path].dtype.kind in "iu":  # of many that nobody named the numbers alone
            has = [f"{numbered.get(kind, kind)}{i}" for i in range(len(has))]
        units = [_str(unit) for unit in file[f"{path}_unit"][...]] if f"{path}_unit" in file else []
        has += [f"{kind} {i}" for i in range(len(has), counts[kind])]
        names[kind] = list(zip(has, units + [""] * (len(has) - len(units))))
    return names


def _read_column(rows: np.ndarray, name: str, file: Any, path: str, shape: tuple[int, ...]) -> None:
    """A dataset, which has an entry for each row, into a field; tangential impulses may have fewer directions."""
    values, field = file[path][: shape[0]], rows[name]
    inner = field.shape[rows.ndim :]
    has = values.shape[len(shape) :]
    if values.shape[: len(shape)] != shape or len(has) != len(inner) or (
            has > inner if name == "tangential_impulse" else has != inner):
        raise ValueError(f"its /{path} has the shape {values.shape}; it must be {shape + inner}")
    if name == "tangential_impulse":
        field[..., : has[0]] = values
    else:
        field[...] = values


def _read_events(file: Any, group: str, of: np.dtype) -> np.ndarray:
    rows = np.zeros(len(file[f"{group}/time"]) if f"{group}/time" in file else 0, dtype=of)
    rows["block"] = rows["id"] = -1
    for name in of.names or ():
        if f"{group}/{name}" in file:
            _read_column(rows, name, file, f"{group}/{name}", rows.shape)
    rows["contact"] = -1 if "contacts/first" in file else rows["id"]  # contacts of a list have no number
    return rows


def _read_list(file: Any, n: int) -> tuple[np.ndarray, np.ndarray]:
    """The number of contacts of each of the n records, and the blocks."""
    first, count = file["contacts/first"][:n], file["contacts/count"][:n]
    if (count < 0).any() or not np.array_equal(first, np.cumsum(count, dtype="i8") - count):
        raise ValueError("its /contacts do not follow one another")
    if count.sum() > len(file["contacts/id"]):
        raise ValueError("it has records whose contacts are not in its list")
    q, v = file["blocks/q"][...], file["blocks/v"][...]
    ends = [[*q[1:], file["q"].shape[1]], [*v[1:], file["v"].shape[1]]]
    return count, np.array(ends).T.astype("i4") - np.column_stack([q, v])


def _read_contacts(file: Any, n: int, of: np.dtype) -> dict[str, Any]:
    """The contacts of the n records; the list of a killed run may be longer."""
    if any(f"contacts/{name}" in file for name in ("first", "contact", *(of.names or ()))):
        missing = [name for name in ("id", "gap", "normal_impulse", "mode") if f"contacts/{name}" not in file]
        if missing:
            raise ValueError(f"it has no /contacts/{missing[0]}")
    if "contacts/first" in file:
        count, blocks = _read_list(file, n)
        shape: tuple[int, ...] = (int(count.sum()),)
    else:
        k = file["contacts/gap"].shape[1] if "contacts/gap" in file else 0
        shape, count, blocks = (n, k), np.full(n, k, dtype="i4"), None
    rows = np.zeros(shape, dtype=of)
    rows["block"] = -1
    for name in of.names or ():
        if f"contacts/{name}" in file:
            of_all = name == "id" and blocks is None  # fixed contacts: the same in all records
            _read_column(rows, name, file, f"contacts/{name}", shape[1:] if of_all else shape)
    return {"contacts": rows, "contact_count": count, "blocks": blocks}


def _read_placed(file: Any, shape: Any) -> list[Any]:
    """Shapes that are placed by coordinates alone, with formulas as the other bodies."""
    from .pictures.bodies import SHAPES
    if "shapes" not in file:
        return []
    group = file["shapes"]
    first = np.concatenate([[0], np.cumsum(group["points"][...])])
    point = group["point"][...] if "point" in group else np.zeros((0, 3))
    columns = zip(*(group[name][...].tolist() for name in ("name", "shape", "size", "dimension", "position", "turn")))
    made, colours = [], _colours(group)
    for i, (name, kind, size, dimension, position, turn) in enumerate(columns):
        where = [f"q{position + j}" for j in range(dimension)]
        made.append(shape(str(_str(name)), SHAPES[kind], size, where, f"q{turn}" if dimension == 2 and turn >= 0 else "",
                          [f"q{turn + j}" for j in range(4)] if dimension == 3 and turn >= 0 else [], [],
                          points=point[first[i] : first[i + 1]].tolist(), colour=colours[i]))
    return made


def _colours(group: Any) -> list[str]:
    return [str(_str(text)) for text in group["colour"][...]] if "colour" in group else [""] * len(group["name"])


def _read_shapes(file: Any, shape: Any) -> list[Any]:
    return _read_named(file, shape) + _read_placed(file, shape)


def _read_named(file: Any, shape: Any) -> list[Any]:
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
    return [shape(*row, points=point[first[i] : first[i + 1]].tolist(), colour=colour)
            for i, (row, colour) in enumerate(zip(columns, _colours(group)))]


def read(file: Any, shape: Any) -> dict[str, Any]:
    """The fields of Trajectory."""
    from ._records import CHANGE, IMPACT, contact_row
    n = len(file["time"])
    columns = {"time": file["time"][:n]}
    nt = file["tangent"].shape[0] if "tangent" in file else 0
    contacts = _read_contacts(file, n, contact_row(nt, "contacts/point" in file and "contacts/force" in file))
    for path, name, _, _, _ in RECORDS:
        kind = "i4" if name.endswith("mode") else "f8"
        columns[name] = _rows(file, path, n) if path in file else np.zeros((n, 0), dtype=kind)
    for path, name in (("energy/potential", "potential"), ("certificate/contact_tol", "contact_tol")):
        if path not in file:
            columns[name] = None
    if "energy/projection" not in file:
        columns["projection_energy"] = np.zeros(n)
    counts = {kind: columns[name].shape[1] for kind, name in
              (("coordinate", "q"), ("velocity", "v"), ("constraint", "multiplier"),
               ("frictional_joint", "frictional_joint_impulse"))}
    sensors, sensor_names = _read_sensors(file, n)
    counts["contact"] = contacts["contacts"].shape[1] if contacts["blocks"] is None else 0
    return {**columns, **contacts, "certificate": _read_certificate(file, columns), "impacts": _read_events(file, "impact", IMPACT),
            "changes": _read_events(file, "change", CHANGE), "names": {**_read_names(file, counts), "sensor": sensor_names}, "sensors": sensors,
            "options": _read_values(file, "options"), "parameters": _read_values(file, "parameters"),
            "model": _str(file.attrs.get("model", "")), "status": _str(file.attrs.get("status", "")),
            "shapes": _read_shapes(file, shape)}
