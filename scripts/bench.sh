#!/bin/sh
# The figures of docs/benchmarks.md: times, rays, flicker and errors at 1920x1080 on the procedural
# grove, against a plain single-ray loop. With GNOMON_SCENES=FOLDER also on the grove.glb in there.
#
#   scripts/bench.sh PROGRAM FOLDER
set -eu
gnomon=$1
folder=$2
methods=naive,ray-mip0,ray-test,ray-raw,ray-saturate,ray-coverage

mkdir -p "$folder"
[ -f "$folder/grove.glb" ] || "$gnomon" scene grove -o "$folder/grove.glb"
for scene in "$folder/grove.glb" ${GNOMON_SCENES:+"$GNOMON_SCENES/grove.glb"}; do
    echo "== $scene"
    "$gnomon" bench "$scene" --methods $methods --frames 60
done
