#!/usr/bin/env python3
"""Up to which step does each solver of the conserving scheme find a solution on TR171's stream?

newton.py [PROGRAM]   PROGRAM is driftlab, by default the one in the PATH. Takes a minute or two. Every
step from 1 down to 0.005, a twentieth shorter each time, that divides the run is tried with every solver,
none of which but the default is rescued by another. First table: the steps with which a run reaches
t = 2, as windows, since they are not always an interval. Second table: the iterations a step at some
of them; in brackets the time at which the solver gave up.
"""
import json
import pathlib
import subprocess
import sys

STREAM = pathlib.Path(__file__).parent.parent / "stream"
SPEEDS = (50, 300, 1000)
END = 2.0
SOLVERS = {
    "fixed point": ["conserving-fixed-point", "rescue=false", "depth=0"],
    "fixed point, depth 3": ["conserving-fixed-point", "rescue=false", "depth=3"],
    "Picard": ["conserving-picard", "rescue=false", "depth=0"],
    "Newton, dense": ["conserving-newton-dense", "rescue=false"],
    "Newton, KLU": ["conserving-newton-klu", "rescue=false"],
    "Newton-GMRES": ["conserving-newton-krylov", "rescue=false"],
    "relaxed, omega = 1": ["conserving-relaxed", "eps=1e-9"],
    "relaxed, omega = 0.7": ["conserving-relaxed", "eps=1e-9", "omega=0.7"],
    "default": ["conserving"],
}
MOST_STEPS, RATIO = 400, 1.05
SHOWN = (10, 20, 40, 100, 200, 400)  # steps in the run


def counts():
    """Of steps in the run."""
    count, exact = 2, 2.0
    while count < MOST_STEPS:
        yield count
        exact = max(exact * RATIO, count + 1)
        count = round(exact)
    yield MOST_STEPS


def run(program, speed, solver, count):
    command = [program, "run", STREAM / f"stream-v{speed}-rule.yaml", "--method", solver[0],
               "--dt", f"{END / count:.17g}", "--t-end", END, "--sample", END, "--time-limit", 5,
               "--json"]  # fmt: skip
    for option in solver[1:]:
        command += ["--set", option]
    printed = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    return json.loads(printed.stdout)


def windows(results):
    """Runs of neighbouring steps that converge, the longest steps first."""
    found, inside = [], False
    for count in sorted(results):
        converged = results[count]["status"] == "ok"
        if converged and inside:
            found[-1][1] = count
        elif converged:
            found.append([count, count])
        inside = converged
    words = [f"{END / a:.3g}" + (f" to {END / b:.3g}" if b > a else "") for a, b in found]
    return ", ".join(words) or "none"


def cell(summary):
    if summary["status"] == "ok":
        return f"{summary['nonlinear_iterations'] / summary['steps']:.1f}"
    return f"({summary['t_end_reached']:.2g})"


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "driftlab"
    tried = sorted({*counts(), *SHOWN})
    results = {
        (name, speed): {count: run(program, speed, solver, count) for count in tried}
        for name, solver in SOLVERS.items()
        for speed in SPEEDS
    }
    print("| steps that converge | " + " | ".join(f"V = {speed}" for speed in SPEEDS) + " |")
    print("|---" * (1 + len(SPEEDS)) + "|")
    for name in SOLVERS:
        cells = [windows(results[name, speed]) for speed in SPEEDS]
        print(f"| {name} | " + " | ".join(cells) + " |")
    print("\n| iterations | step | " + " | ".join(SOLVERS) + " |")
    print("|---:" * 2 + "|---" * len(SOLVERS) + "|")
    for speed in SPEEDS:
        for count in SHOWN:
            cells = [cell(results[name, speed][count]) for name in SOLVERS]
            print(f"| V = {speed} | {END / count:.3g} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
