"""Table and picture of what bench_phases wrote: evaluations of the forces and errors of each integrator, against dopri5
at rtol 1e-13; times over that of dopri5 at the same rtol. usage: phases.py FILE.csv FILE.svg"""
import csv
import math
import sys

WIDTH, HEIGHT, LEFT, TOP = 190, 130, 58, 24  # of a plot, and where the first is
ACROSS, DOWN = 255, 200  # from one to the next
COLOURS = {"dopri5": "#26b", "dop853": "#2a2", "auto": "#888", "ida": "#b22"}


class Plot:
    """Errors against evaluations, both by logarithms, of whole decades."""

    def __init__(self, index, title, curves):
        self.x0, self.y0 = LEFT + ACROSS * (index % 4), TOP + DOWN * (index // 4)
        self.title, self.curves = title, curves
        every = [p for curve in curves.values() for p in curve]
        self.low = [math.floor(math.log10(min(p[i] for p in every))) for i in (0, 1)]
        self.high = [math.ceil(math.log10(max(p[i] for p in every))) for i in (0, 1)]

    def place(self, point):
        part = [(math.log10(point[i]) - self.low[i]) / max(self.high[i] - self.low[i], 1) for i in (0, 1)]
        return self.x0 + WIDTH * part[0], self.y0 + HEIGHT * (1 - part[1])

    def draw(self):
        x, y = self.x0, self.y0
        yield f'<text x="{x}" y="{y - 4}" font-weight="bold">{self.title}</text>'
        yield f'<rect x="{x}" y="{y}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>'
        for decade in range(self.low[1], self.high[1] + 1, max(1, (self.high[1] - self.low[1]) // 4)):
            at = self.place((10.0 ** self.low[0], 10.0**decade))[1]
            yield f'<text x="{x - 4}" y="{at + 3:.1f}" text-anchor="end" font-size="9">1e{decade}</text>'
        for decade in range(self.low[0], self.high[0] + 1):
            at = self.place((10.0**decade, 10.0 ** self.low[1]))[0]
            yield f'<text x="{at:.1f}" y="{y + HEIGHT + 12}" text-anchor="middle" font-size="9">1e{decade}</text>'
        for integrator, curve in self.curves.items():
            colour = COLOURS[integrator]
            places = [self.place(p) for p in curve]
            yield (
                f'<polyline fill="none" stroke="{colour}" points="'
                + " ".join(f"{a:.1f},{b:.1f}" for a, b in places)
                + '"/>'
            )
            yield from (f'<circle cx="{a:.1f}" cy="{b:.1f}" r="2.5" fill="{colour}"/>' for a, b in places)


def picture(plots, names, target):
    width, height = LEFT + 4 * ACROSS - 50, TOP + 2 * DOWN
    with open(target, "w") as file:
        file.write(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            'font-family="sans-serif" font-size="11">\n<rect width="100%" height="100%" fill="white"/>\n'
        )
        for plot in plots:
            file.writelines(line + "\n" for line in plot.draw())
        x, y = LEFT + 3 * ACROSS, TOP + DOWN + 30
        for i, (name, colour) in enumerate((name, COLOURS[name]) for name in names):
            file.write(f'<circle cx="{x}" cy="{y + 20 * i - 4}" r="4" fill="{colour}"/>')
            file.write(f'<text x="{x + 10}" y="{y + 20 * i}">{name}</text>\n')
        file.write(f'<text x="{x}" y="{y + 90}">error at the end (upwards)</text>\n')
        file.write(f'<text x="{x}" y="{y + 105}">against evaluations of the forces</text>\n</svg>\n')


def read(path):
    """runs[example][integrator][rtol] = evaluations, seconds, state at the end."""
    runs = {}
    with open(path, newline="") as file:
        for example, integrator, rtol, evaluations, seconds, *q in csv.reader(file):
            of = runs.setdefault(example, {}).setdefault(integrator, {})
            of[rtol] = (int(evaluations), float(seconds), [float(x) for x in q])
    return runs


def main(source, target):
    runs, plots = read(source), []
    names = [name for name in COLOURS if name in next(iter(runs.values()))]
    print(f"{'':16} {'':>5} " + " ".join(f"{name:>22}" for name in names))
    print(f"{'example':16} {'rtol':>5} " + " ".join(f"{'evals':>6} {'error':>8} {'time':>6}" for _ in names))
    for example, of in runs.items():
        exact, curves = of["dopri5"].pop("1e-13")[2], {name: [] for name in names}
        for rtol, (_, seconds, _) in of["dopri5"].items():
            line = f"{example:16} {rtol:>5}"
            for name in names:
                evaluations, time, q = of[name][rtol]
                error = max(abs(a - b) for a, b in zip(q, exact))
                curves[name].append((evaluations, max(error, 1e-16)))
                line += f" {evaluations:6d} {error:8.1e} {time / seconds:6.2f}"
            print(line)
        plots.append(Plot(len(plots), example, curves))
    picture(plots, names, target)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
