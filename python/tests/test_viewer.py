"""The viewer in a browser: what a headless chromium shows of a falling pile, controls, and refused arguments."""

import base64
import io
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
import urllib.request

import numpy as np
import pytest

import nsdae
from nsdae import GROUND, Bodies, Solid

viser = pytest.importorskip("viser")
SIZE = (800, 480)  # of the window; the controls are on its right


class Browser:
    """Chromium by its DevTools protocol."""

    def __init__(self, folder):
        program = shutil.which("chromium") or shutil.which("google-chrome")
        if program is None:
            assert os.environ.get("CI") != "true", "CI shows the viewer in a browser: install chromium"
            pytest.skip("no chromium here")
        self.process = subprocess.Popen(
            [program, "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run", "--disable-background-networking",
             "--disable-component-update", "--disable-sync", f"--user-data-dir={folder}", "--remote-debugging-port=0",
             "--window-size={},{}".format(*SIZE), "about:blank"], stderr=subprocess.PIPE, text=True)
        port = next(found[1] for found in (re.search(r"ws://127.0.0.1:(\d+)", line) for line in self.process.stderr) if found)
        threading.Thread(target=self.process.stderr.read, daemon=True).start()
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
            page = next(target for target in json.load(answer) if target["type"] == "page")
        from websockets.sync.client import connect  # viser needs it
        self.socket, self.count = connect(page["webSocketDebuggerUrl"], max_size=None), 0

    def call(self, method, **parameters):
        self.count += 1
        self.socket.send(json.dumps({"id": self.count, "method": method, "params": parameters}))
        while True:
            answer = json.loads(self.socket.recv(timeout=300))
            if answer.get("id") == self.count:
                return answer["result"]

    def press(self, label):
        """Clicks the button of this label when it is there."""
        click = f"[...document.querySelectorAll('button')].filter(b => b.innerText.trim() === '{label}').map(b => b.click()).length"
        until(lambda: self.call("Runtime.evaluate", expression=click)["result"]["value"] == 1)

    def picture(self):
        """Of the left part of the window, which has no controls."""
        from PIL import Image
        shot = base64.b64decode(self.call("Page.captureScreenshot", clip={
            "x": 0, "y": 200, "width": 480, "height": SIZE[1] - 200, "scale": 1})["data"])
        return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), float)

    def picture_that(self, holds):
        """The first picture for which it holds and that is as the one before: nothing fades in or moves."""
        pictures = [self.picture()]

        def still():
            pictures.append(self.picture())
            return (np.abs(pictures[-1] - pictures[-2]).max(axis=2) > 2).mean() < 1e-4

        until(lambda: still() and holds(pictures[-1]))
        return pictures[-1]

    def close(self):
        self.socket.close()
        self.process.terminate()
        self.process.wait()


@pytest.fixture
def browser(tmp_path):
    program = Browser(tmp_path / "browser")
    yield program
    program.close()


def until(holds):
    end = time.monotonic() + 300
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.1)


def pile():
    """Balls, boxes and capsules above a floor."""
    world = Bodies(3, gravity=(0, 0, -9.81))
    world.add_solid(GROUND, Solid("plane"))
    for i, shape in enumerate((Solid("box", length=(0.3, 0.2, 0.2)), Solid("sphere", radius=0.12),
                               Solid("capsule", radius=0.08, length=0.2), Solid("sphere", radius=0.1))):
        world.add_solid(world.add(1, (0.01, 0.01, 0.01), position=(0.3 * i, 0, 0.6 + 0.1 * i)), shape)
    world.set_pair(0, 0, mu=0.5)
    return world


@pytest.fixture(scope="module")
def run():
    return nsdae.solve(pile(), 0.6, method="moreau", dt=2e-3, contact_forces=True)


def test_a_falling_pile_differs_between_two_times(run, browser):
    viewer = run.show(block=False)
    browser.call("Page.navigate", url=viewer.url)
    browser.press(">|")
    until(lambda: viewer.record == len(run) - 1)
    # when the bodies have their colours
    end = browser.picture_that(lambda now: (np.ptp(now, axis=2) > 50).mean() > 0.008)

    def changed(now):
        return (np.abs(now - end).max(axis=2) > 30).mean()

    for button, record, holds in (("|<", 0, lambda now: changed(now) > 0.02), (">|", len(run) - 1, lambda now: changed(now) < 0.002)):
        browser.press(button)
        until(lambda record=record: viewer.record == record)
        browser.picture_that(holds)  # bodies cover a twentieth of the picture
    # the five arrows are a thousandth of the picture; nothing is red without them
    assert red(end) == 0
    viewer.forces.value = True
    viewer.redraw()
    browser.picture_that(lambda now: red(now) > 5e-4)
    viewer.close()


def red(picture):
    """The part of a picture that is red as forces are, (176, 22, 28), seen through bodies of glass; bodies are paler."""
    return (picture[..., 0] - picture[..., 1:].max(axis=2) > 60).mean()


def test_play_pause_and_step(run):
    viewer = run.show(block=False)
    assert viewer.record == 0 and not viewer.playing
    viewer.play(True)
    until(lambda: viewer.record == len(run) - 1 and not viewer.playing)
    viewer.jump(7)
    time.sleep(0.2)
    assert viewer.record == 7 and not viewer.playing
    viewer.forces.value = viewer.names.value = True
    viewer.jump(len(run) - 1)
    assert viewer.stage.arrows is not None and len(viewer.stage.names) == 4
    viewer.close()
    with pytest.raises(OSError):
        urllib.request.urlopen(viewer.url, timeout=1)


def test_poses_are_those_of_the_records(run):
    """A vertex of the box, by the batch's pose, and by the quaternion of the record."""
    viewer = run.show(block=False)
    stage = viewer.stage
    for record in (0, 150, len(run) - 1):
        viewer.jump(record)
        (batch, node), = ((b, n[0]) for b, n in zip(stage.batches, stage.nodes) if stage.bodies[b.members[0]].shape == "box")
        rotation = viser.transforms.SO3(np.asarray(node.batched_wxyzs[0], float)).as_matrix()
        seen = (node.batched_positions[0] + (node.vertices * node.batched_scales[0]) @ rotation.T) * stage.unit
        w, u = run.q[record, 3], run.q[record, 4:7]
        corner = np.array([0.15, 0.1, 0.1])
        own = run.q[record, :3] + corner + 2 * np.cross(u, np.cross(u, corner) + w * corner)
        assert np.linalg.norm(seen - own, axis=1).min() < 1e-5  # single precision
    viewer.close()


def test_a_simulation_is_paused_and_stepped(browser):
    sim = nsdae.Sim(pile(), method="moreau", dt=2e-3)
    sim.init()
    viewer = sim.show(block=False)
    browser.call("Page.navigate", url=viewer.url)
    browser.press("Pause")
    steps, ended = [], threading.Event()

    def program():
        while viewer.update():
            sim.step()
            steps.append(sim.time)
        ended.set()

    threading.Thread(target=program).start()
    until(lambda: not viewer.playing)
    time.sleep(0.3)
    count = len(steps)
    browser.press("Step")
    until(lambda: len(steps) == count + 1)
    time.sleep(0.3)
    assert len(steps) == count + 1
    browser.press("Play")
    until(lambda: len(steps) > count + 20)
    browser.press("Restart")
    until(lambda: np.any(np.diff(steps) < 0))
    viewer.close()
    assert ended.wait(10) and not viewer.update()


def at_rest():
    """Balls of 1 kg and a box of 4 kg on a floor."""
    world = Bodies(3, gravity=(0, 0, -10))
    world.add_solid(GROUND, Solid("plane"))
    balls = [world.add(1, (0.01, 0.01, 0.01), position=(0.5 * i, 0.1 * i, 0.1)) for i in range(3)]
    for ball in balls:
        world.add_solid(ball, Solid("sphere", radius=0.1))
    world.add_solid(world.add(4, (0.1, 0.1, 0.1), position=(0, 1, 0.2)), Solid("box", length=(0.6, 0.6, 0.4)))
    world.set_pair(0, 0, mu=0)
    return world


@pytest.mark.parametrize("whole", [True, False], ids=["run", "simulation"])
def test_forces_are_at_the_contacts(whole):
    """Below the centre of each ball is an arrow up of its weight, those of the box are at its corners."""
    sim = nsdae.Sim(at_rest(), method="implicit", dt=2e-3)
    sim.init()
    run = sim.record_run(0.1, contact_forces=True)
    point, force = sim.contact_forces()
    assert point.shape == force.shape == (len(sim.record.contacts), 3)
    assert force.sum(axis=0) == pytest.approx([0, 0, 70], abs=1e-6)
    viewer = run.show(block=False) if whole else sim.show(block=False)
    viewer.forces.value = True
    if whole:
        viewer.jump(len(run) - 1)
    else:
        viewer.draw()
    arrows = viewer.stage.arrows.points * viewer.stage.unit
    tails = {tuple(tail) for tail in (arrows[:, 0].round(3) + 0.0).tolist()}
    corners = {(x, y, 0.0) for x in (-0.3, 0.3) for y in (0.7, 1.3)}
    below = {(0.0, 0.0, 0.0), (0.5, 0.1, 0.0), (1.0, 0.2, 0.0)}
    assert below < tails <= below | corners  # two corners may bear the box
    along = arrows[:, 1] - arrows[:, 0]
    assert np.abs(along[:, :2]).max() < 1e-3 * along[:, 2].min()
    viewer.close()


def test_a_run_without_forces_has_no_arrows():
    viewer = nsdae.solve(at_rest(), 0.01, dt=2e-3).show(block=False)
    assert viewer.pressed is None and not viewer.forces.visible
    viewer.close()


def test_meshes_are_closed_and_split_at_creases():
    from nsdae.pictures import meshes, shapes
    for shape, vertices, volume in ((shapes.box(np.ones(3)), 24, 1), (shapes.globe(1.0, 0.0, 48, 24), 1106, 4 / 3 * np.pi),
                                    (shapes.cone(1.0, 2.0, 96), 3 * 96, 2 / 3 * np.pi),
                                    (shapes.prism(shapes.circle(0.5, 96), 1.0), 4 * 96, np.pi / 4)):
        parts = meshes.meshes_of(shape, 1.0)
        assert sum(len(np.unique(part.triangles)) for part in parts) >= vertices and len(parts[0].vertices) == vertices
        corners = np.concatenate([part.vertices[part.triangles] for part in parts])
        six = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
        assert six / 6 == pytest.approx(volume, rel=0.01)
        edges = np.sum(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 0)
        assert edges == len(corners)


def test_ears_of_random_stars():
    """Triangles of a polygon with dents have its area by the shoelace formula."""
    from nsdae.pictures import meshes, shapes
    random = np.random.default_rng(1)
    for corners in range(4, 24):
        angle = 2 * np.pi * np.arange(corners) / corners
        star = random.uniform(0.2, 1, corners)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        triangles = star[np.array(meshes.ears(star))]
        areas = [shapes.area(triangle) for triangle in triangles]
        assert len(areas) == corners - 2 and min(areas) > 0 and sum(areas) == pytest.approx(shapes.area(star))


def test_what_is_refused(run, tmp_path):
    with pytest.raises(ValueError, match="port is 0: it must be 1 to 65535"):
        run.show(port=0, block=False)
    bare = nsdae.solve(nsdae.System(nq=1, mass=lambda t, q, M: M.fill(1), force=lambda t, q, v, F: None), 0.1, q0=[1])
    with pytest.raises(ValueError, match="names no bodies"):
        bare.show(block=False)
    viewer = bare.show(point=[(0, None, None)], block=False)
    viewer.close()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 65535))
        taken.listen()
        with pytest.raises(ValueError, match="the ports 65535 to 65535 are in use"):
            run.show(port=65535, block=False)
    code = "import sys; sys.modules['viser'] = None; import nsdae; nsdae.load(sys.argv[1]).show()"
    run.save(tmp_path / "pile.h5")
    done = subprocess.run([sys.executable, "-c", code, tmp_path / "pile.h5"], capture_output=True, text=True)
    assert "pip install 'nsdae[viewer]'" in done.stderr.splitlines()[-1]


def test_the_next_port_is_taken(run):
    first = run.show(block=False)
    second = run.show(block=False, port=int(first.url.rsplit(":", 1)[1]))
    assert first.url != second.url
    for viewer in (first, second):
        viewer.close()


@pytest.mark.skipif("NSDAE_BIN" not in os.environ, reason="no programs")
def test_nsdae_view(run, tmp_path):
    run.save(tmp_path / "pile.h5")
    program = os.path.join(os.environ["NSDAE_BIN"], "nsdae-view")
    how = {**os.environ, "NSDAE_PYTHON": sys.executable}
    with subprocess.Popen([program, "--no-browser", tmp_path / "pile.h5"], stdout=subprocess.PIPE, text=True, env=how) as process:
        url = process.stdout.readline().split()[0]
        with urllib.request.urlopen(url) as page:
            assert b"<html" in page.read()
        process.terminate()
    for arguments, said in ((["missing.h5"], "cannot read 'missing.h5': No such file or directory"),
                            (["--port", "70000", "x.h5"], "--port 70000 is outside its range")):
        done = subprocess.run([program, *arguments], capture_output=True, text=True, env=how)
        assert done.returncode and said in done.stderr
