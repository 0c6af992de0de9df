"""What a sweep holds, against a single run, closed forms and an exact map of the ball on a shaking table.
usage: sweep_check.py GRID SINGLE SHAKEN FAILED DRAWS"""

import math
import sys

import h5py
import numpy as np

failures = []


def expect(what, holds):
    if not holds:
        failures.append(what)


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def scales(dataset):
    return [[s.name for s in d.values()] for d in dataset.dims]


def check_grid(grid, single):
    h0, e = grid["grid/h0"][...], grid["grid/e_N"][...]
    q = grid["final/q"]
    expect("shape", q.shape == (600, 2, 1) and h0[0] == 0.5 and h0[-1] == 2 and np.allclose(np.diff(h0), 1.5 / 599))
    expect("scales", scales(q) == [["/grid/h0"], ["/grid/e_N"], ["/coordinate"]])
    units = [text(grid[f"grid/{name}"].attrs["units"]) for name in ("h0", "e_N")] + [text(u) for u in grid["coordinate_unit"]]
    expect("units", units == ["m", "1", "m"] and [text(u) for u in grid["velocity_unit"]] == ["m/s"])
    expect("status", not grid["status"][...].any() and grid.attrs["status"] in (b"complete", "complete"))
    expect("the run by itself has the same end", q[-1, 0, 0] == single["q"][-1, 0] and
           grid["final/v"][-1, 0, 0] == single["v"][-1, 0])
    impacts = single["impact/time"][...]
    expect("and the same impacts", np.array_equal(grid["impact/time"][-1, 0], impacts[-4:]) and
           grid["statistics/impacts"][-1, 0] == len(impacts))
    # a step of 0.005 s finds an impact up to a step late
    first = np.sqrt(2 * h0 / 9.81)
    many = grid["statistics/impacts"][:, 1]
    expect("impacts by then", np.all(many >= 1) and np.all(np.diff(grid["impact/time"][...][:, 1], axis=-1)[many >= 4] > 0))
    expect("e is an axis", e.tolist() == [0.3, 0.9] and first[0] < 2.5)


def flight(t, v, amplitude, w, phase, g):
    """Time of the next impact after one at t that left with v (of the ball): the first root of the gap behind t."""
    def gap(tau):
        y = amplitude * math.sin(w * t + phase) + v * tau - g * tau * tau / 2
        return y - amplitude * math.sin(w * (t + tau) + phase)

    step = 2 * math.pi / w / 400
    tau = step
    while gap(tau) > 0:
        tau += step
    low, high = tau - step, tau
    if low <= 0:
        low = 1e-12
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if gap(middle) > 0 else (low, middle)
    return t + high


def exact_orbit(gamma, e=0.5, period=0.02, g=9.81, impacts=290, last=16):
    """Relative velocities after the last impacts, by the map of impacts alone; None where it is no flight any more."""
    w = 2 * math.pi / period
    amplitude = gamma * g / w**2
    phase = math.acos(math.pi * (1 - e) / (1 + e) / gamma)
    t, v, after = 0.0, 1.01 * g * period / 2, []
    for _ in range(impacts):
        begin = t
        t = flight(t, v, amplitude, w, phase, g)
        table = amplitude * w * math.cos(w * t + phase)
        after.append(-e * (v - g * (t - begin) - table))
        v = table + after[-1]
    return np.array(after[-last:])


SECOND = 1.666  # by this map: two points at 1.664, four at 1.668, eight at 1.700


def points(values, spread=1e-4):
    """How many different ones."""
    ordered = np.sort(values)
    return 1 + int(np.sum(np.diff(ordered) > spread * np.max(np.abs(values))))


def check_shaken(file):
    gamma, v = file["grid/gamma"][...], file["impact/velocity_after"][...]
    e = 0.5
    low = math.pi * (1 - e) / (1 + e)
    double = math.hypot(low, 2 * (1 + e * e) / (1 + e) ** 2)
    once = 9.81 * 0.02 / 2
    seen = set()
    for i, (g, run) in enumerate(zip(gamma, v)):
        orbit = exact_orbit(g)
        count = points(run)
        if abs(g - double) > 0.02 and abs(g - SECOND) > 0.012:  # near a doubling it settles too slowly
            expect(f"gamma {g:.3f}: {count} points, by the map {points(orbit)}", count == points(orbit))
            seen.add(count)
        if abs(g - double) > 0.02 and abs(g - SECOND) > 0.012:
            expect(f"gamma {g:.3f}: the velocities of the map", np.allclose(np.sort(run), np.sort(orbit), rtol=2e-5))
        if g < double - 0.02:  # leaves with g T / 2 against the table's A w cos(phi)
            table = g * 9.81 * 0.02 / (2 * math.pi) * (low / g)
            expect(f"gamma {g:.3f}: once a period", np.allclose(run, once - table, rtol=1e-6))
        sample = file["sample/q"][i, :, 0]
        expect(f"gamma {g:.3f}: samples repeat as impacts do",
               count != 1 or np.ptp(sample) < 1e-7)
        expect("extremes", np.all(file["extreme/q_min"][i] <= sample.min()) and np.all(file["extreme/q_max"][i] >= sample.max()))
    expect(f"one, two and four points are seen: {seen}", {1, 2, 4} <= seen)


def check_failed(file):
    status, run = file["status"][...], file["failure/run"][...]
    expect("failed runs are listed in order", run.tolist() == np.flatnonzero(status < 0).tolist() and len(run) > 0)
    expect("some runs did not fail", np.any(status == 0))
    expect("what failed has no numbers", np.isnan(file["final/q"][...][status < 0]).all())
    expect("the others have", np.isfinite(file["final/q"][...][status == 0]).all())
    expect("reasons", all(len(reason) > 10 for reason in file["failure/reason"]))


def check_draws(file):
    h0, e = file["grid/h0"][...], file["grid/e_N"][...]
    expect("in their range", np.all((h0 >= 0.5) & (h0 < 2)) and np.all((e >= 0) & (e < 1)))
    # of 200 independent uniform draws: mean within 5 standard errors, correlation within 5
    expect("mean", abs(np.mean(h0) - 1.25) < 5 * 1.5 / math.sqrt(12 * 200) and abs(np.mean(e) - 0.5) < 5 / math.sqrt(12 * 200))
    expect("independent", abs(np.corrcoef(h0, e)[0, 1]) < 5 / math.sqrt(200))
    free = np.sqrt(2 * h0 / 9.81) > 0.5
    expect("those that fall freely", np.allclose(file["final/q"][free, 0], h0[free] - 9.81 / 8, rtol=1e-9))


def main(argv):
    grid, single, shaken, failed, draws = (h5py.File(name, "r") for name in argv)
    check_grid(grid, single)
    check_shaken(shaken)
    check_failed(failed)
    check_draws(draws)
    for what in failures:
        print(f"FAILED: {what}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
