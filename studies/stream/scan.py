#!/usr/bin/env python3
"""For which steps do the solvers of the energy-conserving scheme find a solution at V = 1000?

scan.py [PROGRAM]   PROGRAM is driftlab, by default the one in the PATH. Takes two minutes. A cell is the
number of seeds, of ten, with which the run reaches t = 1, the iterations a step in those that do, and
their largest energy error over its scale. Seeds change the random part of the velocities, which is
1 % of V. First table: a row is a step, no solver is rescued by another. Second table: the printed step
with as many iterations a step as are allowed, with and without a rescue by Newton-GMRES.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

SCENE = pathlib.Path(__file__).parent / "stream-v1000-rule.yaml"
METHODS = {
    "Newton, dense": "conserving-newton-dense",
    "Newton, KLU": "conserving-newton-klu",
    "Newton-GMRES": "conserving-newton-krylov",
    "fixed point": "conserving-fixed-point",
}
STEPS = ("0.2", "0.1", "0.05", "0.04", "0.025", "0.02", "0.01", "0.005")
PRINTED = "0.1"
ITERATIONS = (100, 200, 400, 1000)
SEEDS = range(1973, 1983)


def scenes(folder):
    text = SCENE.read_text()
    for seed in SEEDS:
        path = pathlib.Path(folder) / f"seed{seed}.yaml"
        path.write_text(re.sub(r"seed: \d+", f"seed: {seed}", text))
        yield path


def run(program, scene, method, step, iterations, rescue):
    command = [program, "run", str(scene), "--method", method, "--dt", step, "--sample", "0.2"]
    command += ["--set", f"iterations={iterations}", "--set", f"rescue={rescue}", "--json"]
    return json.loads(subprocess.run(command, capture_output=True, text=True).stdout)


def cell(program, paths, method, step, iterations=100, rescue="false"):
    results = [run(program, path, method, step, iterations, rescue) for path in paths]
    ended = [r for r in results if r["status"] == "ok"]
    if not ended:
        return f"0 of {len(results)}"
    each = sum(r["nonlinear_iterations"] for r in ended) / sum(r["steps"] for r in ended)
    worst = max(r["energy_error_max"] / r["energy_scale"] for r in ended)
    return f"{len(ended)} of {len(results)}, {each:.1f}, {worst:.0e}"


def print_row(head, cells):
    print(f"| {head} | " + " | ".join(cells) + " |", flush=True)


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "driftlab"
    with tempfile.TemporaryDirectory() as folder:
        paths = list(scenes(folder))
        print_row("step", METHODS)
        print("|---:" + "|---" * len(METHODS) + "|")
        for step in STEPS:
            print_row(step, [cell(program, paths, method, step) for method in METHODS.values()])
        print()
        print_row("iterations, step " + PRINTED, METHODS)
        print("|---" * (1 + len(METHODS)) + "|")
        for rescue in ("false", "true"):
            for count in ITERATIONS:
                cells = [cell(program, paths, method, PRINTED, count, rescue)
                         for method in METHODS.values()]  # fmt: skip
                print_row(f"{count}, rescued" if rescue == "true" else str(count), cells)


if __name__ == "__main__":
    main()
