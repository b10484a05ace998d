#!/bin/sh
# Instructions that a method's step takes beyond its forces, on two particles: all that valgrind
# counts but what is inside dl_model_acceleration, the time loop included. Each method runs twice,
# longer the second time; the difference has neither start-up nor reading in it.
#
#     bench/callgrind_methods.sh DRIFTLAB
#
# Exit status: 0 within the bounds, 1 above one, 2 used wrongly, 77 where nothing can be counted.
set -eu

# Instructions a step at most: measured with GCC 12 at -O3, and a tenth.
bounds="leapfrog 135
composition-2-verlet 244
composition-4-suzuki 601"

if [ $# -ne 1 ] || [ ! -x "$1" ]; then
    echo "usage: $0 DRIFTLAB" >&2
    exit 2
fi
driftlab=$1
scene=$(dirname "$0")/../studies/kepler/kepler.yaml

skip() {
    echo "skipped: $1"
    exit 77
}
command -v valgrind >/dev/null || skip "there is no valgrind"
"$driftlab" --version | grep -q 'build *Release' || skip "not a Release build"
if grep -q __asan_init "$driftlab"; then skip "a sanitised build"; fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# beyond METHOD STEPS: instructions outside the forces
beyond() {
    end=$(awk -v steps="$2" 'BEGIN { print steps / 64 }')
    valgrind --tool=callgrind --callgrind-out-file="$work/out" "$driftlab" run "$scene" \
        --method "$1" --dt 0.015625 --t-end "$end" --sample "$end" >/dev/null 2>&1 ||
        skip "$1 does not run under valgrind"
    callgrind_annotate --inclusive=yes --threshold=100 "$work/out" |
        awk '{ count = $1; gsub(",", "", count) }
             /PROGRAM TOTALS/ { all = count }
             / [^ ]*:dl_model_acceleration( |$)/ { forces = count }
             END { if (!all || !forces) exit 1; printf "%d", all - forces }'
}

failed=0
while read -r method bound; do
    short=$(beyond "$method" 128)
    long=$(beyond "$method" 1152)
    awk -v name="$method" -v short="$short" -v long="$long" -v bound="$bound" 'BEGIN {
        each = (long - short) / 1024
        printf "%s, N = 2: %.1f instructions a step beyond the forces (bound %d)\n", name, each,
            bound
        exit !(each > 0 && each <= bound)
    }' || { echo "above the bound: $method"; failed=1; }
done <<END
$bounds
END
exit $failed
