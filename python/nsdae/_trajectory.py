"""What a run leaves: arrays, pictures, animations, files."""

from __future__ import annotations

import contextlib
import os
import tempfile
from dataclasses import dataclass, field
from typing import Any, Iterator, Sequence

import numpy as np

from . import _file
from ._records import CLOSED, EVENTS, certificates, events
from ._system import KINDS, System

_AXES = {"coordinate": "q", "velocity": "v", "constraint": "multiplier", "contact": "gap", 
         "frictional_joint": "frictional_joint_impulse"}


def names_of(system: System) -> dict[str, list[tuple[str, str]]]:
    """(name, unit) by kind; those without a name are numbered."""
    numbered = {"coordinate": "q", "velocity": "v"}
    return {kind: [(name or f"{numbered.get(kind, kind)}{i}", unit) for i, (name, unit) in enumerate(system.names(kind))]
            for kind in KINDS}


@dataclass
class Shape:
    """What a body looks like and where it is, for animations. Places are formulas over the time t, the coordinates
    (by name, or q0, q1, ...) and the parameters, or numbers.

    name      other than those of the others
    shape     "point", "disc", "segment", "polygon", "path", "sphere", "capsule", "box", "plane"
    size      up to three lengths [m]: disc: radius, radius of its hole; segment, path: width; sphere: radius; capsule:
              radius, length; box: edges; plane: its normal
    position  formulas of x, y, z of its origin
    angle     formula of its angle about z [rad]
    quaternion  formulas of w, x, y, z, which turn its frame into space
    end       formulas of x, y, z of a segment's other end
    points    corners of a polygon or path in its own frame, x, y or x, y, z each
    """

    name: str
    shape: str
    size: Sequence[float] = ()
    position: Sequence[str | float] = ()
    angle: str | float = ""
    quaternion: Sequence[str | float] = ()
    end: Sequence[str | float] = ()
    points: Sequence[Sequence[float]] = ()


@dataclass
class Trajectory:
    """A run, as arrays of n records: the start, and the steps that were kept.

    time [n];  q [n, nq];  v [n, nv];  multiplier [n, m], mean bilateral forces over the step that ends here
    gap, normal_impulse, mode [n, k];  tangential_impulse [n, k, nt]  of the contacts; mode: 0 open, 1 slip, 2 stick
    frictional_joint_impulse, frictional_joint_mode [n, f]  of bilateral constraints with friction
    kinetic, dissipated [n] [J];  potential [n], None where the model gives none
    lcp_residual, constraint_drift, penetration [n]
    certificate [n]  structured array: what Record.certificate has, of each record; None of a file without it
    impacts   structured array: time, contact, normal_impulse, tangential_impulse [2], velocity_before, velocity_after,
              peak_force, accumulation (1: stands for infinitely many that end at its time), and of contacts by list,
              whose contact is -1, id and block [2]
    changes   structured array: time, contact, frictional_joint, mode_before, mode_after (method event)
    names     {"coordinate": [(name, unit), ...], "velocity", "constraint", "contact", "frictional_joint"}
    contacts  of contacts by list those closed in the steps of all records, one after another: structured array: id,
              block [2], gap, normal_impulse, tangential_impulse [2], mode; contacts_at(i) are those of record i
    contact_count [n]  how many each record has;  blocks [blocks, 2]  nq and nv of each, None where there are none
    options, stats, parameters, model, status, shapes   what the run was told and how it ended
    """

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    multiplier: np.ndarray
    gap: np.ndarray
    normal_impulse: np.ndarray
    tangential_impulse: np.ndarray
    mode: np.ndarray
    frictional_joint_impulse: np.ndarray
    frictional_joint_mode: np.ndarray
    kinetic: np.ndarray
    potential: np.ndarray | None
    dissipated: np.ndarray
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
    contacts: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=CLOSED))
    contact_count: np.ndarray | None = None
    blocks: np.ndarray | None = None
    certificate: np.ndarray | None = None

    def __post_init__(self) -> None:
        if self.contact_count is None:
            self.contact_count = np.zeros(len(self.time), dtype="i4")

    @classmethod
    def _of_run(cls, arrays: dict[str, Any], names: dict[str, list[tuple[str, str]]], *, has_potential: bool,
                **told: Any) -> Trajectory:
        impacts, changes, contacts = events(arrays)
        columns = {name: values for name, values in arrays.items()
                   if name not in (*EVENTS, "acceleration", "potential", "certificate")}
        return cls(**columns, potential=arrays["potential"] if has_potential else None, impacts=impacts, changes=changes,
                   contacts=contacts, certificate=certificates(arrays), names=names, **told)

    @property
    def method(self) -> str:
        """The method's name."""
        return str(self.options.get("method", ""))

    def contacts_at(self, record: int) -> np.ndarray:
        """The contacts by list that were closed in the step that ends at a record."""
        ends = np.cumsum(self.contact_count)
        i = range(len(self))[record]
        return self.contacts[ends[i] - self.contact_count[i] : ends[i]]

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, name: str) -> np.ndarray:
        """The column [n] of a coordinate or velocity by its name."""
        for kind, of in (("coordinate", self.q), ("velocity", self.v)):
            for i, (has, _) in enumerate(self.names[kind]):
                if has == name:
                    return of[:, i]
        known = [has for kind in ("coordinate", "velocity") for has, _ in self.names[kind]]
        raise KeyError(f"no coordinate or velocity is called '{name}': they are {', '.join(known)}")

    def __repr__(self) -> str:
        span = f"{self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "empty"
        return (f"nsdae.Trajectory({self.model!r}, {self.method}, {span}, {len(self)} records, "
                f"{len(self.impacts)} impacts, {self.status})")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it as an HDF5 file that nsdae-plot, nsdae-animate, nsdae-vtk and load() read; one of that name is
        replaced."""
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
        """As a file that is nowhere but in memory."""
        with _file.in_memory() as file:
            _file.fill(self, file)
            yield file

    def plot(self, only: Sequence[str] | None = None, title: str | None = None) -> Any:
        """A figure of matplotlib: what nsdae-plot draws. only: some of its panels ("coordinates", "velocities",
        "multipliers", "modes", "forces", "impulses", "energy", "certificate")."""
        from .pictures import plot
        unknown = [name for name in only or () if name not in plot.PANELS]
        if unknown:
            raise ValueError(f"no panel is called '{unknown[0]}': they are {', '.join(plot.PANELS)}")
        with self._opened() as file:
            return plot.draw(file, plot.panels(file, only), title or plot.title_of(file))

    def animate(self, path: str | os.PathLike[str] | None = None, **options: Any) -> Any:
        """The bodies in motion, as nsdae-animate draws them: into a file that ends with .gif, .mp4 or .html, or
        without a path as something that a notebook shows. Needs shapes, or point=(0, 1, None): a point at (q0, q1, 0).

        options: speed (0.1: a tenth of real time), fps, start, end [s], width [pixels], title, point, forces
        (True: those of contacts by list, as lines from body to body)
        """
        if path is not None:
            self._animate(os.fspath(path), options)
            return None
        with tempfile.TemporaryDirectory() as folder:
            page = os.path.join(folder, "animation.html")
            self._animate(page, options)
            with open(page, encoding="utf-8") as file:
                return Page(file.read())

    def _animate(self, path: str, options: dict[str, Any]) -> None:
        from .pictures import animate
        words = {"start": "from", "end": "to"}
        with tempfile.TemporaryDirectory() as folder:
            whole = os.path.join(folder, "trajectory.h5")
            self.save(whole)
            arguments = [whole, f"--output={path}"]
            for name, value in options.items():
                if name == "point":
                    value = ",".join("-" if c is None else str(c) for c in value)
                if value is not False:
                    arguments.append(f"--{words.get(name, name)}" + ("" if value is True else f"={value}"))
            try:
                told = animate.parse(arguments)
            except SystemExit:
                raise ValueError(f"animate() was given {options!r} for '{path}': see its help") from None
            try:
                with animate.open_trajectory(whole) as file:
                    name = self.model or "the trajectory"
                    told.file = name
                    time = animate.times_of(file)
                    first, last = animate.shown(time, told.start, told.end, name)
                    animate.write(path, file, time, first, last, told)
            except animate.Problem as problem:
                raise ValueError(str(problem)) from problem


class Page:
    """An animation for notebooks; save it with animate(path)."""

    def __init__(self, html: str):
        self.html = html

    def _repr_html_(self) -> str:
        quoted = self.html.replace("&", "&amp;").replace('"', "&quot;")
        return f'<iframe srcdoc="{quoted}" width="100%" height="620" frameborder="0"></iframe>'


def load(path: str | os.PathLike[str]) -> Trajectory:
    """Reads a trajectory file of any program of nsdae, also one that a killed run left."""
    from .pictures import trajectory as tool
    try:
        with tool.open_trajectory(os.fspath(path), "v") as file:
            return Trajectory(**_file.read(file, Shape))
    except ValueError as error:
        raise ValueError(f"cannot read '{os.fspath(path)}': {error}") from None
    except tool.Problem as problem:
        cause = problem.__cause__
        raise (type(cause) if isinstance(cause, OSError) else ValueError)(str(problem)) from cause
