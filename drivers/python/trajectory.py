"""Common functions of the Python programs: opening a trajectory, writing a file completely, errors of one line."""

import argparse
import contextlib
import errno
import os
import re
import sys

import h5py
import numpy as np

from guard import Unsafe, open_guarded

VERSION = 2  # of the format, the newest that is read here
# ranks of the datasets of numbers that are read by rows and columns
RANKS = {
    "time": 1, "q": 2, "v": 2, "multiplier": 2, "contact/gap": 2, "contact/mode": 2, "contact/normal_impulse": 2,
    "contact/tangential_impulse": 3, "slide/impulse": 2, "slide/mode": 2, "contacts/first": 1, "contacts/count": 1,
    "contacts/id": 1, "contacts/block": 2, "contacts/gap": 1, "contacts/mode": 1, "contacts/normal_impulse": 1,
    "contacts/tangential_impulse": 2, "impact/time": 1, "change/time": 1, "blocks/q": 1, "blocks/v": 1, "bodies/size": 2,
    "bodies/points": 1, "bodies/point": 2, "shapes/size": 2, "shapes/points": 1, "shapes/point": 2,
}


class Problem(Exception):
    """An error of a file, in one line."""


def text(value):
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


def reason(error):
    """The system's reason where HDF5 says it, else what HDF5 says last in its parentheses."""
    if not isinstance(error, OSError):
        return f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
    number = getattr(error, "errno", None) or next(iter(re.findall(r"errno = (\d+)", str(error))), None)
    if number and int(number) == errno.EAGAIN:
        return "a program is writing it; what a run with --live writes can be read along"
    return os.strerror(int(number)) if number else str(error).split(" (")[-1].rstrip(")\"'")


def check(file, path, needed):
    if text(file.attrs.get("format", "")) != "nsdae-trajectory":
        raise Problem(f"'{path}' is not an nsdae trajectory")
    version = file.attrs.get("format_version", VERSION)
    if version > VERSION:
        raise Problem(f"'{path}' is of format version {version}; this program reads up to {VERSION}")
    for name in ("time", "q") + needed:
        if name not in file:
            raise Problem(f"'{path}' is damaged or was never complete: it has no /{name}")
    for name, rank in RANKS.items():
        if name in file:
            check_rank(file[name], path, name, rank)
    if file["time"].shape[0] == 0:
        raise Problem(f"'{path}' holds no records")
    if not np.all(np.isfinite(file["time"])) or np.any(np.diff(file["time"]) < 0):
        raise Problem(f"'{path}' is damaged: /time must rise and be finite")


def check_rank(dataset, path, name, rank):
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind not in "iuf" or dataset.ndim != rank:
        raise Problem(f"'{path}' is damaged: /{name} must be a dataset of numbers of rank {rank}")


def open_file(path):
    """Also one that a run with --live writes, or that such a run left when it was killed."""
    try:
        return open_guarded(path)
    except OSError as error:
        with contextlib.suppress(OSError, ValueError):
            return open_guarded(path, swmr=True)
        raise Problem(f"cannot read '{path}': {reason(error)}") from error


# What a file of wrong content raises: the schema's checks name the likely faults, this the others.
DAMAGE = (OSError, LookupError, RuntimeError, ValueError, TypeError, AttributeError, ArithmeticError, MemoryError)


@contextlib.contextmanager
def reading(path):
    """The file, which may be of unknown origin; whatever cannot be read in it is a Problem."""
    try:
        with open_file(path) as file:
            yield file
    except Unsafe as unsafe:
        raise Problem(f"cannot read '{path}': {unsafe}") from unsafe
    except DAMAGE as error:
        raise Problem(f"'{path}' is damaged: {reason(error)}") from error


@contextlib.contextmanager
def open_trajectory(path, *needed):
    """A trajectory, with /time, /q and the datasets needed."""
    with reading(path) as file:
        check(file, path, needed)
        yield file


NAMES = {"coordinate": "coordinate", "velocity": "velocity", "constraint": "constraint", "contact": "contact/contact",
         "slide": "slide/slide"}


def heading(file, path=""):
    """Model and method; of a file without a model its own name."""
    name = text(file.attrs.get("model", "")) or os.path.splitext(os.path.basename(path))[0]
    return ", ".join(word for word in (name, text(file.attrs.get("method", ""))) if word)


def names_of_rows(file, kind, count):
    """Names of coordinates, velocities, ...: the file's, else numbers."""
    path = NAMES[kind]
    named = [text(name) for name in file[path][:count]] if path in file else []
    return named + [f"{kind} {i}" for i in range(len(named), count)]


def put(path, content):
    """Writes beside the file and moves it there when it is whole: what was there is not lost."""
    part = f"{path}.part"
    try:
        if os.path.isdir(path):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), path)
        with open(part, "wb") as file:
            file.write(content)
        os.replace(part, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.remove(part)
        raise


def replace(path, content):
    try:
        put(path, content)
    except OSError as error:
        raise Problem(f"cannot write '{path}': {reason(error)}") from error


def tell(line):
    try:
        print(line, flush=True)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes once more at its end
        raise Problem(f"cannot write to standard output: {reason(error)}") from error


class Parser(argparse.ArgumentParser):
    """Wrong usage is one line too."""

    def error(self, message):
        self.exit(2, f"{self.prog}: error: {message}; --help lists the options\n")
