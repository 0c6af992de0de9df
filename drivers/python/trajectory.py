"""Common functions of the Python programs: opening a trajectory, writing a file completely, errors of one line."""

import argparse
import contextlib
import errno
import os
import re
import sys

import numpy as np

VERSION = 3  # of the format, the newest that is read here
# ranks of the datasets of numbers that are read by rows and columns
RANKS = {
    "time": 1, "q": 2, "v": 2, "multiplier": 2, "frictional_joint/impulse": 2, "frictional_joint/mode": 2,
    "contacts/first": 1, "contacts/count": 1, "contacts/block": 2, "impact/time": 1, "change/time": 1, "blocks/q": 1,
    "blocks/v": 1, "bodies/size": 2, "bodies/points": 1, "bodies/point": 2, "shapes/size": 2, "shapes/points": 1,
    "shapes/point": 2,
}
LIST_RANKS = {"gap": 1, "mode": 1, "normal_impulse": 1, "tangential_impulse": 2, "point": 2, "force": 2}  # fixed contacts: one more


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


def has_list(file):
    """Whether the contacts are of a contact list, not fixed."""
    return "contacts/first" in file


def has_forces(file):
    """Whether contacts have points and forces."""
    return "contacts/point" in file and "contacts/force" in file


class Older:
    """A file of version 1 (fixed contacts) or 2 (contact list) by the names of version 3. Version 1 has no ids: they are
    the numbers of the contacts."""

    JOINTS = {"frictional_joint/impulse": "slide/impulse", "frictional_joint/mode": "slide/mode",
              "frictional_joint/frictional_joint": "slide/slide", "change/frictional_joint": "change/slide",
              "change/id": "change/contact"}
    FIXED = {"impact/id": "impact/contact", **{f"contacts/{name}": f"contact/{name}" for name in (
        "contact", "gap", "normal_impulse", "tangential_impulse", "mode")}}

    def __init__(self, file):
        self.file, self.filename, self.attrs = file, file.filename, file.attrs
        self.names = self.JOINTS if has_list(file) else {**self.JOINTS, **self.FIXED}

    def has_numbers(self, name):
        return name == "contacts/id" and "contact/gap" in self.file

    def __contains__(self, name):
        return self.names.get(name, name) in self.file or self.has_numbers(name)

    def __getitem__(self, name):
        return np.arange(self.file["contact/gap"].shape[1]) if self.has_numbers(name) else self.file[self.names.get(name, name)]

    def get(self, name, default=None):
        return self[name] if name in self else default


def as_version_3(file, path):
    """The trajectory by the names of version 3, whatever version wrote it."""
    if text(file.attrs.get("format", "")) != "nsdae-trajectory":
        raise Problem(f"'{path}' is not an nsdae trajectory")
    version = np.asarray(file.attrs.get("format_version", VERSION))
    if version.dtype.kind not in "iu":
        raise Problem(f"'{path}' is damaged: its attribute format_version must be a whole number")
    if version > VERSION:
        raise Problem(f"'{path}' is of format version {version}; this program reads up to {VERSION}")
    return file if version == VERSION else Older(file)


def check(file, path, needed):
    for name in ("time", "q") + needed:
        if name not in file:
            raise Problem(f"'{path}' is damaged or was never complete: it has no /{name}")
    more = 0 if has_list(file) else 1
    contacts = {f"contacts/{name}": rank + more for name, rank in LIST_RANKS.items()}
    for name, rank in {**RANKS, **contacts, "contacts/id": 1}.items():
        if name in file:
            check_rank(file[name], path, name, rank)
    if file["time"].shape[0] == 0:
        raise Problem(f"'{path}' holds no records")
    if not np.all(np.isfinite(file["time"])) or np.any(np.diff(file["time"]) < 0):
        raise Problem(f"'{path}' is damaged: /time must rise and be finite")


def check_rank(dataset, path, name, rank):
    if not hasattr(dataset, "ndim") or dataset.dtype.kind not in "iuf" or dataset.ndim != rank:
        raise Problem(f"'{path}' is damaged: /{name} must be a dataset of numbers of rank {rank}")


def open_file(path):
    """Also one that a run with --live writes, or that such a run left when it was killed."""
    from guard import open_guarded  # with h5py, which pictures of what is in memory do not need
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
    from guard import Unsafe
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
    with reading(path) as any_version:
        file = as_version_3(any_version, path)
        check(file, path, needed)
        yield file


NAMES = {"coordinate": "coordinate", "velocity": "velocity", "constraint": "constraint", "contact": "contacts/contact",
         "frictional_joint": "frictional_joint/frictional_joint"}


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
