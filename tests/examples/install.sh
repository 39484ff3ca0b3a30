#!/bin/sh
# Installs the build into a fresh prefix. The command there must render a textured stage, wherever the prefix is
# moved; the embedding examples, built with nothing but the prefix and pkg-config, must give the same pictures, and
# say where to look when the module that reads images is gone.
# Usage: sh install.sh CMAKE BUILD_FOLDER CC SOURCE_FOLDER
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
stage=$4/examples/stages/everything.usda
"$1" --install "$2" --prefix "$work/here" > "$work/log"

mv "$work/here" "$work/prefix"
cohort=$work/prefix/bin/cohort
"$cohort" render "$stage" -o "$work/command.exr" --spp 1 --converted "$work/converted" --stats "$work/stats.json" \
    --quiet
sed -n '/^"warnings": \[/,/^\]/p' "$work/stats.json" > "$work/warnings"
test "$(wc -l < "$work/warnings")" -eq 2

PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig
XDG_CACHE_HOME=$work/cache
export PKG_CONFIG_PATH XDG_CACHE_HOME
for program in embed_stage embed_scene; do
    "$3" -std=c11 "$4/examples/$program.c" $(pkg-config --cflags --libs cohort) -o "$work/$program"
done
"$work/embed_stage" "$stage" "$work/embedded.exr" 1
"$cohort" diff "$work/embedded.exr" "$work/command.exr" --tolerance 1e-6
"$work/embed_scene" "$work/scene.exr" 1
test -s "$work/scene.exr"

rm "$work/prefix/lib/cohort/cohort_oiio.so"
if "$work/embed_stage" "$stage" "$work/none.exr" 1 2> "$work/said"; then
    echo "a missing module goes unnoticed"
    exit 1
fi
grep -q 'cohort_oiio.so.*lib/cohort' "$work/said"
test ! -e "$work/none.exr"
