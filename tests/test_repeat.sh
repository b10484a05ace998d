#!/bin/bash
# A study that is measured twice, in the order of the file and side by side, finds the same: every
# count and every error in every bit. Argument: the program.
set -euo pipefail
program=$1
studies=$(cd "$(dirname "$0")/../studies" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cat > "$work/study.yaml" <<STUDY
name: repeat
scene: $studies/wall/penetration-program-p9.yaml
samples: 5
error: 1.0e-6
repeats: 1
reference: {extended: long-double}
cases:
STUDY
for method in leapfrog gauss-6 conserving conserving-newton-klu composition-8-kahan-li; do
    echo "  - {method: $method, step: [1.0e-5, 2.5e-6]}" >> "$work/study.yaml"
done
for method in arkode-erk cvode-adams cvode-bdf-klu gsl-rk8pd gsl-msadams; do
    echo "  - {method: $method, atol: 1.0e-12, rtol: [1.0e-6, 1.0e-8]}" >> "$work/study.yaml"
done

jobs=$(nproc)
[ "$jobs" -le 2 ] || jobs=2
"$program" study "$work/study.yaml" --out "$work/first.h5" > "$work/first"
"$program" study "$work/study.yaml" --out "$work/second.h5" -j "$jobs" > "$work/second"
"$program" compare "$work/first.h5" "$work/second.h5" > "$work/compared"
if ! grep -q '^20 in both, 20 of them alike in every count, error and verdict' "$work/compared"; then
    echo "FAIL: two runs differ" >&2
    cat "$work/compared" >&2
    exit 1
fi
grep -q ' cpu' "$work/first" || { echo "FAIL: no front" >&2; exit 1; }
grep -q '^  cheapest for a position error of at most$' "$work/first" ||
    { echo "FAIL: nothing is told of accuracies" >&2; exit 1; }
echo "ok"
