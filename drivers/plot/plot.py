"""Pictures of an nsdae trajectory or sweep: coordinates, velocities, modes of contacts, forces, impulses, energy, certificate."""

import contextlib
import io
import itertools
import os
import sys
import warnings

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

import sweeps
from bodies import COLOURS, WHOLE, bodies_of, colours_of, names_of, read_rows
from choice import BAND, LEGEND_MAX, Choice
from contacts import contacts_of, step_length
from formula import evaluate
from modes import MODE_COLOURS, MODES, has_strips, kinds_of, strips
from trajectory import Parser, Problem, has_list, heading, names_of_rows, open_trajectory, reading, replace, tell, text

FORMATS = (".png", ".svg", ".pdf")
NEEDED = ("v", "energy/kinetic", "energy/dissipated", "certificate", "impact/time")
POINTS_MAX = 20000  # more than this of a line are drawn as an image within an SVG or PDF
COLUMN_MAX = 8  # of them beside a row of its height
STRIPS_MAX = 24
IMPACTS_MAX = 100  # drawn impacts
NAMES_MAX = 12  # in a message
RECORDS_MAX = 240  # of a large system's
DOTS_MAX = 20000
ROUNDING = np.finfo(float).eps
HEIGHT, LOW, STRIP_HEIGHT = 1.8, 1.2, 0.26  # inches


class Row:
    """A row of the picture: its axis has one unit."""

    def __init__(self, title, draw, height=HEIGHT, note=""):
        self.title, self.draw, self.height, self.note = title, draw, height, note


def titled(name, unit):
    return name if unit in ("", "1") or unit.startswith("of the model") else f"{name} [{plain(unit)}]"


def plain(name):
    """As it is, not as a formula."""
    return name.replace("$", r"\$")


def line(axes, time, values, name, **look):
    axes.plot(time, values, label=plain(name), **{"linewidth": 1.2, **look})


def some(dataset, time):
    """Records that are shown of a dataset: all, or some hundred where it is large."""
    n = len(time)
    return np.arange(n) if dataset.size <= WHOLE else np.unique(np.linspace(0, n - 1, RECORDS_MAX).round().astype(int))


def band(axes, time, values, kind):
    """Of many columns [n, c] the range and the median."""
    axes.fill_between(time, values.min(axis=1), values.max(axis=1), color="0.9", linewidth=0,
                      label=f"all {values.shape[1]}")
    axes.fill_between(time, *np.quantile(values, (0.25, 0.75), axis=1), color="0.75", linewidth=0, label="half of them")
    line(axes, time, np.median(values, axis=1), f"median {kind}")


DASHES = ("-", "--", ":", "-.")  # of the columns of one body


def looks_of(file):
    """Of each column of q that places a body: the body's colour, as in an animation. A column belongs to the first
    body that it places."""
    looks = {}
    with contextlib.suppress(Problem):  # without bodies
        bodies = bodies_of(file, "", None, file["time"][:1], file["q"][:1])
        for body, colour in zip(bodies, colours_of(bodies)):
            looks.update((column, colour) for column in body.columns if colour and column not in looks)
    return looks


def look_of(colour, number=0):
    return {"color": colour, "linestyle": DASHES[number % len(DASHES)]} if colour else {}


def coordinate_of(file, column):
    """Column of the coordinate whose rate is a velocity; in space of a rotation its first."""
    nq, nv = file["q"].shape[1], file["v"].shape[1]
    if nq == nv:
        return column
    body, entry = divmod(column, 6)
    return 7 * body + min(entry, 3) if nq * 6 == nv * 7 else None


def rows_of(title, when, values, names, units, kind, choice, look):
    """A row for each unit of the columns: lines, or of very many a band. look(i, used): of a column."""
    rows = []
    for unit in dict.fromkeys(units):
        mine = [i for i in range(len(names)) if units[i] == unit]
        if choice.banded(len(mine)):
            rows.append(Row(titled(title, unit), lambda axes, mine=mine: band(axes, when, values[:, mine], kind)))
            continue
        drawn, note = choice.of([names[i] for i in mine], values[:, mine])
        drawn = [mine[i] for i in drawn]

        def lines(axes, drawn=drawn):
            used = []
            for i in drawn:
                line(axes, when, values[:, i], names[i], **look(i, used))

        rows += [Row(titled(title, unit), lines, note=note)] if drawn else []
    return rows


def by_unit(file, time, kind, path, title, choice):
    """A row for each unit of the columns of a dataset."""
    records = some(file[path], time)
    values, when = read_rows(file[path], records), time[records]
    colours = looks_of(file) if values.shape[1] <= 4 * BAND else {}
    names = names_of_rows(file, kind, values.shape[1])
    units = [text(u) for u in file.get(f"{kind}_unit", [])][: len(names)]
    units += [text(file[path].attrs.get("units", ""))] * (len(names) - len(units))

    def look(i, used):
        colour = colours.get(i if kind == "coordinate" else coordinate_of(file, i))
        used.append(colour)
        return look_of(colour, used.count(colour) - 1)

    few = len(names) <= LEGEND_MAX or choice.names  # of many bodies no entries of quaternions
    rows = rows_of(title, when, values, names, units, kind, choice, look)
    return [row for row in rows if few or row.title != title]


def coordinates(file, time, choice):
    return by_unit(file, time, "coordinate", "q", "coordinates", choice)


def velocities(file, time, choice):
    return by_unit(file, time, "velocity", "v", "velocities", choice)


def steps(file, time):
    """How long the step was that ends at each record [n]: where only every N-th was kept, the last of them."""
    length = np.diff(time, prepend=time[0])
    return np.minimum(length, file["options/dt"][()]) if "options/dt" in file else length


def struck(file, time):
    """Of each record [n] whether the step that ends there had an impact."""
    when = file["impact/time"][...]
    at = np.searchsorted(time, when)
    when, at = when[at < len(time)], at[at < len(time)]
    return np.isin(np.arange(len(time)), at[when > time[at] - steps(file, time)[at] * (1 + 1e-9)])


FORCE = {"m": "N", "rad": "N m", "1": "N m"}  # of a constraint of that unit: their product is a work


def multipliers(file, time, choice):
    """A row for each unit. Steps with an impact, whose multipliers are impulses, and the start are left out."""
    records = some(file["multiplier"], time)
    left_out = struck(file, time) | (steps(file, time) <= 0)
    records = records[~left_out[records]] if file["multiplier"].shape[1] > BAND else records
    values = np.where(left_out[records, None], np.nan, read_rows(file["multiplier"], records))
    names = names_of_rows(file, "constraint", values.shape[1])
    if len(names) <= BAND and choice.leaves_out("multipliers", len(names), "forces of constraints"):
        return []
    units = [FORCE.get(text(u), "") for u in file.get("constraint_unit", [])][: len(names)]
    units += [""] * (len(names) - len(units))
    return rows_of("mean forces of\nconstraints", time[records], values, names, units, "constraint", choice, lambda i, used: {})


def impacts(file, *names):
    """Datasets of the impacts, as long as the shortest: a file that is being written grows between two readings."""
    columns = [file[f"impact/{name}"][...] for name in names]
    return [column[:min(map(len, columns))] for column in columns]


def modes(file, time, choice):
    """Stick, slip and open as a strip for each contact; impacts are ticks in it."""
    shown = strips(file, time, np.unique(np.linspace(0, len(time) - 1, 2000).astype(int)))
    shown = [strip for strip in shown if not choice.names or choice.asks_for(strip["name"])][:STRIPS_MAX]
    when, which = impacts(file, "time", "id")

    def draw(axes):
        for row, strip in enumerate(shown):
            for mode, colour in enumerate(MODE_COLOURS):
                pieces = [(a, b - a) for a, b, m in strip["spans"] if m == mode]
                axes.broken_barh(pieces, (row - 0.38, 0.76), color=colour, linewidth=0)
            hit = when[which == strip["number"]] if strip["kind"] == "contact" else []
            axes.vlines(hit, row - 0.38, row + 0.38, color="k", linewidth=0.7)
        axes.set_yticks(range(len(shown)), [plain(strip["name"]) for strip in shown], fontsize="small")
        axes.set_ylim(len(shown) - 0.4, -0.6)
        keys = [plt.Rectangle((0, 0), 1, 1, color=colour, label=name) for name, colour in zip(MODES, MODE_COLOURS)]
        if len(when):
            keys.append(plt.Line2D([], [], color="k", linewidth=0.7, label="impact"))
        outside(axes, handles=keys)

    return [Row("", draw, max(STRIP_HEIGHT * (len(shown) + 1), 0.9))]


def forces(file, time, choice):
    """Mean forces of contacts and frictional joints between impacts: the impulse of a step over its length. Steps with an
    impact are left out, because an impact elsewhere also causes impulses in closed contacts."""
    step, hit = steps(file, time), struck(file, time)
    lines = []
    for kind, path, symbol in (("contact", "contacts/normal_impulse", "normal"),
                               ("contact", "contacts/tangential_impulse", "friction"),
                               ("frictional_joint", "frictional_joint/impulse", "friction")):
        if path not in file or kind not in kinds_of(file):
            continue
        impulse = file[path][: len(time)]
        rest = impulse.reshape(len(time), impulse.shape[1], -1)
        for i, row in enumerate(names_of_rows(file, kind, impulse.shape[1])):
            for j in range(rest.shape[2]):
                number = f" {j}" if rest.shape[2] > 1 else ""
                lines.append((rest[:, i, j], f"{row}, {symbol}{number}", "-" if symbol == "normal" else "--"))

    lines = [one for one in lines if np.any(one[0][~hit] != 0)]
    if choice.leaves_out("forces", len(lines), "forces of contacts and friction"):
        return []
    means = np.array([np.divide(values, step, out=np.full(len(time), np.nan), where=(step > 0) & ~hit) for values, *_ in lines])
    drawn, note = choice.of([name for _, name, _ in lines], means.T) if lines else ([], "")

    def draw(axes):
        for i in drawn:
            line(axes, time, means[i], lines[i][1], linestyle=lines[i][2], linewidth=1)
        axes.axhline(0, color="0.8", linewidth=0.6, zorder=0)

    return [Row("mean contact\nforces [N]", draw, note=note)] if drawn else []


def listed(file, time, choice):
    """Of a contact list the number of closed contacts and their mean forces over a step. Steps with an impact are left
    out, as above, unless they are the majority."""
    records, dt = some(file["contacts/id"], time), step_length(file)
    found = [contacts_of(file, int(record)) for record in records]
    counts = np.array([[np.count_nonzero(c.mode == mode) for mode in range(len(MODES))] for c in found])
    force = np.array([[np.max(c.normal, initial=0), np.median(c.normal) if len(c.normal) else 0] for c in found]) / dt
    hit = struck(file, time)[records]
    with_impacts = np.mean(hit) > 0.5
    force[(hit & ~with_impacts) | (steps(file, time)[records] <= 0)] = np.nan
    title = "mean forces\nwith impacts [N]" if with_impacts else "mean contact\nforces [N]"

    def number(axes):
        axes.stackplot(time[records], counts[:, ::-1].T, labels=[MODES[2], MODES[1], "without force"],
                       colors=[MODE_COLOURS[2], MODE_COLOURS[1], "0.8"])
        axes.set_ylim(bottom=0)

    def largest(axes):
        line(axes, time[records], force[:, 0], "largest normal")
        line(axes, time[records], force[:, 1], "median normal")
        axes.set_ylim(bottom=0)

    return [Row("closed\ncontacts", number), Row(title, largest)]


def listed_impulses(file, time):
    """Of all impacts, the strongest ones where they are many."""
    when, values = impacts(file, "time", "normal_impulse")
    strongest = np.argsort(-values, kind="stable")[:DOTS_MAX]

    def draw(axes):
        axes.plot(when[strongest], values[strongest], ".", markersize=2, label="normal", rasterized=True)
        axes.set_ylim(bottom=0)

    return [Row("impulses of\nimpacts [N s]", draw)]


def impulses(file, time, choice):
    """Of impacts, as they are."""
    if has_list(file):
        return listed_impulses(file, time)
    rubs = ["tangential_impulse"] if "impact/tangential_impulse" in file else []
    when, which, normal, *tangential = impacts(file, "time", "id", "normal_impulse", *rubs)
    names = names_of_rows(file, "contact", int(which.max()) + 1)
    tangential = tangential[0].reshape(len(when), -1) if rubs else np.zeros((len(when), 0))

    def stems(axes, t, values, name, marker):
        if np.any(values != 0):
            (drawn,) = axes.plot(t, values, marker, markersize=3.5, label=plain(name), linestyle="none")
            axes.vlines(t, 0, values, color=drawn.get_color(), linewidth=0.8, alpha=0.7)

    def draw(axes):
        for i, name in enumerate(names):
            mine = which == i
            stems(axes, when[mine], normal[mine], f"{name}, normal", "o")
            for j in range(tangential.shape[1]):
                number = f" {j}" if tangential.shape[1] > 1 else ""
                stems(axes, when[mine], tangential[mine, j], f"{name}, friction{number}", "x")
        axes.axhline(0, color="0.8", linewidth=0.6, zorder=0)

    return [Row("impulses of\nimpacts [N s]", draw)]


def energy(file, time, choice):
    """The potential is counted from the start: only its changes mean something."""
    values = {name: dataset[: len(time)] for name, dataset in file["energy"].items()}

    def draw(axes):
        line(axes, time, values["kinetic"], "kinetic")
        if "potential" in values:
            potential = values["potential"] - values["potential"][0]
            line(axes, time, potential, "potential - start")
            line(axes, time, values["kinetic"] + potential, "their sum", linewidth=2.6, color="0.75", zorder=1)
        line(axes, time, values["dissipated"], "dissipated", linestyle="--")

    return [Row("energy [J]", draw)]


def certificate(file, time, choice):
    """What rounding alone explains is drawn at rounding."""
    group = file["certificate"]
    reach = max(float(np.max(np.abs(read_rows(file["q"], some(file["q"], time))), initial=0)), 1e-300)
    shown_as = {"lcp_residual": "LCP residual"}
    shown = {name: group[name][: len(time)] for name in ("lcp_residual", "constraint_drift", "penetration") if name in group}

    def draw(parts, floor, said):
        def dots(axes):
            drawn = []
            for name in parts:
                there = shown[name] > 0
                drawn.append(np.maximum(shown[name][there], floor))
                axes.plot(time[there], drawn[-1], ".", markersize=2.5, label=shown_as.get(name, plain(name.replace("_", " "))))
            least, most = (fold(np.concatenate(drawn)) for fold in (np.min, np.max))
            axes.set_yscale("log")
            axes.set_ylim(least / 3, max(3 * most, 30 * least))
            if least <= floor:
                axes.axhline(floor, color="0.7", linewidth=0.7, linestyle=":", label=said)

        return dots

    rows = []
    if np.any(shown["lcp_residual"] > 0):
        rows.append(Row("residual", draw(["lcp_residual"], ROUNDING, "rounding, or below"), LOW))
    lengths = [name for name in ("constraint_drift", "penetration") if np.any(shown[name] > 0)]
    if lengths:
        rows.append(Row("errors of\nposition [m]", draw(lengths, ROUNDING * reach, "rounding of q, or below"), LOW))
    return rows


def always(file):
    return True


PANELS = {
    "coordinates": (coordinates, always),
    "velocities": (velocities, always),
    "multipliers": (multipliers, lambda file: "multiplier" in file),
    "modes": (modes, has_strips),
    "forces": (forces, has_strips),
    "contacts": (listed, has_list),
    "impulses": (impulses, lambda file: len(file["impact/time"]) > 0),
    "energy": (energy, always),
    "certificate": (certificate, always),
}


SECOND = ("energy", "certificate")  # what checks the run: a picture of its own


def outside(axes, **what):
    columns = 1 if len(what.get("handles", axes.get_legend_handles_labels()[0])) <= COLUMN_MAX else 2
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False, ncol=columns, **what)


def title_of(file, path=""):
    title, status = heading(file, path), text(file.attrs.get("status", ""))
    if "options/dt" in file:
        title += f", dt {file['options/dt'][()]:g} s"
    if status != "complete":
        title += f" ({status})"
    return plain(title)


def mark_impacts(axes, file):
    when = file["impact/time"][...]
    if len(when) <= IMPACTS_MAX:
        for t in when:
            axes.axvline(t, color="0.88", linewidth=0.6, zorder=0)


def records(file):
    """How many there are of everything: while a run writes along, some datasets are ahead."""
    names = ["time", "q", "v", "multiplier", "frictional_joint/impulse", "frictional_joint/mode"]
    names += [] if has_list(file) else [f"contacts/{name}" for name in ("gap", "normal_impulse", "tangential_impulse", "mode")]
    for group in ("energy", "certificate"):
        names += [f"{group}/{name}" for name in file.get(group, {})]
    length = {name: len(file[name]) for name in names if name in file}
    number = min(n for name, n in length.items() if grows(file[name]))
    for name, n in length.items():
        if n < number:
            raise Problem(f"'{file.filename}' is damaged: /{name} has {n} records of {number}")
    return number


def grows(dataset):
    return dataset.maxshape[:1] == (None,)


def draw(file, names, title, wanted=None, asked=None):
    """wanted, asked: patterns of the names of what is drawn, panels that were asked for, see Choice."""
    time, choice = file["time"][: records(file)], Choice(wanted, asked)
    rows = [row for name in names for row in PANELS[name][0](file, time, choice)]
    choice.check()
    if not rows:
        raise Problem(f"the trajectory has nothing for {', '.join(names)}")
    heights = [row.height for row in rows]
    figure, axes = plt.subplots(len(rows), 1, sharex=True, squeeze=False, figsize=(9, 0.8 + sum(heights)),
                                layout="constrained", gridspec_kw={"height_ratios": heights})
    for axis, row in zip(axes[:, 0], rows):
        mark_impacts(axis, file)
        row.draw(axis)
        axis.set_ylabel(row.title)
        axis.margins(x=0.01)
        for drawn in axis.lines + axis.collections:
            drawn.set_rasterized(len(time) > POINTS_MAX)
        axis.spines[["top", "right"]].set_visible(False)
        if axis.get_legend() is None and 0 < len(axis.get_legend_handles_labels()[0]) <= LEGEND_MAX:
            outside(axis, title=row.note or None, title_fontsize="small", alignment="left")
    left_out = f"\nleft out: {', '.join(choice.left_out)}" if choice.left_out else ""
    axes[-1, 0].set_xlabel("time [s]" + left_out)
    figure.suptitle(title)
    figure.align_ylabels()
    return figure


def velocity_of(file, column):
    """Column of the velocity that is the rate of a coordinate: the same one, or in space that of a body's position."""
    nq, nv = file["q"].shape[1], file["v"].shape[1]
    if nq == nv:
        return column
    body, entry = divmod(column, 7)
    return 6 * body + entry if nq * 6 == nv * 7 and entry < 3 else None


def draw_phase(axis, file, name):
    """Velocity over coordinate; an impact is a line straight up or down."""
    number = records(file)
    coordinates, velocities = (names_of_rows(file, kind, file[path].shape[1]) for kind, path in (("coordinate", "q"), ("velocity", "v")))
    units = [[text(unit) for unit in file.get(f"{kind}_unit", [])] for kind in ("coordinate", "velocity")]
    if name not in coordinates:
        raise Problem(f"no coordinate is called '{name}': they are {', '.join(coordinates)}")
    i = coordinates.index(name)
    j = velocity_of(file, i)
    if j is None:
        raise Problem(f"'{name}' has no velocity of its own")
    line(axis, file["q"][:number, i], file["v"][:number, j], name, linewidth=0.9, **look_of(looks_of(file).get(i)))
    axis.set_xlabel(titled(plain(name), *(unit for unit in units[0][i:i + 1] or [""])))
    axis.set_ylabel(titled("velocity of " + plain(velocities[j]), *(unit for unit in units[1][j:j + 1] or [""])))


def path_of(name, bodies, values):
    """x and y of the centre of a body, or of a point X,Y: two formulas of the coordinates."""
    body = next((body for body in bodies if body.name == name), None)
    if body is not None:
        centre = body.position if body.end is None else (body.position + body.end) / 2
        return centre[..., 0], centre[..., 1]
    if name.count(",") != 1:
        known = f"they are {', '.join(body.name for body in bodies[:NAMES_MAX])}; " if bodies else ""
        raise Problem(f"no body is called '{name}': {known}a point is X,Y, two formulas of the coordinates")
    return [evaluate(formula, values) for formula in name.split(",")]


def draw_paths(axis, file, names):
    """y over x of bodies and points, with a mark at the start; a point has a colour that no body has before it."""
    shown = some(file["q"], file["time"][: records(file)])
    time, q = file["time"][...][shown], read_rows(file["q"], shown)
    bodies = bodies_of(file, file.filename, None, time, q) if "bodies" in file or "shapes" in file else []
    colours = dict(zip((body.name for body in bodies), colours_of(bodies)))
    others = itertools.cycle([c for c in COLOURS if c not in colours.values()] or COLOURS)
    for name in names:
        x, y = (np.broadcast_to(values, len(time)) for values in path_of(name, bodies, names_of(file, time, q)))
        colour = (colours[name] or "0.5") if name in colours else next(others)
        line(axis, x, y, name, linewidth=0.9, color=colour, marker="o", markersize=4, markevery=[0])
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    outside(axis)


def portraits(file, phases, paths, title):
    """Phase portraits, one for each name, and one picture of all paths."""
    drawn = [lambda axis, name=name: draw_phase(axis, file, name) for name in phases or ()]
    drawn += [lambda axis: draw_paths(axis, file, paths)] if paths else []
    figure, axes = plt.subplots(len(drawn), 1, squeeze=False, figsize=(7, 0.8 + 4.5 * len(drawn)), layout="constrained")
    for axis, draw_it in zip(axes[:, 0], drawn):
        draw_it(axis)
        axis.spines[["top", "right"]].set_visible(False)
    figure.suptitle(title)
    return figure


def parameter_at(word):
    name, value = word.split("=")
    return name, float(value)


parameter_at.__name__ = "value of a parameter (NAME=VALUE)"  # argparse quotes it


def parse(argv):
    parser = Parser(prog="nsdae-plot", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="file", help="trajectory, e.g. pendulum.h5")
    parser.add_argument("-o", "--output", help="picture of one file: .png, .svg or .pdf; default FILE.png")
    parser.add_argument("--only", action="append", metavar="PANEL",
                        help=f"draw this panel ({', '.join(PANELS)}), or this quantity of a sweep, e.g. final/q; repeatable")
    parser.add_argument("--name", action="append", metavar="PATTERN",
                        help="draw these coordinates, velocities, constraints and contacts, e.g. 'z*'; repeatable; "
                        "default all, or of more than 12 the 6 that vary most")
    parser.add_argument("--at", action="append", default=[], type=parameter_at, metavar="NAME=VALUE",
                        help="for a sweep: the runs with the nearest value of this parameter; repeatable")
    parser.add_argument("--certificate", action="store_true", help="energy and certificate in place of motion and forces")
    parser.add_argument("--phase", action="append", metavar="NAME",
                        help="phase portrait: velocity over this coordinate; repeatable")
    parser.add_argument("--path", action="append", metavar="BODY_OR_POINT",
                        help="path of this body's centre, or of the point X,Y, two formulas of the coordinates; repeatable")
    parser.add_argument("--title", help="title, by default model, method and step")
    parser.add_argument("--dpi", type=int, default=150, help="dots per inch of a PNG, 20 to 1200 (default 150)")
    parser.add_argument("--version", action="version", version="nsdae-plot @PROJECT_VERSION@")
    arguments = parser.parse_args(argv)
    if not 20 <= arguments.dpi <= 1200:
        parser.error(f"--dpi {arguments.dpi} is outside its range: it must be 20 to 1200")
    unknown = [name for name in arguments.only or () if name not in PANELS and "/" not in name]
    if unknown:
        parser.error(f"--only '{unknown[0]}': a panel is one of {', '.join(PANELS)}; a sweep's quantity has a '/'")
    if arguments.output and len(arguments.files) > 1:
        parser.error(f"--output is for one file, not {len(arguments.files)}")
    if arguments.output is not None and not arguments.output.lower().endswith(FORMATS):
        parser.error(f"--output '{arguments.output}' must end with {', '.join(FORMATS)}")
    arguments.file = arguments.files[0]
    return arguments


def picture(figure, output, dpi):
    """The file's bytes."""
    whole = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of names with characters that the font has not
        figure.savefig(whole, format=output[-3:].lower(), dpi=dpi)
    plt.close(figure)
    return whole.getbuffer()


def panels(file, only, certificate=False):
    """The panels of a picture: those that are asked for; else motion and forces, or energy and certificate."""
    chosen = only or [name for name in PANELS if (name in SECOND) == certificate]
    names = [name for name, (_, there) in PANELS.items() if there(file) and name in chosen]
    if not names:
        raise Problem(f"the trajectory has nothing for {', '.join(chosen)}")
    return names


def figure_of(arguments):
    with reading(arguments.file) as file:
        if sweeps.is_sweep(file):
            return sweeps.draw(file, arguments.only, arguments.title, arguments.at)
    with open_trajectory(arguments.file, *NEEDED) as file:
        title = arguments.title or title_of(file, arguments.file)
        if arguments.phase or arguments.path:
            return portraits(file, arguments.phase, arguments.path, title)
        return draw(file, panels(file, arguments.only, arguments.certificate), title, arguments.name, arguments.only)


def main(argv):
    arguments = parse(argv)
    matplotlib.use("Agg")  # no window, whatever the user's own choice is
    try:
        for arguments.file in arguments.files:
            output = arguments.output or os.path.splitext(arguments.file)[0] + ".png"
            replace(output, picture(figure_of(arguments), output, arguments.dpi))
            tell(f"picture in {output}")
    except Problem as problem:
        print(f"nsdae-plot: error: {problem}", file=sys.stderr)
        return 1
    except ValueError as error:  # a title that is no formula, say
        print(f"nsdae-plot: error: cannot draw '{arguments.file}': {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
