#!/bin/sh
# The algorithm headers as GLSL: every shader of shaders/check compiles for Vulkan 1.3 and is valid
# SPIR-V, every algorithm header has such a shader, and it calls each function of its header.
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
    [ "$name" != dialect_end ] || continue
    if [ ! -f "$SOURCE/shaders/check/$name.comp" ]; then
        echo "FAILED: shaders/check/$name.comp is missing"
        failed=1
        continue
    fi
    # Functions of the algorithms begin with GN_FN, those for GLSL alone with their type.
    functions=$(sed -nE 's/^(GN_FN [a-z_0-9]+|float|int|uint|bool) (gn_[a-z_0-9]+)\(.*/\2/p' "$header")
    for function in $functions; do
        if ! grep -q "[^a-z_0-9]$function(" "$SOURCE/shaders/check/$name.comp"; then
            echo "FAILED: shaders/check/$name.comp does not call $function"
            failed=1
        fi
    done
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
