#!/usr/bin/env python3
"""For which steps do the solvers of the energy-conserving scheme find a solution at V = 1000?

scan.py [PROGRAM]   PROGRAM is driftlab, by default the one in the PATH. A row is a step, a column a
solver; a cell is the number of seeds, of ten, with which the run reaches t = 1, and the iterations
a step in those that do. Seeds change the random part of the velocities, which is 1 % of V.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

SCENE = pathlib.Path(__file__).parent / "stream-v1000-rule.yaml"
SOLVERS = {
    "Newton": ["--method", "conserving-newton-dense"],
    "fixed point": ["--method", "conserving-fixed-point", "--set", "rescue=false"],
}
STEPS = ("0.2", "0.1", "0.05", "0.04", "0.025", "0.02", "0.01", "0.005")
SEEDS = range(1973, 1983)


def scenes(folder):
    text = SCENE.read_text()
    for seed in SEEDS:
        path = pathlib.Path(folder) / f"seed{seed}.yaml"
        path.write_text(re.sub(r"seed: \d+", f"seed: {seed}", text))
        yield path


def run(program, scene, options, step):
    command = [program, "run", str(scene), *options, "--dt", step, "--sample", "0.2", "--json"]
    return json.loads(subprocess.run(command, capture_output=True, text=True).stdout)


def cell(program, paths, options, step):
    results = [run(program, path, options, step) for path in paths]
    ended = [r for r in results if r["status"] == "ok"]
    if not ended:
        return f"0 of {len(results)}"
    each = sum(r["nonlinear_iterations"] for r in ended) / sum(r["steps"] for r in ended)
    worst = max(r["energy_error_max"] / r["energy_scale"] for r in ended)
    return f"{len(ended)} of {len(results)}, {each:.1f} iterations, energy {worst:.0e}"


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "driftlab"
    print("| step | " + " | ".join(SOLVERS) + " |")
    print("|---:|" + "---|" * len(SOLVERS))
    with tempfile.TemporaryDirectory() as folder:
        paths = list(scenes(folder))
        for step in STEPS:
            cells = [cell(program, paths, options, step) for options in SOLVERS.values()]
            print(f"| {step} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
