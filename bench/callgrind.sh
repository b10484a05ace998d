#!/bin/sh
# Instructions of the hot loops, counted by valgrind: no noise, so that a loop that has become
# longer is seen at once. Each loop runs twice, longer the second time; the difference has neither
# start-up nor reading in it. Three loops have bounds; scenes that lack something are held to loops
# written by hand for them, and may cost a twentieth more.
#
#     bench/callgrind.sh BENCH_FORCE [ISA]
#
# ISA: avx2 or plain (valgrind 3.19 knows no AVX-512); by default the wider that runs. Exit status:
# 0 within the bounds, 1 above one, 2 used wrongly, 77 where nothing can be counted here.
set -eu

# Instructions a unit at most: measured with GCC 12 at -O3, and a tenth.
bound() {
    case $1-$2 in
    fluid-avx2) echo 190 ;;
    fluid-plain) echo 239 ;;
    swirl-avx2) echo 4.65 ;;
    swirl-plain) echo 14.2 ;;
    crystal-1e4-avx2) echo 260 ;;
    crystal-1e4-plain) echo 343 ;;
    esac
}

if [ $# -lt 1 ] || [ $# -gt 2 ] || [ ! -x "$1" ]; then
    echo "usage: $0 BENCH_FORCE [avx2|plain]" >&2
    exit 2
fi
bench=$1
isa=${2:-}

skip() {
    echo "skipped: $1"
    exit 77
}
command -v valgrind >/dev/null || skip "there is no valgrind"
build=$("$bench" --loop fluid --isa plain --count 1)
case $build in
*"build Release sanitised no") ;;
*) skip "not a plain Release build ($build)" ;;
esac

# under_valgrind LOOP ISA COUNT: "instructions units"
under_valgrind() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$bench" --loop "$1" --isa "$2" \
        --count "$3" 2>&1 |
        awk '$2 == "Collected" { instructions = $4 } $1 == "loop" { units = $6 }
             END { if (!instructions || !units) exit 1; print instructions, units }'
}

if [ -z "$isa" ]; then
    isa=plain
    if under_valgrind swirl avx2 1 >/dev/null; then isa=avx2; fi
fi

# each LOOP SHORT LONG: sets $each, instructions a unit
each() {
    short=$(under_valgrind "$1" "$isa" "$2") || skip "$isa does not run under valgrind"
    long=$(under_valgrind "$1" "$isa" "$3")
    each=$(echo "$short $long" | awk '{ printf "%.4f", ($3 - $1) / ($4 - $2) }')
}

# judge LOOP UNIT EACH BOUND WHAT
judge() {
    awk -v name="$1 ($isa)" -v unit="$2" -v each="$3" -v bound="$4" -v what="$5" 'BEGIN {
        printf "%s: %.2f instructions per %s (%s %.2f)\n", name, each, unit, what, bound
        exit !(each > 0 && each <= bound)
    }' || { echo "above the bound: $1"; failed=1; }
}

# count LOOP UNIT SHORT LONG
count() {
    each "$1" "$3" "$4"
    judge "$1" "$2" "$each" "$(bound "$1" "$isa")" bound
}

# beside HAND SHORT LONG LOOP...: each of them at most 1.05 of the loop by hand
beside() {
    hand=$1 from=$2 to=$3
    shift 3
    each "$hand" "$from" "$to"
    limit=$(echo "$each" | awk '{ printf "%.4f", 1.05 * $1 }')
    for loop; do
        each "$loop" "$from" "$to"
        judge "$loop" "particle and step" "$each" "$limit" "1.05 of by hand:"
    done
}

failed=0
count fluid "particle and step" 100 600
count swirl "ordered pair" 2 22
count crystal-1e4 "particle and step" 4 24
beside free-by-hand 100 1100 free free-verlet
beside falling-by-hand 100 1100 falling
beside stream-by-hand 100 1100 stream
exit $failed
