#!/usr/bin/env python3
"""Measures what the papers' scenes leave out, and loops by hand, and writes README.md's tables.

table.py [--program PROGRAM] [--bench BENCH_FORCE]
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import findings  # noqa: E402

BUILD = HERE.parent.parent / "build"
SCENES = {
    "free": "leave-outs/free.yaml",
    "falling": "leave-outs/falling.yaml",
    "kepler": "kepler/kepler.yaml",
    "stream": "stream/stream.yaml",
    "swirl": "swirl/swirl.yaml",
    "settled": "drop/settled.yaml",
    "drop": "drop/drop.yaml",
}
HEAP_NOISE = 0.25  # kB: what the heap keeps back for itself
BY_HAND = ("nothing acts", "gravity alone", "no walls, stream")


def output(*command, **more):
    return json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True, **more).stdout)


def measure(program):
    found = {}
    for name, scene in SCENES.items():
        path = str(HERE.parent / scene)
        found[name] = output(program, "explain", path, "--cost", "--json")
    return found


def matrix(found, first, cell):
    """Things added by scenes; a dot where the scene has the thing already."""
    yield f"| added | {' | '.join(found)} |"
    yield "|---|" + "---:|" * len(found)
    yield first
    of = {name: {r["added"]: r for r in told["rows"]} for name, told in found.items()}
    order = []
    for rows in of.values():  # as the program has them, everything last
        for what in rows:
            if what not in order and what != "nothing" and not what.startswith("everything"):
                order.append(what)
    last = [what for what in order if what.startswith("pairs without")]
    rest = [what for what in order if what not in last]
    for what in rest + last + ["everything", "everything, reference kernel"]:
        cells = (cell(rows[what]) if what in rows else "." for rows in of.values())
        yield f"| {what} | {' | '.join(cells)} |"


def number(value):
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def times(found):
    own = (number(told["rows"][0]["seconds_per_step"] * 1e6) for told in found.values())
    first = f"| *nothing: µs a step* | {' | '.join(own)} |"
    yield from matrix(found, first, lambda row: number(row["ratio"]))


def memories(found):
    own = (number(told["rows"][0]["bytes"] / 1000) for told in found.values())
    first = f"| *nothing: kB* | {' | '.join(own)} |"
    base = {id(row): told["rows"][0]["bytes"] for told in found.values() for row in told["rows"]}

    def more(row):
        kilobytes = (row["bytes"] - base[id(row)]) / 1000
        return f"{kilobytes:+.1f}" if abs(kilobytes) >= HEAP_NOISE else "0"

    yield from matrix(found, first, more)


def by_hand(rows):
    yield "| scene | loop | ns a particle and step | times the loop by hand | from | to |"
    yield "|---|---|---:|---:|---:|---:|"
    for row in rows:
        if row["case"] not in BY_HAND:
            continue
        line = f"| {row['case']} | {row['with']} | {row['time']['median']:.3g} |"
        if "ratio" in row:  # by hand over ours
            r = row["ratio"]
            line += f" {1 / r['median']:.3f} | {1 / r['maximum']:.3f} | {1 / r['minimum']:.3f} |"
        else:
            line += " 1 | | |"
        yield line


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", default=str(BUILD / "driftlab"))
    parser.add_argument("--bench", default=str(BUILD / "bench_force"))
    given = parser.parse_args()
    readme = HERE / "README.md"
    # without LAMMPS, which is not asked about here
    bench = output(given.bench, "--json", env={**os.environ, "PATH": ""})
    findings.replace(readme, "table.py: by hand", list(by_hand(bench["rows"])))
    found = measure(given.program)
    findings.replace(readme, "table.py: times", list(times(found)))
    findings.replace(readme, "table.py: memory", list(memories(found)))


if __name__ == "__main__":
    main()
