#!/bin/sh
# The built-in grove with several methods: pictures, a table, and a page that shows them together.
#
#   scripts/demo.sh PROGRAM FOLDER
set -eu
gnomon=$1
folder=$2
methods="ray-mip0 ray-test ray-raw ray-saturate ray-coverage"
size=1280x720

mkdir -p "$folder"
scene=$folder/grove.glb
page=$folder/index.html
[ -f "$scene" ] || "$gnomon" scene grove -o "$scene"

for method in $methods; do
    "$gnomon" render "$scene" --method $method --size $size -o "$folder/$method.png"
done
"$gnomon" bench "$scene" --methods "$(echo $methods | tr ' ' ',')" --size $size --frames 8 \
    >"$folder/table.txt"

{
    cat <<'END'
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>gnomon: the grove</title>
<style>
body { font: 16px/1.5 sans-serif; max-width: 1300px; margin: 2em auto; padding: 0 1em; }
img { width: 100%; display: block; }
figure { margin: 0 0 2em; }
figcaption { font-weight: bold; }
pre { overflow-x: auto; background: #f4f4f4; padding: 1em; }
</style>
<h1>The grove, one shadow ray for each pixel</h1>
<p>The same scene, light and rays; only what a leaf does to a ray differs. Look at the shadows of
the leaves on the ground. What the columns mean is in docs/metrics.md.</p>
<pre>
END
    sed 's/&/\&amp;/g; s/</\&lt;/g' "$folder/table.txt"
    echo "</pre>"
    for method in $methods; do
        echo "<figure><figcaption>$method</figcaption><img src=\"$method.png\" alt=\"$method\"></figure>"
    done
    echo "</html>"
} >"$page"

cat "$folder/table.txt"
echo "Pictures, the table and a page are in $folder: open $page"
