#!/bin/sh
# The pictures of docs/methods.md: each filterable map beside percentage-closer filtering of the same
# depths, with the difference (orange: lighter, blue: darker); pcf9 and sm beside traced rays.
#
#   scripts/figures.sh GNOMON [FOLDER]
#
# GNOMON is the program, FOLDER docs/images unless told otherwise.
set -eu

gnomon=${1:?usage: scripts/figures.sh GNOMON [FOLDER]}
folder=${2:-docs/images}
mkdir -p "$folder"

pair() { # A B [OPTION...]
    a=$1
    b=$2
    shift 2
    "$gnomon" compare railing --a "$a" --b "$b" --size 420x236 --quiet -o "$folder/$b.png" "$@"
}

pair ray-mip0 sm
pair ray-mip0 pcf9
for method in vsm esm evsm128 msm64 msm128 nlmsm64 nlmsm32; do
    # One bias for both, or the difference would show that.
    pair pcf9 "$method" --map-samples 1 --normal-bias 6
done
pair ray-mip0 sd-evsm

# Three casters one behind the other, and a shadow over a short distance: the moment paper's Figures
# 9 and 8.
pair pcf9 nlmsm64 --camera CamUmbrella --cascades 1 --map-size 256 --reading nearest \
    --normal-bias 8 --gain 20 -o "$folder/three-casters.png"
pair nlmsm64 nlmsm32 --cascades 1 --reading nearest --depth-bias 0.0005 --gain 20 \
    -o "$folder/banding.png"

# xi4 under filters of several widths: its Figure 4.
"$gnomon" histogram railing --quiet -o "$folder/xi4.svg"
