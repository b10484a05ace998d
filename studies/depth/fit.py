#!/usr/bin/env python3
"""Is the pressure linear in the depth (liquid), or its logarithm (gas)?

fit.py TRAJECTORY.h5 FROM SURFACE [PROGRAM]

Reads `driftlab observe TRAJECTORY.h5 --what pressure --from FROM --bin 0.2 --json`. The depth is
SURFACE less the height. Both straight lines, p = a + b depth and ln p = a + b depth, are fitted by
least squares, all bins weighing the same: first to the bins deeper than 0.2 but for the lowest,
where the floor makes a layer, then to those above, as far as p is five times its standard error.
Printed: slope, its error from the scatter, R^2, and the root mean square of (fit - p)/p.
"""
import json
import math
import subprocess
import sys


def read(path, start, program):
    command = [program, "observe", path, "--what", "pressure", "--from", start]
    command += ["--bin", "0.2", "--json"]
    seen = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    rows = seen["observables"]["pressure"]
    return [(sum(r["height"]) / 2, r["pressure"]["mean"], r["pressure"]["error"]) for r in rows]


def line(x, y):
    """Least squares: intercept, slope, its error, R^2."""
    n, mx, my = len(x), sum(x) / len(x), sum(y) / len(y)
    sxx = sum((a - mx) ** 2 for a in x)
    slope = sum((a - mx) * (b - my) for a, b in zip(x, y)) / sxx
    rest = sum((b - my - slope * (a - mx)) ** 2 for a, b in zip(x, y))
    total = sum((b - my) ** 2 for b in y)
    return my - slope * mx, slope, math.sqrt(rest / (n - 2) / sxx), 1 - rest / total


def rms_miss(pressures, fitted):
    return math.sqrt(sum((f / p - 1) ** 2 for p, f in zip(pressures, fitted)) / len(pressures))


def report(title, points):
    x, p = [d for d, _, _ in points], [q for _, q, _ in points]
    print(f"{title}: {len(points)} bins, depth {min(x):.2f} to {max(x):.2f}")
    a, b, error, r2 = line(x, p)
    miss = rms_miss(p, [a + b * d for d in x])
    print(f"  p    = {a:.0f} + ({b:.0f} +- {error:.0f}) depth   R^2 {r2:.4f}   misses p by {miss:.1%}")
    a, b, error, r2 = line(x, [math.log(q) for q in p])
    miss = rms_miss(p, [math.exp(a + b * d) for d in x])
    print(f"  ln p = {a:.3f} + ({b:.3f} +- {error:.3f}) depth   R^2 {r2:.4f}   misses p by {miss:.1%}")


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    path, start, surface = sys.argv[1], sys.argv[2], float(sys.argv[3])
    rows = read(path, start, sys.argv[4] if len(sys.argv) > 4 else "driftlab")
    points = [(surface - h, p, e) for h, p, e in rows[1:]]
    relative = [e / p for d, p, e in points if d > 0.2]
    report("below the surface", [row for row in points if row[0] > 0.2])
    report("above it", [row for row in points if row[0] <= 0.2 and row[1] > 5 * row[2]])
    print(f"standard errors of p: {min(relative):.1%} to {max(relative):.1%}")


if __name__ == "__main__":
    main()
