#!/bin/bash
# studies/breakpoints/table.py has a case of every line that the study prints, those on the Pareto
# fronts too. Argument: the program.
set -euo pipefail
program=$1
if ! command -v python3 >/dev/null; then
    echo "SKIPPED: python3 is not installed"
    exit 77
fi
studies=$(cd "$(dirname "$0")/../studies/breakpoints" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cat > "$work/study.yaml" <<STUDY
name: pair
scenes: [$studies/pair-taper.yaml, $studies/pair-located.yaml]
error: 1.0e-6
repeats: 1
reference: {extended: long-double}
cases:
  - {method: leapfrog, step: [1.0e-3, 5.0e-4, 2.5e-4]}
  - {method: gsl-rk8pd, atol: 1.0e-12, rtol: [1.0e-6, 1.0e-8]}
STUDY
"$program" study "$work/study.yaml" --out "$work/results.h5" > "$work/printed"
grep -Eq '^  leapfrog .* (cpu|forces)$' "$work/printed" # or this tests nothing
"$studies/table.py" < "$work/printed" > "$work/tables"
cells() {
    grep "^| $1" "$work/tables" | tr '|' '\n' | grep -c '[0-9].*[0-9]'
}
# slopes of position and energy on two scenes; two tolerances on each, and a slope
[ "$(cells leapfrog)" = 2 ]
[ "$(cells gsl-rk8pd)" -ge 5 ]
