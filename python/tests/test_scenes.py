"""Scenes from files, and how a run goes on if a contact problem is left above its tolerance."""

import os
import subprocess

import numpy as np
import pytest

import nsdae

DATA = os.path.join(os.path.dirname(__file__), "..", "..", "data")
BIN = os.environ.get("NSDAE_BIN")
OPTIONS = {"method": "moreau", "contact_work": 1e5}


def scene(name):
    world = nsdae.read_scene(os.path.join(DATA, f"scene_{name}.csv"))
    return world, {**OPTIONS, "dt": world.scene.dt}


def test_a_scene_is_what_the_file_has():
    world, _ = scene("mixed")
    with open(os.path.join(DATA, "scene_mixed.csv"), encoding="utf-8") as file:
        rows = [line.rstrip("\n").split(",") for line in file if not line.startswith(("#", "kind"))]
    q, v = world.start()
    q = q.reshape(-1, 7)
    numbers = np.array([row[1:] for row in rows], float)
    assert world.scene[1:] == (0, 0.5, 0, 9.81, 0.002) and world.scene.wall[0] == -world.scene.wall[1]
    assert np.array_equal(q[:, :3], numbers[:, 7:10])
    assert q[:, 3:] == pytest.approx(numbers[:, 10:14], abs=1e-8)
    assert np.array_equal(v.reshape(-1, 6), numbers[:, 14:])
    shapes = world.shapes()
    assert [s.shape for s in shapes] == ["plane"] * 5 + [row[0] for row in rows]
    for drawn, row, size in zip(shapes[5:], rows, numbers[:, :3]):
        assert list(drawn.size) == list(size[:{"sphere": 1, "capsule": 2, "box": 3}[row[0]]])


@pytest.mark.skipif(not BIN, reason="NSDAE_BIN does not say where the programs are")
@pytest.mark.parametrize("name", ["boxes", "mixed", "shapes", "wall"])
def test_the_program_and_python_have_the_same_bytes(name, tmp_path):
    path = tmp_path / "run.h5"
    subprocess.run([os.path.join(BIN, "nsdae-scene"), os.path.join(DATA, f"scene_{name}.csv"), "--quiet", "--t-end", "0.1",
                    "--output", path], check=True)
    world, options = scene(name)
    mine, theirs = nsdae.solve(world, 0.1, **options), nsdae.load(path)
    for field in ("time", "q", "v", "penetration"):
        assert np.array_equal(getattr(mine, field), getattr(theirs, field)), field
    drawn, written = ({s.name: (s.shape, [x for x in s.size if x], np.round(s.points, 12).tolist()) for s in shapes if s.shape != "plane"}
                      for shapes in (world.shapes(), theirs.shapes))
    assert drawn == written


def test_errors_name_file_line_and_column(tmp_path):
    path = tmp_path / "bad.csv"
    with open(os.path.join(DATA, "scene_wall.csv"), encoding="utf-8") as file:
        path.write_text(file.read().replace("box,", "box,nan", 1))
    with pytest.raises(nsdae.ArgumentError, match=r"bad.csv' line 9, column 2 \(size0\): size0 = 'nan0.1'"):
        nsdae.read_scene(path)
    with pytest.raises(nsdae.Error, match="cannot read"):
        nsdae.read_scene(tmp_path / "none.csv")
    with pytest.raises(nsdae.ArgumentError, match="NUL"):
        nsdae.read_scene("a\0b")


def test_contact_give_and_contact_work():
    """A bound of the work that no step meets: contact_give = 1 stops the run, more goes on and counts the steps."""
    world, options = scene("mixed")
    options = options | {"contact_tol": 1e-4}
    with pytest.raises(nsdae.Error) as stopped:
        nsdae.solve(world, 0.2, **options | {"contact_work": 1, "contact_give": 1})
    assert stopped.value.status == nsdae.Status.E_LCP
    with pytest.warns(nsdae.RunWarning):
        run = nsdae.solve(world, 0.2, **options | {"contact_work": 1, "contact_give": 1e6})
    assert run.stats["inexact_steps"] == np.count_nonzero(run.lcp_residual > 1e-4) > 0
    run = nsdae.solve(world, 0.2, **options | {"contact_work": 0, "contact_give": 1})
    assert run.stats["inexact_steps"] == 0 and run.lcp_residual.max() <= 1e-4
    for name, value in (("contact_give", 0.5), ("contact_work", -1)):
        with pytest.raises(nsdae.ArgumentError, match=name):
            nsdae.Sim(world, **{name: value})
