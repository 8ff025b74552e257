#!/bin/sh
# Every table of docs/benchmarks.md. Run it on an idle machine.
#
#   benchmarks/run.sh GNOMON [stability|speed|threads|growth|lights|filter|depth|evaluate|maps ...]
#
# GNOMON is the program. With GNOMON_SCENES set to a folder that holds grove.glb, court.glb and
# leafbox.glb, those are measured beside the built-in scenes.
set -eu

gnomon=${1:?usage: benchmarks/run.sh GNOMON [stability|speed|threads|growth|lights|filter|depth|evaluate|maps ...]}
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
        bench "$scene" --camera CamWalk --frames 60 --repeats 1 --reference 64 --reference-frames 4
    done
}

# Against the naive baseline, from fixed cameras.
speed() {
    for scene in grove $scenes; do
        for camera in CamRoad CamGlade CamWall CamWalk; do
            bench "$scene" --camera "$camera" --frames 3 --repeats 5
        done
    done
    bench court --frames 3 --repeats 5
    [ -z "$scenes" ] || bench "$GNOMON_SCENES/court.glb" --frames 3 --repeats 5
}

threads() {
    for threads in 1 2; do
        for scene in grove $scenes; do
            bench "$scene" --camera CamWalk --frames 3 --repeats 5 --threads "$threads"
        done
    done
}

# 0.2, 2 and 20 million instanced triangles.
growth() {
    for scale in 0.57 5.7 57; do
        bench grove --scale "$scale" --camera CamWalk --frames 3 --repeats 3
    done
}

# A point light in a box.
lights() {
    bench leafbox --camera CamOrbit --frames 12 --repeats 3
    [ -z "$scenes" ] || bench "$GNOMON_SCENES/leafbox.glb" --camera CamOrbit --frames 12 --repeats 3
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
        bench "$scene" --camera CamWalk --frames 30 --repeats 1 \
            --methods ray-mip0,ray-test,ray-coverage,sm,pcf,pcf9,vsm,evsm,msm64,nlmsm64,nlmsm32,sd-vsm
    done
}

[ $# -gt 0 ] || set -- stability speed threads growth lights filter depth evaluate maps
for part; do
    "$part"
done
