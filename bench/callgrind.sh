#!/bin/sh
# Instructions of the two hot loops, counted by valgrind: no noise, so that a loop that has become
# longer is seen at once. Each loop runs twice, longer the second time; the difference has neither
# start-up nor reading in it.
#
#     bench/callgrind.sh BENCH_FORCE [ISA]
#
# ISA: avx2 or plain (valgrind 3.19 knows no AVX-512); by default the wider that runs. Exit status:
# 0 within the bounds, 1 above one, 2 used wrongly, 77 where nothing can be counted here.
set -eu

# Instructions a unit at most: measured with GCC 12 at -O3, and a tenth.
bound() {
    case $1-$2 in
    fluid-avx2) echo 231 ;;
    fluid-plain) echo 267 ;;
    swirl-avx2) echo 8.2 ;;
    swirl-plain) echo 23.2 ;;
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

# count LOOP UNIT SHORT LONG
count() {
    short=$(under_valgrind "$1" "$isa" "$3") || skip "$isa does not run under valgrind"
    long=$(under_valgrind "$1" "$isa" "$4")
    echo "$short $long" | awk -v name="$1 ($isa)" -v unit="$2" -v bound="$(bound "$1" "$isa")" '{
        each = ($3 - $1) / ($4 - $2)
        printf "%s: %.2f instructions per %s (bound %.2f)\n", name, each, unit, bound
        exit !(each > 0 && each <= bound)
    }' || { echo "above the bound: $1"; failed=1; }
}

failed=0
count fluid "particle and step" 100 600
count swirl "ordered pair" 2 22
exit $failed
