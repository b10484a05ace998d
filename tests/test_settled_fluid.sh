#!/bin/bash
# The settled fluid with every event located: it goes on past t = 0.0135, where a particle that slides
# along a side wall falls on the edge of another's cutoff. Argument: the program.
set -euo pipefail
program=$1
scene=$(cd "$(dirname "$0")/../studies/drop" && pwd)/settled-located.yaml

told=$("$program" run "$scene" --method leapfrog --t-end 0.018)
value() {
    grep "^  $1" <<< "$told" | awk '{print $NF}'
}
test "$(value 'status')" = ok
test "$(value 'contacts ended')" -ge 8
test "$(value 'contacts begun')" -lt 100

# Methods of every family tend to the reference's trajectory, through 126 events in a step of it.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat > "$work/study.yaml" <<STUDY
name: settled-agree
scene: $scene
end: 1.0e-4
samples: 1
error: 1.0e-8
repeats: 1
reference: {extended: long-double}
cases:
  - {method: leapfrog, step: [1.0e-4, 1.0e-5]}
  - {method: conserving-fixed-point, step: 1.0e-5}
  - {method: cvode-adams, rtol: 1.0e-10}
  - {method: composition-4-suzuki, step: 1.0e-4}
  - {method: arkode-erk, rtol: 1.0e-8}
  - {method: gsl-rk8pd, rtol: 1.0e-8}
STUDY
"$program" study "$work/study.yaml" --out "$work/results.h5" > "$work/told"

# METHOD BOUND: the RMS position error of its last case is below the bound
is_near() {
    awk -v method="$1" -v bound="$2" '
        $1 == method { for (i = 1; i < NF; i++) if ($i == "ok") error = $(i + 4) }
        END { exit !(error != "" && error + 0 < bound + 0) }' "$work/told" ||
        { echo "$1 is not within $2 of the reference"; cat "$work/told"; exit 1; }
}
is_near leapfrog 1e-9
is_near conserving-fixed-point 1e-9
is_near cvode-adams 1e-9
is_near composition-4-suzuki 1e-12
is_near arkode-erk 1e-12
is_near gsl-rk8pd 1e-12
