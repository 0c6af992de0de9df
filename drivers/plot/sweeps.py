"""Pictures of a sweep: curves and bifurcation diagrams over one parameter, maps over two."""

import numpy as np

from trajectory import Problem, text

OWN = ("grid", "failure")  # groups that hold no results
CALLED = {"extreme/q_min": "least", "extreme/q_max": "largest", "final/v": "final velocity", "sample/v": "sample velocity",
          "extreme/v_min": "least velocity", "extreme/v_max": "largest velocity"}
HEIGHT, MAP_HEIGHT = 2.2, 3.4  # inches
ROWS_MAX = 12
DOTS_AS_IMAGE = 20000  # more of them are drawn as an image within an SVG or PDF
SAME = 1e-6  # of the spread of all samples: nearer ones are one point of an orbit


def is_sweep(file):
    return text(file.attrs.get("format", "")) == "nsdae-sweep"


def with_unit(name, unit):
    """Names of parameters are not formulas."""
    named = name if unit in ("", "1") or unit.startswith("of the model") else f"{name} [{unit}]"
    return named.replace("$", r"\$")


def dimensions(file):
    """For each dimension of the runs its parameters, as (name, values)."""
    return [[(scale.name.split("/")[-1], scale[...]) for scale in dimension.values()] for dimension in file["status"].dims]


def titles(file):
    """Of each parameter, with its unit."""
    return {name: with_unit(name, text(scale.attrs.get("units", ""))) for name, scale in file["grid"].items()}


def results(file):
    """Every kept quantity by its path."""
    found = {}
    for group in file:
        if group not in OWN and hasattr(file[group], "keys"):
            found.update((f"{group}/{name}", dataset) for name, dataset in file[group].items())
    return found


def chosen(file, only):
    """Those that are asked for, else samples before impacts before the rest without what checks the numbers."""
    found = results(file)
    if only:
        missing = [name for name in only if not any(path == name or path.startswith(name + "/") for path in found)]
        if missing:
            raise Problem(f"the sweep has no '{missing[0]}': it has {', '.join(sorted(found))}")
        return {path: d for path, d in found.items() if any(path == n or path.startswith(n + "/") for n in only)}
    for first in (("sample/q",), ("impact/velocity_after",)):
        if first[0] in found:
            return {path: found[path] for path in first}
    left_out = ("statistics/worst_",) + ("final/v",) * ("final/q" in found)
    return {path: d for path, d in found.items() if not path.startswith(left_out)} or found


def components(path, dataset, rank):
    """(title, values [runs..., points]) of each component of a quantity; points: samples of one run, or one."""
    values = dataset[...]
    unit = text(dataset.attrs.get("units", ""))
    names, units = [path.replace("_", " ")], [unit]
    scales = dataset.dims[len(dataset.shape) - 1] if dataset.ndim > rank else ()
    if len(scales):
        kind, file = scales[0].name, dataset.file
        what = CALLED.get(path, path.split("/")[0])
        names = [f"{what} {text(name)}" for name in scales[0][...]]
        units = [text(u) for u in file[f"{kind}_unit"]] if f"{kind}_unit" in file else [unit] * len(names)
        values = np.moveaxis(values, -1, 0)
    else:
        values = values[None]
    for name, of_name, of in zip(names, units, values):
        yield with_unit(name, of_name), of.reshape(*of.shape[:rank], -1)


def slice_at(file, rank, at):
    """An index into the dimensions of the runs, and what it says: --at NAME=VALUE takes the nearest value."""
    index, said = [slice(None)] * rank, []
    for name, value in at:
        where = [(i, v) for i, of in enumerate(dimensions(file)) for n, v in of if n == name]
        if not where:
            raise Problem(f"--at {name}: the sweep varies {', '.join(n for of in dimensions(file) for n, _ in of)}")
        i, values = where[0]
        index[i] = int(np.argmin(np.abs(values - value)))
        said.append(f"{name} = {values[index[i]]:g}")
    return tuple(index), said


def curve(axes, parameters, title, values):
    """Over one parameter: a line of one value a run, dots of several, dots where the values are drawn at random."""
    name, x = parameters[0]
    points = values.shape[-1]
    ordered = bool(np.all(np.diff(x) > 0))
    if points == 1 and ordered:
        axes.plot(x, values[:, 0], "-" if len(x) > 60 else ".-", linewidth=1, markersize=4)
    else:
        size = 2.0 if values.size < 5000 else 0.6
        (drawn,) = axes.plot(np.repeat(x, points), values.reshape(-1), ".", markersize=size, color="k", markeredgewidth=0)
        drawn.set_rasterized(values.size > DOTS_AS_IMAGE)
    axes.set_xlabel(name)
    axes.set_ylabel(title)
    axes.margins(x=0.01)


def periods(values):
    """How many points the orbit of each run has: samples nearer to each other than a millionth of their spread are
    one."""
    spread = np.nanmax(values) - np.nanmin(values) if np.isfinite(values).any() else 0
    ordered = np.sort(values, axis=-1)
    count = 1.0 + np.sum(np.diff(ordered, axis=-1) > SAME * (spread or 1), axis=-1)
    return np.where(np.isnan(values).any(axis=-1), np.nan, count)


def surface(figure, axes, parameters, title, values):
    """Over two parameters: colours; of several values a run the number of different ones."""
    (x_name, x), (y_name, y) = parameters[1][0], parameters[0][0]
    if values.shape[-1] > 1:
        title, values = f"points of {title}", periods(values)[..., None]
    mesh = axes.pcolormesh(x, y, values[..., 0], shading="nearest", rasterized=True)
    figure.colorbar(mesh, ax=axes, label=title)
    axes.set_xlabel(x_name)
    axes.set_ylabel(y_name)


def scatter(figure, axes, parameters, title, values):
    """Over two parameters that are drawn together."""
    (x_name, x), (y_name, y) = parameters[:2]
    dots = axes.scatter(x, y, c=values[:, 0], s=4, rasterized=len(x) > DOTS_AS_IMAGE)
    figure.colorbar(dots, ax=axes, label=title)
    axes.set_xlabel(x_name)
    axes.set_ylabel(y_name)


def title_of(file, said):
    failed = int(np.sum(file["status"][...] < 0))
    left = int(np.sum(file["status"][...] > 0))
    parts = [text(file.attrs.get(name, "")) for name in ("model", "method")] + said
    parts += [f"{failed} runs failed"] * (failed > 0) + [f"{left} runs not done"] * (left > 0)
    return ", ".join(part for part in parts if part).replace("$", r"\$")


def draw(file, only=None, title=None, at=()):
    """The picture of a sweep, as a figure."""
    rank = file["status"].ndim
    index, said = slice_at(file, rank, at)
    free = [of for of, i in zip(dimensions(file), index) if isinstance(i, slice)]
    if not 1 <= len(free) <= 2:
        raise Problem(f"the sweep varies {len(free)} dimensions ({'; '.join(', '.join(n for n, _ in of) for of in free)}): "
                      "fix all but one or two with --at NAME=VALUE")
    free = [[(titles(file)[name], values) for name, values in of] for of in free]
    rows = [(name, values[index]) for path, dataset in chosen(file, only).items()
            for name, values in components(path, dataset, rank)]
    if len(rows) > ROWS_MAX:
        raise Problem(f"these are {len(rows)} pictures: choose with --only, e.g. --only {sorted(results(file))[0]}")
    flat = len(free) == 1 and len(free[0]) < 2
    height = (HEIGHT if flat else MAP_HEIGHT) * len(rows) + 0.8
    import matplotlib.pyplot as plt  # reading a sweep does not need it
    figure, axes = plt.subplots(len(rows), 1, squeeze=False, figsize=(8, height), layout="constrained")
    for axis, (name, values) in zip(axes[:, 0], rows):
        if len(free) == 2:
            surface(figure, axis, free, name, values)
        elif flat:
            curve(axis, free[0], name, values)
        else:
            scatter(figure, axis, free[0], name, values)
    figure.suptitle(title or title_of(file, said))
    return figure
