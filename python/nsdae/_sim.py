"""Simulations: step by step, or a whole run at once."""

from __future__ import annotations

import warnings
from typing import Any, Iterator

import numpy as np

from . import _core
from ._bodies import Bodies
from ._errors import Error, RunWarning, Status, in_python
from ._records import LcpProblem, Record, certificates
from ._system import System, vector
from ._trajectory import Shape, Trajectory, names_of

METHODS = dict(_core.METHODS)


# options that are a yes or a no
_SWITCHES = {key for key, _, _, values in _core.OPTIONS if values == "no or yes"}


def _texts(options: dict[str, Any]) -> dict[str, Any]:
    """As the library reads them: every digit of a number; True and False of a switch are yes and no."""
    def text(key: str, value: Any) -> Any:
        if isinstance(value, (bool, np.bool_)):
            return ("yes" if value else "no") if key in _SWITCHES else int(value)
        if isinstance(value, (float, np.floating)):
            return repr(float(value))
        return value

    return {key: text(key, value) for key, value in options.items()}


class Sim:
    """A simulation of a System or of Bodies; options are the library's, by name: method, dt, rtol, ... (help(nsdae) lists
    them). One call at a time uses it: another one, from a callback or another thread, raises Error (Status.E_STATE).

    >>> sim = nsdae.Sim(system, method="moreau", dt=1e-3)
    >>> sim.init([1.0])
    >>> for record in sim.steps(3):
    ...     print(record.time, record.q)
    """

    def __init__(self, system: System | Bodies, **options: Any):
        self._bodies = system if isinstance(system, Bodies) else None
        self.system = system.system() if isinstance(system, Bodies) else system
        self._core = _core.Sim(self.system._core, _texts(options))

    def init(self, q0: Any = None, v0: Any = None, t0: float = 0) -> Status:
        """Starts at t0 with q0 [nq] and v0 [nv], which must satisfy the constraints. Default: the start of the Bodies; of
        a System v0 at rest."""
        return Status(self._core.init(float(t0), *self._start(q0, v0)))

    def _start(self, q0: Any, v0: Any) -> tuple[np.ndarray, np.ndarray]:
        d = self.system.dims
        own = (None, np.zeros(d.nv)) if self._bodies is None else self._bodies.start()
        q0, v0 = own[0] if q0 is None else q0, own[1] if v0 is None else v0
        if q0 is None:
            raise ValueError("q0 is missing: coordinates at the start")
        return vector("q0", q0, d.nq), vector("v0", v0, d.nv)

    def project(self, q0: Any = None, v0: Any = None, t0: float = 0) -> tuple[np.ndarray, np.ndarray]:
        """q0 and v0 (default: as of init) moved as little as can be so that they satisfy constraints and contacts."""
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
            problem = self._core.failed_lcp()
            error.problem = LcpProblem(*problem) if problem else None
        except Error:  # it was never started, or is in another call
            pass

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
        """What it did since init(): steps, LCPs, impacts, the worst residual, the energy balance, ...; certificate has the
        largest figures of all records and the energies of the last."""
        stats = self._core.stats()
        stats["certificate"] = certificates(stats)[0]
        return stats

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

    def set_frictional_joint(self, j: int, mu: float) -> None:
        """Friction of frictional joint j in this simulation."""
        self._told(self._core.set_frictional_joint, j, float(mu))

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
        if shapes is None and self._bodies is not None:
            shapes = self._bodies.shapes()
        recorder = _core.Recorder()
        try:
            if said := self._core.record_run(float(t_end), every, recorder):
                warnings.warn(in_python(said), RunWarning, stacklevel=stacklevel)
        except Error as error:
            self._complete(error)
            if error.record is not None:
                error.trajectory = self._trajectory(recorder, "failed", model, parameters, shapes)
            raise
        return self._trajectory(recorder, "complete", model, parameters, shapes)

    def _trajectory(self, recorder: Any, status: str, model: str, parameters: Any, shapes: Any) -> Trajectory:
        return Trajectory._of_run(recorder.arrays(), names_of(self.system), has_potential=self._core.has_potential(),
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
    sim = Sim(system, **options)
    if project:
        q0, v0 = sim.project(q0, v0, t0)
    sim.init(q0, v0, t0)
    return sim.record_run(t_end, every, model=model, parameters=parameters, shapes=shapes, stacklevel=3)
