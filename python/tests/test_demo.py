"""python -m nsdae demo, with NumPy alone; what an optional part needs is named."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest

import nsdae

ALONE = """
import runpy, sys
for name in ("h5py", "matplotlib", "PIL"):
    sys.modules[name] = None
sys.argv[:] = ["nsdae", *sys.argv[1:]]
runpy.run_module("nsdae", run_name="__main__")
"""


def alone(*arguments, cwd):
    return subprocess.run([sys.executable, "-W", "error", "-c", ALONE, *arguments], cwd=cwd, capture_output=True, text=True)


def test_a_page_with_numpy_alone(tmp_path):
    """The last domino falls, to the height of half a domino's depth or on another one."""
    done = alone("demo", "--no-browser", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "nsdae-demo.html").read_text()
    assert f"open {tmp_path / 'nsdae-demo.html'}" in done.stdout
    assert not re.search(r'https?://|src="', page.split("<script", 1)[1].split("application/json", 1)[0])
    scene = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)[1])
    assert len(scene["time"]) > 100 and scene["time"][-1] == 5


def test_what_is_missing_is_named(tmp_path):
    done = alone("demo", "--no-browser", "--output", "demo.gif", cwd=tmp_path)
    assert done.returncode == 1 and "pip install 'nsdae[plot]'" in done.stderr and "Traceback" not in done.stderr


def test_the_dominoes_fall():
    from nsdae.__main__ import COUNT, DOMINO, demo
    run = demo()
    heights = run.q.reshape(len(run), -1, 7)[:, :COUNT, 2]
    assert np.all(heights[0] == DOMINO[2] / 2) and np.all(heights[-1] < 0.75 * DOMINO[2] / 2)
    fallen = np.argmax(heights < 0.9 * DOMINO[2] / 2, axis=0)
    assert np.all(np.diff(fallen) > 0)  # one after the other


def test_pictures_from_memory_are_those_of_the_file(tmp_path):
    """What is drawn from arrays against the same from HDF5's file."""
    pytest.importorskip("h5py", reason="h5py is not here")
    from nsdae import _file
    from test_copies import mechanism
    run = nsdae.solve(mechanism(), 0.3, method="moreau", dt=1e-2, model="pile", parameters={"a": 1.5})
    run.save(tmp_path / "run.h5")
    import h5py
    with run._opened() as arrays, h5py.File(tmp_path / "run.h5") as file:
        seen = []

        def compare(path, item):
            if isinstance(item, h5py.Dataset):
                mine, its = np.asarray(arrays[path]), item[()]
                its = np.asarray(its.decode() if isinstance(its, bytes) else its)
                if its.dtype == object:
                    its = np.array([text.decode() for text in its.reshape(-1)], dtype=object).reshape(its.shape)
                assert mine.shape == its.shape and np.all(mine == its), path
                assert arrays[path].attrs.get("units", "") == item.attrs.get("units", ""), path
                seen.append(path)

        file.visititems(compare)
        assert sorted(seen) == sorted(arrays.of)
        assert set(arrays) == set(file) and set(arrays["contacts"]) == set(file["contacts"])
        for group in (lambda of: of), (lambda of: of["contacts"]):
            assert set(group(arrays).attrs) == set(group(file).attrs)
        assert "nothing" not in arrays and arrays.get("nothing") is None
        with pytest.raises(KeyError):
            arrays["nothing"]
    assert isinstance(arrays, _file.Arrays)
