"""What nsdae-plot draws, against what is known: units have axes of their own, the normal force on an
incline is m g cos(slope), impulses are those of the file, strips are the file's modes, and no number
of the certificate is below rounding; kinds of pictures, one-line errors, and a run that is drawn along.
usage: plot_check.py BIN_DIR DATA_DIR"""

import json
import os
import re
import signal
import subprocess
import sys
import time

import h5py
import matplotlib
import numpy as np
import tools
from tools import plot
from trajectory import open_trajectory

ONE = ("--only", "energy") if tools.QUICK else ()  # panel


def expect(name, holds, what=""):
    if not holds:
        sys.exit(f"{name} {what}")


def axes_of(example):
    plot.plt.close("all")
    with open_trajectory(f"{example}.h5", *plot.NEEDED) as file:
        pictures = (False,) if tools.QUICK and example != "pendulum" else (False, True)
        figures = [plot.draw(file, plot.panels(file, None, second), example) for second in pictures]
    shown = [[axes.get_ylabel().replace("\n", " ") for axes in figure.axes] for figure in figures]
    checks = {"energy [J]", "residual", "errors of position [m]"}
    expect("motion and forces first", not set(shown[0]) & checks and set(shown[-1]) <= checks or len(shown) == 1, shown)
    return [axes for figure in figures for axes in figure.axes]


def lines(axes, title):
    (found,) = [a for a in axes if a.get_ylabel().replace("\n", " ") == title]
    return {line.get_label(): line.get_xydata() for line in found.get_lines() if not line.get_label().startswith("_")}


def incline():
    axes = axes_of("incline")
    with h5py.File("incline.h5") as f:
        p = {name: value[()] for name, value in f["parameters"].items()}
        mode, time = f["contacts/mode"][:, 0], f["time"][...]
    shown = lines(axes, "mean contact forces [N]")
    normal = shown["plane, normal"][1:, 1]  # it lies on the plane from the start
    expect("normal force", np.abs(normal - p["m"] * p["g"] * np.cos(p["slope"])).max() < 1e-9)
    friction = np.hypot(shown["plane, friction 0"][1:, 1], shown["plane, friction 1"][1:, 1])
    holds = p["m"] * p["g"] * np.sin(p["slope"])
    expect("friction at rest", abs(friction[-1] - holds) < 1e-9, f"is {friction[-1]}, not {holds}")
    (strip,) = [a for a in axes if [t.get_text() for t in a.get_yticklabels()] == ["plane"]]
    kinds = {tuple(np.round(c.get_facecolor()[0], 3)): c for c in strip.collections if len(c.get_paths())}
    expect("strips", len(kinds) >= 2)
    sticks = time[1:][mode[1:] == 2]
    ends = [path.get_extents() for c in kinds.values() for path in c.get_paths()]
    expect("stick from then on", any(abs(e.x0 - time[np.searchsorted(time, sticks[0]) - 1]) < 1e-12 and
                                     abs(e.x1 - time[-1]) < 1e-12 for e in ends))


def pendulum():
    axes = axes_of("pendulum")
    titles = [a.get_ylabel().replace("\n", " ") for a in axes]
    for title in ("coordinates [m]", "coordinates [rad]", "velocities [m/s]", "velocities [rad/s]",
                  "mean forces of constraints [N]"):
        expect("an axis for each unit", title in titles, f"lacks {title}: {titles}")
    expect("no forces where there are only impacts", "mean contact forces [N]" not in titles)
    with h5py.File("pendulum.h5") as f:
        impulses, q = f["impact/normal_impulse"][...], f["q"][...]
        drift = f["certificate/constraint_drift"][...]
        energy = f["energy/kinetic"][...] + f["energy/potential"][...] - f["energy/potential"][0]
    mean = lines(axes, "mean forces of constraints [N]")["pivot_y"][:, 1]
    expect("no force before the first step", np.isnan(mean[0]) and np.isfinite(mean[1]))
    expect("coordinates", list(lines(axes, "coordinates [m]")) == ["x", "y"])
    expect("theta", np.array_equal(lines(axes, "coordinates [rad]")["theta"][:, 1], q[:, 2]))
    expect("impulses", np.array_equal(lines(axes, "impulses of impacts [N s]")["stop, normal"][:, 1], impulses))
    expect("energy", np.allclose(lines(axes, "energy [J]")["their sum"][:, 1], energy, rtol=0, atol=1e-12))
    residual = lines(axes, "residual")["LCP residual"][:, 1]
    expect("residuals end at rounding", residual.min() >= np.finfo(float).eps)
    errors = lines(axes, "errors of position [m]")["constraint drift"][:, 1]
    floor = np.finfo(float).eps * np.abs(q).max()
    expect("drift ends at rounding", np.array_equal(errors, np.maximum(drift[drift > 0], floor)))


def falling_rod():
    """The end that it slides on answers to the impact of the other: no force. Then both carry half its weight."""
    with h5py.File("falling-rod.h5") as f:
        weight = f["parameters/m"][()] * f["parameters/g"][()]
    shown = lines(axes_of("falling-rod"), "mean contact forces [N]")
    normal = shown["first_end, normal"][1:, 1]
    expect("the step of the impact", np.isnan(normal).sum() == 1)
    expect("no impulse in a force", np.nanmax(normal) < weight, f"{np.nanmax(normal)}")
    expect("half the weight", abs(normal[-1] - weight / 2) < 1e-2 * weight, f"{normal[-1]}")


def phases():
    """A phase portrait has the file's numbers; energy alone bounds its orbit between impacts."""
    with open_trajectory("pendulum.h5", *plot.NEEDED) as file:
        (axis,) = plot.portraits(file, ["theta"], (), "").axes
        drawn = axis.get_lines()[0].get_xydata()
        expect("phase", np.array_equal(drawn, np.stack([file["q"][:, 2], file["v"][:, 2]], axis=1)))
        expect("its units", (axis.get_xlabel(), axis.get_ylabel()) == ("theta [rad]", "velocity of theta [rad/s]"),
               (axis.get_xlabel(), axis.get_ylabel()))
        both = [a.get_xlabel() for a in plot.portraits(file, ["y", "x"], (), "").axes]
        expect("one for each name", both == ["y [m]", "x [m]"], both)


def paths():
    """A body's path is that of its middle, a point's that of its formulas, each as long as the file."""
    with open_trajectory("crank-slider.h5", *plot.NEEDED) as file:
        (axis,) = plot.portraits(file, (), ["rod", "slider", "L1*sin(theta_1), -L1*cos(theta_1)"], "").axes
        rod, slider, pin = (line.get_xydata() for line in axis.get_lines())
        L1, (one, two) = file["parameters/L1"][()], file["q"][...].T
        a = L1 * np.column_stack([np.sin(one), -np.cos(one)])
        b = a + file["parameters/L2"][()] * np.column_stack([np.sin(two), -np.cos(two)])
        for name, drawn, exact in (("rod", rod, (a + b) / 2), ("slider", slider, b), ("pin", pin, a)):
            expect(f"path of {name}", drawn.shape == exact.shape and np.abs(drawn - exact).max() < 1e-14)
        expect("metres are as long both ways", axis.get_aspect() == 1)


def colours():
    """A body has one colour in the animation, over time and in its path; strips of frictional joints are drawn."""
    tools.runs("nsdae-animate", "-o", "crank-slider.html", "crank-slider.h5")
    with open("crank-slider.html", encoding="utf-8") as page:
        found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read(), re.S)
    animated = {body["name"]: body["colour"] for body in json.loads(found[1])["bodies"]}
    expect("three colours", len({animated[name] for name in ("crank", "rod", "slider")}) == 3, animated)
    with open_trajectory("crank-slider.h5", *plot.NEEDED) as file:
        (axis,) = plot.portraits(file, (), ["slider", "crank", "rod", "q0,q1"], "").axes
        drawn = {line.get_label(): line.get_color() for line in axis.get_lines()}
        expect("a point is no body", drawn.pop("q0,q1") not in animated.values())
        expect("paths", drawn == {name: animated[name] for name in drawn}, drawn)
    axes = axes_of("crank-slider")
    for quantity in ("coordinates [rad]", "velocities [rad/s]"):
        (axis,) = [a for a in axes if a.get_ylabel() == quantity]
        drawn = [line.get_color() for line in axis.get_lines() if not line.get_label().startswith("_")]
        expect(quantity, drawn == [animated["crank"], animated["rod"]], drawn)
    expect("strip of the joint", ["slot"] in [[t.get_text() for t in a.get_yticklabels()] for a in axes])
    for name in ("crank-slider",) if tools.QUICK else ("crank-slider", "pendulum", "incline"):
        figures = {axis.figure for axis in (axes if name == "crank-slider" else axes_of(name))}
        for text in (text for figure in figures for text in figure.findobj(matplotlib.text.Text)):
            expect("labels of 12 pixels", text.get_fontsize() * 150 / 72 >= 12, text.get_text())


def many():
    """Of many lines those that vary most are drawn, each with a name; --name draws others, and panels left out are named."""
    tools.runs("nsdae-ragdoll", "--quiet", "--method", "moreau", "--t-end", "0.1", "--output", "ragdoll.h5")
    axes = axes_of("ragdoll")
    for axis in axes:
        drawn = [line for line in axis.get_lines() if len(line.get_xdata()) > 2]
        names = [text.get_text() for text in axis.get_legend().get_texts()] if axis.get_legend() else []
        expect("a name for each line", len(drawn) <= 12 and {line.get_label() for line in drawn} <= set(names), axis.get_ylabel())
    with open_trajectory("ragdoll.h5", *plot.NEEDED) as file:
        q = file["q"][...].reshape(len(file["q"]), -1, 7)[..., :3]
        most = np.sort(np.ptp(q, axis=0).ravel())[-6:]
        spans = [np.ptp(values[:, 1]) for values in lines(axes, "coordinates [m]").values()]
        expect("those that vary most", np.array_equal(np.sort(spans), most), spans)
        figure = plot.draw(file, ["coordinates"], "", ["z*"])
        shown = {line.get_label(): line.get_ydata() for axis in figure.axes for line in axis.get_lines()
                 if not line.get_label().startswith("_")}
        expect("those asked for", list(shown) == [f"z{i}" for i in range(10)] and
               all(np.array_equal(shown[f"z{i}"], q[:, i, 2]) for i in range(10)), list(shown))
    said = axes[0].figure.axes[-1].get_xlabel()
    expect("panels left out", "40 forces of constraints (--only multipliers)" in said, said)
    (axis, *_) = axes_asked("ragdoll", ["multipliers"])
    asked = [line.get_label() for line in axis.get_lines() if not line.get_label().startswith("_")]
    expect("a panel that is asked for", len(asked) == 6, asked)
    tools.refuses(1, "--name 'zz*' is the name of nothing", "nsdae-plot", "--name", "zz*", "ragdoll.h5")
    tools.runs("nsdae-plot", *ONE, "ragdoll.h5", "a.h5")
    tools.refuses(2, "--output is for one file, not 2", "nsdae-plot", "-o", "b.png", "ragdoll.h5", "a.h5")


def axes_asked(example, panels):
    with open_trajectory(f"{example}.h5", *plot.NEEDED) as file:
        return plot.draw(file, plot.panels(file, panels), example, asked=panels).axes


def headings():
    """A run without a name is titled by its file."""
    with open_trajectory("pendulum.h5", *plot.NEEDED) as file:
        expect("title", plot.title_of(file, "x/run.h5").startswith("pendulum, implicit, dt "), plot.title_of(file))
    with h5py.File("nameless.h5", "w") as out, h5py.File("pendulum.h5") as file:
        for name in file:
            file.copy(name, out)
        out.attrs.update({**file.attrs, "model": ""})
        expect("title of a file", plot.title_of(out, "x/run.h5").startswith("run, implicit, dt "), plot.title_of(out, "x/run.h5"))
        expect("title of no file", plot.title_of(out).startswith("implicit, dt "), plot.title_of(out))


def written(name, *arguments):
    tools.runs("nsdae-plot", *arguments)
    tools.expect(os.path.getsize(name) > 0, name)


def pictures(data):
    tools.runs("nsdae-pendulum", "--quiet", "--dt", "0.02", "--t-end", "1", "--output", "a.h5")
    for example in ("clearance-hinge", "crank-slider"):
        tools.make(example, data, ())
    for example in ("incline", "pendulum", "falling-rod"):
        tools.runs(f"nsdae-{example}", "--quiet", "--output", f"{example}.h5")
    tools.started_by_launcher("nsdae-plot", *(["--dpi", "50"] if tools.QUICK else []), "a.h5")  # as users start it
    tools.expect(os.path.getsize("a.png") > 0, "a.png")
    written("a.svg", "-o", "a.svg", "--only", "energy", "--only", "impulses", "a.h5")
    with open("a.svg", encoding="utf-8") as file:
        tools.expect("<svg" in file.read(), "a.svg")
    tools.runs("nsdae-sweep", "bouncing-ball", "--grid", "h0=0.5:2:5", "--grid", "e_N=0.3,0.9", "--t-end", "0.1", "--keep", "final",
               "--processes", "1", "--quiet", "--output", "sweep.h5")
    written("slice.svg", "--at", "e_N=0.9", "--only", "final/q", "-o", "slice.svg", "sweep.h5")
    if tools.QUICK:
        return
    written("clearance-hinge.png", "clearance-hinge.h5")
    written("crank-slider.png", "crank-slider.h5")
    written("c.png", "--phase", "theta", "-o", "c.png", "pendulum.h5")
    written("e.png", "--path", "rod", "--path", "x, 2*y", "-o", "e.png", "pendulum.h5")
    written("d.png", "--certificate", "-o", "d.png", "pendulum.h5")
    written("b.png", "--only", "modes", "--only", "forces", "-o", "b.png", "clearance-hinge.h5")


def damaged():
    """Files that are none, cut off, or changed: the signature of the groups' lists of names."""
    with open("a.h5", "rb") as file:
        whole = file.read()
    for name, content in (("text.h5", b"text"), ("short.h5", whole[:5000]), ("damaged.h5", whole.replace(b"SNOD", b"xxxx"))):
        with open(name, "wb") as file:
            file.write(content)


def errors():
    damaged()
    for code, words, *arguments in ((1, "nothing for forces", "--only", "forces", "a.h5"),
                                    (1, "no coordinate is called 'thet': they are x, y, theta", "--phase", "thet", "a.h5"),
                                    (1, "no body is called 'bar': they are", "--path", "bar", "a.h5"),
                                    (1, "no value for 'z'", "--path", "x,z", "a.h5"),
                                    (1, "No such file or directory", "none.h5"),
                                    (1, "cannot read 'text.h5'", "text.h5"),
                                    (1, "cannot read 'short.h5': truncated file", "short.h5"),
                                    (1, "'damaged.h5' is damaged", "damaged.h5"),
                                    (1, "cannot write 'no/a.png': No such file", "--only", "energy", "-o", "no/a.png", "a.h5"),
                                    (2, "must end with .png, .svg, .pdf", "-o", "picture", "a.h5")):
        tools.refuses(code, words, "nsdae-plot", *arguments)


def records(path):
    """Of a file that another program writes; 0 before it is a whole one."""
    try:
        with h5py.File(path, "r", swmr=True, locking=False) as file:
            return len(file["time"])
    except (OSError, KeyError):
        return 0


def live():
    """A run with --live is drawn along, and after it was killed; in the quick form it is stopped while it is drawn."""
    command = ["nsdae-pendulum", "--quiet", "--live", "--dt", "1e-4", "--t-end", "1e5", "--output", "live.h5"]
    with subprocess.Popen([os.path.join(tools.BIN, command[0]), *command[1:]]) as run:
        while run.poll() is None and records("live.h5") < 100:
            time.sleep(0.02)
        if tools.QUICK:
            run.send_signal(signal.SIGSTOP)
        tools.runs("nsdae-plot", *ONE, "live.h5")
        run.kill()
    tools.runs("nsdae-plot", "--only", "energy", "live.h5")


pictures(sys.argv[2])
for part in (incline, pendulum, falling_rod, phases, paths, colours, many, headings):
    with tools.judged(part.__name__):
        part()
errors()
live()
tools.end("units, forces, impulses, strips and certificate are what they are")
