#!/bin/sh
# The hot loops stay within their bounds of instructions; skipped (77) where there is no valgrind
# or the build is sanitised or not Release. Argument: the program, beside which bench_force is.
set -eu
here=$(dirname "$0")
bench=$(dirname "$1")/bench_force
"$here/../bench/callgrind.sh" "$bench"
