#!/bin/sh
# Brings every C file into the style of .clang-format; with --check, only says what is not in it.
set -eu
cd "$(dirname "$0")/.."

files=$(find app benchmarks fuzz include src tests tools -name '*.[ch]' -o -name '*.inc' -o -name '*.cpp')
if [ "${1:-}" = --check ]; then
    clang-format --dry-run -Werror $files
else
    clang-format -i $files
fi
