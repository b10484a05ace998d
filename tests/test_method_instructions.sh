#!/bin/sh
# What methods do beyond their forces stays within its bounds of instructions; skipped (77) where
# there is no valgrind or the build is sanitised or not Release. Argument: the program.
set -eu
exec "$(dirname "$0")/../bench/callgrind_methods.sh" "$1"
