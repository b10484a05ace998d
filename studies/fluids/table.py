#!/usr/bin/env python3
"""Runs the fluids of TR323's Table II and writes what became of them beside what is printed.

table.py [--program PROGRAM] [--to TIME] [--folder FOLDER] [NAME ...]

NAME is a scene of this folder without `.yaml`; by default the sixteen fluids. Each is run by
    driftlab run NAME.yaml --method leapfrog --t-end TIME --sample 0.02 --no-ledger --out ...
(fluid 8, which blows up, with the ledger) unless FOLDER (default: this one) has that file, and looked at by
    driftlab observe FOLDER/NAME.h5 --from T --what energy,depth,separation,density --json
The means are those of the last eighth of the run. The trend is the mean kinetic energy per particle
of that eighth less that of the eighth before it, in percent of the latter; the mean between two
times follows from the means from either time to the end. A fluid is called steady if the trend is
less than 3 %, or twice its standard error.
"""
import argparse
import json
import math
import pathlib
import subprocess

HERE = pathlib.Path(__file__).parent
# depth, mean separation, kinetic energy per particle: TR323 (1978), Table II
PRINTED = {
    1: (1.2, 0.13, 0.46), 2: (5, 0.36, 4.62), 3: (8.5, 0.45, 64.03), 4: (10, 0.50, 0.69),
    5: (3.5, 0.25, 0.28), 6: (2.6, 0.25, 0.33), 7: (2.5, 0.24, 0.03), 8: (10, 0.50, 0.58),
    9: (9, 0.48, 0.67), 10: (5.5, 0.34, 47.20), 11: (7, 0.40, 34.54), 12: (5, 0.34, 108.00),
    13: (4, 0.43, 3.45), 14: (8, 0.46, 88.17), 15: (6, 0.46, 86.87), 16: (5.7, 0.37, 264.49),
}  # fmt: skip
TREND, TENTHS = 0.03, 10
WATCHED = ["fluid08"]  # loses its energy, which only the ledger tells


def run(options, name):
    path = options.folder / f"{name}.h5"
    if path.exists():
        return path, None
    command = [options.program, "run", str(HERE / f"{name}.yaml"), "--method", "leapfrog"]
    command += ["--t-end", f"{options.to:g}", "--sample", "0.02", "--out", str(path)]
    command += ["--json"] if name in WATCHED else ["--no-ledger", "--json"]
    result = json.loads(subprocess.run(command, capture_output=True, text=True).stdout)
    return path, None if result["status"] == "ok" else result["message"]


def observe(options, path, what, *more):
    command = [options.program, "observe", str(path), "--what", what, *more, "--json"]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def kinetic(options, path, start):
    seen = observe(options, path, "energy", "--from", f"{start:g}")
    row = seen["observables"]["energy"][0]["kinetic_per_particle"]
    return seen["frames"], row["mean"], row["error"]


def trend(options, path):
    """Relative change of the kinetic energy from the last eighth but one to the last."""
    count, late, error = kinetic(options, path, options.to * 7 / 8)
    both, mean, _ = kinetic(options, path, options.to * 6 / 8)
    early = (both * mean - count * late) / (both - count)
    return late / early - 1, math.sqrt(2) * error / early


def nature(options, path, depth):
    """Particles per area in the tenths of the depth, from the floor, over their mean."""
    seen = observe(options, path, "density", "--from", f"{options.to * 7 / 8:g}",
                   "--bin", f"{depth / TENTHS:.12g}")  # fmt: skip
    density = [row["density"]["mean"] for row in seen["observables"]["density"][:TENTHS]]
    return " ".join(f"{value * len(density) / sum(density):.2f}" for value in density)


def row(options, name):
    path, failure = run(options, name)
    number = int(name[5:7])
    depth, separation, energy = PRINTED[number]
    if failure or not path.exists():
        return f"| {name} | {depth} / - | {separation} / - | {energy} / - | {failure} | |"
    seen = observe(options, path, "depth,separation", "--from", f"{options.to * 7 / 8:g}")
    value = seen["observables"]
    most = value["depth"][0]["most"]["mean"]
    near = value["separation"][0]["nearest_3"]["mean"]
    _, mean, error = kinetic(options, path, options.to * 7 / 8)
    change, uncertain = trend(options, path)
    state = "steady" if abs(change) < max(TREND, 2 * uncertain) else f"{100 * change:+.0f} %"
    return (f"| {name} | {depth} / {most:.2f} | {separation} / {near:.3f} | "
            f"{energy} / {mean:.4g} ± {error:.1g} | {state} | {nature(options, path, most)} |")  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="driftlab")
    parser.add_argument("--to", type=float, default=20)
    parser.add_argument("--folder", type=pathlib.Path, default=HERE)
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args()
    print("| scene | depth | mean separation | kinetic energy/particle | trend | density by tenths |")
    print("|---|---|---|---|---|---|")
    for name in options.names or [f"fluid{number:02}" for number in PRINTED]:
        print(row(options, name), flush=True)


if __name__ == "__main__":
    main()
