#!/bin/sh
# Makes a small report and opens it in headless Chromium, 1440 and 390 pixels wide: drive.mjs moves
# its sliders, flips, zooms, and looks at its plots.
set -eu

for tool in chromium node; do
    command -v "$tool" >/dev/null || {
        echo "report: skipped, there is no $tool (scripts/setup.sh browser)"
        exit 77
    }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$BUILD/bin/gnomon" report railing -o "$folder/report" --size 96x54 --frames 3 --camera CamRailing \
    --methods ray-mip0,lt-vsm --figures sequence,leak2,moment3 --quiet >/dev/null
node "$SOURCE/tests/report/drive.mjs" "$folder/report/index.html"
