"""What the programs in Python share: opening a trajectory, and one-line errors."""

import argparse
import os
import re

import h5py


class Problem(Exception):
    """What is wrong with a file, in one line."""


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def reason(error):
    """The system's reason where HDF5 says it, else what HDF5 says last in its parentheses."""
    number = getattr(error, "errno", None) or next(iter(re.findall(r"errno = (\d+)", str(error))), None)
    return os.strerror(int(number)) if number else str(error).split(" (")[-1].rstrip(")")


def open_trajectory(path):
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise Problem(f"cannot read '{path}': {reason(error)}") from error
    if text(file.attrs.get("format", "")) != "nsdae-trajectory":
        raise Problem(f"'{path}' is not an nsdae trajectory")
    if file["time"].shape[0] == 0:
        raise Problem(f"'{path}' holds no records")
    return file


class Parser(argparse.ArgumentParser):
    """Wrong usage is one line too."""

    def error(self, message):
        self.exit(2, f"{self.prog}: error: {message}; --help lists the options\n")
