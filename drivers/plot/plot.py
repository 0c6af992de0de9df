"""Pictures of an nsdae trajectory: coordinates, velocities, impulses, energy, certificate."""

import io
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)
import numpy as np  # noqa: E402

from trajectory import Parser, Problem, open_trajectory, replace, tell, text  # noqa: E402

FORMATS = (".png", ".svg", ".pdf")
NEEDED = ("v", "energy/kinetic", "energy/dissipated", "certificate", "impact/time")
POINTS_MAX = 20000  # more than this of a line are drawn as an image within an SVG or PDF
LEGEND_MAX = 12  # more lines than this say nothing in a legend


def label(axes, dataset, name):
    units = text(dataset.attrs.get("units", ""))
    axes.set_ylabel(name if units in ("", "1") or units.startswith("of the model") else f"{name} [{units}]")


def legend(axes):
    lines = axes.get_legend_handles_labels()[0]
    if 1 < len(lines) <= LEGEND_MAX:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False)


def lines_of(axes, time, dataset, prefix):
    values = dataset[: len(time)].reshape(len(time), -1)
    for i in range(values.shape[1]):
        name = f"${prefix}_{{{i + 1}}}$" if values.shape[1] > 1 else f"${prefix}$"
        axes.plot(time, values[:, i], label=name, linewidth=1.2)


def coordinates(axes, file, time):
    lines_of(axes, time, file["q"], "q")
    label(axes, file["q"], "coordinates")


def velocities(axes, file, time):
    lines_of(axes, time, file["v"], "v")
    label(axes, file["v"], "velocities")


def multipliers(axes, file, time):
    lines_of(axes, time, file["multiplier"], r"\lambda")
    label(axes, file["multiplier"], "mean bilateral forces")


def stems(axes, time, values, name, marker):
    hit = values != 0
    if np.any(hit):
        (line,) = axes.plot(time[hit], values[hit], marker, markersize=3.5, label=name)
        axes.vlines(time[hit], 0, values[hit], color=line.get_color(), linewidth=0.6, alpha=0.6)


def impulses(axes, file, time):
    if "contact" in file:
        normal = file["contact/normal_impulse"][: len(time)]
        for i in range(normal.shape[1]):
            stems(axes, time, normal[:, i], rf"$\Lambda_{{N{i + 1}}}$", "o")
        if "tangential_impulse" in file["contact"]:
            tangential = file["contact/tangential_impulse"][: len(time)].reshape(len(time), -1)
            for i in range(tangential.shape[1]):
                stems(axes, time, tangential[:, i], rf"$\Lambda_{{T{i + 1}}}$", "x")
    if "slide" in file:
        lines_of(axes, time, file["slide/impulse"], r"\Lambda_S")
    axes.axhline(0, color="0.8", linewidth=0.6, zorder=0)
    axes.set_ylabel("impulses of a step [N s]")


def energy(axes, file, time):
    values = {name: dataset[: len(time)] for name, dataset in file["energy"].items()}
    axes.plot(time, values["kinetic"], label="kinetic", linewidth=1)
    if "potential" in values:
        axes.plot(time, values["potential"], label="potential", linewidth=1)
        axes.plot(time, values["kinetic"] + values["potential"], label="total", linewidth=1.6, color="k")
    axes.plot(time, values["dissipated"], label="dissipated", linewidth=1, linestyle="--")
    axes.set_ylabel("energy [J]")


def certificate(axes, file, time):
    names = {
        "lcp_residual": "LCP residual",
        "constraint_drift": "constraint drift",
        "penetration": "penetration",
    }
    for name, shown in names.items():
        values = file["certificate"][name][: len(time)]
        axes.plot(time, np.where(values > 0, values, np.nan), ".", markersize=2.5, label=shown)
        if np.any(values > 0):
            axes.set_yscale("log")
    axes.set_ylabel("certificate")


PANELS = {
    "coordinates": (coordinates, lambda file: True),
    "velocities": (velocities, lambda file: True),
    "multipliers": (multipliers, lambda file: "multiplier" in file),
    "impulses": (impulses, lambda file: "contact" in file or "slide" in file),
    "energy": (energy, lambda file: True),
    "certificate": (certificate, lambda file: True),
}


def title_of(file):
    attrs = {name: text(value) for name, value in file.attrs.items()}
    title = f"{attrs.get('model', '')}, {attrs.get('method', '')}"
    if "options/dt" in file:
        title += f", dt {file['options/dt'][()]:g} s"
    if attrs.get("status") != "complete":
        title += f" ({attrs.get('status')})"
    return title


def mark_impacts(axes, file):
    for t in file["impact/time"][:200]:
        axes.axvline(t, color="0.85", linewidth=0.6, zorder=0)


def records(file):
    """How many there are of everything: while a run writes along, some datasets are ahead."""
    names = ["time", "q", "v", "multiplier"]
    for group in ("contact", "slide", "energy", "certificate"):
        names += [f"{group}/{name}" for name in file.get(group, {})]
    return min(len(file[name]) for name in names if name in file)


def draw(file, names, title):
    time = file["time"][: records(file)]
    figure, rows = plt.subplots(
        len(names), 1, sharex=True, squeeze=False, figsize=(9, 0.8 + 2.1 * len(names)), layout="constrained"
    )
    for axes, name in zip(rows[:, 0], names):
        mark_impacts(axes, file)
        PANELS[name][0](axes, file, time)
        axes.margins(x=0.01)
        for drawn in axes.lines + axes.collections:
            drawn.set_rasterized(len(time) > POINTS_MAX)
        axes.spines[["top", "right"]].set_visible(False)
        legend(axes)
    rows[-1, 0].set_xlabel("time [s]")
    figure.suptitle(title)
    figure.align_ylabels()
    return figure


def parse(argv):
    parser = Parser(prog="nsdae-plot", description=__doc__)
    parser.add_argument("file", help="trajectory, e.g. pendulum.h5")
    parser.add_argument("-o", "--output", help="picture (.png, .svg or .pdf); default FILE.png")
    parser.add_argument("--only", action="append", choices=list(PANELS), help="this panel; repeatable")
    parser.add_argument("--title", help="instead of model, method and step")
    parser.add_argument("--dpi", type=int, default=150, help="of a PNG, 20 to 1200 (default 150)")
    parser.add_argument("--version", action="version", version="nsdae-plot @PROJECT_VERSION@")
    arguments = parser.parse_args(argv)
    if not 20 <= arguments.dpi <= 1200:
        parser.error(f"--dpi {arguments.dpi} is outside its range: it must be 20 to 1200")
    if arguments.output is None:
        arguments.output = os.path.splitext(arguments.file)[0] + ".png"
    elif not arguments.output.lower().endswith(FORMATS):
        parser.error(f"--output '{arguments.output}' must end with {', '.join(FORMATS)}")
    return arguments


def picture(figure, arguments):
    """The file's bytes."""
    whole = io.BytesIO()
    figure.savefig(whole, format=arguments.output[-3:].lower(), dpi=arguments.dpi)
    return whole.getbuffer()


def panels(file, only):
    names = [name for name, (_, there) in PANELS.items() if there(file) and (not only or name in only)]
    if not names:
        raise Problem(f"the trajectory has nothing for {', '.join(only)}")
    return names


def main(argv):
    arguments = parse(argv)
    try:
        with open_trajectory(arguments.file, *NEEDED) as file:
            figure = draw(file, panels(file, arguments.only), arguments.title or title_of(file))
        replace(arguments.output, picture(figure, arguments))
        tell(f"picture in {arguments.output}")
    except Problem as problem:
        print(f"nsdae-plot: error: {problem}", file=sys.stderr)
        return 1
    except ValueError as error:  # a title that is no formula, say
        print(f"nsdae-plot: error: cannot draw '{arguments.file}': {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
