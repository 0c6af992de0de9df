"""sweep(): the format of nsdae-sweep, order and interruptions without a trace."""

import filecmp
import os
import pty
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np
import pytest

import nsdae
from conftest import G, ball_callbacks
from test_files import needs_programs, program


def bounce(h0, e_N=0.5):
    run = nsdae.solve(nsdae.System(nq=1, k=1, e_n=e_N, **ball_callbacks()), 1.2, [h0])
    return {"final/q": run.q[-1], "impacts": len(run.impacts)}


GRID = {"h0": np.linspace(0.5, 2, 6), "e_N": [0.3, 0.9]}


def test_results_and_scales(tmp_path):
    got = nsdae.sweep(bounce, GRID, output=tmp_path / "s.h5")
    assert got["final/q"].shape == (6, 2, 1) and got["impacts"].shape == (6, 2) and not got.status.any()
    assert got["final/q"][4, 1] == bounce(GRID["h0"][4], 0.9)["final/q"]
    assert np.array_equal(got["h0"], GRID["h0"]) and repr(got) == "nsdae.Sweep(h0 (6) x e_N (2); 12 of 12 runs done)"
    with h5py.File(tmp_path / "s.h5") as file:
        assert [[s.name for s in d.values()] for d in file["final/q"].dims][:2] == [["/grid/h0"], ["/grid/e_N"]]
        assert file.attrs["status"] in (b"complete", "complete")


def test_results_in_memory(tmp_path):
    """Those of the file, pictures too, and no file is left."""
    before = set(os.listdir(tempfile.gettempdir()))
    got, kept = nsdae.sweep(bounce, GRID), nsdae.sweep(bounce, GRID, output=tmp_path / "s.h5")
    assert got.path is None and repr(got) == repr(kept) and got.results.keys() == kept.results.keys()
    assert all(np.array_equal(got[name], kept[name]) for name in kept.results)
    assert not [name for name in set(os.listdir(tempfile.gettempdir())) - before if name.startswith("nsdae-")]
    drawn, read = (sweep.plot(only=["result/impacts"], at={"e_N": 0.9}).axes[0].lines[0] for sweep in (got, kept))
    assert np.array_equal(drawn.get_xydata(), read.get_xydata())


def test_the_same_bytes_whoever_did_it(tmp_path):
    nsdae.sweep(bounce, GRID, output=tmp_path / "one.h5")
    nsdae.sweep(bounce, GRID, output=tmp_path / "four.h5", workers=4)
    assert filecmp.cmp(tmp_path / "one.h5", tmp_path / "four.h5", shallow=False)


def test_taken_up_again(tmp_path):
    nsdae.sweep(bounce, GRID, output=tmp_path / "whole.h5")
    calls = []

    def breaks(**values):
        calls.append(values)
        if len(calls) == 7:
            raise KeyboardInterrupt
        return bounce(**values)

    part = tmp_path / "part.h5"
    with pytest.raises(KeyboardInterrupt):
        nsdae.sweep(breaks, GRID, output=part)
    left = int(np.sum(nsdae.load_sweep(part).status == 1))
    assert 0 < left < 12
    count = []
    nsdae.sweep(lambda **v: count.append(1) or bounce(**v), GRID, output=part)
    assert len(count) == left + 1  # and the one that shows the shapes
    assert filecmp.cmp(part, tmp_path / "whole.h5", shallow=False)
    nsdae.sweep(bounce, GRID, output=part)
    with pytest.raises(ValueError, match="another sweep"):
        nsdae.sweep(bounce, {"h0": [1, 2, 3]}, output=part)


PROGRAM = """
import sys, time
sys.path.insert(0, sys.argv[1])
import numpy as np, nsdae
from test_sweep import GRID, bounce
def slowly(**values):
    time.sleep(0.25)
    return bounce(**values)
nsdae.sweep(slowly, GRID, output=sys.argv[2])
"""


def test_killed_and_taken_up(tmp_path):
    nsdae.sweep(bounce, GRID, output=tmp_path / "whole.h5")
    part = tmp_path / "part.h5"
    command = [sys.executable, "-c", PROGRAM, os.path.dirname(__file__), str(part)]
    with subprocess.Popen(command) as run:
        while not part.exists():
            assert run.poll() is None, "ended before it wrote"
            time.sleep(0.01)
        time.sleep(0.3)
        run.send_signal(signal.SIGKILL)
    assert 0 < np.sum(nsdae.load_sweep(part).status == 1)
    subprocess.run(command, check=True)
    assert filecmp.cmp(part, tmp_path / "whole.h5", shallow=False)


def test_failures_keep_their_reason(tmp_path):
    def some(h0):
        if h0 > 1.2:
            nsdae.solve(nsdae.System(nq=1, k=1, **ball_callbacks()), 1, [-h0], method="event")
        return h0

    got = nsdae.sweep(some, {"h0": GRID["h0"]}, output=tmp_path / "s.h5")
    failed = GRID["h0"] > 1.2
    assert np.array_equal(got.status < 0, failed) and list(got.failures) == np.flatnonzero(failed).tolist()
    assert all("gap" in reason or "overlap" in reason or "contact" in reason for reason in got.failures.values())
    assert np.isnan(got["value"][failed]).all() and np.array_equal(got["value"][~failed], GRID["h0"][~failed])


def test_what_is_no_failure_of_a_run_ends_the_sweep(tmp_path):
    def wrong(h0):
        return {"a": np.zeros(2 if h0 > 1 else 1)}

    with pytest.raises(ValueError, match="other names or shapes"):
        nsdae.sweep(wrong, {"h0": [0.5, 2]}, output=tmp_path / "s.h5")
    with pytest.raises(ZeroDivisionError):
        nsdae.sweep(lambda h0: 1 / (h0 - 1), {"h0": [2, 1]}, output=tmp_path / "t.h5")
    with pytest.raises(ValueError, match="grid is empty"):
        nsdae.sweep(bounce, {}, output=tmp_path / "u.h5")
    with pytest.raises(ValueError, match="finite"):
        nsdae.sweep(bounce, {"h0": [np.nan]}, output=tmp_path / "u.h5")


def test_draws(tmp_path):
    told = {"grid": {"h0": (0.5, 2), "e_N": (0, 1)}, "random": 50}
    one = nsdae.sweep(lambda h0, e_N: h0 * e_N, **told, seed=1, output=tmp_path / "a.h5")
    two = nsdae.sweep(lambda h0, e_N: h0 * e_N, **told, seed=1, output=tmp_path / "b.h5", workers=3)
    other = nsdae.sweep(lambda h0, e_N: h0 * e_N, **told, seed=2, output=tmp_path / "c.h5")
    assert np.array_equal(one["h0"], two["h0"]) and not np.array_equal(one["h0"], other["h0"])
    assert one["value"].shape == (50,) and np.array_equal(one["value"], one["h0"] * one["e_N"])
    assert one.plot().axes[0].get_xlabel() == "h0"


def test_pictures(tmp_path):
    got = nsdae.sweep(bounce, GRID, output=tmp_path / "s.h5")
    figure = got.plot(only=["result/impacts"])
    assert (figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()) == ("e_N", "h0")
    line = got.plot(only=["result/impacts"], at={"e_N": 0.9}).axes[0].lines[0]
    assert np.array_equal(line.get_ydata(), got["impacts"][:, 1]) and np.array_equal(line.get_xdata(), GRID["h0"])
    with pytest.raises(ValueError, match="nothing"):
        got.plot(only=["nothing"])


@needs_programs
def test_files_of_the_program(tmp_path):
    """The same ball by nsdae-sweep and by Python."""
    path = tmp_path / "c.h5"
    program("nsdae-sweep", "bouncing-ball", "--grid", "h0=0.5:2:4", "--set", "g=9.81", "--t-end", "1", "--keep",
            "statistics", "--keep", "final", "--processes", "1", "--quiet", "--output", path)
    theirs = nsdae.load_sweep(path)

    def fall(h0):
        run = nsdae.solve(nsdae.System(nq=1, k=1, e_n=0.9, **ball_callbacks(m=1)), 1, [h0])
        return {"final/q": run.q[-1], "final/v": run.v[-1], "statistics/impacts": len(run.impacts)}

    own = nsdae.sweep(fall, {"h0": np.linspace(0.5, 2, 4)}, output=tmp_path / "p.h5")
    assert np.array_equal(own["h0"], theirs["h0"]) and G == 9.81
    assert np.allclose(own["final/q"], theirs["final/q"], atol=1e-12)
    assert np.array_equal(own["statistics/impacts"], theirs["statistics/impacts"])
    assert theirs.plot().axes[0].get_xlabel() == "h0 [m]"
    assert "picture" in program("nsdae-plot", tmp_path / "p.h5", "-o", tmp_path / "p.png").stdout


MPI_PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
import nsdae
from test_sweep import GRID, bounce, stops_once

def main():
    try:
        got = nsdae.sweep({"whole": bounce, "stops": stops_once}[sys.argv[3]], GRID, output=sys.argv[2], mpi=True)
        print("not here" if got is None else repr(got))
    except ZeroDivisionError as error:
        print("ended:", error)

main()
"""


def stops_once(**values):
    """Another program's bug: on whichever rank it is, it ends the sweep."""
    return bounce(**values) if values["h0"] < 1.5 else 1 / 0


def mpirun(n, *arguments):
    allowed = {f"OMPI_{name}": "1" for name in ("ALLOW_RUN_AS_ROOT", "ALLOW_RUN_AS_ROOT_CONFIRM",
                                                "MCA_rmaps_base_oversubscribe")}
    return subprocess.run(["mpirun", "-n", str(n), sys.executable, "-c", MPI_PROGRAM, os.path.dirname(__file__), *arguments],
                          capture_output=True, text=True, timeout=120, env={**os.environ, **allowed})


@pytest.mark.skipif(not shutil.which("mpirun"), reason="mpirun is not here")
def test_ranks_of_mpi(tmp_path):
    """The same bytes with any number of ranks; what is no failure of a run ends it on all of them; taken up again."""
    pytest.importorskip("mpi4py", reason="mpi4py is not here")
    try:
        from mpi4py import MPI  # noqa: F401
    except (ImportError, RuntimeError) as error:
        pytest.skip(f"mpi4py finds no MPI: {error}")
    nsdae.sweep(bounce, GRID, output=tmp_path / "alone.h5")
    for n in (1, 3):
        done = mpirun(n, str(tmp_path / f"{n}.h5"), "whole")
        assert done.returncode == 0 and "12 of 12 runs done" in done.stdout, done
        assert done.stdout.count("not here") == n - 1, done  # lines of ranks may run into each other
        assert filecmp.cmp(tmp_path / "alone.h5", tmp_path / f"{n}.h5", shallow=False)
    part = tmp_path / "part.h5"
    done = mpirun(2, str(part), "stops")
    assert "ended: division by zero" in done.stdout, done
    left = int(np.sum(nsdae.load_sweep(part).status == 1))
    assert 0 < left < 12
    assert mpirun(2, str(part), "whole").returncode == 0
    assert filecmp.cmp(tmp_path / "alone.h5", part, shallow=False)


def test_the_bar_on_a_terminal(tmp_path):
    """Shown where standard error is a terminal and the sweep lasts, with the time left, and taken away at the end."""
    master, slave = pty.openpty()
    command = [sys.executable, "-c", PROGRAM, os.path.dirname(__file__), str(tmp_path / "s.h5")]
    with subprocess.Popen(command, stderr=slave, stdout=subprocess.PIPE) as run:
        os.close(slave)
        shown = b""
        while True:
            try:
                part = os.read(master, 4096)
            except OSError:  # the other side is closed
                break
            if not part:
                break
            shown += part
    os.close(master)
    text = shown.decode()
    assert run.returncode == 0 and re.search(r"\r\d+ of 12 runs, 0:\d\d left\x1b\[K", text), text
    assert text.endswith("\r\x1b[K"), text
