#!/usr/bin/env python3
"""Writes what a study of this folder printed as two tables in Markdown: table.py PRINTED.txt

    driftlab study fluid.yaml --out fluid.h5 | tee fluid.txt
    table.py fluid.txt

Order: slopes of log(error) over log(step) through the five smallest steps, of the position at the
end / of the energy, without errors that are roundoff (2e-12; 1e-12) or, for the position, below
three times the reference's (marked with ! by the study); the error at the largest step in brackets
where it does not fall. Tolerances: for each rtol the
force evaluations, with their error; a row ends with the slope of log(error) over log(rtol).
"""
import math
import re
import sys

COLUMNS = re.compile(
    r"^  (?P<method>\S+) +(?P<options>\S.*?) +(?P<status>[a-z-]+) +(?P<cpu>\S+) +(?P<forces>\d+) +"
    r"(?P<steps>\d+) +(?P<error>\S+?)(?P<refused>!?) +(?P<energy>\S+)$"
)
FITTED, ROUNDOFF = 5, {"error": 2e-12, "energy": 1e-12}


def read(path):
    """{scene: [case, ...]} in the order of the file."""
    scenes, cases = {}, None
    with open(path, encoding="utf-8") as file:
        for line in file:
            head = re.match(r"^(\S+) \(errors", line)
            if head:
                cases = scenes.setdefault(head[1].split("-", 1)[1], [])
            found = COLUMNS.match(line.rstrip())
            if found and found["method"] != "method":
                cases.append(case_of(found))
    return scenes


def case_of(found):
    options = dict(word.split("=") for word in found["options"].split())
    step, rtol = float(options.get("step", 0)), float(options.get("rtol", 0))
    name = found["method"] + (" " + options["table"] if "table" in options else "")
    return {
        "name": name,
        "step": step,
        "rtol": 0 if step else rtol,
        "ok": found["status"] == "ok",
        "status": found["status"],
        "forces": int(found["forces"]),
        "error": float(found["error"]) if found["status"] == "ok" else math.nan,
        "energy": float(found["energy"]) if found["status"] == "ok" else math.nan,
        "refused": found["refused"] == "!",
    }


def slope(points):
    """Of the logarithms of (x, y), or None for less than two."""
    if len(points) < 2:
        return None
    x, y = [math.log(p[0]) for p in points], [math.log(p[1]) for p in points]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def names(scenes, key):
    listed = {case["name"]: None for cases in scenes.values() for case in cases if case[key]}
    return list(listed)


def order(cases, name, what):
    of_it = sorted((c["step"], c[what], c["refused"] and what == "error") for c in cases
                   if c["name"] == name and c["step"] and c["ok"])  # fmt: skip
    fitted = [(h, e) for h, e, bad in of_it if not bad and e > ROUNDOFF[what]][:FITTED]
    errors = [e for _, e in fitted]
    if len(fitted) < 2 or max(errors) < 10 * min(errors):
        return f"({max(of_it)[1]:.0e})"
    return f"{slope(fitted):.2f}"


def tolerance(case):
    if not case["ok"]:
        return f"{case['status']} ({case['forces']})"
    return f"{case['forces']}, {'< ' if case['refused'] else ''}{case['error']:.1e}"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    scenes = read(sys.argv[1])
    print("| order in Δt | " + " | ".join(scenes) + " |")
    print("|---" * (1 + len(scenes)) + "|")
    for name in names(scenes, "step"):
        row = [f"{order(c, name, 'error')} / {order(c, name, 'energy')}" for c in scenes.values()]
        print(f"| {name} | " + " | ".join(row) + " |")
    tolerances = sorted({c["rtol"] for cases in scenes.values() for c in cases} - {0}, reverse=True)
    print("\n| forces, error | | " + " | ".join(f"rtol {t:g}" for t in tolerances) + " | slope |")
    print("|---" * (3 + len(tolerances)) + "|")
    for name in names(scenes, "rtol"):
        for scene, cases in scenes.items():
            of_it = {c["rtol"]: c for c in cases if c["name"] == name and c["rtol"]}
            used = [(t, c["error"]) for t, c in of_it.items() if c["ok"] and not c["refused"]]
            fitted = slope(used)
            row = [tolerance(of_it[t]) if t in of_it else "" for t in tolerances]
            print(f"| {name} | {scene} | " + " | ".join(row) +
                  f" | {'' if fitted is None else format(fitted, '.2f')} |")  # fmt: skip


if __name__ == "__main__":
    main()
