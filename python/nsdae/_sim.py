"""Simulations: step by step, or a whole run at once."""

from __future__ import annotations

import warnings
from typing import Any, Iterator

import numpy as np

from . import _core
from ._bodies import Bodies
from ._errors import Error, RunWarning, Status
from ._records import LcpProblem, Record
from ._system import System, vector
from ._trajectory import Shape, Trajectory, names_of

METHODS = dict(_core.METHODS)


def _texts(options: dict[str, Any]) -> dict[str, Any]:
    """As the library reads them: every digit of a number, 0 and 1."""
    def text(value: Any) -> Any:
        if isinstance(value, (bool, np.bool_)):
            return int(value)
        if isinstance(value, (float, np.floating)):
            return repr(float(value))
        return value

    return {key: text(value) for key, value in options.items()}


class Sim:
    """A simulation of a system; options are the library's, by name: method, dt, rtol, ... (help(nsdae) lists them).

    >>> sim = nsdae.Sim(system, method="moreau", dt=1e-3)
    >>> sim.init([1.0])
    >>> for record in sim.steps(3):
    ...     print(record.time, record.q)
    """

    def __init__(self, system: System, **options: Any):
        self.system = system
        self._core = _core.Sim(system._core, _texts(options))

    def init(self, q0: Any, v0: Any = None, t0: float = 0) -> Status:
        """Starts at t0 with q0 [nq] and v0 [nv] (default: at rest), which must satisfy the constraints."""
        return Status(self._core.init(float(t0), *self._start(q0, v0)))

    def _start(self, q0: Any, v0: Any) -> tuple[np.ndarray, np.ndarray]:
        d = self.system.dims
        return vector("q0", q0, d.nq), vector("v0", np.zeros(d.nv) if v0 is None else v0, d.nv)

    def project(self, q0: Any, v0: Any = None, t0: float = 0) -> tuple[np.ndarray, np.ndarray]:
        """q0 and v0 moved as little as can be so that they satisfy constraints and contacts."""
        return self._core.project(float(t0), *self._start(q0, v0))

    def _told(self, call: Any, *arguments: Any) -> Any:
        try:
            return call(*arguments)
        except Error as error:
            self._complete(error)
            raise

    def _complete(self, error: Error) -> None:
        """The state that is left, and the problem that was not solved."""
        try:
            error.record = self.record
        except Error:  # it was never started
            pass
        problem = self._core.failed_lcp()
        error.problem = LcpProblem(*problem) if problem else None

    def step(self) -> Status:
        """One step of dt: OK, EVENT (an impact or a change of mode), ZENO, or a warning."""
        return Status(self._told(self._core.step))

    def run(self, t_end: float) -> Status:
        """Steps to t_end."""
        return Status(self._told(self._core.run, float(t_end), False))

    def run_to_event(self, t_end: float) -> Status:
        """Steps to t_end, or to the end of the first step with an impact or a change of mode."""
        return Status(self._told(self._core.run, float(t_end), True))

    def steps(self, t_end: float) -> Iterator[Record]:
        """Yields the record after each step up to t_end; the last step is shortened to end there."""
        now = self.record.time
        while now < t_end:
            if now + 1.5 * self.options["dt"] < t_end:
                self.step()
            else:  # the run knows where the grid of steps ends
                self.run(min(now + self.options["dt"], t_end))
            record = self.record
            if record.time <= now:
                return
            now = record.time
            yield record

    @property
    def record(self) -> Record:
        """The state now."""
        return Record(self._core.record())

    @property
    def time(self) -> float:
        """Now [s]."""
        return self.record.time

    @property
    def stats(self) -> dict[str, Any]:
        """What it did since init(): steps, LCPs, impacts, the worst residual, the energy balance, ..."""
        return self._core.stats()

    @property
    def options(self) -> dict[str, Any]:
        """Every option."""
        return self._core.options()

    def set_options(self, **options: Any) -> None:
        """Other options from here on; method, polygon, linear_solver and projection are fixed."""
        self._told(self._core.set_options, _texts(options))

    def set_contact(self, i: int, mu: float = 0, e_n: float = 0, e_t: float = 0) -> None:
        """Coefficients of contact i in this simulation, in place of the system's."""
        self._told(self._core.set_contact, i, float(mu), float(e_n), float(e_t))

    def set_slide(self, j: int, mu: float) -> None:
        """Friction of slide j in this simulation."""
        self._told(self._core.set_slide, j, float(mu))

    def interpolate(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """q and v at a time within the last step."""
        return self._told(self._core.interpolate, float(t))

    @property
    def state(self) -> bytes:
        """All that the next step depends on; set into a simulation of the same system and options the run goes on
        with the same bytes."""
        return self._told(self._core.state)

    @state.setter
    def state(self, block: bytes) -> None:
        self._told(self._core.set_state, block)

    def record_run(self, t_end: float, every: int = 1, *, model: str = "", parameters: dict[str, Any] | None = None,
                   shapes: list[Shape] | None = None, stacklevel: int = 2) -> Trajectory:
        """Steps to t_end and returns the records: the first one now, each every-th step, and the last.
        Warns (RunWarning) of what the method does not explain, as said where this was called (stacklevel as that of
        warnings.warn)."""
        status = "complete"
        try:
            self._core.record_run(float(t_end), every)
            if said := self._core.said():
                warnings.warn(said, RunWarning, stacklevel=stacklevel)
        except Error as error:
            self._complete(error)
            error.trajectory = self._trajectory("failed", model, parameters, shapes)
            raise
        return self._trajectory(status, model, parameters, shapes)

    def _trajectory(self, status: str, model: str, parameters: Any, shapes: Any) -> Trajectory:
        return Trajectory._of_run(self._core.recorded(), names_of(self.system), has_potential=self._core.has_potential(),
                                  options=self.options, stats=self.stats, status=status, model=model,
                                  parameters=parameters or {}, shapes=shapes or [], blocks=self.system.blocks)

    def __repr__(self) -> str:
        return f"nsdae.Sim({self.system!r}, method={self.options['method']!r}, dt={self.options['dt']!r})"


def solve(system: System | Bodies, t_end: float, q0: Any = None, v0: Any = None, *, t0: float = 0, every: int = 1,
          project: bool = False, model: str = "", parameters: dict[str, Any] | None = None,
          shapes: list[Shape] | None = None, **options: Any) -> Trajectory:
    """Integrates a system from t0 to t_end and returns its trajectory, as arrays.

    system    a System, or Bodies, which know their start
    q0, v0    coordinates [nq] and velocities [nv] at the start; v0 at rest by default
    every     keeps the start, each every-th step and the last one; impacts are all kept
    project   True: the start is moved to the constraints first
    model, parameters, shapes   what the trajectory says of itself when it is drawn, animated or saved
    options   of the library, by name: method ("implicit", "moreau", "event", "penalty"), dt, rtol, ...

    Raises ArgumentError, CallbackError (its __cause__ is what the callback raised), ProblemError (.problem has the
    complementarity problem) and Error, each with .record, the state before the step that failed, and .trajectory, what
    there is until then. RunWarning says what the method does not explain. Ctrl-C ends the run with KeyboardInterrupt.
    """
    if isinstance(system, Bodies):
        shapes = system.shapes() if shapes is None else shapes
        start = system.start()
        q0, v0 = start[0] if q0 is None else q0, start[1] if v0 is None else v0
        system = system.system()
    if q0 is None:
        raise ValueError("q0 is missing: coordinates at the start")
    sim = Sim(system, **options)
    if project:
        q0, v0 = sim.project(q0, v0, t0)
    sim.init(q0, v0, t0)
    return sim.record_run(t_end, every, model=model, parameters=parameters, shapes=shapes, stacklevel=3)
