#!/usr/bin/env python3
"""Runs the extreme studies of this folder and writes README.md's tables.

table.py [--program PROGRAM] [--jobs N] [--swirl]

--swirl: the tables of TR299's bodies alone. Results are kept beside the studies: run again, only what is missing is measured.
"""
import argparse
import collections
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import findings  # noqa: E402

ORDER = ["papers", "drop", "near", "masses", "exponents", "walls", "crossing", "straight", "long"]
LADDERS = ["cold", "steps"]
SWIRL = ["swirl", "swirl-steps"]


def name_of(finding):
    rtol = re.search(r"\brtol=(\S+)", finding.options)
    step = re.search(r"\bstep=(\S+)", finding.options)
    chosen = rtol and (not step or step[1] == "0")
    return f"{finding.method} {rtol[1]}" if chosen else finding.method


def count(words):
    counts = collections.Counter(words)
    return ", ".join(f"{word} {counts[word]}" for word in counts)


def scenes_table(found):
    yield "| scene | methods | hold | others |"
    yield "|---|---:|---:|---|"
    for scene in dict.fromkeys(f.scene for f in found):
        words = [f.verdict for f in found if f.scene == scene]
        others = [w for w in words if w != "holds"]
        yield f"| {scene} | {len(words)} | {words.count('holds')} | {count(others)} |"


def methods_table(found):
    yield "| method | scenes | hold | others |"
    yield "|---|---:|---:|---|"
    for name in dict.fromkeys(name_of(f) for f in found):
        own = [f for f in found if name_of(f) == name]
        words = [f.verdict for f in own]
        fails = collections.defaultdict(list)
        for f in own:
            if f.verdict != "holds":
                fails[f.verdict].append(f.scene)
        told = "; ".join(f"{word}: {', '.join(scenes)}" for word, scenes in fails.items())
        yield f"| {name} | {len(words)} | {words.count('holds')} | {told} |"


def ladder_table(found):
    """Methods that end alike share a row."""
    rows = collections.defaultdict(list)
    for f in found:
        told = re.sub(r" \([^;]*\)(?=;|$)", "", f.reason)
        ladder = f.verdict in ("fails", "holds in part") or told.startswith("holds ")
        rows[told if ladder else f"{f.verdict} at its own steps"].append(name_of(f))
    yield "| methods | how it ends |"
    yield "|---|---|"
    for told, names in rows.items():
        yield f"| {', '.join(names)} | {told} |"


def swirl_lines(found):
    yield from ["", "The 239, at the report's step:", "", *scenes_table(found["swirl"]), ""]
    failing = {name_of(f) for f in found["swirl"] if f.verdict != "holds"}
    others = [f for f in found["swirl"] if name_of(f) in failing]
    yield from ["Those methods that do not hold on all three:", "", *methods_table(others), ""]
    for scene in dict.fromkeys(f.scene for f in found["swirl-steps"]):
        own = [f for f in found["swirl-steps"] if f.scene == scene]
        yield from [f"Three of them, {scene}, steps from 1e-3 to 1e3 times 2/ω:", ""]
        yield from [*ladder_table(own), ""]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=str(HERE.parent.parent / "build" / "driftlab"))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--swirl", action="store_true")
    options = parser.parse_args()
    found = {
        name: findings.run(options.program, HERE / f"{name}.yaml", options.jobs)
        for name in SWIRL + (ORDER + LADDERS if not options.swirl else [])
    }
    findings.replace(HERE / "README.md", "table.py --swirl", swirl_lines(found))
    if options.swirl:
        return
    runs = [f for name in ORDER for f in found[name]]
    lines = ["", "Every scene:", "", *scenes_table(runs), ""]
    lines += ["Every method (with its rtol where it chooses its steps):", "", *methods_table(runs), ""]
    for name, title in (
        ("steps", "Steps from 1e-3 to 1e3 times 2/ω"),
        ("cold", "A cold crystal, steps from 0.01 to 10 times 2/ω"),
    ):
        lines += [f"{title}:", "", *ladder_table(found[name]), ""]
    findings.replace(HERE / "README.md", "table.py", lines)


if __name__ == "__main__":
    main()
