#!/usr/bin/env python3
"""Runs the method comparison and writes README.md's tables.

table.py [--program PROGRAM] [--jobs N] [--again NAME ...]

Results are kept beside the studies: run again, only what is missing is measured. `--again` measures
those studies a second time, all of them anew, and tells what differs between the two.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import findings  # noqa: E402

SCENES = {"stream": "TR171's stream: smooth forces", "penetration": "TR171's penetration: stiff and short",
          "swirl": "TR299's swirling fluid: a force that jumps",
          "drop": "TR323's drop: a force that jumps, and mirror walls"}  # fmt: skip
CHEAPEST = re.compile(r"^    (1e[+-]\d+(?: to \S+)?)  +(.+?) +(\S+) s  (.+?) +(\d+)$")


def measure(options, name, suffix=""):
    """What the study prints, and the path of its results."""
    path = HERE / f"results-{name}{suffix}.h5"
    command = [options.program, "study", str(HERE / f"{name}.yaml"), "-j", str(options.jobs),
               "--out", str(path)]  # fmt: skip
    text = subprocess.run(
        command + (["--force"] if suffix else []), check=True, stdout=subprocess.PIPE, text=True
    ).stdout
    return text, path


def statuses(text):
    """Of every case, in the order of the table."""
    lines = text.splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("  method "))
    at = lines[head].index("status")
    for line in lines[head + 1 :]:
        if line.startswith("  cheapest for"):
            return
        yield line[at:].split()[0] + (" !" if "! " in line[at:] else "")


def count(text, name):
    found = list(statuses(text))
    failed = [word.split()[0] for word in found if not word.startswith("ok")]
    words = ", ".join(f"{failed.count(word)} {word}" for word in sorted(set(failed)))
    return f"| {name} | {len(found)} | {found.count('ok')} | {found.count('ok !')} | {words} |"


def cheapest(text):
    asked = re.search(r"^  cheapest for (.* error) of at most$", text, re.M)[1]
    yield f"| {asked} of at most | least CPU time | CPU s | fewest forces | forces |"
    yield "|---|---|---:|---|---:|"
    for match in filter(None, map(CHEAPEST.match, text.splitlines())):
        yield "| " + " | ".join(match.groups()) + " |"


def compare(options, name):
    first, second = measure(options, name)[1], measure(options, name, "-again")[1]
    found = json.loads(subprocess.run(
        [options.program, "compare", str(first), str(second), "--json"], check=True,
        stdout=subprocess.PIPE, text=True).stdout)  # fmt: skip
    print(
        f"{name}: {found['same']} of {len(found['pairs'])} cases agree in every count and error; "
        f"{found['swapped']} of {found['ranked']} pairs whose CPU time differs by more than a fifth "
        f"have changed places; CPU time {found['ratio_least']:.2f} to {found['ratio_most']:.2f} times "
        f"as long, median {found['ratio_median']:.2f}"
    )
    for pair in found["pairs"]:
        if not pair["same"]:
            print(f"  {pair['method']} {pair['options']}: {pair['a']} {pair['b']}")
    return found["same"] == len(found["pairs"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=str(HERE.parent.parent / "build" / "driftlab"))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--again", nargs="+", choices=SCENES, metavar="NAME")
    options = parser.parse_args()
    if options.again:
        sys.exit(not all([compare(options, name) for name in options.again]))
    texts = {name: measure(options, name)[0] for name in SCENES}
    lines = ["", "| scene | cases | count | refused | fail |", "|---|---:|---:|---:|---|"]
    lines += [count(text, name) for name, text in texts.items()] + [""]
    for name, title in SCENES.items():
        answer = re.search(r"^(?:cheapest for|nothing reached) .* on .*$", texts[name], re.M)[0]
        lines += [f"### {title}", "", *cheapest(texts[name]), "", answer[0].upper() + answer[1:] + ".", ""]
    findings.replace(HERE / "README.md", "table.py", lines)


if __name__ == "__main__":
    main()
