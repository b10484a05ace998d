"""What a study has found, from what `driftlab study` prints; and tables in a README.

A README's table stands between <!-- begin: written by NAME --> and <!-- end -->.
"""
import dataclasses
import pathlib
import re
import subprocess

FINDING = re.compile(r"^  (\S+) (.*?): (could not be measured \((\S+)\)|[^:]+): (.*)$")
QUANTITY = re.compile(r"^    (.+?)(?: \[.*?\])?: (\S+)")


@dataclasses.dataclass
class Finding:
    scene: str
    method: str
    options: str
    verdict: str
    reason: str
    quantities: dict


def read(text):
    """Findings in the order of the study."""
    found, scene = [], ""
    for line in text.splitlines():
        match = FINDING.match(line)
        if match:
            verdict = match[4] if match[4] else match[3]
            found.append(Finding(scene, match[1], match[2], verdict, match[5], {}))
        elif QUANTITY.match(line) and found:
            name, value = QUANTITY.match(line).groups()
            try:
                found[-1].quantities[name] = float(value)
            except ValueError:
                found[-1].quantities[name] = None
        elif not line.startswith(" "):
            scene = line.strip()
    return found


def run(program, study, jobs):
    """Runs what is missing of a study; results are kept in results-NAME.h5 beside it."""
    study = pathlib.Path(study)
    results = study.parent / f"results-{study.stem}.h5"
    command = [program, "study", str(study), "--out", str(results), "-j", str(jobs)]
    return read(subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout)


def replace(readme, name, lines):
    """Puts the lines between the README's marks of that name."""
    readme = pathlib.Path(readme)
    begin, end = f"<!-- begin: written by {name} -->", "<!-- end -->"
    before, rest = readme.read_text().split(begin, 1)
    after = rest.split(end, 1)[1]
    readme.write_text(before + "\n".join([begin, *lines, end]) + after)
