#!/bin/sh
# The algorithm headers as GLSL, run on a Vulkan device that is a processor (Mesa's lavapipe): every
# function of tests/lanes/functions.h, and the chain from depths to visibility, gives the same bits
# as in scalar C where arithmetic is precise, NaNs whatever their payload, and else what stays
# within the bounds of functions.c and chain.c.
set -eu

if ! command -v glslangValidator >/dev/null; then
    echo "skipped: glslangValidator is not installed (scripts/setup.sh checks)"
    exit 77
fi
if ! pkg-config --exists vulkan; then
    echo "skipped: the Vulkan loader and headers are not installed (scripts/setup.sh checks)"
    exit 77
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
here=$SOURCE/tests/vulkan

for shader in functions chain; do
    glslangValidator --quiet -V --target-env vulkan1.1 -I"$SOURCE/include" -o "$folder/$shader.spv" \
        "$here/$shader.comp"
done
"$CC" -std=gnu17 -O2 -ffp-contract=off -fno-math-errno -fno-trapping-math \
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -I "$SOURCE/include" -I "$SOURCE/tests" \
    "$here"/*.c "$SOURCE/tests/lanes/inputs.c" "$SOURCE/tests/lanes/lanes_1.c" \
    $(pkg-config --cflags --libs vulkan) -lm -o "$folder/vulkan"
"$folder/vulkan" "$folder/functions.spv" "$folder/chain.spv"
