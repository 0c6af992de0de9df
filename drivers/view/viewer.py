"""The bodies of an nsdae trajectory in a browser: turn, zoom, play, step; names, shadows and contact forces."""

import os
import sys
import threading
import time
import webbrowser

import numpy as np

from bodies import bodies_of, columns_of, count_of, is_spatial, read_motion, times_of
from contacts import arrows, force_arrows, unit_of
from scene import camera
from trajectory import Parser, Problem, has_forces, heading, open_trajectory, tell

PORT = 8080
POSES_MAX = 1000000  # bodies by records that are kept: 100 MB
FPS = 30
SPEEDS = ["1/100", "1/50", "1/20", "1/10", "1/5", "1/2", "1", "2", "5", "10"]


class NoViser(Problem):
    """viser is not installed."""


def chosen(speed):
    top, _, bottom = speed.partition("/")
    return float(top) / float(bottom or 1)


class Viewer:
    """Controls of a stage. All of its methods may be called from any thread."""

    def __init__(self, stage, title, has_forces, playing=False):
        self.stage, self.url = stage, stage.url
        self.playing, self.begun = playing, playing
        self.closed, self.lock = threading.Event(), threading.RLock()
        gui = stage.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(59, 110, 165))
        self.title = gui.add_markdown(f"**{title}**")
        self.clock = gui.add_markdown("")
        self.button = gui.add_button("Pause" if playing else "Play")
        self.button.on_click(lambda _: self.play(not self.playing))
        self.add_time(gui)
        self.speed = gui.add_dropdown("speed", SPEEDS, initial_value="1")
        self.names = gui.add_checkbox("names", False, hint="a click on a body shows its name, too")
        self.forces = gui.add_checkbox("contact forces", False, visible=has_forces)
        view = gui.add_button("View all")
        for control in (self.names, self.forces):
            control.on_update(lambda _: self.redraw())
        view.on_click(lambda event: self.view_all(event.client))
        stage.server.on_client_connect(lambda _: self.begin())

    def begin(self):
        """Plays when the first browser is there."""
        if not self.begun:
            self.play(True)

    def play(self, playing):
        self.playing, self.begun = playing, True
        self.button.label = "Pause" if playing else "Play"

    def view_all(self, client):
        if client is not None:
            self.stage.set_camera(client.camera)

    def open_browser(self):
        """Where there is a screen."""
        if sys.platform in ("win32", "darwin") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            webbrowser.open(self.url)

    def close(self):
        """Ends the server."""
        if not self.closed.is_set():
            self.closed.set()
            self.stage.close()

    def wait(self):
        """Until it is closed or interrupted."""
        try:
            while not self.closed.wait(0.2):
                pass
        except KeyboardInterrupt:
            pass
        finally:
            self.close()

    def _repr_html_(self):
        return f'<iframe src="{self.url}" width="100%" height="620" frameborder="0"></iframe>'

    def __repr__(self):
        return f"nsdae viewer at {self.url}{' (closed)' if self.closed.is_set() else ''}"


class Playback(Viewer):
    """A motion of which all records are there."""

    def __init__(self, stage, title, times, pressed, way):
        self.times, self.pressed, self.way = times, pressed, way
        self.record, self.now = 0, times[0]
        super().__init__(stage, title, pressed is not None)
        self.show(0)
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def add_time(self, gui):
        last = len(self.times) - 1
        self.slider = gui.add_slider("record", 0, max(last, 1), 1, 0, disabled=last == 0)
        self.slider.on_update(lambda event: self.jump(self.slider.value) if event.client else None)
        self.step = gui.add_button_group("step", ["|<", "<", ">", ">|"])
        self.step.on_click(lambda _: self.jump({"|<": 0, "<": self.record - 1, ">": self.record + 1, ">|": last}[self.step.value]))

    def jump(self, record):
        self.play(False)
        self.show(min(max(int(record), 0), len(self.times) - 1))

    def play(self, playing):
        if playing and self.record == len(self.times) - 1:
            self.show(0)
        super().play(playing)

    def show(self, record, now=None):
        """Draws a record."""
        with self.lock:
            self.record, self.now = record, self.times[record] if now is None else now
            self.slider.value = record
            self.clock.content = f"t = {self.times[record]:.4f} s"
            self.redraw()

    def redraw(self):
        with self.lock:
            self.stage.label(self.names.value)
            self.stage.show(self.record, self.pressed[self.record] if self.forces.value else None,
                            self.way[self.record] if self.way is not None else None)

    def run(self):
        before = time.monotonic()
        while not self.closed.wait(1 / FPS):
            passed, before = time.monotonic() - before, time.monotonic()
            if not self.playing:
                continue
            now = self.now + passed * chosen(self.speed.value)
            record = int(np.searchsorted(self.times, now, side="right")) - 1
            if record != self.record:
                self.show(record, now)
            self.now = now
            if record == len(self.times) - 1:
                super().play(False)


def stage_of(bodies, title, port):
    """Of viser, which --help does without."""
    try:
        from stage import Stage
    except ImportError as error:
        raise NoViser(f"the viewer needs viser ({error}): pip install viser, or name a Python that has it in NSDAE_PYTHON") from error
    return Stage(bodies, title, port)


def playback(file, path, *, title=None, point=None, port=PORT):
    """Opens a viewer of a trajectory."""
    times = times_of(file)
    most = int(np.clip(POSES_MAX // max(count_of(file, point), 1), 2, len(times))) if len(times) > 1 else 1
    records = np.unique(np.linspace(0, len(times) - 1, most).round().astype(int))
    bodies = read_motion(file, path, point, records)
    title = heading(file, path) if title is None else title
    follow = camera(bodies, len(records)) if is_spatial(bodies) else None
    stage = stage_of(bodies, title, port)
    pressed = force_arrows(file, records, stage.size / 10) if has_forces(file) and not point else None
    return Playback(stage, title, times[records], pressed, follow[1] if follow else None)


class Live(Viewer):
    """A simulation that its own program steps: `now` tells time and coordinates, `pressed` points and forces of contacts (None:
    it has none), `restart` sets its start."""

    def __init__(self, stage, title, file, now, pressed, restart, playing):
        self.file, self.tell_now, self.pressed, self.restart = file, now, pressed, restart
        self.steps, self.again, self.strongest = 0, False, 0.0
        self.anchor = self.drawn = None  # speed, time and clock that the pace counts from; clock of the last drawing
        super().__init__(stage, title, pressed is not None, playing)

    def add_time(self, gui):
        gui.add_button("Step").on_click(lambda _: self.step())
        gui.add_button("Restart").on_click(lambda _: self.ask_restart())

    def step(self):
        self.play(False)
        self.steps += 1

    def ask_restart(self):
        self.again = True

    def redraw(self):
        self.drawn = None  # the program draws it

    def arrows(self):
        """Forces at the contacts. A tenth of the scene is the force that one in twenty is larger than, the largest so far."""
        points, forces = self.pressed()
        points, forces = points[np.isfinite(points[:, 0])], forces[np.isfinite(points[:, 0])]
        if len(forces):
            self.strongest = max(self.strongest, unit_of(forces))
        return arrows(points, forces / (self.strongest or 1.0), self.stage.size / 10)

    def draw(self):
        t, q = self.tell_now()
        self.stage.set_bodies(bodies_of(self.file, "the simulation", None, np.array([t]), q[None]))
        self.clock.content = f"t = {t:.4f} s"
        self.stage.label(self.names.value)
        self.stage.show(0, self.arrows() if self.forces.value else None)
        self.drawn = time.monotonic()

    def due(self):
        return self.drawn is None or time.monotonic() - self.drawn >= 1 / FPS

    def pace(self):
        """Waits until the time of the simulation is due at the speed that is chosen."""
        key, t = self.speed.value, self.tell_now()[0]
        if self.anchor is None or self.anchor[0] != key:
            self.anchor = key, t, time.monotonic()
        _, start, since = self.anchor
        late = (t - start) / chosen(key) - (time.monotonic() - since)
        if late < -0.5:  # slower than that speed: it does not catch up
            self.anchor = None
        elif late > 0:
            self.closed.wait(late)

    def update(self):
        """Draws the present state; waits while the browser has it paused. Whether the viewer is open."""
        while not self.closed.is_set():
            if self.again:
                self.restart()
                self.again, self.anchor, self.drawn = False, None, None
            if self.due():
                self.draw()
            if self.playing:
                self.pace()
                return not self.closed.is_set()
            if self.steps > 0:
                self.steps, self.drawn = self.steps - 1, None
                return True
            self.anchor = None
            self.closed.wait(1 / FPS)
        return False


def live(file, path, now, pressed, restart, *, title=None, port=PORT, playing=True):
    """Opens a viewer of a simulation; its file, in memory, has the shapes, and a record."""
    t, q = now()
    title = heading(file, path) if title is None else title
    bodies = bodies_of(file, path, None, np.array([t]), q[None])
    return Live(stage_of(bodies, title, port), title, file, now, pressed, restart, playing)


def parse(argv):
    parser = Parser(prog="nsdae-view", description=__doc__)
    parser.add_argument("file", help="trajectory, e.g. pendulum.h5")
    parser.add_argument("--port", type=int, default=PORT, metavar="N",
                        help=f"port of the page, 1 to 65535 (default {PORT}); the next one that is free is taken")
    parser.add_argument("--no-browser", action="store_true", help="print the address only")
    parser.add_argument("--title", help="title, by default model and method")
    parser.add_argument("--point", metavar="X,Y,Z", action="append", type=columns_of,
                        help="a point at these coordinates of q, numbered from 0, in place of the bodies, "
                        "- for none; repeatable")
    parser.add_argument("--version", action="version", version="nsdae-view @PROJECT_VERSION@")
    arguments = parser.parse_args(argv)
    if not 1 <= arguments.port <= 65535:
        parser.error(f"--port {arguments.port} is outside its range: 1 to 65535")
    return arguments


def main(argv=None):
    arguments = parse(argv)
    try:
        with open_trajectory(arguments.file) as file:
            viewer = playback(file, arguments.file, title=arguments.title, point=arguments.point, port=arguments.port)
        tell(f"{viewer.url} shows {arguments.file}; Ctrl-C ends it")
        if not arguments.no_browser:
            viewer.open_browser()
        viewer.wait()
    except Problem as problem:
        print(f"nsdae-view: error: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
