"""What nsdae-plot draws, against what is known: units have axes of their own, the normal force on an
incline is m g cos(slope), impulses are those of the file, strips are the file's modes, and no number
of the certificate is below rounding. usage: plot_check.py SHARE_DIR FOLDER (of incline.h5, pendulum.h5, falling-rod.h5)"""

import sys

import h5py
import numpy as np

sys.path.insert(0, sys.argv[1])
import plot  # noqa: E402
from trajectory import open_trajectory  # noqa: E402


def expect(name, holds, what=""):
    if not holds:
        sys.exit(f"{name} {what}")


def axes_of(example):
    with open_trajectory(f"{sys.argv[2]}/{example}.h5", *plot.NEEDED) as file:
        figure = plot.draw(file, plot.panels(file, None), example)
    return figure.axes


def lines(axes, title):
    (found,) = [a for a in axes if a.get_ylabel().replace("\n", " ") == title]
    return {line.get_label(): line.get_xydata() for line in found.get_lines() if not line.get_label().startswith("_")}


def incline():
    axes = axes_of("incline")
    with h5py.File(f"{sys.argv[2]}/incline.h5") as f:
        p = {name: value[()] for name, value in f["parameters"].items()}
        mode, time = f["contact/mode"][:, 0], f["time"][...]
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
    with h5py.File(f"{sys.argv[2]}/pendulum.h5") as f:
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
    with h5py.File(f"{sys.argv[2]}/falling-rod.h5") as f:
        weight = f["parameters/m"][()] * f["parameters/g"][()]
    shown = lines(axes_of("falling-rod"), "mean contact forces [N]")
    normal = shown["first_end, normal"][1:, 1]
    expect("the step of the impact", np.isnan(normal).sum() == 1)
    expect("no impulse in a force", np.nanmax(normal) < weight, f"{np.nanmax(normal)}")
    expect("half the weight", abs(normal[-1] - weight / 2) < 1e-2 * weight, f"{normal[-1]}")


incline()
pendulum()
falling_rod()
print("units, forces, impulses, strips and certificate are what they are")
