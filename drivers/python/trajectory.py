"""What the programs in Python share: opening a trajectory, writing a file whole, one-line errors."""

import argparse
import contextlib
import errno
import os
import re
import sys

import h5py

VERSION = 2  # of the format, the newest that is read here


class Problem(Exception):
    """What is wrong with a file, in one line."""


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def reason(error):
    """The system's reason where HDF5 says it, else what HDF5 says last in its parentheses."""
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
    if file["time"].shape[0] == 0:
        raise Problem(f"'{path}' holds no records")


def open_file(path):
    """Also one that a run with --live writes, or that such a run left when it was killed."""
    try:
        return h5py.File(path, "r")
    except OSError as error:
        with contextlib.suppress(OSError, ValueError):
            return h5py.File(path, "r", swmr=True)
        raise Problem(f"cannot read '{path}': {reason(error)}") from error


@contextlib.contextmanager
def open_trajectory(path, *needed):
    """The file, with /time, /q and what else is needed; what cannot be read in it is a Problem too."""
    with open_file(path) as file:
        try:
            check(file, path, needed)
            yield file
        except (OSError, KeyError, RuntimeError) as error:
            raise Problem(f"'{path}' is damaged: {reason(error)}") from error


NAMES = {"coordinate": "coordinate", "velocity": "velocity", "constraint": "constraint", "contact": "contact/contact",
         "slide": "slide/slide"}


def names_of_rows(file, kind, count):
    """Names of coordinates, velocities, ...: the file's, else numbers."""
    path = NAMES[kind]
    named = [text(name) for name in file[path][:count]] if path in file else []
    return named + [f"{kind} {i}" for i in range(len(named), count)]


def replace(path, content):
    """Writes beside the file and moves it there when it is whole: what was there is not lost."""
    part = f"{path}.part"
    try:
        if os.path.isdir(path):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        with open(part, "wb") as file:
            file.write(content)
        os.replace(part, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            os.remove(part)
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
