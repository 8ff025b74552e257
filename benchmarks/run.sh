#!/bin/sh
# Every table of docs/benchmarks.md. Run it on an idle machine.
#
#   benchmarks/run.sh GNOMON [stability|speed|threads|growth|lights|tracers|tracer-growth|filter|depth|
#                             evaluate|maps|leak|leak-sizes|leak-lights ...]
#
# GNOMON is the program. With GNOMON_SCENES set to a folder that holds grove.glb, court.glb and
# leafbox.glb, those are measured beside the built-in scenes.
#
# leak, leak-sizes and leak-lights leave JSON in out/leak, from which benchmarks/leak.py (Python 3)
# makes tables, those in docs/benchmarks.md among them, and docs/images/leak-*.svg. Their settings,
# environment variables with these defaults: FRAMES=60 SIZE=1920x1080 FPS=60 START=1 (seconds)
# RUNS=1 (the fastest of so many counts) RESULTS=out/leak IMAGES=docs/images
# DOCUMENT=docs/benchmarks.md. "leak leak-sizes leak-lights" takes a quarter of an hour on two
# cores.
set -eu

gnomon=${1:?usage: benchmarks/run.sh GNOMON [PART ...]}
shift
scenes=${GNOMON_SCENES:+$GNOMON_SCENES/grove.glb}

bench() {
    echo
    echo "\$ gnomon bench $*"
    "$gnomon" bench "$@" --quiet
}

# Flicker, toggles and error over a slow camera walk (the ray cone paper's main claim).
stability() {
    for scene in grove $scenes; do
        bench "$scene" --tracer bvh --camera CamWalk --frames 60 --repeats 1 --reference 64 --reference-frames 4
    done
}

# Against the naive baseline, from fixed cameras.
speed() {
    for scene in grove $scenes; do
        for camera in CamRoad CamGlade CamWall CamWalk; do
            bench "$scene" --tracer bvh --camera "$camera" --frames 3 --repeats 5
        done
    done
    bench court --tracer bvh --frames 3 --repeats 5
    [ -z "$scenes" ] || bench "$GNOMON_SCENES/court.glb" --tracer bvh --frames 3 --repeats 5
}

threads() {
    for threads in 1 2; do
        for scene in grove $scenes; do
            bench "$scene" --tracer bvh --camera CamWalk --frames 3 --repeats 5 --threads "$threads"
        done
    done
}

# 0.2, 2 and 20 million instanced triangles.
growth() {
    for scale in 0.57 5.7 57; do
        bench grove --tracer bvh --scale "$scale" --camera CamWalk --frames 3 --repeats 3
    done
}

# A point light in a box.
lights() {
    bench leafbox --tracer bvh --camera CamOrbit --frames 12 --repeats 3
    [ -z "$scenes" ] || bench "$GNOMON_SCENES/leafbox.glb" --tracer bvh --camera CamOrbit --frames 12 --repeats 3
}

# Tree and light buffer over camera walks, building included; all rays and leak tracing.
tracers() {
    for scene in grove court leafbox ${GNOMON_SCENES:+grove.glb court.glb leafbox.glb}; do
        case $scene in
        *leafbox*) camera=CamOrbit ;;
        *) camera=CamWalk ;;
        esac
        case $scene in
        *.glb) path=$GNOMON_SCENES/$scene ;;
        *) path=$scene ;;
        esac
        bench "$path" --camera "$camera" --frames 60 --warm-up 0 --repeats 1 --methods \
            ray-mip0:bvh,ray-mip0:light-buffer,ray-mip0,ray-saturate:bvh,ray-saturate:light-buffer,\
ray-saturate,lt-vsm:bvh,lt-vsm:light-buffer
    done
}

# 0.2, 2 and 20 million instanced triangles in a light buffer, its first frame and the next.
tracer_growth() {
    for scale in 0.57 5.7 57; do
        for camera in CamWalk CamRoad; do
            bench grove --scale "$scale" --camera "$camera" --frames 2 --warm-up 0 --repeats 1 \
                --methods ray-mip0:bvh,ray-mip0:light-buffer
        done
    done
}

# Making the texels of a shadow map: fused, in three passes, and a memcpy.
filter() {
    bench --filter
}

# Drawing its depth: triangles against ray packets, and a whole set of cascades.
depth() {
    for scene in grove $scenes; do
        bench --maps "$scene" --camera CamRoad
    done
}

# Reading it: nanoseconds a pixel.
evaluate() {
    bench --evaluate grove --camera CamRoad
}

# Map methods over a camera walk, maps kept from frame to frame, beside rays.
maps() {
    for scene in grove $scenes; do
        bench "$scene" --tracer bvh --camera CamWalk --frames 30 --repeats 1 \
            --methods ray-mip0,ray-test,ray-coverage,sm,pcf,pcf9,vsm,evsm,msm64,nlmsm64,nlmsm32,sd-vsm
    done
}

# Leak tracing ------------------------------------------------------------------------------------

FRAMES=${FRAMES:-60} SIZE=${SIZE:-1920x1080} FPS=${FPS:-60} START=${START:-1} RUNS=${RUNS:-1}
RESULTS=${RESULTS:-out/leak} IMAGES=${IMAGES:-docs/images} DOCUMENT=${DOCUMENT:-docs/benchmarks.md}

# PART NAME SCENE FRAMES METHODS [OPTION...]: leaves PART@NAME.json.
record() {
    part=$1 name=$2 scene=$3 frames=$4 methods=$5
    shift 5
    case $scene in
    *leafbox*) camera=CamOrbit ;;
    *) camera=CamWalk ;;
    esac
    mkdir -p "$RESULTS"
    echo "$(date +%T) $part, $name" >&2
    "$gnomon" bench "$scene" --tracer bvh --camera "$camera" --size "$SIZE" --fps "$FPS" --time "$START" \
        --warm-up 8 --frames "$frames" --repeats "$RUNS" --methods "$methods" --quiet --json "$@" \
        >"$RESULTS/new"
    mv "$RESULTS/new" "$RESULTS/$part@$name.json"
}

evaluate_leaks() {
    python3 "$(dirname "$0")/leak.py" "$@" || {
        echo "leak.py failed, or there is no Python 3: the results are in $RESULTS" >&2
        exit 1
    }
}

report() {
    evaluate_leaks report "$RESULTS" --images "$IMAGES" --into "$DOCUMENT"
}

# Speed, errors and flicker over the camera's path of every scene (the leak tracing paper's Table 2
# and Figure 7), parts switched off (Table 3) and types of maps (Figure 8a).
leak() {
    for scene in grove court leafbox ${GNOMON_SCENES:+grove.glb court.glb leafbox.glb}; do
        case $scene in
        *.glb) path=$GNOMON_SCENES/$scene ;;
        *) path=$scene ;;
        esac
        record path "$scene" "$path" "$FRAMES" \
            ray-saturate,lt-evsm,lt-vsm,ray-mip0,lt-evsm:mip0,lt-vsm:mip0
    done
    record ablation grove "${scenes:-grove}" $(((FRAMES + 1) / 2)) \
        "ray-saturate,sm:no-reuse,vsm:no-reuse,msm128:no-reuse,ltt-evsm,lt-evsm:no-reuse,\
lt-evsm:no-remove,lt-evsm:no-expand,lt-evsm,lt-vsm,lt-esm,lt-msm,lt-evsm:filtered,lt-vsm:filtered,\
lt-esm:filtered,lt-msm:filtered,lt-nlmsm64,lt-nlmsm32,hybrid-pcf"
    report
}

# Larger and smaller pictures (Figure 8b) and maps (section 4.2.1).
leak_sizes() (
    for SIZE in 1280x720 1920x1080 2560x1440 3840x2160; do
        record height "$SIZE" "${scenes:-grove}" $(((FRAMES + 3) / 4)) ray-saturate,lt-evsm
    done
    SIZE=1920x1080
    record texels grove "${scenes:-grove}" $(((FRAMES + 1) / 2)) \
        ray-saturate,lt-evsm:size=512,lt-evsm:size=1024,lt-evsm:size=2048,lt-evsm:size=4096
    report
)

# 1 to 42 point lights in the leaf box, maps of 1024x1024 as the paper's code has for them.
leak_lights() (
    SIZE=960x540
    for count in 1 4 16 42; do
        record lights "$count" leafbox 4 ray-saturate,lt-evsm --lamps "$count" --map-size 1024
    done
    report
)

[ $# -gt 0 ] || set -- stability speed threads growth lights tracers tracer-growth filter depth evaluate maps leak \
    leak-sizes leak-lights
for part; do
    "$(echo "$part" | tr - _)"
done
