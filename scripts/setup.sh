#!/bin/sh
# Makes sure that the packages gnomon needs are installed (Debian 12 and its relatives).
#
#   scripts/setup.sh build     to build, run and test it (the default)
#   scripts/setup.sh checks    for .ci/run as well: second compiler, sanitizers, linters, GLSL
#                              tools, a Vulkan device
#   scripts/setup.sh figures   for the pictures and plots of README and docs
#   scripts/setup.sh browser   to test the page of gnomon report as well
#
# Installs what is missing with apt-get when it may: as root, or with a sudo that does not ask for a
# password. Otherwise it prints the line to run, and exits with 1. Does nothing when all is there.
set -eu

build="cmake ninja-build pkg-config gcc g++ libembree-dev libassimp-dev libcglm-dev libopenexr-dev
    libspng-dev libturbojpeg0-dev libwebp-dev libcjson-dev libcmocka-dev libjs-chart.js libavcodec-dev
    libavformat-dev libswscale-dev libavutil-dev"
checks="clang clang-format clang-tidy llvm libclang-rt-dev libomp-dev glslang-tools spirv-tools
    libvulkan-dev mesa-vulkan-drivers"
figures="gnuplot-nox imagemagick jq python3"

case "${1:-build}" in
build) packages=$build ;;
checks) packages="$build $checks" ;;
figures) packages="$build $figures" ;;
browser) packages="$build chromium nodejs" ;;
*)
    echo "usage: $0 [build|checks|figures|browser]" >&2
    exit 2
    ;;
esac

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "setup: not a Debian system; going on with what is there. Needed are the equivalents of:" >&2
    echo "setup:" $packages >&2
    exit 0
fi

installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' $packages 2>/dev/null |
    sed -n 's/^installed //p')
missing=""
for package in $packages; do
    echo "$installed" | grep -qxF "$package" || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" -eq 0 ]; then
    as_root=""
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    as_root="sudo"
else
    echo "setup: packages are missing and only an administrator can install them. Run:" >&2
    echo "    sudo apt-get install -y --no-install-recommends$missing" >&2
    exit 1
fi

echo "setup: installing$missing"
$as_root apt-get update -q
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
