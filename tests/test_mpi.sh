#!/bin/bash
# A study under mpiexec, several ranks on this machine: the same results as by one process, also when
# a rank is killed or all of it is. Argument: the program, beside which driftlab-ranks is.
set -euo pipefail
program=$1
[ -x "$(dirname "$program")/driftlab-ranks" ] || { echo "built without MPI"; exit 77; }
command -v mpiexec >/dev/null || { echo "no mpiexec"; exit 77; }
mpiexec --version 2>&1 | grep -q "OpenRTE\|Open MPI" || { echo "not Open MPI's mpiexec"; exit 77; }
studies=$(cd "$(dirname "$0")/../studies" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 # a container's

fail() {
    echo "FAIL: $*" >&2
    tail -n 20 "$work"/*.err "$work/compared" >&2 || true
    exit 1
}

# Processes of `study $work/NAME.yaml`, but for mpiexec: the program's own, by the rank they were
# started as. A rank's cases run in children of it, which are no ranks.
processes_of() { # NAME
    pgrep -f "^$program study $work/$1.yaml" || true
}

rank_of() { # PID
    tr '\0' '\n' <"/proc/$1/environ" 2>/dev/null | sed -n 's/^OMPI_COMM_WORLD_RANK=//p'
}

parent_of() { # PID
    ps -o ppid= -p "$1" | tr -d ' '
}

# A rank other than the first that is at a case, or nothing.
busy_rank() { # NAME
    local pid above
    for pid in $(processes_of "$1"); do
        above=$(parent_of "$pid")
        [ "${above:-1}" -gt 1 ] || continue
        [[ $(rank_of "$pid") =~ ^[1-9]$ ]] || continue
        [ "$(rank_of "$above")" != "$(rank_of "$pid")" ] || { echo "$above"; return; }
    done
}

# Waits, 20 s at most, until the words say something, and says it.
wait_for() { # COMMAND...
    local said
    for _ in $(seq 200); do
        said=$("$@")
        [ -z "$said" ] || { echo "$said"; return; }
        sleep 0.1
    done
    return 1
}

kept_in() { # FILE: "yes" where there are two cases or more
    local found
    found=$("$program" compare "$1" "$1" 2>/dev/null | sed -n 's/^\([0-9]*\) in both.*/\1/p')
    [ "${found:-0}" -lt 2 ] || echo yes
}

gone() { # NAME
    [ -n "$(processes_of "$1" | xargs -r ps -o stat= -p | grep -v Z || true)" ] || echo yes
}

same() { # A B COUNT
    "$program" compare "$work/$1.h5" "$work/$2.h5" >"$work/compared"
    grep -q "^$3 in both, $3 of them alike in every count, error and verdict .* 0 only in A, 0 only in B" \
        "$work/compared" || fail "$1 and $2 differ"
}

study() { # NAME
    printf 'name: %s\nscene: %s\nsamples: 2\nerror: 1e-6\nrepeats: 1\n' "$1" "$studies/stream/stream.yaml"
    printf 'reference: {extended: long-double}\n'
}

{
    study cases
    echo "limits: {seconds: 60}"
    echo "cases:"
    echo "  - {method: leapfrog, step: [2.5e-6, 5.0e-6, 1.0e-5, 2.0e-5, 0.01]}"
    echo "  - {method: composition-4-suzuki, step: [1.0e-5, 2.0e-5, 0.01]}"
    echo "  - {method: gsl-rk8pd, atol: 1.0e-12, rtol: [1.0e-6, 1.0e-8, 1.0e-12]}"
} >"$work/cases.yaml"

# --- the same as by one process, and nothing but what that says ---

"$program" study "$work/cases.yaml" --out "$work/one.h5" >"$work/one.out" 2>"$work/one.err"
[ ! -s "$work/one.err" ] || fail "one process says something"
mpiexec --oversubscribe -n 4 "$program" study "$work/cases.yaml" --out "$work/four.h5" \
    >"$work/four.out" 2>"$work/four.err" || fail "four ranks end with $?"
same one four 11
[ "$(grep -c '^results: ' "$work/four.out")" = 1 ] || fail "not one process prints"
! grep -qv '^[0-9]*/12  ' "$work/four.err" || fail "four ranks say more than their progress"
[ "$(wait_for gone cases)" = yes ] || fail "processes are left"

# --- a rank that is killed costs its case, which another does ---

mpiexec --oversubscribe -n 3 "$program" study "$work/cases.yaml" --out "$work/lost.h5" \
    >"$work/lost.out" 2>"$work/lost.err" &
mpi=$!
victim=$(wait_for busy_rank cases) || fail "no rank is at a case"
kill -KILL "$victim"
wait "$mpi" || fail "with a killed rank mpiexec ends with $?"
grep -q '^driftlab: rank [12] on .* is lost; "stream-v50: .*" is handed to another$' "$work/lost.err" ||
    fail "nothing is said of the killed rank"
same one lost 11

# --- all of it killed: what is finished is kept, and the rest is done when it is started again ---

mpiexec --oversubscribe -n 3 "$program" study "$work/cases.yaml" --out "$work/again.h5" \
    >"$work/killed.out" 2>"$work/killed.err" &
mpi=$!
wait_for kept_in "$work/again.h5" >/dev/null || fail "no case is kept"
kill -KILL "$mpi"
wait "$mpi" 2>/dev/null || true
[ "$(wait_for gone cases)" = yes ] || fail "processes outlive mpiexec"
cp "$work/again.h5" "$work/part.h5"
[ -n "$(kept_in "$work/part.h5")" ] || fail "the cases are gone"
mpiexec --oversubscribe -n 3 "$program" study "$work/cases.yaml" --out "$work/again.h5" \
    >"$work/again.out" 2>"$work/again.err" || fail "started again it ends with $?"
same one again 11
"$program" compare "$work/part.h5" "$work/again.h5" >"$work/compared"
kept=$(sed -n 's/^\([0-9]*\) in both.*/\1/p' "$work/compared")
if [ "$kept" -lt 2 ] || [ "$kept" -ge 11 ]; then fail "$kept cases were kept, expected some"; fi
grep -q '^CPU seconds, B/A: median 1 (1 to 1)$' "$work/compared" || fail "kept cases were done again"

# --- control-C, and a limit on time ---

{
    study endless
    echo "limits: {seconds: 600}"
    echo "cases: [{method: leapfrog, step: [0.01, 0.02, 1.0e-9, 2.0e-9]}]"
} >"$work/endless.yaml"
mpiexec --oversubscribe -n 3 "$program" study "$work/endless.yaml" --out "$work/endless.h5" \
    >"$work/endless.out" 2>"$work/endless.err" &
mpi=$!
wait_for kept_in "$work/endless.h5" >/dev/null || fail "no case is kept"
kill -INT "$mpi"
! wait "$mpi" || fail "interrupted, it says that all is well"
grep -q "^driftlab: interrupted: 2 of 4 cases are kept in " "$work/endless.err" || fail "nothing is said of the interrupt"
[ "$(wait_for gone endless)" = yes ] || fail "processes outlive an interrupt"
sed 's/seconds: 600/seconds: 0.2/' "$work/endless.yaml" >"$work/limited.yaml"
mpiexec --oversubscribe -n 3 "$program" study "$work/limited.yaml" --out "$work/endless.h5" \
    >"$work/limited.out" 2>"$work/limited.err" || fail "with a limit it ends with $?"
[ "$(grep -c timeout "$work/limited.out")" -ge 2 ] || fail "no case meets the limit on time"

# --- what cannot be: said once ---

! mpiexec --oversubscribe -n 3 "$program" study "$work/none.yaml" >"$work/none.out" 2>"$work/none.err" ||
    fail "a study that is not there is run"
# (a process that mpiexec stops meanwhile may say that it was interrupted)
[ "$(grep -c "^driftlab: .*none.yaml: No such file" "$work/none.err")" = 1 ] || fail "not one process says what is wrong"
! mpiexec --oversubscribe -n 2 "$program" study "$work/cases.yaml" -j 2 --out "$work/four.h5" \
    >"$work/jobs.out" 2>"$work/jobs.err" || fail "-j goes with mpiexec"
grep -q 'expected 1 under mpiexec' "$work/jobs.err" || fail "nothing is said of -j"

# The program itself never has MPI in it.
! ldd "$program" | grep -q libmpi || fail "the program loads MPI"
echo "ok"
