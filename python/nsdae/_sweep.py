"""Parameter sweeps, in the file format of nsdae-sweep."""

from __future__ import annotations

import contextlib
import fcntl
import io
import itertools
import os
import sys
import tempfile
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from typing import TYPE_CHECKING, Any, Callable, Iterator, Mapping, Sequence

import numpy as np

from . import _core, _frames
from ._errors import Error, needed

if TYPE_CHECKING:
    import pandas
    import xarray

NOT_DONE = 1
REASON_SIZE = 160


class Sweep:
    """Results of a sweep, from memory or a file.

    ``sweep["final/q"]`` and ``sweep["result/height"]`` are results by path, shape (runs..., ...).

    Attributes
    ----------
    dimensions : list of dict
        Parameters of each dimension of the runs: ``[{"r": values}, {"mu": values}]``.
    status : ndarray of int, shape (runs...)
        0 completed, < 0 failed, 1 pending.
    failures : dict
        Reasons of the failed runs, by the number of the run (last dimension fastest).
    results : dict
        Results by path.
    path : str or None
        The file.
    """

    def __init__(self, dimensions: list[dict[str, np.ndarray]], status: np.ndarray, results: dict[str, np.ndarray],
                 failures: dict[int, str], path: str | None, content: bytes = b""):
        self.dimensions, self.status, self.results, self.failures, self.path = dimensions, status, results, failures, path
        self._content = content  # bytes of the file, if there is no path

    def __getitem__(self, name: str) -> np.ndarray:
        for known in (name, f"result/{name}"):
            if known in self.results:
                return self.results[known]
        for dimension in self.dimensions:
            if name in dimension:
                return dimension[name]
        raise KeyError(f"the sweep has no '{name}': it has {', '.join([*self.results, *itertools.chain(*self.dimensions)])}")

    def plot(self, only: Sequence[str] | None = None, title: str | None = None, at: Mapping[str, float] | None = None) -> Any:
        """Draws curves over one parameter, bifurcation diagrams, or maps over two parameters.

        Parameters
        ----------
        only : list of str, optional
            Quantities, such as "final/q".
        title : str, optional
            Title of the picture.
        at : dict, optional
            ``{"mu": 0.1}``: only the runs with the nearest value.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ValueError
            A quantity or parameter is unknown.
        """
        h5py, _ = needed("h5py", "hdf5"), needed("matplotlib", "plot")
        from .pictures import sweeps, trajectory
        try:
            own = not self.path  # made by this process
            with h5py.File(io.BytesIO(self._content), "r") if own else trajectory.reading(self.path) as file:
                return sweeps.draw(file, only, title, list((at or {}).items()))
        except trajectory.Problem as problem:
            raise ValueError(str(problem)) from None

    def to_pandas(self) -> pandas.DataFrame:
        """Returns a table of pandas: a row for each run, with its parameters, status and results.

        Returns
        -------
        pandas.DataFrame
        """
        return _frames.sweep_to_pandas(self)

    def to_xarray(self) -> xarray.Dataset:
        """Returns a dataset of xarray, over the parameters.

        Returns
        -------
        xarray.Dataset
        """
        return _frames.sweep_to_xarray(self)

    def _repr_html_(self) -> str:
        sizes = [(", ".join(d), f"{len(next(iter(d.values())))} values") for d in self.dimensions]
        done = f"{int(np.sum(self.status == 0))} of {self.status.size}"
        return _frames.page("nsdae.Sweep", [*sizes, ("runs done", done), ("results", ", ".join(self.results))])

    def __repr__(self) -> str:
        names = " x ".join(f"{', '.join(d)} ({len(next(iter(d.values())))})" for d in self.dimensions)
        return f"nsdae.Sweep({names}; {int(np.sum(self.status == 0))} of {self.status.size} runs done)"


@contextlib.contextmanager
def _reading(path: str | os.PathLike[str]) -> Iterator[Any]:
    """Opens a file of unknown origin; errors are an OSError or a ValueError."""
    needed("h5py", "hdf5")
    from .pictures import trajectory
    try:
        with trajectory.reading(os.fspath(path)) as file:
            yield file
    except trajectory.Problem as problem:
        cause = problem.__cause__
        raise (type(cause) if isinstance(cause, OSError) else ValueError)(str(problem)) from cause


def load_sweep(path: str | os.PathLike[str]) -> Sweep:
    """Reads the file of `sweep` or nsdae-sweep, also of an unfinished sweep.

    Parameters
    ----------
    path : path-like
        The file.

    Returns
    -------
    Sweep

    Raises
    ------
    OSError
        The file cannot be read.
    ValueError
        The file is no sweep, or is damaged.
    """
    from .pictures import sweeps
    with _reading(path) as file:
        if not sweeps.is_sweep(file):
            raise sweeps.Problem(f"'{os.fspath(path)}' is not an nsdae sweep")
        failures = {}
        if "failure" in file:
            failures = {int(run): sweeps.text(reason) for run, reason in zip(file["failure/run"], file["failure/reason"])}
        return Sweep([dict(of) for of in sweeps.dimensions(file)], file["status"][...],
                     {name: dataset[...] for name, dataset in sweeps.results(file).items()}, failures, os.fspath(path))


def _dimensions(grid: Mapping[str, Any], random: int, seed: int) -> list[dict[str, np.ndarray]]:
    """With random > 0 a pair (low, high) is drawn; other entries are values."""
    drawn = {name: of for name, of in grid.items() if random and isinstance(of, tuple) and len(of) == 2}
    found = []
    for name, values in grid.items():
        if name not in drawn:
            array = np.atleast_1d(np.asarray(values, dtype=float))
            if array.ndim != 1 or not len(array) or not np.isfinite(array).all():
                raise ValueError(f"grid: the values of {name} must be finite numbers, one at least")
            found.append({name: array})
    if drawn:
        source = np.random.default_rng(seed)
        found.append({name: source.uniform(low, high, random) for name, (low, high) in drawn.items()})
    elif random:
        raise ValueError("random: nothing to draw; a drawn parameter has a pair (low, high)")
    if not found:
        raise ValueError("grid is empty: {'name': values}")
    return found


def _values(dimensions: list[dict[str, np.ndarray]], run: int) -> dict[str, float]:
    index = np.unravel_index(run, [len(next(iter(d.values()))) for d in dimensions])
    return {name: float(values[i]) for d, i in zip(dimensions, index) for name, values in d.items()}


def _row(result: Any) -> dict[str, np.ndarray]:
    """Result of a run, as arrays by path."""
    if not isinstance(result, Mapping):
        result = {"value": result}
    return {name if "/" in name else f"result/{name}": np.asarray(value, dtype=float) for name, value in result.items()}


class _File:
    """The file of a sweep, created complete and filled in place, the status of a run last.

    It is valid at any time, and its bytes do not depend on the order of the runs.
    """

    def __init__(self, path: str, dimensions: list[dict[str, np.ndarray]], model: str, first: Mapping[str, np.ndarray]):
        self.path, self.shape = path, tuple(len(next(iter(d.values()))) for d in dimensions)
        setting = self._setting(dimensions, model, first)
        if os.path.exists(path):
            self._compare(setting)
        else:
            self._create(dimensions, model, first, setting)
        self._open(first)

    @staticmethod
    def _setting(dimensions: Any, model: str, first: Mapping[str, np.ndarray]) -> str:
        lines = [f"library={_core.VERSION}", f"model={model}", "made by=python"]
        lines += [f"grid={name},{len(v)},{v.tobytes().hex() if len(v) < 64 else hash_of(v)}" for d in dimensions
                  for name, v in d.items()]
        return "\n".join(lines + [f"{name}={of.shape}" for name, of in first.items()]) + "\n"

    def _compare(self, setting: str) -> None:
        with _reading(self.path) as file:
            is_sweep = "setting" in file and file.attrs.get("format") in ("nsdae-sweep", b"nsdae-sweep")
            has = not is_sweep or file["setting"][...].tobytes().decode().splitlines()
        if not is_sweep:
            raise ValueError(f"'{self.path}' exists and is not a sweep: give another output, or remove it")
        differ = next((f"'{a}', this one '{b}'" for a, b in itertools.zip_longest(has, setting.splitlines())
                       if a != b), None)
        if differ:
            raise ValueError(f"'{self.path}' is the file of another sweep: it has {differ}; give another output, or remove it")

    def _create(self, dimensions: Any, model: str, first: Mapping[str, np.ndarray], setting: str) -> None:
        h5py = needed("h5py", "hdf5")
        from .pictures import trajectory
        whole = io.BytesIO()  # HDF5 itself crashes after a write that found the disk full
        with h5py.File(whole, "w") as file:
            for name, word in (("format", "nsdae-sweep"), ("status", "running"), ("library_version", _core.VERSION),
                               ("model", model), ("method", "")):
                file.attrs.create(name, np.bytes_(word.ljust(9, "\0") if name == "status" else word or "\0"),
                                  dtype="S9" if name == "status" else None)
            file.attrs["format_version"] = np.int32(1)
            self._put(file, "setting", np.frombuffer(setting.encode(), dtype="u1"), "1", "settings of the runs, as text")
            for d in dimensions:
                for name, values in d.items():
                    self._put(file, f"grid/{name}", values, "", "values").make_scale(name)
            for name, of in first.items():
                self._axes(file, self._put(file, name, None, "", "result of each run", self.shape + of.shape), dimensions)
            self._axes(file, self._put(file, "status", None, "1", "0 completed, < 0 failed (status of the library), 1 pending",
                                       self.shape), dimensions)
        trajectory.put(self.path, whole.getbuffer())

    @staticmethod
    def _put(file: Any, path: str, values: Any, unit: str, said: str, shape: Any = None) -> Any:
        h5py = needed("h5py", "hdf5")
        kind = {"data": values} if values is not None else \
            {"shape": shape, "dtype": "i4" if path == "status" else "f8",
             "fillvalue": np.int32(NOT_DONE) if path == "status" else np.nan}
        how = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        how.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        made = file.create_dataset(path, track_times=False, dcpl=how, **kind)
        made.attrs["units"], made.attrs["description"] = unit, said
        return made

    @staticmethod
    def _axes(file: Any, dataset: Any, dimensions: Any) -> None:
        for i, d in enumerate(dimensions):
            for name in d:
                dataset.dims[i].attach_scale(file[f"grid/{name}"])

    def _open(self, first: Mapping[str, np.ndarray]) -> None:
        with _reading(self.path) as file:
            self.status = file["status"][...].reshape(-1)
            word = file.attrs["status"]
            self.complete = (word if isinstance(word, bytes) else word.encode()).rstrip(b"\0") == b"complete"
            self.at = {name: file[name].id.get_offset() for name in [*first, "status"]}
        self.raw = os.open(self.path, os.O_RDWR)
        try:
            fcntl.lockf(self.raw, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(self.raw)
            raise BlockingIOError(f"another sweep is writing '{self.path}'") from None

    def put(self, run: int, status: int, row: Mapping[str, np.ndarray]) -> None:
        for name, values in row.items():
            content = np.ascontiguousarray(values).tobytes()
            os.pwrite(self.raw, content, self.at[name] + run * len(content))
        os.pwrite(self.raw, np.int32(status).tobytes(), self.at["status"] + 4 * run)

    def finish(self, failures: Mapping[int, str]) -> None:
        h5py = needed("h5py", "hdf5")
        from .pictures import trajectory
        with open(self.path, "rb") as old:
            whole = io.BytesIO(old.read())
        with h5py.File(whole, "r+") as file:
            if "failure" in file:
                del file["failure"]
            if failures:
                runs = sorted(failures)
                file.create_dataset("failure/run", data=np.array(runs, dtype="i8"), track_times=False)
                file.create_dataset("failure/reason", track_times=False, data=np.array(
                    [failures[run].encode()[: REASON_SIZE - 1] for run in runs], dtype=f"S{REASON_SIZE}"))
            file.attrs.modify("status", np.bytes_(b"complete"))
        trajectory.put(self.path, whole.getbuffer())

    def close(self) -> None:
        os.close(self.raw)


def hash_of(values: np.ndarray) -> str:
    """Checksum of the bytes."""
    import hashlib
    return hashlib.sha256(values.tobytes()).hexdigest()


@contextlib.contextmanager
def _workers(workers: int, mpi: bool) -> Iterator[Executor | None]:
    """Threads, or the ranks of MPI. All ranks except the first work here and return None."""
    if not mpi:
        with ThreadPoolExecutor(workers) as pool:
            yield pool
        return
    from mpi4py import MPI
    from mpi4py.futures import MPICommExecutor
    with MPICommExecutor(MPI.COMM_WORLD, root=0) as pool:
        yield pool


def _attempt(run: Callable[..., Any], values: dict[str, float]) -> tuple[int, Any]:
    """Returns (0, row) or (status, reason)."""
    try:
        return 0, _row(run(**values))
    except Error as error:
        return int(error.status), str(error)


def sweep(run: Callable[..., Any], grid: Mapping[str, Any], *, output: str | os.PathLike[str] | None = None, random: int = 0, seed: int = 0,
          workers: int = 1, mpi: bool = False, model: str = "", progress: bool | None = None) -> Sweep | None:
    """Runs a function for every combination of parameters.

    Parameters
    ----------
    run : callable
        ``run(**parameters)`` returns a number, an array, or a dict of them, of the same shapes for all runs. An `Error` is a
        failed run, whose reason is kept. Other exceptions end the sweep.
    grid : dict
        ``{"r": values, "mu": values}``. With ``random > 0`` a pair (low, high) is drawn uniformly.
    output : path-like, optional
        File; by default the results are in memory only. An unfinished sweep in an existing file is continued, to the bytes of
        an uninterrupted sweep.
    random : int
        Number of draws.
    seed : int
        Seed of the draws.
    workers : int
        Threads; useful if the runs use compiled callbacks.
    mpi : bool
        True: use the ranks of mpi4py, under mpirun. ``run`` must be picklable.
    model : str
        Name of the model.
    progress : bool, optional
        Show a progress bar; by default if stderr is a terminal.

    Returns
    -------
    Sweep or None
        None on all ranks except the first.

    Raises
    ------
    ValueError
        The grid is empty or wrong, all runs failed, or the file belongs to another sweep.
    """
    if output is None:
        with tempfile.TemporaryDirectory(prefix="nsdae-") as folder:
            return _in_memory(sweep(run, grid, output=os.path.join(folder, "sweep.h5"), random=random, seed=seed,
                                    workers=workers, mpi=mpi, model=model, progress=progress))
    dimensions = _dimensions(grid, random, seed)
    total = int(np.prod([len(next(iter(d.values()))) for d in dimensions]))
    with _workers(workers, mpi) as pool:
        if pool is None:
            return None
        outcome = next((o for o in (_attempt(run, _values(dimensions, i)) for i in range(total)) if o[0] == 0), None)
        if outcome is None:
            raise ValueError("every run of the sweep failed; the first: " + _attempt(run, _values(dimensions, 0))[1])
        file = _File(os.fspath(output), dimensions, model, outcome[1])
        try:
            if not file.complete:
                _go(pool, run, dimensions, file, outcome[1], progress)
        finally:
            file.close()
    return load_sweep(output)


def _in_memory(made: Sweep | None) -> Sweep | None:
    """Keeps the bytes of the file, for plot()."""
    if made is not None:
        with open(made.path or "", "rb") as file:
            made._content = file.read()
        made.path = None
    return made


def _go(pool: Executor, run: Callable[..., Any], dimensions: Any, file: _File, like: Mapping[str, np.ndarray],
        progress: bool | None) -> None:
    todo = [i for i in range(file.status.size) if file.status[i] != 0]
    failures: dict[int, str] = {}
    waiting: dict[Future[Any], int] = {}
    bar = _Bar(len(todo), sys.stderr.isatty() if progress is None else progress)
    nothing = {name: np.full(of.shape, np.nan) for name, of in like.items()}
    ahead = iter(todo)

    def hand_out(count: int) -> None:
        for i in itertools.islice(ahead, count):
            waiting[pool.submit(_attempt, run, _values(dimensions, i))] = i

    hand_out(64)
    try:
        while waiting:
            done, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                i = waiting.pop(future)
                status, result = future.result()
                if status == 0 and {n: v.shape for n, v in result.items()} != {n: v.shape for n, v in like.items()}:
                    raise ValueError(f"run {i} ({_values(dimensions, i)}) returned other names or shapes than the first")
                if status != 0:
                    failures[i] = result
                file.put(i, status, result if status == 0 else nothing)
                bar.step()
            hand_out(len(done))
    finally:
        for future in waiting:
            future.cancel()
        bar.clear()
    file.finish(failures)


class _Bar:
    """Progress bar: completed runs and remaining time."""

    def __init__(self, total: int, shown: bool):
        import time
        self.total, self.shown, self.done, self.clock = total, shown, 0, time.monotonic
        self.begin = self.last = self.clock()

    def step(self) -> None:
        self.done += 1
        now = self.clock()
        if not self.shown or now - self.last < 0.1 or now - self.begin < 1:
            return
        self.last = now
        left = round((now - self.begin) * (self.total - self.done) / self.done)
        print(f"\r{self.done} of {self.total} runs, {left // 60}:{left % 60:02d} left\033[K", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        if self.shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
