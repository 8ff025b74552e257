#!/bin/sh
# The dialect's promise: the same bits from every compiler, optimisation level, instruction set and
# number of lanes. Compilers and instruction sets that are not here are left out, by name.
set -eu

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
here=$SOURCE/tests/lanes
checked=0
failed=0

# Functions that are not compared.
for header in "$SOURCE"/include/gnomon/shadow/*.h; do
    names=$(sed -nE 's/^GN_FN [a-z_0-9]+ (gn_[a-z_0-9]+)\(.*/\1/p' "$header")
    for name in $names; do
        if ! grep -q "[^a-z_0-9]$name(" "$here/functions.h"; then
            echo "FAILED: tests/lanes/functions.h does not have $name of $(basename "$header")"
            failed=1
        fi
    done
done

# check COMPILER FLAG...
check() {
    "$@" -std=gnu17 -ffp-contract=off -fno-math-errno -fno-trapping-math -Wno-psabi \
        -I "$SOURCE/include" "$here"/lanes_*.c "$here/inputs.c" "$here/print.c" \
        -o "$folder/print" -lm
    # One line a function, however many lanes.
    "$folder/print" | LC_ALL=C sort -u >"$folder/lines"
    checked=$((checked + 1))
    if [ ! -f "$folder/expected" ]; then
        cp "$folder/lines" "$folder/expected"
    fi
    functions=$(cut -d' ' -f1 "$folder/lines" | sort -u | wc -l)
    if [ "$functions" -gt 0 ] && [ "$(wc -l <"$folder/lines")" -eq "$functions" ] &&
        cmp -s "$folder/expected" "$folder/lines"; then
        echo "ok: $*, $functions functions"
    else
        diff "$folder/expected" "$folder/lines" || true
        echo "FAILED: $*"
        failed=1
    fi
}

for compiler in gcc clang; do
    if ! command -v $compiler >/dev/null; then
        echo "left out: $compiler is not installed"
        continue
    fi
    for level in -O0 -O2 -O3; do
        check $compiler $level
    done
    # Flags of kernels_avx2.c and kernels_avx512.c; -mfma so that a contraction would show.
    if grep -qw avx2 /proc/cpuinfo && grep -qw fma /proc/cpuinfo; then
        check $compiler -O2 -mavx2 -mfma
    else
        echo "left out: no AVX2 here"
    fi
    if grep -qw avx512bw /proc/cpuinfo && grep -qw avx512vl /proc/cpuinfo; then
        check $compiler -O2 -mavx2 -mfma -mavx512f -mavx512dq -mavx512vl -mavx512bw
    else
        echo "left out: no AVX-512 here"
    fi
done
[ "$checked" -gt 0 ] || exit 77
exit $failed
