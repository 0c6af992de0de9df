"""What the programs in Python share: opening a trajectory, and one-line errors."""

import argparse
import os

import h5py


class Problem(Exception):
    """What is wrong with a file, in one line."""


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def reason(error):
    """HDF5's reason is the last thing in its parentheses."""
    return os.strerror(error.errno) if error.errno else str(error).split(" (")[-1].rstrip(")")


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
