"""Trajectories in files, pictures and animations; the programs' own files where they are built (NSDAE_BIN)."""

import lzma
import os
import subprocess

import h5py
import numpy as np
import pytest

import nsdae
from conftest import G, block

BIN = os.environ.get("NSDAE_BIN")
needs_programs = pytest.mark.skipif(not BIN, reason="NSDAE_BIN does not say where the programs are")


def program(name, *arguments):
    return subprocess.run([os.path.join(BIN, name), *map(str, arguments)], check=True, capture_output=True, text=True)


def same(a, b):
    for name, value in vars(a).items():
        other = getattr(b, name)
        if isinstance(value, np.ndarray):
            assert value.dtype == other.dtype and np.array_equal(value, other), name
        elif name not in ("stats", "shapes"):
            assert value == other, name


@pytest.mark.parametrize("spatial", [False, True])
def test_what_is_saved_is_loaded(ball, tmp_path, spatial):
    if spatial:
        run = nsdae.solve(block(0.5, 0.7), 0.2, [0, 0, 0.001], method="event", dt=0.01, model="block")
    else:
        run = nsdae.solve(ball, 1, [1], model="ball", parameters={"m": 0.1, "e_N": 0.5},
                          shapes=[nsdae.Shape("ball", "sphere", (0.05,), (0, "y+0.05")),
                                  nsdae.Shape("floor", "plane", (0, 1, 0)),
                                  nsdae.Shape("mark", "polygon", points=[(0, 0), (1, 0), (0, 1)])])
    path = tmp_path / "run.h5"
    run.save(path)
    back = nsdae.load(path)
    same(run, back)
    assert [s.name for s in back.shapes] == [s.name for s in run.shapes]
    again = tmp_path / "again.h5"
    back.save(again)
    same(nsdae.load(again), run)


def test_load_refuses_in_one_line(tmp_path, ball):
    with pytest.raises(FileNotFoundError, match="missing.h5"):
        nsdae.load(tmp_path / "missing.h5")
    other = tmp_path / "other.h5"
    other.write_bytes(b"no HDF5 at all")
    with pytest.raises(OSError, match="other.h5"):
        nsdae.load(other)
    with h5py.File(tmp_path / "empty.h5", "w"):
        pass
    with pytest.raises(ValueError, match="not an nsdae trajectory"):
        nsdae.load(tmp_path / "empty.h5")
    with pytest.raises(OSError):
        nsdae.solve(ball, 0.1, [1]).save(tmp_path / "no" / "such" / "folder.h5")


def test_files_that_lead_elsewhere_are_refused(tmp_path, ball):
    """Also where a sweep is read, drawn or taken up."""
    run, many = tmp_path / "run.h5", tmp_path / "many.h5"
    nsdae.solve(ball, 0.1, [1]).save(run)
    nsdae.sweep(lambda h: {"h": h}, {"h": [1.0, 2.0]}, output=os.fspath(many))
    secret = tmp_path / "secret"
    secret.write_bytes(b"not for others " * 100)
    with h5py.File(run, "r+") as file:
        n = len(file["time"])
        del file["v"]
        file.create_dataset("v", (n, 1), "f8", external=[(os.fspath(secret), 0, 8 * n)])
    with pytest.raises(ValueError, match="/v has its data in other files"):
        nsdae.load(run)
    sweep = nsdae.load_sweep(many)
    with h5py.File(many, "r+") as file:
        del file["result/h"]
        file["result/h"] = h5py.ExternalLink(os.fspath(run), "/q")
    for read in (lambda: nsdae.load_sweep(many), sweep.plot,
                 lambda: nsdae.sweep(lambda h: {"h": h}, {"h": [1.0, 2.0]}, output=os.fspath(many))):
        with pytest.raises(ValueError, match="/result/h is a soft or external link"):
            read()


def layout(path):
    """Shape, type, scales and attributes of every dataset."""
    found = {}

    def visit(name, item):
        if isinstance(item, h5py.Group):
            found[name] = dict(item.attrs)
        else:
            scales = [[s.name for s in d.values()] for d in item.dims] if "DIMENSION_LIST" in item.attrs else []
            found[name] = (item.shape, item.dtype.kind, item.maxshape, scales, item.attrs["units"], item.is_scale)

    with h5py.File(path) as file:
        file.visititems(lambda name, item: visit(name, item) if name.split("/")[0] not in (
            "options", "parameters", "restart", "bodies") else None)
        return found, sorted(file.attrs)


def test_a_file_without_certificates(ball, tmp_path):
    """Files of before have none: they are read, and drawn."""
    path = tmp_path / "run.h5"
    nsdae.solve(ball, 1, [1]).save(path)
    with h5py.File(path, "a") as file:
        for name in ("energy/work", "energy/unexplained", *(f"certificate/{name}" for name in file["certificate"] if name
                     not in ("lcp_residual", "constraint_drift", "penetration"))):
            del file[name]
    run = nsdae.load(path)
    assert run.certificate is None and len(run) > 10
    run.plot()
    again = tmp_path / "again.h5"
    run.save(again)
    assert layout(again) == layout(path)


DATA = os.path.join(os.path.dirname(__file__), "..", "..", "tests", "data")


@pytest.mark.parametrize("name", ["version_1_contacts", "version_1_frictional_joint", "version_2_list"])
def test_files_of_older_versions(tmp_path, name):
    """They are loaded, and saved in the format of today."""
    old, new = tmp_path / "old.h5", tmp_path / "new.h5"
    with lzma.open(os.path.join(DATA, f"{name}.h5.xz")) as packed:
        old.write_bytes(packed.read())
    run = nsdae.load(old)
    run.save(new)
    same(nsdae.load(new), run)
    with h5py.File(old) as file, h5py.File(new) as saved:
        assert saved.attrs["format_version"] == 3 and not {"contact", "slide"} & set(saved)
        if name == "version_1_frictional_joint":
            assert np.array_equal(run.frictional_joint_impulse, file["slide/impulse"]) and run.contacts.shape == (len(run), 0)
            assert run.names["frictional_joint"] == [(file["slide/slide"].asstr()[0], "")]
            return
        listed = "contacts" in file
        group = file["contacts" if listed else "contact"]
        assert np.array_equal(run.gap, group["gap"]) and np.array_equal(run.mode, group["mode"])
        assert np.array_equal(run.tangential_impulse, group["tangential_impulse"])
        assert run.gap.size > 0 and len(run.impacts) > 0 and np.array_equal(run.impacts["time"], file["impact/time"])
        assert np.array_equal(run.impacts["id"], file["impact/id" if listed else "impact/contact"])
        assert np.array_equal(run.changes["id"], file["change/contact"])
        if listed:
            assert np.array_equal(run.contact_count, group["count"]) and np.array_equal(run.contacts["block"], group["block"])
        else:
            assert run.contacts["id"].tolist() == [[0, 1, 2]] * len(run) and len(run.changes) > 0


def ball_of_list():
    """On the ground, by a contact list."""
    def contacts(t, q, v, reach, found):
        found.add([7], [[0, -1]], [q[0]], [[[[1]], [[0]]]])

    def mass_blocks(t, q, M):
        M[:] = 1

    def force(t, q, v, F):
        F[:] = -G

    return nsdae.System(blocks=[1], mass_blocks=mass_blocks, force=force, contacts=contacts)


@pytest.mark.parametrize("listed", [False, True])
@pytest.mark.parametrize("name", ["gap", "mode", "id", "normal_impulse"])
@pytest.mark.parametrize("rows", [None, 1, -1])
def test_a_file_with_too_few_contacts(ball, tmp_path, listed, name, rows):
    """A column of the contacts that is missing, or shorter than the others, is an error that names it."""
    path = tmp_path / "run.h5"
    nsdae.solve(ball_of_list() if listed else ball, 0.1, [0], method="moreau").save(path)
    with h5py.File(path, "a") as file:
        values = file[f"contacts/{name}"][...]
        of_all = name == "id" and not listed
        assert len(values) > 2 or of_all
        del file[f"contacts/{name}"]
        if rows is not None:
            file[f"contacts/{name}"] = values[: 0 if of_all else rows]
    with pytest.raises(ValueError, match="contacts" if name == "id" else f"/contacts/{name}"):
        nsdae.load(path)


@pytest.mark.parametrize("name", ["v", "energy/kinetic", "energy/work"])
def test_a_file_with_too_few_rows(ball, tmp_path, name):
    path = tmp_path / "run.h5"
    nsdae.solve(ball, 0.1, [1]).save(path)
    with h5py.File(path, "a") as file:
        values = file[name][:1]
        del file[name]
        file[name] = values
    with pytest.raises(ValueError, match=f"/{name} has 1 of"):
        nsdae.load(path)


@pytest.mark.parametrize("version", ["three", b"3", 3.5, np.nan])
def test_a_file_whose_version_is_no_number(ball, tmp_path, version):
    path = tmp_path / "run.h5"
    nsdae.solve(ball, 0.1, [1]).save(path)
    with h5py.File(path, "a") as file:
        file.attrs["format_version"] = version
    with pytest.raises(ValueError, match="format_version must be a whole number"):
        nsdae.load(path)


@needs_programs
def test_a_saved_run_is_laid_out_as_the_programs_lay_it_out(tmp_path):
    """The bouncing ball by its program and by Python: the same bytes in every dataset."""
    path = tmp_path / "c.h5"
    program("nsdae-bouncing-ball", "--t-end", 1.5, "--quiet", "--output", path)
    theirs = nsdae.load(path)

    def mass(t, q, M):
        M[0, 0] = 1

    def force(t, q, v, F):
        F[0] = -G

    def gap(t, q, g):
        g[0] = q[0]

    def gap_normal(t, q, W):
        W[0, 0] = 1

    def contact_bias(t, q, w_n, w_t):
        w_n[0] = 0

    def contact_acceleration(t, q, v, omega_n, omega_t, omega_s):
        omega_n[0] = 0

    ball = nsdae.System(nq=1, k=1, e_n=0.9, mass=mass, force=force, gap=gap, gap_normal=gap_normal,
                        contact_bias=contact_bias, contact_acceleration=contact_acceleration,
                        potential=lambda t, q: G * q[0], names={"coordinate": [("y", "m")], "contact": [("floor", "m")],
                                                                "velocity": [theirs.names["velocity"][0]]})
    own = nsdae.solve(ball, 1.5, [1], model="bouncing-ball", parameters=theirs.parameters, dt=theirs.options["dt"],
                      projection="none", shapes=theirs.shapes)
    same(own, theirs)
    saved = tmp_path / "python.h5"
    own.save(saved)
    assert layout(saved) == layout(path)


@needs_programs
def test_the_tools_read_what_is_saved(tmp_path):
    from test_bodies import Bodies, Solid
    world = Bodies(2, gravity=(0, -G))
    disc = world.add(mass=1, inertia=0.01, position=(0, 0.5), velocity=(1, 0))
    world.add_contact(world.add_solid(nsdae.GROUND, Solid("plane")), world.add_solid(disc, Solid("disc", radius=0.1)),
                      e_n=0.5, mu=0.3)
    path = tmp_path / "disc.h5"
    nsdae.solve(world, 0.5, model="disc").save(path)
    assert "2 bodies" in program("nsdae-animate", path, "-o", tmp_path / "disc.gif").stdout
    assert "picture" in program("nsdae-plot", path, "-o", tmp_path / "disc.png").stdout
    program("nsdae-vtk", path, "--output", tmp_path / "disc.vtkhdf")


@needs_programs
@pytest.mark.parametrize("name", ["crank-slider", "woodpecker", "incline", "rolling-ball"])
def test_files_of_the_programs_survive(tmp_path, name):
    """Slides, two tangential directions, shapes: loaded, saved, loaded."""
    path = tmp_path / "c.h5"
    program(f"nsdae-{name}", "--t-end", 0.2, "--quiet", "--output", path)
    theirs = nsdae.load(path)
    theirs.save(tmp_path / "python.h5")
    same(nsdae.load(tmp_path / "python.h5"), theirs)
    mine, _ = layout(tmp_path / "python.h5")
    assert mine == layout(path)[0]


def test_plot(ball):
    run = nsdae.solve(ball, 1, [1])
    figure = run.plot()
    titles = [axes.get_ylabel() for axes in figure.axes]
    assert any("y [m]" in t or "[m]" in t for t in titles) and figure.axes[-1].get_xlabel() == "time [s]"
    drawn = run.plot(only=["coordinates"]).axes[0].lines
    assert any(len(line.get_ydata()) == len(run) and np.array_equal(line.get_ydata(), run["y"]) for line in drawn)
    with pytest.raises(ValueError, match="panel"):
        run.plot(only=["colours"])


def test_portraits(ball):
    run = nsdae.solve(ball, 1, [1], shapes=[nsdae.Shape("ball", "sphere", (0.05,), (0, "y+0.05"))])
    portrait, paths = run.plot(phase=["y"], path=["ball", "t, 2*y"]).axes
    assert np.array_equal(portrait.lines[0].get_xydata(), np.column_stack([run.q[:, 0], run.v[:, 0]]))
    centre, point = (line.get_xydata() for line in paths.lines)
    assert np.array_equal(centre, np.column_stack([0 * run.time, run["y"] + 0.05]))
    assert np.array_equal(point, np.column_stack([run.time, 2 * run["y"]]))
    with pytest.raises(ValueError, match="no body is called 'bell': they are ball; a point is X,Y"):
        run.plot(path=["bell"])
    with pytest.raises(ValueError, match="no coordinate is called 'z'"):
        run.plot(phase=["z"])


def test_animate(ball, tmp_path):
    run = nsdae.solve(ball, 0.5, [1], shapes=[nsdae.Shape("ball", "sphere", (0.05,), (0, "y+0.05"))])
    run.animate(tmp_path / "ball.gif", speed=0.5, width=200)
    assert (tmp_path / "ball.gif").read_bytes()[:6] == b"GIF89a"
    page = run.animate()
    assert "<iframe" in page._repr_html_() and "ball" in page.html
    nsdae.solve(ball, 0.1, [1]).animate(tmp_path / "point.html", point=(None, 0, None))
    with pytest.raises(ValueError, match="no bodies|names no"):
        nsdae.solve(ball, 0.1, [1]).animate()
    with pytest.raises(ValueError, match="speeed"):
        run.animate(tmp_path / "ball.gif", speeed=1)
