"""Picture of the table that bench_dae writes, beside the published digits of MEBDFI. usage: dae.py FILE.csv FILE.svg"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.fonttype"] = "none"
from matplotlib import pyplot

STYLES = {"dopri5": "o-", "dop853": "s-", "ida": "^-"}
# (residuals, digits) as published in the Test Set for IVP Solvers
MEBDFI = {
    "squeezer": [(993, 4.0), (2026, 5.5), (2564, 5.8)],
    "car-axis": [(2216, 2.5), (5629, 4.7)],
    "flexible-crank": [(37327, 1.8)],
}


def main(source, target):
    with open(source, newline="") as file:
        rows = list(csv.DictReader(file))
    figure, axes = pyplot.subplots(2, 3, figsize=(10, 6.5), sharex="col", constrained_layout=True)
    for (upper, lower), (problem, published) in zip(axes.T, MEBDFI.items()):
        for integrator, style in STYLES.items():
            own = [row for row in rows if row["problem"] == problem and row["integrator"] == integrator]
            if not own:
                continue
            digits = [float(row["digits_q"]) for row in own]
            upper.semilogy(digits, [float(row["forces"]) for row in own], style, label=integrator)
            lower.semilogy(digits, [float(row["ms"]) for row in own], style)
        upper.semilogy([d for _, d in published], [n for n, _ in published], "kx--", label="MEBDFI (published)")
        upper.set_title(problem)
        lower.set_xlabel("correct digits of q")
        for axis in (upper, lower):
            axis.grid(True, which="major", alpha=0.3)
    axes[0, 0].set_ylabel("evaluations of the forces")
    axes[1, 0].set_ylabel("CPU time [ms]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="upper center", ncol=4, bbox_to_anchor=(0.5, 0))
    figure.savefig(target, bbox_inches="tight")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
