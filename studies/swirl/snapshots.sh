#!/bin/sh
# What a scene looks like at given steps of the paper's leap-frog: snapshots.sh SCENE STEP...
#
# For each step the scene is run from its start to that step, and its last frame observed (driftlab
# run, driftlab observe). A line holds: the mean angular velocity (TR299 (3.12)) and the rotation of
# the rigid body with the same angular momentum, both of all particles; particles that have escaped,
# groups, particles of the system, by observe's definition; solid, liquid and gas particles by Table
# IV; seconds of CPU time; the largest energy error over the energy scale, what radiation took being
# booked. Steps are the paper's, 1e-4, whatever the step of the method: DT (default 1e-4). DRIFTLAB
# is the program.
set -eu

driftlab=${DRIFTLAB:-driftlab}
dt=${DT:-1e-4}
if [ $# -lt 2 ]; then
    echo "usage: snapshots.sh SCENE STEP..." >&2
    exit 2
fi
scene=$1
shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

echo "  step  (3.12)  rigid  escaped groups system  solid liquid gas  CPU s  energy error"
for step; do
    end=$(awk -v s="$step" 'BEGIN { printf "%.10g", s * 1e-4 }')
    "$driftlab" run "$scene" --method leapfrog --dt "$dt" --t-end "$end" --sample 5e-3 \
        --out "$folder/run.h5" >"$folder/run.txt"
    "$driftlab" observe "$folder/run.h5" --what motion,states,escaped --last >"$folder/seen.txt"
    awk -v step="$step" '
        /CPU seconds/ { cpu = $3 }
        /energy error, largest/ { wrong = $4 }
        /energy scale/ { scale = $3 }
        /^[a-z]+:/ { section = $1 }
        $1 == "angular_velocity" { omega = $2 }
        $1 == "rigid_rotation" { rigid = $2 }
        section == "states:" && NF == 4 && $1 > 0 { solid += $2; liquid += $3; gas += $4 }
        section == "escaped:" && NF == 2 { found[$1] = $2 }
        END {
            printf "%6d  %6.3f %6.3f  %7d %6d %6d  %5d %6d %3d  %5.1f  %.1e\n", step, omega, rigid,
                found["particles"], found["groups"], found["system"], solid, liquid, gas, cpu,
                wrong / scale
        }' "$folder/run.txt" "$folder/seen.txt"
done
