"""Picture of the table that bench_precision writes. usage: precision.py FILE.csv FILE.png"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

LINES = {"event": "o-", "implicit": "s-", "moreau": "^-"}


def main(source, target):
    with open(source, newline="") as file:
        rows = list(csv.DictReader(file))
    figure, axes = pyplot.subplots(1, 2, figsize=(9, 4), sharex=True, constrained_layout=True)
    for axis, column, title in (
        (axes[0], "impulse_error", "first impulse, relative"),
        (axes[1], "angle_error_rad", "angle at 1 s [rad]"),
    ):
        for method, style in LINES.items():
            own = [row for row in rows if row["method"] == method]
            axis.loglog(
                [float(row["ratio"]) for row in own],
                [float(row[column]) for row in own],
                style,
                label=method,
            )
        axis.set_title("error of the " + title)
        axis.set_xlabel("time, that of event at rtol 1e-8 = 1")
        axis.grid(True, which="major", alpha=0.3)
    axes[0].legend()
    figure.savefig(target, dpi=110)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
