"""Table and picture of what bench_phases wrote for two libraries: evaluations of the forces, errors against the 2nd's
own end at rtol 1e-13, times as ratios, and at equal error the ratio that lies between the points.
usage: phases.py OLD.csv NEW.csv OLD_NAME NEW_NAME FILE.svg"""
import csv
import math
import sys

WIDTH, HEIGHT, LEFT, TOP = 190, 130, 58, 24  # of a plot, and where the first is
ACROSS, DOWN = 255, 200  # from one to the next
COLOURS = ("#b22", "#26b")


class Plot:
    """Errors against evaluations, both by logarithms, of whole decades."""

    def __init__(self, index, title, curves):
        self.x0, self.y0 = LEFT + ACROSS * (index % 4), TOP + DOWN * (index // 4)
        self.title, self.curves = title, curves
        every = [p for curve in curves for p in curve]
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
        for curve, colour in zip(self.curves, COLOURS):
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
        for i, (name, colour) in enumerate(zip(names, COLOURS)):
            file.write(f'<circle cx="{x}" cy="{y + 20 * i - 4}" r="4" fill="{colour}"/>')
            file.write(f'<text x="{x + 10}" y="{y + 20 * i}">{name}</text>\n')
        file.write(f'<text x="{x}" y="{y + 60}">error at the end (upwards)</text>\n')
        file.write(f'<text x="{x}" y="{y + 75}">against evaluations of the forces</text>\n</svg>\n')


def read(path):
    runs = {}
    with open(path, newline="") as file:
        for row in csv.reader(file):
            example, rtol = row[0], row[1]
            runs.setdefault(example, {})[rtol] = (int(row[2]), float(row[3]), [float(x) for x in row[4:]])
    return runs


def error(q, exact):
    return max(abs(a - b) for a, b in zip(q, exact))


def points(runs, exact):
    """(rtol, evaluations, seconds, error) of each but the finest."""
    return [(rtol, n, s, error(q, exact)) for rtol, (n, s, q) in runs.items() if rtol != "1e-13"]


def at_error(of, wanted, column):
    """Work at an error, between the points by logarithms; None where no run is as good."""
    good = [p for p in of if p[3] <= wanted]
    if not good:
        return None
    near = min(good, key=lambda p: p[column])
    worse = [p for p in of if p[3] > wanted and p[column] < near[column]]
    if not worse or near[3] <= 0:
        return near[column]
    before = max(worse, key=lambda p: p[column])
    share = math.log(before[3] / wanted) / math.log(before[3] / near[3])
    return before[column] * (near[column] / before[column]) ** share


def main(old_path, new_path, old_name, new_name, target):
    old, new = read(old_path), read(new_path)
    print(f"{'':16} {'':>6} {old_name:>18} {new_name:>18}   {new_name} / {old_name}")
    print(f"{'example':16} {'rtol':>6}" + 2 * f" {'evals':>8} {'error':>9}" + "   evals  time  time at its error")
    plots = []
    for example in new:
        exact = new[example]["1e-13"][2]
        theirs, ours = points(old[example], exact), points(new[example], exact)
        for a, b in zip(theirs, ours):
            equal = at_error(ours, a[3], 2)
            same = f"{equal / a[2]:.2f}" if equal else "-"
            print(
                f"{example:16} {a[0]:>6} {a[1]:8d} {a[3]:9.1e} {b[1]:8d} {b[3]:9.1e}"
                f"   {b[1] / a[1]:5.2f} {b[2] / a[2]:5.2f} {same:>8}"
            )
        plots.append(Plot(len(plots), example, [[(p[1], max(p[3], 1e-16)) for p in of] for of in (theirs, ours)]))
    picture(plots, (old_name, new_name), target)


if __name__ == "__main__":
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    main(*sys.argv[1:])
