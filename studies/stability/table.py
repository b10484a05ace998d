#!/usr/bin/env python3
"""Runs the stability studies of this folder and writes README.md's tables and maps.

table.py [--program PROGRAM] [--jobs N]

Results are kept beside the studies: run again, only what is missing is measured.
"""
import argparse
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import findings  # noqa: E402

SCENES = {"stream": "TR171's stream at V = 50", "fluid": "TR323's settled fluid (blow-up alone)",
          "swirl": "TR299's swirling fluid"}  # fmt: skip
MAPS = {"speed": "speed", "exponents": "attraction", "masses": "ratio"}


def show(value):
    return "–" if value is None else f"{value:.3g}"


def limits_table(found):
    measured = next(f for f in found if f.quantities)
    yield (
        f"2/ω is {show(measured.quantities['2/omega at the start'])} at the start and "
        f"{show(measured.quantities['2/omega along the run'])} along the run; r0/\\|v\\| is "
        f"{show(measured.quantities['r0/|v|'])}."
    )
    yield ""
    yield "| method | h ω | expected | stable up to | ends in | stable again up to | a force or Jacobian |"
    yield "|---|---:|---:|---:|---|---:|---:|"
    for f in found:
        value = f.quantities.get
        if not f.quantities:
            yield f"| {f.method} | – | – | – | {f.reason} | | |"
            continue
        limit, top = value("step limit"), value("largest stable step")
        word = re.search(r"ends in ([a-z -]+)", f.reason)
        again = show(top) if top and (limit is None or top > limit) else ""
        unlimited = "no limit up to" in f.reason
        yield (
            f"| {f.method} | {'none' if unlimited else show(value('h omega limit'))} "
            f"| {show(value('predicted limit'))} | {show(limit)} | {word[1] if word else f.verdict} "
            f"| {again} | {show(value('step limit an evaluation'))} |"
        )


def map_table(found, over):
    methods = list(dict.fromkeys(f.method for f in found))
    values = list(dict.fromkeys(f.quantities["$" + over] for f in found))
    yield f"| {over} | 2/ω along the run | r0/\\|v\\| | " + " | ".join(methods) + " |"
    yield "|---:|---:|---:|" + "---:|" * len(methods)
    for value in values:
        own = {f.method: f for f in found if f.quantities["$" + over] == value}
        first = own[methods[0]].quantities
        cells = [show(own[m].quantities["step limit"]) for m in methods]
        yield (
            f"| {value:g} | {show(first['2/omega along the run'])} | {show(first['r0/|v|'])} | "
            + " | ".join(cells)
            + " |"
        )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=str(HERE.parent.parent / "build" / "driftlab"))
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    lines = [""]
    for name, title in SCENES.items():
        found = findings.run(options.program, HERE / f"{name}.yaml", options.jobs)
        lines += [f"### {title}", "", *limits_table(found), ""]
    for name, over in MAPS.items():
        found = findings.run(options.program, HERE / f"{name}.yaml", options.jobs)
        lines += [f"### Over {over}", "", *map_table(found, over), ""]
        for method in ("leapfrog", "conserving-newton-klu") if name == "speed" else ():
            picture = HERE / f"{name}-{method}.png"
            results = HERE / f"results-{name}.h5"
            subprocess.run(
                [options.program, "map", str(results), "--over", over, "--method", method,
                 "--out", str(picture)], check=True, stdout=subprocess.DEVNULL)  # fmt: skip
            lines += [f"![{method} over {over}]({picture.name})", ""]
    findings.replace(HERE / "README.md", "table.py", lines)


if __name__ == "__main__":
    main()
