#!/bin/sh
# Renders the five stages with trusted references eight times each and compares; takes minutes.
# Usage: sh tests/oracle/renders.sh COHORT [SHARED]
set -eu
cohort=$1 shared=${2:-${COHORT_SHARED:-../shared}}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0
for name in cornell room lights sun dome; do
    for seed in 1 2 3 4 5 6 7 8; do
        "$cohort" render "$shared/renders/$name.usda" -o "$folder/${name}_$seed.exr" --spp 256 \
            --max-depth 6 --filter box --seed "$seed" -q
    done
    python3 "$shared/oracle/compare_render.py" "$shared/renders/${name}_ref.json" \
        "$folder/${name}"_?.exr || failed=1
done
exit "$failed"
