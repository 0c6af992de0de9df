"""Results of a run: arrays, pictures, animations, files."""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Iterator, Sequence

import numpy as np

from . import _file, _frames
from ._errors import needed
from ._records import EVENTS, ContactColumns, certificates, events
from ._system import KINDS, System

if TYPE_CHECKING:
    import pandas
    import xarray

    from ._viewer import Viewer


def names_of(system: System) -> dict[str, list[tuple[str, str]]]:
    """(name, unit) by kind; default names are numbered."""
    numbered = {"coordinate": "q", "velocity": "v"}
    return {kind: [(name or f"{numbered.get(kind, kind)}{i}", unit) for i, (name, unit) in enumerate(system.names(kind))]
            for kind in KINDS}


@dataclass
class Shape:
    """Shape and position of a body, for animations.

    Positions are numbers, or formulas over the time t, the coordinates (by name, or q0, q1, ...) and the parameters.

    Attributes
    ----------
    name : str
        Unique name.
    shape : str
        "point", "disc", "segment", "polygon", "path", "sphere", "capsule", "box", "plane", "polyhedron",
        "cylinder", "cone" or "ellipsoid".
    size : sequence of float
        Up to three lengths [m], see Notes.
    position : sequence of str or float
        x, y, z of the origin.
    angle : str or float
        Angle about z [rad].
    quaternion : sequence of str or float
        w, x, y, z of the rotation of its frame into space.
    end : sequence of str or float
        x, y, z of the other end of a segment.
    points : sequence
        Corners of a polygon or path, or of the triangles of a polyhedron, in its own frame: x, y or x, y, z each.
    colour : str
        "#rrggbb"; empty: chosen by the program.

    Notes
    -----
    Sizes:

    - disc: radius, radius of its hole
    - segment, path: width
    - sphere: radius
    - capsule, cylinder, cone: radius, length
    - box, ellipsoid: edges, axes
    - plane: its normal
    """

    name: str
    shape: str
    size: Sequence[float] = ()
    position: Sequence[str | float] = ()
    angle: str | float = ""
    quaternion: Sequence[str | float] = ()
    end: Sequence[str | float] = ()
    points: Sequence[Sequence[float]] = ()
    colour: str = ""


@dataclass
class Trajectory(ContactColumns):
    """Result of a run, as arrays of n records: the start, and the recorded steps.

    ``trajectory["theta"]`` is the column of a coordinate or velocity by its name.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s]
    q : ndarray, shape (n, nq)
        Coordinates.
    v : ndarray, shape (n, nv)
        Velocities.
    multiplier : ndarray, shape (n, m)
        Mean bilateral forces of the step.
    contacts : structured ndarray, shape (n, k) or (c,)
        Fixed contacts: all of each record. Contact list: the closed contacts of all records one after another; `contacts_at`
        selects a record.
    gap, normal_impulse, mode : ndarray, shape (n, k) or (c,)
        Fields of the contacts: gaps [m], normal impulses [N s] and modes (0 open, 1 slip, 2 stick).
    tangential_impulse : ndarray, shape (n, k, nt) or (c, nt)
        [N s]
    contact_count : ndarray of int, shape (n,)
        Number of contacts of each record.
    frictional_joint_impulse, frictional_joint_mode : ndarray, shape (n, f)
        Friction impulses [N s] and modes of the frictional joints.
    kinetic, dissipated : ndarray, shape (n,)
        Energies [J].
    projection_energy : ndarray, shape (n,)
        Potential energy that projection="slop" added so far [J], a part of `dissipated`.
    potential : ndarray or None, shape (n,)
        Potential energy [J]; None without a potential.
    lcp_residual, constraint_drift, penetration : ndarray, shape (n,)
        Residual of the contact problem, max abs(Phi), largest overlap [m].
    contact_tol : ndarray or None, shape (n,)
        Largest tolerance of the contact problems of the step, 0 without one. None in older files.
    certificate : structured ndarray or None, shape (n,)
        ``Record.certificate`` of each record.
    sensors : dict
        Values of the named sensors of `Bodies.add_sensor`, shape (n,) or (n, components).
    impacts, changes : structured ndarray
        Impacts and mode transitions, see Notes.
    names : dict
        ``{"coordinate": [(name, unit), ...], ...}``, also of "velocity", "constraint", "contact", "frictional_joint",
        "sensor".
    blocks : ndarray or None, shape (blocks, 2)
        nq and nv of each block, with a contact list.
    options, stats, parameters : dict
        Options, statistics and parameters of the run.
    model, status : str
        Name of the model; "complete" or "failed".
    shapes : list of Shape
        Bodies.

    Notes
    -----
    Fields of the structured arrays:

    - impacts: time, contact, normal_impulse, tangential_impulse [2], velocity_before, velocity_after, peak_force, accumulation
      (1: Zeno accumulation that ends at its time), id, block [2].
    - changes: time, contact, frictional_joint, mode_before, mode_after, id, block [2] (method "event").
    - contacts: id, block [2], gap, normal_impulse, tangential_impulse [nt], mode; with ``contact_forces=True`` also point [3] [m]
      and force [3] [N], as of `Sim.contact_forces`.

    id is the number of a fixed contact, from 0, or the identifier in the contact list. block has the blocks of a listed contact;
    -1 is the ground, and both are -1 for fixed contacts. contact is the number of a fixed contact, or -1.
    """

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    multiplier: np.ndarray
    contacts: np.ndarray
    contact_count: np.ndarray
    frictional_joint_impulse: np.ndarray
    frictional_joint_mode: np.ndarray
    kinetic: np.ndarray
    potential: np.ndarray | None
    dissipated: np.ndarray
    projection_energy: np.ndarray
    lcp_residual: np.ndarray
    constraint_drift: np.ndarray
    penetration: np.ndarray
    impacts: np.ndarray
    changes: np.ndarray
    names: dict[str, list[tuple[str, str]]]
    options: dict[str, Any] = field(default_factory=dict)
    stats: dict[str, Any] = field(default_factory=dict)
    parameters: dict[str, Any] = field(default_factory=dict)
    model: str = ""
    status: str = "complete"
    shapes: list[Shape] = field(default_factory=list)
    blocks: np.ndarray | None = None
    certificate: np.ndarray | None = None
    contact_tol: np.ndarray | None = None
    sensors: dict[str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def _of_run(cls, arrays: dict[str, Any], names: dict[str, list[tuple[str, str]]], *, has_potential: bool,
                **told: Any) -> Trajectory:
        impacts, changes, contacts = events(arrays)
        columns = {name: values for name, values in arrays.items()
                   if name not in (*EVENTS, "nt", "acceleration", "potential", "certificate", "sensors")}
        named = [(name, unit) for name, unit in names["sensor"] if name]
        sensors = {name: values for (name, _), values in zip(names["sensor"], arrays["sensors"]) if name}
        names = {**names, "sensor": named}
        return cls(**columns, potential=arrays["potential"] if has_potential else None, impacts=impacts, changes=changes,
                   contacts=contacts, certificate=certificates(arrays), names=names, sensors=sensors, **told)

    @property
    def method(self) -> str:
        """Name of the method."""
        return str(self.options.get("method", ""))

    def contacts_at(self, record: int) -> np.ndarray:
        """Returns the contacts of a record.

        Parameters
        ----------
        record : int
            Number of the record.

        Returns
        -------
        structured ndarray
        """
        ends = np.cumsum(self.contact_count)
        i = range(len(self))[record]
        return self.contacts.reshape(-1)[ends[i] - self.contact_count[i] : ends[i]]

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, name: str) -> np.ndarray:
        """Column of a coordinate or velocity by its name, shape (n,), or a sensor; the coordinate, if a velocity has its name."""
        found = [of[:, i] for kind, of in (("coordinate", self.q), ("velocity", self.v))
                 for i, (has, _) in enumerate(self.names[kind]) if has == name]
        if found and name in self.sensors:
            raise KeyError(f"'{name}' is the name of a sensor and of a coordinate or velocity: use q, v or sensors")
        if found or name in self.sensors:
            return found[0] if found else self.sensors[name]
        known = dict.fromkeys([has for kind in ("coordinate", "velocity") for has, _ in self.names[kind]] + list(self.sensors))
        raise KeyError(f"no coordinate, velocity or sensor is called '{name}': they are {', '.join(known)}")

    def __repr__(self) -> str:
        span = f"{self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "empty"
        return (f"nsdae.Trajectory({self.model!r}, {self.method}, {span}, {len(self)} records, "
                f"{len(self.impacts)} impacts, {self.status})")

    def _repr_html_(self) -> str:
        span = f"{self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "empty"
        return _frames.page(self.model or "nsdae.Trajectory", [
            ("method", self.method), ("time", span), ("records", len(self)), ("impacts", len(self.impacts)), ("status", self.status),
            *((word.replace("_", " "), float(getattr(self, word).max())) for word in
              ("penetration", "constraint_drift", "lcp_residual") if len(self))])

    def to_pandas(self, table: str = "records") -> pandas.DataFrame:
        """Returns a table of pandas, with the time as its index.

        Parameters
        ----------
        table : str
            "records": coordinates, velocities, forces, energies, sensors by their names. A velocity that has the name of a
            coordinate has the prefix ``v_``. "impacts", "changes", "contacts": the fields of these arrays; components have
            numbered columns.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        ValueError
            The table is unknown.
        """
        return _frames.pandas_of(self, table)

    def to_xarray(self) -> xarray.Dataset:
        """Returns a dataset of xarray, over the time and the names of coordinates, velocities, constraints and contacts.

        Contacts of a list are in ``to_pandas("contacts")``.

        Returns
        -------
        xarray.Dataset
        """
        return _frames.xarray_of(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes an HDF5 file for nsdae-plot, nsdae-animate, nsdae-vtk and `load`.

        An existing file is replaced when the new one is complete.

        Parameters
        ----------
        path : path-like
            The file.
        """
        path = os.fspath(path)
        part = f"{path}.part"
        try:
            _file.write(self, part)
            os.replace(part, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.remove(part)
            raise

    @contextlib.contextmanager
    def _opened(self) -> Iterator[Any]:
        """Opens it as a file in memory."""
        file = _file.Arrays()
        _file.fill(self, file)
        yield file

    def plot(self, only: Sequence[str] | None = None, title: str | None = None, *, phase: Sequence[str] = (),
             path: Sequence[str] = ()) -> Any:
        """Draws the trajectory, as nsdae-plot does.

        Parameters
        ----------
        only : list of str, optional
            Panels: "coordinates", "velocities", "multipliers", "modes", "forces", "impulses", "energy", "certificate".
        title : str, optional
            Title of the picture.
        phase : list of str, optional
            Coordinates: phase portraits in place of the panels.
        path : list of str, optional
            Bodies and points: paths of their centres, y over x, in place of the panels. A point is "X,Y", two formulas of
            the coordinates, such as "x + 0.5*cos(theta), y".

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ValueError
            A panel, coordinate or body is unknown.
        """
        needed("matplotlib", "plot")
        from .pictures import plot
        if phase or path:
            with self._opened() as file:
                try:
                    return plot.portraits(file, phase, path, title or plot.title_of(file))
                except plot.Problem as problem:
                    raise ValueError(str(problem)) from None
        unknown = [name for name in only or () if name not in plot.PANELS]
        if unknown:
            raise ValueError(f"no panel is called '{unknown[0]}': they are {', '.join(plot.PANELS)}")
        with self._opened() as file:
            return plot.draw(file, plot.panels(file, only), title or plot.title_of(file), asked=only)

    def animate(self, path: str | os.PathLike[str] | None = None, **options: Any) -> Any:
        """Animates the bodies, as nsdae-animate does. It needs shapes, or the option ``point``.

        Parameters
        ----------
        path : path-like, optional
            File with the ending .gif, .mp4 or .html. Without it an object for notebooks is returned.
        **options
            speed (0.1: a tenth of real time), fps, start, end [s], width [pixels], title.
            point=(0, 1, None) draws a point at (q0, q1, 0). forces=True draws contact forces at their points (``contact_forces=True`` of `solve`), or
            those of a contact list as lines between bodies.

        Returns
        -------
        Page or None

        Raises
        ------
        ValueError
            An option is wrong, or there are no bodies.
        """
        if path is not None:
            self._animate(os.fspath(path), options)
            return None
        with tempfile.TemporaryDirectory() as folder:
            page = os.path.join(folder, "animation.html")
            self._animate(page, options)
            with open(page, encoding="utf-8") as file:
                return Page(file.read())

    def show(self, *, title: str | None = None, point: Sequence[tuple[int | None, int | None, int | None]] | None = None,
             port: int = 8080, block: bool = True) -> Viewer:
        """Shows the bodies in a browser, as nsdae-view does. It needs viser: ``pip install 'nsdae[viewer]'``.

        Parameters
        ----------
        title : str, optional
            Title, by default model and method.
        point : list of tuple, optional
            (0, 1, None) is a point at (q0, q1, 0), in place of the bodies.
        port : int
            Port of the page, 1 to 65535; the next one that is free is taken.
        block : bool
            True: open a browser and wait for Ctrl-C. False: return at once.

        Returns
        -------
        Viewer

        Raises
        ------
        ImportError
            viser is not installed.
        ValueError
            There are no bodies, or no port is free.
        """
        from ._viewer import opened, shown
        with self._opened() as file:
            viewer: Viewer = opened("playback", file, self.model or "the trajectory", title=title, point=point, port=port)
        if block:
            shown(viewer)
            viewer.wait()
        return viewer

    def _animate(self, path: str, options: dict[str, Any]) -> None:
        if not path.endswith(".html"):
            needed("PIL", "plot")
        from .pictures import animate
        words = {"start": "from", "end": "to"}
        arguments = ["", f"--output={path}"]
        for name, value in options.items():
            if name == "point":
                value = ",".join("-" if c is None else str(c) for c in value)
            if value is not False:
                arguments.append(f"--{words.get(name, name)}" + ("" if value is True else f"={value}"))
        complaint = io.StringIO()
        try:
            with contextlib.redirect_stderr(complaint):
                told = animate.parse(arguments)
        except SystemExit:
            why = complaint.getvalue().strip().split("error: ")[-1]
            raise ValueError(f"animate('{path}'): {why}") from None
        try:
            with self._opened() as file:
                told.file = self.model or "the trajectory"
                told.title = animate.heading(file) if told.title is None else told.title
                time = animate.times_of(file)
                first, last = animate.shown(time, told.start, told.end, told.file)
                animate.write(path, file, time, first, last, told)
        except animate.Problem as problem:
            raise ValueError(str(problem)) from problem


class Page:
    """Animation for notebooks; ``animate(path)`` saves it."""

    def __init__(self, html: str):
        self.html = html

    def _repr_html_(self) -> str:
        quoted = self.html.replace("&", "&amp;").replace('"', "&quot;")
        return f'<iframe srcdoc="{quoted}" width="100%" height="620" frameborder="0"></iframe>'


def load(path: str | os.PathLike[str]) -> Trajectory:
    """Reads a trajectory file of any program of nsdae, also of a killed run.

    Parameters
    ----------
    path : path-like
        The file.

    Returns
    -------
    Trajectory

    Raises
    ------
    OSError
        The file cannot be read.
    ValueError
        The file is no trajectory, or is damaged.
    """
    needed("h5py", "hdf5")
    from .pictures import trajectory as tool
    try:
        with tool.open_trajectory(os.fspath(path), "v") as file:
            return Trajectory(**_file.read(file, Shape))
    except ValueError as error:
        raise ValueError(f"cannot read '{os.fspath(path)}': {error}") from None
    except tool.Problem as problem:
        cause = problem.__cause__
        raise (type(cause) if isinstance(cause, OSError) else ValueError)(str(problem)) from cause
