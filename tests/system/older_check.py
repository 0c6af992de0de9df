"""Files of format versions 1 and 2. The programs give the same output for a file and for its copy that has the names of
version 3; no run is resumed in it. usage: older_check.py BIN_DIR DATA_DIR"""

import lzma
import os
import subprocess
import sys

import h5py
import numpy as np
from tools import QUICK

BIN, DATA = sys.argv[1:3]
sys.path.insert(0, os.path.join(BIN, "..", "share", "nsdae"))

import animate  # noqa: E402
import plot  # noqa: E402
import vtkhdf  # noqa: E402
from trajectory import open_trajectory  # noqa: E402

FILES = {"version_1_contacts": "woodpecker", "version_1_frictional_joint": "crank-slider", "version_2_list": "heap"}
# Names of version 3 of what the versions 1 and 2 have, from docs/trajectory.md.
RENAMED = {"slide/impulse": "frictional_joint/impulse", "slide/mode": "frictional_joint/mode",
           "slide/slide": "frictional_joint/frictional_joint", "change/slide": "change/frictional_joint",
           "change/contact": "change/id", "impact/contact": "impact/id", "contact/contact": "contacts/contact",
           "contact/gap": "contacts/gap", "contact/mode": "contacts/mode", "contact/normal_impulse": "contacts/normal_impulse",
           "contact/tangential_impulse": "contacts/tangential_impulse"}


def expect(name, holds, what=""):
    if not holds:
        sys.exit(f"older: {name} {what}")


def unpack(name):
    path = f"{name}.h5"
    with lzma.open(os.path.join(DATA, f"{path}.xz")) as packed, open(path, "wb") as file:
        file.write(packed.read())
    return path


def renamed(old, new):
    """A copy with the names of version 3."""
    with h5py.File(old) as source, h5py.File(new, "w") as copy:
        for name in source:
            source.copy(name, copy)
        copy.attrs.update(source.attrs)
        copy.attrs["format_version"] = 3
        for before, after in RENAMED.items():
            if before in copy:
                copy.move(before, after)
        for group in ("contact", "slide"):
            if group in copy:
                expect("all is moved", len(copy[group]) == 0, group)
                del copy[group]
        if "contacts/contact" in copy:
            copy["contacts/id"] = np.arange(len(copy["contacts/contact"]))


def output(program, path, end, *arguments):
    """The bytes of a picture or file."""
    made = f"output.{end}"
    expect(f"{program.__name__} {path}", not program.main([path, "--output", made, *arguments]))
    with open(made, "rb") as file:
        content = file.read()
    os.remove(made)
    return content


def check_reading(old, new):
    """Every dataset of the copy, by its name."""
    names = []
    with h5py.File(new) as copy, open_trajectory(old) as file:
        copy.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        for name in names:
            expect(f"{old} has", name in file, name)
            expect(f"{old} gives", np.array_equal(file[name][()], copy[name][()]), name)
        expect("number of datasets", len(names) > 50)
        expect("and no others", "contacts/nothing" not in file and file.get("contact/nothing") is None)


def check_programs(old, new):
    outputs = [(vtkhdf, "vtkhdf"), (animate, "html"), (plot, "png", "--dpi", "50"), (plot, "png", "--dpi", "50", "--certificate")]
    if QUICK:  # the groups that have other names since
        outputs = [*outputs[:2], (plot, "png", "--only", "modes", "--only", "forces")][: 3 if old == "version_1_contacts.h5" else 2]
    for program, end, *arguments in outputs:
        expect(f"{program.__name__} {end}", output(program, old, end, *arguments) == output(program, new, end, *arguments), old)


def check_resume(old, model):
    with open(old, "rb") as file:
        before = file.read()
    told = subprocess.run([os.path.join(BIN, f"nsdae-{model}"), "--restart", old], capture_output=True, text=True)
    expect("not resumed", told.returncode != 0 and f"cannot resume '{old}': it was made by version 0.2" in told.stderr,
           told.stderr)
    with h5py.File(old) as file:
        expect("still there", file.attrs["status"] == "complete" and len(before) == os.path.getsize(old))


for name, model in FILES.items():
    old, new = unpack(name), f"{name}_3.h5"
    renamed(old, new)
    check_reading(old, new)
    check_programs(old, new)
    check_resume(old, model)
print(f"{len(FILES)} files of versions 1 and 2 are read and not resumed")
