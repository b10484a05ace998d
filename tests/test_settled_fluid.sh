#!/bin/bash
# The settled fluid with every event located goes on past t = 0.0135, where a particle that slides
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
