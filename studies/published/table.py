#!/usr/bin/env python3
"""The table of README.md: published end values beside the reference in quad precision.

    studies/published/table.py [DRIFTLAB]
"""
import json
import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "driftlab"
SCENES = [("pleiades", []), ("detest-c5", ["--relative-to", "1"]), ("detest-d1", ["--kepler"]),
          ("detest-d2", ["--kepler"]), ("detest-d3", ["--kepler"]), ("detest-d4", ["--kepler"]),
          ("detest-d5", ["--kepler"]), ("figure-eight", [])]


def compare(name, options):
    words = [PROGRAM, "reference", FOLDER / f"{name}.yaml", "--published",
             FOLDER / "data" / f"{name}.csv", "--precision", "quad", "--samples", "1", "--json"]
    return json.loads(subprocess.run(words + options, check=True, capture_output=True).stdout)


print("| scene | t | numbers | agree to the last digit | largest difference "
      "| reference's own error | from the exact motion |")
print("|---|---|---|---|---|---|---|")
for name, options in SCENES:
    found = compare(name, options)
    published, exact = found["published"], found["from_exact"]
    print(f"| {name} | {found['time'][-1]:g} | {published['numbers']} | {published['agree']} "
          f"| {published['largest']:.1e}, {published['units']:.2g} units of the last digit "
          f"| {found['error']:.1e} | {f'{exact[-1]:.1e}' if exact else ''} |")
