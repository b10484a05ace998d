#!/bin/sh
# The benchmark runs and tells what it should; nothing here depends on how fast the machine is.
# Argument: the program, beside which bench_force is.
set -eu
bench=$(dirname "$1")/bench_force
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
    echo "test_bench: $1" >&2
    exit 1
}
expect() { # FILE TEXT
    grep -qF -- "$2" "$1" || { cat "$1" >&2; fail "\"$2\" is not in $1"; }
}

# The table, the JSON and the README, with LAMMPS where it is installed. Its temporary folder goes.
mkdir "$work/tmp"
TMPDIR=$work/tmp "$bench" --quick --readme "$work/readme" >"$work/table"
[ -z "$(ls -A "$work/tmp")" ] || fail "files were left in TMPDIR"
for text in 'leap-frog, settled fluid' 'forces, swirl' 'ns/particle/step' 'ns/ordered pair' \
    '(chosen)' '<= 12:' '<= 0.4:' 'layer, 10^4' 'crystal, 10^4' '<= 25:' 'the reference kernel' 'neighbour-list, plain' LAMMPS \
    'nothing acts' 'gravity alone' 'no walls, stream' 'a loop by hand' 'ratio >= 0.95:'; do
    expect "$work/table" "$text"
    expect "$work/readme" "$text"
done
for text in 'processor: ' 'compiler: ' 'date: ' '--readme bench/README.md' '(chosen)'; do
    expect "$work/readme" "$text"
done
if command -v lmp >/dev/null; then
    expect "$work/table" 'ratio >= 2.40:'
    expect "$work/table" 'forces at step 0 differ from ours by'
fi

# Without LAMMPS it says so and goes on.
PATH=$work/tmp "$bench" --quick --json >"$work/json"
for text in '"benchmark": "force"' '"lammps": "skipped' '"processor":' '"minimum":' '"median":' \
    '"repeats": 2' '"target": 12.0' '"target_met":' '"unit": "ns/ordered pair"'; do
    expect "$work/json" "$text"
done

# The loops that an instruction counter runs.
"$bench" --loop fluid --isa plain --count 3 >"$work/loop"
expect "$work/loop" 'loop fluid isa plain units 834 '
"$bench" --loop swirl --isa plain --count 2 >"$work/loop"
expect "$work/loop" 'loop swirl isa plain units 113764 '
for loop in free free-verlet free-by-hand falling falling-by-hand; do
    "$bench" --loop "$loop" --isa plain --count 2 >"$work/loop"
    expect "$work/loop" "loop $loop isa plain units 2000 "
done

# Refused, with status 2.
for arguments in '--nonsense' '--loop nonsense' '--loop fluid --isa nonsense' '--count 0' 'x'; do
    status=0
    # shellcheck disable=SC2086 # words
    "$bench" $arguments >"$work/out" 2>&1 || status=$?
    [ "$status" -eq 2 ] || fail "\"$arguments\": status $status, expected 2"
done
