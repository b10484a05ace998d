#!/usr/bin/env python3
"""Writes what a study of this folder prints as two tables in Markdown.

    driftlab study fluid.yaml --out fluid.h5 | table.py [LONGEST]

Order: slopes of log(error) over log(step), of the position at the end / of the energy, through the
steps up to LONGEST (default: all), without errors that are roundoff (2e-12; 1e-12) or, for the
position, below three times the reference's (marked with ! by the study). In brackets, where there
are not two: the error at the longest step.
Tolerances: for each rtol the force evaluations with their position error; at the end of a row the
slope of log(error) over log(rtol).
"""
import math
import re
import sys

COLUMNS = re.compile(
    r"^  (?P<method>\S+) +(?P<options>\S.*?) +(?P<status>[a-z-]+) +(?P<cpu>\S+) +(?P<forces>\d+) +"
    r"(?P<steps>\d+) +(?P<error>\S+?)(?P<refused>!?) +(?P<energy>\S+)(?: (?: cpu)?(?: forces)?)?$"
)
ROUNDOFF = {"error": 2e-12, "energy": 1e-12}


def read(lines):
    """{scene: [case, ...]} in the order of the study."""
    scenes, cases = {}, None
    for line in lines:
        head = re.match(r"^(\S+) \(errors", line)
        if head:
            cases = scenes.setdefault(head[1].split("-", 1)[1], [])
        found = COLUMNS.match(line.rstrip())
        if found:
            cases.append(case_of(found))
        elif " ok " in line or " unstable " in line:
            sys.exit(f"table.py: not understood: {line.rstrip()}")
    return scenes


def number(word):
    """What the study prints of an error: a dash or "horizon" where there is none."""
    try:
        return float(word)
    except ValueError:
        return math.nan


def case_of(found):
    options = dict(word.split("=") for word in found["options"].split())
    step, ok = float(options.get("step", 0)), found["status"] == "ok"
    return {
        "name": found["method"] + (" " + options["table"] if "table" in options else ""),
        "step": step,
        "rtol": 0 if step else float(options.get("rtol", 0)),
        "ok": ok,
        "status": found["status"],
        "forces": int(found["forces"]),
        "error": number(found["error"]) if ok else math.nan,
        "energy": number(found["energy"]) if ok else math.nan,
        "refused": found["refused"] == "!",
    }


def slope(points):
    """Of the logarithms of (x, y)."""
    x, y = [math.log(p[0]) for p in points], [math.log(p[1]) for p in points]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def names(scenes, key):
    listed = {case["name"]: None for cases in scenes.values() for case in cases if case[key]}
    return list(listed)


def order(cases, name, longest, what):
    of_it = sorted((c["step"], c[what], c["refused"] and what == "error") for c in cases
                   if c["name"] == name and 0 < c["step"] <= longest and c["ok"])  # fmt: skip
    fitted = [(h, e) for h, e, refused in of_it if not refused and e > ROUNDOFF[what]]
    if len(fitted) >= 2:
        return f"{slope(fitted):.2f}"
    return f"({of_it[-1][1]:.0e})" if of_it else "-"


def tolerance(case):
    if not case["ok"]:
        return f"{case['status']} ({case['forces']})"
    return f"{case['forces']}, {'< ' if case['refused'] else ''}{case['error']:.1e}"


def tolerances_of(cases, name, tolerances):
    of_it = {c["rtol"]: c for c in cases if c["name"] == name and c["rtol"]}
    used = [(t, c["error"]) for t, c in of_it.items() if c["ok"] and not c["refused"]]
    row = [tolerance(of_it[t]) if t in of_it else "" for t in tolerances]
    return row + [f"{slope(used):.2f}" if len(used) >= 2 else ""]


def main():
    if len(sys.argv) > 2 or sys.stdin.isatty():
        sys.exit(__doc__)
    scenes, longest = read(sys.stdin), float(sys.argv[1]) if len(sys.argv) == 2 else math.inf
    print("| order in Δt | " + " | ".join(scenes) + " |")
    print("|---" * (1 + len(scenes)) + "|")
    for name in names(scenes, "step"):
        row = [" / ".join(order(cases, name, longest, what) for what in ROUNDOFF)
               for cases in scenes.values()]  # fmt: skip
        print(f"| {name} | " + " | ".join(row) + " |")
    tolerances = sorted({c["rtol"] for cases in scenes.values() for c in cases} - {0}, reverse=True)
    print("\n| forces, error | | " + " | ".join(f"rtol {t:g}" for t in tolerances) + " | slope |")
    print("|---" * (3 + len(tolerances)) + "|")
    for name in names(scenes, "rtol"):
        for scene, cases in scenes.items():
            row = tolerances_of(cases, name, tolerances)
            print(f"| {name} | {scene} | " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
