#!/bin/sh
# From a fresh checkout to a picture: installs what is missing, builds Cohort, renders a stage.
# Usage: sh examples/quickstart.sh [options for cohort render, such as --spp 16]
set -eu
cd "$(dirname "$0")/.."

fail() {
    echo "quickstart: $1" >&2
    exit 1
}

command -v apt-get > /dev/null || fail "made for Debian 12 and its kin; elsewhere, see README.md for what to install"
sh examples/setup.sh || fail "packages are missing and could not be installed: this needs root or sudo, and a network"

build=build
mkdir -p "$build"
echo "quickstart: building in $build/ (log: $build/quickstart.log)"
{
    cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DCOHORT_TESTS=OFF &&
        cmake --build "$build" --parallel "$(nproc)"
} > "$build/quickstart.log" 2>&1 || {
    tail -n 20 "$build/quickstart.log" >&2
    fail "the build failed; the whole log is in $build/quickstart.log"
}

image="$build/quickstart"
stats="$build/quickstart.json"
echo "quickstart: rendering examples/stages/quickstart.usda"
"$build/cli/cohort" render examples/stages/quickstart.usda -o "$image.exr" -o "$image.png" \
    --level 4 --light-samples 2 --spp 64 --stats "$stats" "$@" ||
    fail "the render failed; cohort said why above"

# figure SECTION NAME: a number of the statistics; SECTION "" for the top level.
figure() {
    awk -v section="$1" -v name="$2" '
        /^"[a-z_]+": [{[]/ { split($0, part, "\""); at = part[2] }
        /^[}\]]/ { at = "" }
        at == section && index($0, "\"" name "\": ") == 1 {
            sub(/^[^:]*: /, ""); sub(/,$/, ""); print; exit
        }' "$stats"
}

size=$(od -An -j 16 -N 8 -t u1 "$image.png" |
    awk '{ print (($1 * 256 + $2) * 256 + $3) * 256 + $4 " x " (($5 * 256 + $6) * 256 + $7) * 256 + $8 }')
echo
echo "  $(pwd)/$image.png    to look at"
echo "  $(pwd)/$image.exr    scene-linear"
echo
figure rays traced | awk -v size="$size" -v samples="$(figure "" samples_per_pixel)" \
    -v load="$(figure seconds load)" -v render="$(figure seconds render)" '{
        printf "  %s pixels, %d samples each\n", size, samples
        printf "  %.1f s to load, %.1f s to render\n", load, render
        printf "  %.1f million rays, %.2f million a second\n", $1 / 1e6, $1 / 1e6 / render
    }'
