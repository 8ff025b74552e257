#!/bin/sh
# The algorithm headers as GLSL: every shader of shaders/check compiles for Vulkan 1.3 and is valid
# SPIR-V, and every algorithm header has such a shader.
set -eu

for tool in glslangValidator spirv-val; do
    if ! command -v $tool >/dev/null; then
        echo "skipped: $tool is not installed (scripts/setup.sh checks)"
        exit 77
    fi
done

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0

for header in "$SOURCE"/include/gnomon/shadow/*.h; do
    name=$(basename "$header" .h)
    if [ "$name" != dialect_end ] && [ ! -f "$SOURCE/shaders/check/$name.comp" ]; then
        echo "FAILED: shaders/check/$name.comp is missing"
        failed=1
    fi
done

for shader in "$SOURCE"/shaders/check/*.comp; do
    if glslangValidator -V --target-env vulkan1.3 -I"$SOURCE/include" -o "$folder/out.spv" \
        "$shader" >"$folder/log" 2>&1 && spirv-val --target-env vulkan1.3 "$folder/out.spv"; then
        echo "ok: $(basename "$shader")"
    else
        cat "$folder/log"
        echo "FAILED: $shader"
        failed=1
    fi
done
exit $failed
