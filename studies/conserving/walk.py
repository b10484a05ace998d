#!/usr/bin/env python3
"""How does the energy error of the conserving scheme grow over a million steps?

walk.py [PROGRAM]   PROGRAM is driftlab, by default the one in the PATH. Needs h5py (Debian:
python3-h5py) and a few minutes. A row is a run. Its error after n steps is the RMS over all samples
of by how much the energy, ledger included, has changed n steps later, in units of the energy's scale.
The exponent is the slope of its logarithm over that of n: 1/2 for a random walk, 1 for a drift. It is
fitted from 1000 steps on to a tenth of the run, so that each n is seen often.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import h5py

HERE = pathlib.Path(__file__).parent
STREAM, BOUNCE = HERE.parent / "stream/stream.yaml", HERE / "bounce.yaml"
SETTLED = HERE.parent / "drop/settled.yaml"
EVERY = 100  # steps between samples
RUNS = [  # scene, step, steps, tolerance of the solver or None for the default
    (STREAM, 0.02, 1_000_000, None),
    (STREAM, 0.02, 100_000, "1e-12"),
    (STREAM, 0.02, 100_000, "1e-10"),
    (STREAM, 0.02, 100_000, "1e-8"),
    (BOUNCE, 1e-4, 1_000_000, None),
    (BOUNCE, 1e-4, 100_000, "1e-10"),
    (BOUNCE, 1e-4, 100_000, "1e-8"),
    (SETTLED, 1e-4, 100_000, None),
]
SHOWN = (1000, 10_000, 100_000)


def run(program, folder, scene, step, steps, tolerance):
    out = pathlib.Path(folder) / "run.h5"
    command = [program, "run", scene, "--method", "conserving", "--dt", f"{step}",
               "--t-end", f"{step * steps:.10g}", "--sample", f"{step * EVERY:.10g}",
               "--energy-bound", "1e9", "--out", out, "--json"]  # fmt: skip
    if tolerance:
        command += ["--set", f"tolerance={tolerance}"]
    printed = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    summary = json.loads(printed.stdout)
    if summary["status"] != "ok":
        sys.exit(f"{scene.name}: {summary['status']}: {printed.stderr}")
    with h5py.File(out) as file:
        return summary, file["observables/energy_error/value"][:]


def rms_after(errors, samples):
    changes = errors[samples:] - errors[:-samples]
    return math.sqrt(float((changes * changes).mean()))


def exponent(errors):
    lags, lag = [], 10
    while lag <= len(errors) // 10:
        lags.append(lag)
        lag = 2 * lag
    x = [math.log(lag) for lag in lags]
    y = [math.log(rms_after(errors, lag)) for lag in lags]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def row(program, folder, scene, step, steps, tolerance):
    summary, errors = run(program, folder, scene, step, steps, tolerance)
    errors = errors / summary["energy_scale"]
    shown = [f"{rms_after(errors, n // EVERY):.1e}" if 5 * n <= steps else "" for n in SHOWN]
    momenta = [
        f"{summary[name + '_error_max'] / summary[name + '_scale']:.0e}"
        if summary[name + "_error_max"] is not None else "-"
        for name in ("momentum", "angular_momentum")
    ]
    return [scene.stem, tolerance or "default", f"{steps:.0e}", f"{summary['cpu_seconds']:.0f}",
            f"{summary['nonlinear_iterations'] / steps:.1f}", *shown, f"{abs(errors[-1]):.1e}",
            f"{exponent(errors):.2f}", *momenta]  # fmt: skip


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "driftlab"
    head = ["scene", "tolerance", "steps", "CPU s", "iterations a step",
            *(f"error after {n:.0e}" for n in SHOWN), "at the end", "exponent",
            "momentum", "angular momentum"]  # fmt: skip
    print("| " + " | ".join(head) + " |\n" + "|---" * len(head) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for case in RUNS:
            print("| " + " | ".join(row(program, folder, *case)) + " |", flush=True)


if __name__ == "__main__":
    main()
