#!/bin/sh
# Every picture and plot of README and docs, and the tables of leak tracing in docs/benchmarks.md.
# Needs ImageMagick, gnuplot, jq and Python 3 (scripts/setup.sh figures).
#
#   scripts/figures.sh GNOMON [FOLDER [pictures|plots ...]]
#
# GNOMON is the program, FOLDER docs/images unless told otherwise. pictures: of README.md,
# docs/methods.md and docs/metrics.md, some minutes; they do not depend on the machine. plots: those of
# docs/benchmarks.md, by benchmarks/run.sh, a quarter of an hour on an idle machine; the document's
# tables are written anew with them (in a copy in FOLDER where one is given). Both unless told
# otherwise.
set -eu

gnomon=${1:?usage: scripts/figures.sh GNOMON [FOLDER]}
folder=${2:-docs/images}
document=docs/benchmarks.md
if [ $# -ge 2 ]; then
    document=$folder/benchmarks.md
    shift
fi
shift
mkdir -p "$folder"
if [ "$document" != docs/benchmarks.md ]; then
    cp docs/benchmarks.md "$document"
fi

pictures() (

# The README's.
"$gnomon" render grove --camera CamRoad --size 960x540 --quiet -o "$folder/grove.png"

# How long the lists of a light buffer are.
"$gnomon" render grove --camera CamRoad --tracer light-buffer --aov light-buffer --size 960x540 --quiet \
    -o "$folder/tiles.png"
mv "$folder/tiles.light-buffer.png" "$folder/light-buffer.png"
rm "$folder/tiles.png"

# Each filterable map beside percentage-closer filtering of the same depths, with the difference
# (orange: lighter, blue: darker); pcf9 and sm beside traced rays.
pair() { # A B [OPTION...]
    a=$1
    b=$2
    shift 2
    "$gnomon" compare railing --a "$a" --b "$b" --size 420x236 --quiet -o "$folder/$b.png" "$@" >/dev/null
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
"$gnomon" histogram railing --quiet -o "$folder/xi4.svg" >/dev/null

# One row of pixels over time, with a reference: docs/metrics.md.
"$gnomon" bench grove --camera CamWalk --size 480x270 --frames 90 --repeats 1 --quiet \
    --methods ray-mip0,ray-coverage,ray-raw,sm --reference 16 --reference-frames 90 \
    --profile "$folder/profile.png" --profile-row 150 >/dev/null

# Leak tracing, on the built-in scene of what a map's texels miss.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

edges() { # OUT [OPTION...]; the AOVs lie beside OUT
    out=$1
    shift
    "$gnomon" render edges --quiet --aov "$aovs" -o "$work/$out" "$@"
}

cut_out() { # WIDTHxHEIGHT+X+Y SCALE NAME OUT: a part of a picture, enlarged, with a border
    convert "$work/$3.png" -crop "$1" +repage -filter point -resize "$2" -bordercolor gray50 \
        -border 2 "$work/$4.png"
}

# Its Figures 4 and 5: visibility and classes of the test alone; classes with rays added, then taken
# away; visibility.
aovs=visibility,class
for camera in CamEdges CamGaps; do
    still="--camera $camera --size 960x540 --map-size 512 --warm-up 12"
    edges $camera.test.png $still --method ltt-vsm
    edges $camera.add.png $still --method lt-vsm --no-remove
    edges $camera.mask.png $still --method lt-vsm
done
row() { # CAMERA WIDTHxHEIGHT+X+Y OUT
    cut_out "$2" 200% "$1.test.visibility" a
    cut_out "$2" 200% "$1.test.class" b
    cut_out "$2" 200% "$1.add.class" c
    cut_out "$2" 200% "$1.mask.class" d
    cut_out "$2" 200% "$1.mask.visibility" e
    (cd "$work" && convert a.png b.png c.png d.png e.png +append "$3.png")
}
row CamEdges 140x140+90+250 roller
row CamEdges 140x140+540+145 vanes
row CamGaps 140x140+815+225 sheet
(cd "$work" && convert roller.png vanes.png sheet.png -append classes.png)
cp "$work/classes.png" "$folder/leak-classes.png"

# Its Figure 10: a map of 64 x 64 and a fence that the mask does not know of at first; after 20 and
# 200 frames. Last: known from the first frame.
aovs=visibility
fence="--camera CamFence --size 640x360 --map-size 64 --cascades 1 --shadow-distance 15"
fence="$fence --method lt-evsm"
edges fence.png $fence --no-expand --no-remove --warm-up 10 --history-out "$work/history"
edges fence.####.png $fence --frames 1:200 --history-in "$work/history"
edges whole.png $fence --warm-up 10
part=640x170+0+140
cut_out $part 100% fence.visibility a
cut_out $part 100% fence.0020.visibility b
cut_out $part 100% fence.0200.visibility c
cut_out $part 100% whole.visibility d
(cd "$work" && convert \( a.png b.png +append \) \( c.png d.png +append \) -append fences.png)
cp "$work/fences.png" "$folder/leak-fence.png"

# Its Figure 9: a tree far away under a low sun, a moving camera, a map of 512 x 512: the test alone,
# with the mask, rays.
tree="--camera CamTree --sun 5,12 --size 960x540 --fps 60 --frames 20:20"
edges test.#.png $tree --map-size 512 --warm-up 20 --method ltt-evsm
edges mask.#.png $tree --map-size 512 --warm-up 20 --method lt-evsm
edges rays.#.png $tree --method ray-saturate
for picture in test mask rays; do
    cut_out 230x170+340+330 200% $picture.20.visibility $picture
done
(cd "$work" && convert test.png mask.png rays.png +append tree.png)
cp "$work/tree.png" "$folder/leak-tree.png"

# Wrong pixels a frame of a walk.
"$gnomon" bench edges --camera CamWalk --size 640x360 --frames 120 --repeats 1 --quiet --json \
    --methods ltt-vsm:size=512,lt-vsm:size=512,ltt-vsm,lt-vsm >"$work/walk.json"
jq -r '[.methods[0:4][].series.wrong] | transpose | .[] | map(100 * .) | @tsv' "$work/walk.json" \
    >"$work/walk.tsv"
gnuplot <<PLOT
set terminal svg size 720,300 font "sans-serif,12" background "white"
set output "$folder/leak-walk.svg"
set xlabel "frame"
set ylabel "wrong pixels, %"
set logscale y
set yrange [0.001:5]
set key outside
set grid y
plot "$work/walk.tsv" using 0:1 with lines lw 2 dt 2 lc "#d04020" title "ltt-vsm, 512", \
     "" using 0:2 with lines lw 2 lc "#d04020" title "lt-vsm, 512", \
     "" using 0:3 with lines lw 2 dt 2 lc "#2060c0" title "ltt-vsm, 2048", \
     "" using 0:4 with lines lw 2 lc "#2060c0" title "lt-vsm, 2048"
PLOT
)

# A report as a browser shows it; it names this machine.
report() (
    command -v chromium >/dev/null || {
        echo "figures: there is no chromium (scripts/setup.sh browser): report.jpg stays" >&2
        exit 0
    }
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    "$gnomon" report railing -o "$work/report" --size 960x540 --camera CamRailing --methods nlmsm64 \
        --figures moment1 --quiet >/dev/null
    chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --virtual-time-budget=5000 \
        --window-size=1360,1290 --screenshot="$work/report.png" "file://$work/report/index.html#moment" \
        2>/dev/null
    convert "$work/report.png" -quality 85 "$folder/report.jpg"
)

# Speed, errors, sizes and lights of leak tracing; a report.
plots() {
    IMAGES=$folder DOCUMENT=$document benchmarks/run.sh "$gnomon" leak leak-sizes leak-lights
    report
}

[ $# -gt 0 ] || set -- pictures plots
for part; do
    "$part"
done
