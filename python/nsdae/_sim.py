"""Simulations: step by step, or a whole run."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Iterator

import numpy as np

from . import _core
from ._arguments import named, refused
from ._bodies import Bodies
from ._errors import ArgumentError, Error, RunWarning, in_python
from ._file import Growing
from ._records import LcpProblem, Record, certificates, joined
from ._system import System, vector
from ._tables import Options, Status
from ._trajectory import Shape, Trajectory, names_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._viewer import LiveViewer

METHODS: dict[str, str] = dict(_core.METHODS)


# options with the values yes and no
_SWITCHES = {key for key, _, _, _, kind in _core.OPTIONS if kind == ("no", "yes")}
# arguments of scipy.integrate.solve_ivp, and what is in their place here
_SCIPY = {
    "args": "user=, the last argument of compiled callbacks", "dense_output": "Sim.interpolate, the state within a step",
    "events": "Sim.run_to_event; impacts and mode transitions are found without it",
    "first_step": "dt=, the time step", "fun": "System(mass=..., force=...)",
    "jac": "the callbacks force_stiffness and force_damping", "max_step": "step_max=, or dt= of a time-stepping method",
    "t_eval": "every=, which keeps every N-th step of dt=, or Sim.interpolate", "t_span": "t_end= and t0=", "y0": "q0= and v0=",
}


def _texts(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options as texts of the library, with all digits of a number; True and False of a switch are yes and no."""
    def text(key: str, value: Any) -> Any:
        if key in _SCIPY:
            raise ArgumentError(f"{key} is an argument of SciPy; here it is {_SCIPY[key]}", Status.E_OPTION, argument=key)
        if isinstance(value, (bool, np.bool_)):
            return ("yes" if value else "no") if key in _SWITCHES else int(value)
        if isinstance(value, (float, np.floating)):
            return repr(float(value))
        return value

    return {key: text(key, value) for key, value in options.items()}


_PAUSE = 1.0  # time between two writes of an output [s]


@named
class Sim:
    """Simulation of a system.

    Parameters
    ----------
    system : System or Bodies
        The model.
    **options
        Options of the library: method, dt, rtol, ...; ``help(nsdae)`` lists them.

    Attributes
    ----------
    system : System
        The model.

    Raises
    ------
    ArgumentError
        An option is unknown or out of range.

    Notes
    -----
    Only one call at a time may use a simulation. A second call, from a callback or another thread, raises `Error` with
    ``Status.E_STATE``.

    A simulation can be pickled if its system can. The copy continues from its state with the same bytes.

    Examples
    --------
    >>> sim = nsdae.Sim(system, method="moreau", dt=1e-3)
    >>> sim.init([1.0])
    >>> for record in sim.steps(3):
    ...     print(record.time, record.q)
    """

    def __init__(self, system: System | Bodies, **options: Unpack[Options]):
        self._bodies = system if isinstance(system, Bodies) else None
        self.system = system.system() if isinstance(system, Bodies) else system
        self._core = _core.Sim(self.system._core.core, _texts(options))
        self._coefficients: dict[tuple[str, int], tuple[float, ...]] = {}  # that differ from the system
        self._initial: tuple[float, np.ndarray, np.ndarray] | None = None

    def __reduce__(self) -> Any:
        started = self._core.started()
        initial = self._initial if started and self.record.step == 0 else None  # the copy has a record of it, too
        state = self.state if started and initial is None else None
        return _copy, (self._bodies or self.system, self.options, self._coefficients, initial, state)

    def _set(self, name: str, i: int, *values: float) -> None:
        self._told(getattr(self._core, name), i, *map(float, values))
        self._coefficients[name, i] = values

    def init(self, q0: Any = None, v0: Any = None, t0: float = 0) -> Status:
        """Sets the initial state, which must satisfy the constraints.

        Parameters
        ----------
        q0 : array_like, shape (nq,), optional
            Coordinates. Default: the start of the `Bodies`; required for a `System`.
        v0 : array_like, shape (nv,), optional
            Velocities. Default: the start of the `Bodies`; zero for a `System`.
        t0 : float
            Time [s].

        Returns
        -------
        Status

        Raises
        ------
        ArgumentError
            The state is inconsistent.
        """
        initial = float(t0), *map(np.array, self._start(q0, v0))
        status = Status(self._core.init(*initial))
        self._initial = initial
        return status

    def _start(self, q0: Any, v0: Any) -> tuple[np.ndarray, np.ndarray]:
        d = self.system.dims
        own = (None, np.zeros(d.nv)) if self._bodies is None else self._bodies.start()
        q0, v0 = own[0] if q0 is None else q0, own[1] if v0 is None else v0
        if q0 is None:
            raise refused("q0", "q0 is missing: coordinates at the start")
        return vector("q0", q0, d.nq), vector("v0", v0, d.nv)

    def project(self, q0: Any = None, v0: Any = None, t0: float = 0) -> tuple[np.ndarray, np.ndarray]:
        """Projects a state onto constraints and contacts, by the least change in the metric of M.

        Parameters
        ----------
        q0, v0, t0
            As for `init`.

        Returns
        -------
        q : ndarray, shape (nq,)
        v : ndarray, shape (nv,)
        """
        return self._core.project(float(t0), *self._start(q0, v0))

    def _told(self, call: Any, *arguments: Any) -> Any:
        try:
            return call(*arguments)
        except Error as error:
            self._complete(error)
            raise

    def _complete(self, error: Error) -> None:
        """Adds the last state and the unsolved problem to an error."""
        try:
            error.record = self.record
            problem = self._core.failed_lcp()
            error.problem = LcpProblem(*problem) if problem else None
        except Error:  # never started, or in another call
            pass

    def step(self) -> Status:
        """Takes one step of dt.

        Returns
        -------
        Status
            OK, EVENT (an impact or a mode transition), ZENO, or a warning.
        """
        return Status(self._told(self._core.step))

    def run(self, t_end: float) -> Status:
        """Takes steps until t_end.

        Parameters
        ----------
        t_end : float
            End time [s].

        Returns
        -------
        Status
        """
        return Status(self._told(self._core.run, float(t_end), False))

    def run_to_event(self, t_end: float) -> Status:
        """Takes steps until t_end, or to the end of the first step with an impact or a mode transition.

        Parameters
        ----------
        t_end : float
            End time [s].

        Returns
        -------
        Status
        """
        return Status(self._told(self._core.run, float(t_end), True))

    def steps(self, t_end: float) -> Iterator[Record]:
        """Iterates over the records of the steps until t_end. The last step is shortened to end there.

        Parameters
        ----------
        t_end : float
            End time [s].

        Yields
        ------
        Record
        """
        return self._steps(float(t_end))

    def _steps(self, t_end: float) -> Iterator[Record]:
        now = self.time
        while now < t_end:
            if now + 1.001 * self._core.dt() < t_end:
                self.step()
            else:  # a rest of dt / 1000 is no step
                self.run(t_end)
            before, now = now, self.time
            if now <= before:
                return
            yield self.record

    @property
    def record(self) -> Record:
        """Current state, a `Record`."""
        return Record(self._core.record())

    @property
    def time(self) -> float:
        """Current time [s]."""
        return self._core.time()

    @property
    def q(self) -> np.ndarray:
        """Current coordinates, a copy, shape (nq,)."""
        return self._core.q()

    @property
    def v(self) -> np.ndarray:
        """Current velocities, a copy, shape (nv,)."""
        return self._core.v()

    @property
    def contacts(self) -> np.ndarray:
        """Contacts of the last step, a copy: as `Record.contacts`."""
        return self._core.contacts()

    @property
    def stats(self) -> dict[str, Any]:
        """Statistics since `init`: steps, LCPs, impacts, worst residual, energy balance, ...

        ``stats["certificate"]`` has the largest figures of all records and the energies of the last.
        """
        stats = self._core.stats()
        stats["certificate"] = certificates(stats)[0]
        return stats

    @property
    def options(self) -> dict[str, Any]:
        """All options with their values."""
        return self._core.options()

    def set_options(self, **options: Unpack[Options]) -> None:
        """Changes options for the following steps.

        The options method, polygon, projection and threads cannot be changed.

        Parameters
        ----------
        **options
            New values.
        """
        self._told(self._core.set_options, _texts(options))

    def set_contact(self, i: int, mu: float = 0, e_n: float = 0, e_t: float = 0) -> None:
        """Sets the coefficients of a contact in this simulation, in place of those of the system.

        Parameters
        ----------
        i : int
            Fixed contact.
        mu, e_n, e_t : float
            Coefficient of friction, normal and tangential restitution.
        """
        self._set("set_contact", i, mu, e_n, e_t)

    def set_frictional_joint(self, j: int, mu: float) -> None:
        """Sets the coefficient of friction of a frictional joint in this simulation.

        Parameters
        ----------
        j : int
            Frictional joint.
        mu : float
            Coefficient of friction.
        """
        self._set("set_frictional_joint", j, mu)

    def set_friction_bound(self, j: int, bound: float) -> None:
        """Sets the friction bound of a frictional joint in this simulation.

        Parameters
        ----------
        j : int
            Frictional joint, whose bound is set in the system.
        bound : float
            Largest friction force [N] or torque [N m] without a load.
        """
        self._set("set_friction_bound", j, bound)

    def set_control(self, i: int, value: float) -> None:
        """Sets the target of a motor in this simulation, in place of its constant target.

        The next step begins with it. It is part of the state.

        Parameters
        ----------
        i : int
            Motor, without a drive.
        value : float
            Target [N, N m; m/s, rad/s; m, rad].
        """
        self._set("set_control", i, value)

    def get_control(self, i: int) -> float:
        """Returns the target of a motor in this simulation.

        Parameters
        ----------
        i : int
            Motor, without a drive.

        Returns
        -------
        value : float
            Target.
        """
        return self._told(self._core.get_control, i)

    def get_sensor(self, i: int) -> np.ndarray:
        """Reads a sensor of `Bodies.add_sensor` at the present record.

        Parameters
        ----------
        i : int
            Number of the sensor.

        Returns
        -------
        ndarray
            Its values. Forces and accelerations are means over the step.
        """
        return self._told(self._core.get_sensor, i)

    def contact_forces(self) -> tuple[np.ndarray, np.ndarray]:
        """Returns where the contacts of the present record act, and their forces.

        Returns
        -------
        point : ndarray, shape (c, 3)
            Points midway between the surfaces of two solids [m], in the order of `Record.contacts`. NaN for a contact without
            an impulse, a limit, a rope or a contact of user rows.
        force : ndarray, shape (c, 3)
            Forces on the body of the larger number, means over the step [N].
        """
        point, force = self._told(self._core.contact_forces)
        return point.reshape(-1, 3), force.reshape(-1, 3)

    def interpolate(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Interpolates the state within the last step.

        Parameters
        ----------
        t : float
            Time [s].

        Returns
        -------
        q : ndarray, shape (nq,)
        v : ndarray, shape (nv,)
        """
        return self._told(self._core.interpolate, float(t))

    @property
    def state(self) -> bytes:
        """Serialised state, bytes.

        A simulation of the same system and options that is set to it continues with the same bytes.
        """
        return self._told(self._core.state)

    @state.setter
    def state(self, block: bytes) -> None:
        self._told(self._core.set_state, block)
        self._initial = None

    def record_run(self, t_end: float, every: int = 1, *, model: str = "", parameters: dict[str, Any] | None = None,
                   shapes: list[Shape] | None = None, output: str | os.PathLike[str] | None = None,
                   contact_forces: bool = False, stacklevel: int = 2) -> Trajectory:
        """Takes steps until t_end and returns the records.

        Parameters
        ----------
        t_end : float
            End time [s].
        every : int
            Keep the start, every N-th step and the last.
        model, parameters, shapes, output, contact_forces
            As for `solve`.
        stacklevel : int
            As for ``warnings.warn``.

        Returns
        -------
        Trajectory

        Warns
        -----
        RunWarning
            Energy, penetration or drift exceed the bound of the method.
        """
        if shapes is None and self._bodies is not None:
            shapes = self._bodies.shapes()
        if contact_forces:
            self.contact_forces()  # of a system without solids it is an error
        recorder = _core.Recorder()
        known = dict(has_potential=self._core.has_potential(), options=self.options, model=model,
                     parameters=parameters or {}, shapes=shapes or [],
                     blocks=self.system.blocks if self.system._listed else None)
        stats, names = self.stats, {**names_of(self.system), "sensor": self._core.sensors()}
        unwritten: list[OSError] = []
        parts: list[dict[str, Any]] = []
        growing = None if output is None else Growing(os.fspath(output))

        def made(arrays: dict[str, Any], status: str, stats: dict[str, Any]) -> Trajectory:
            return Trajectory._of_run(arrays, names, stats=stats, status=status, **known)

        def write() -> None:
            parts.append(recorder.arrays())
            try:
                growing.append(made(parts[-1], "running", stats))
            except OSError as error:
                unwritten.append(error)
                raise

        def whole(status: str) -> Trajectory:
            run = made(joined([*parts, recorder.arrays()]), status, self.stats)
            if growing is not None and not unwritten:
                run.save(growing.path)
            return run

        try:
            if said := self._core.record_run(float(t_end), every, recorder, write if growing else None, _PAUSE,
                                                    contact_forces):
                warnings.warn(in_python(said), RunWarning, stacklevel=stacklevel + 1)  # that of the decorator
        except Error as error:
            self._complete(error)
            if error.record is not None:
                error.trajectory = whole("failed")
            if unwritten:
                raise unwritten[0] from None
            raise
        finally:
            if growing is not None:
                growing.close()
        return whole("complete")

    def show(self, *, title: str | None = None, shapes: list[Shape] | None = None, port: int = 8080,
             block: bool = True) -> LiveViewer:
        """Shows the simulation in a browser, which starts, pauses and steps it. It needs viser: ``pip install 'nsdae[viewer]'``.

        Parameters
        ----------
        title : str, optional
            Title, by default the method.
        shapes : list of Shape, optional
            Bodies; default: those of the `Bodies`.
        port : int
            Port of the page, 1 to 65535; the next one that is free is taken.
        block : bool
            True: open a browser and take steps until Ctrl-C. False: return at once; the program takes the steps, and calls
            ``update`` after each.

        Returns
        -------
        LiveViewer

        Raises
        ------
        ImportError
            viser is not installed.
        ValueError
            There are no bodies, or no port is free.

        Examples
        --------
        >>> viewer = sim.show(block=False)
        >>> while viewer.update() and sim.time < 3:
        ...     sim.step()
        """
        from ._viewer import opened, shown
        start = self.state

        def now() -> tuple[float, np.ndarray]:
            return self.time, self.q

        def restart() -> None:
            self.state = start

        with self.record_run(self.time, shapes=shapes)._opened() as file:
            viewer: LiveViewer = opened("live", file, "the simulation", now, self.contact_forces if self._bodies else None,
                                        restart, title=title, port=port, playing=not block)
        if block:
            try:
                shown(viewer)
                while viewer.update():
                    self.step()
            except KeyboardInterrupt:
                pass
            finally:
                viewer.close()
        return viewer

    def __repr__(self) -> str:
        return f"nsdae.Sim({self.system!r}, method={self.options['method']!r}, dt={self.options['dt']!r})"


def _copy(model: System | Bodies, options: dict[str, Any], coefficients: dict[tuple[str, int], tuple[float, ...]],
          initial: tuple[float, np.ndarray, np.ndarray] | None, state: bytes | None) -> Sim:
    sim = Sim(model, **options)
    for (name, i), values in coefficients.items():
        sim._set(name, i, *values)
    if initial is not None:
        t0, q0, v0 = initial
        sim.init(q0, v0, t0)
    if state is not None:
        sim.state = state
    return sim


@named
def solve(system: System | Bodies, t_end: float, q0: Any = None, v0: Any = None, *, t0: float = 0, every: int = 1,
          project: bool = False, model: str = "", parameters: dict[str, Any] | None = None,
          shapes: list[Shape] | None = None, output: str | os.PathLike[str] | None = None, contact_forces: bool = False,
          **options: Unpack[Options]) -> Trajectory:
    """Integrates a system and returns its trajectory.

    Parameters
    ----------
    system : System or Bodies
        The model. `Bodies` have an initial state.
    t_end : float
        End time [s].
    q0 : array_like, shape (nq,), optional
        Coordinates at the start.
    v0 : array_like, shape (nv,), optional
        Velocities at the start, default zero.
    t0 : float
        Start time [s].
    every : int
        Keep the start, every N-th step and the last. All impacts are kept.
    project : bool
        True: project the initial state onto the constraints first.
    model : str
        Name of the model, for pictures and files.
    parameters : dict, optional
        Parameters of the model, for pictures and files.
    shapes : list of Shape, optional
        Bodies for animations.
    output : path-like, optional
        An HDF5 file, as of `Trajectory.save`. It is written at the first record and then every second: a killed run
        leaves the records up to its last second, and the work file ``output.part``.
    contact_forces : bool
        Keep points [m] and forces [N] of the contacts, fields ``point`` and ``force`` of `Trajectory.contacts`, for arrows in
        the viewer; only of `Bodies`.
    **options
        Options of the library: method ("implicit", "moreau", "event", "penalty"), dt, rtol, ...

    Returns
    -------
    Trajectory

    Raises
    ------
    ArgumentError
        An argument or option is wrong.
    CallbackError
        A callback raised the exception in ``__cause__``.
    ProblemError
        A contact problem was not solved; ``problem`` has it.
    Error
        Any other failure. All have ``record``, the state before the failed step, and ``trajectory``, the result up to it.
    KeyboardInterrupt
        Ctrl-C ends the run.

    Warns
    -----
    RunWarning
        Energy, penetration or drift exceed the bound of the method.
    """
    if np.size(t_end) == 2:
        first, last = t_end
        raise ArgumentError(f"t_end is {t_end}; it must be a number: give t_end={last}, t0={first}", Status.E_ARGUMENT, argument="t_end")
    sim = Sim(system, **options)
    if project:
        q0, v0 = sim.project(q0, v0, t0)
    sim.init(q0, v0, t0)
    return sim.record_run(t_end, every, model=model, parameters=parameters, shapes=shapes, output=output,
                          contact_forces=contact_forces, stacklevel=4)
