#!/bin/sh
# Checks the rules that no compiler checks: the order of rooms, names, sizes, words.
# Usage: sh tests/rules/check.sh SOURCE_DIR [BUILD_DIR]   exits 1 and names each breach
# Symbols are checked when BUILD_DIR holds static libraries.
set -u
rules=$(cd "$(dirname "$0")" && pwd)
cd "$1" || exit 2
build=${2:-}
breaches=$(mktemp) || exit 2
trap 'rm -f "$breaches"' EXIT

rooms=
for room in renderer usda_loader delegate cli examples; do
    [ -d "$room" ] && rooms="$rooms $room"
done
tests=
[ -d tests ] && tests=tests

# shellcheck disable=SC2086
find $rooms -name '*.[ch]' -o -name '*.cpp' | sort > "$breaches.sources"
# shellcheck disable=SC2086
find $rooms $tests -type f \( -name '*.[ch]' -o -name '*.cpp' \) | sort > "$breaches.code"
trap 'rm -f "$breaches" "$breaches.sources" "$breaches.code" "$breaches.tests"' EXIT

xargs awk -f "$rules/includes.awk" < "$breaches.sources" >> "$breaches"

xargs awk -v file_wall=600 -v function_wall=80 -f "$rules/sizes.awk" < "$breaches.sources" |
    awk '/^--$/ { rest = 1; next } rest { print > "/dev/stderr"; next } { print }' >> "$breaches"

# One name, one file within a top-level folder: a message that says "vertex.c:120" leaves no doubt.
awk -F/ '{ f = $1 ": " $NF; n[f]++; at[f] = at[f] " " $0 }
         END { for (f in n) if (n[f] > 1) print f ": more than one file of this name:" at[f] }' \
    "$breaches.code" >> "$breaches"

# Every source file has a test of its name, or is named by the first comment of another one.
if [ -n "$tests" ]; then
    find tests -name 'test_*' -type f | while read -r test; do
        basename "$test"
        awk '/^#!/ { next } /^(\/\/|#) / { print; next } { exit }' "$test"
    done > "$breaches.tests"
    grep -E '[.](c|cpp)$' "$breaches.sources" | grep -v '^examples/' | while read -r source; do
        file=$(basename "$source")
        grep -qE "^test_${file%.*}[.]|(^|[ (/])${file%.*}[.]${file##*.}" "$breaches.tests" ||
            echo "$source: no test_${file%.*}, and no test says that it tests $file"
    done >> "$breaches"
fi

# Work left for later belongs nowhere in the tree. This file holds the words, so it is left out.
# shellcheck disable=SC2086
grep -rnwE 'TODO|FIXME|XXX|HACK' $rooms $tests --include='*.[ch]' --include='*.cpp' \
    --include='*.txt' --include='*.md' --include='*.awk' |
    sed 's/$/: unfinished work/' >> "$breaches"

# C++ stays in the shims, and each shim stays small.
grep '\.cpp$' "$breaches.sources" | grep -v '^renderer/shims/' | sed 's/$/: C++ outside the shims/' >> "$breaches"

# Instruction-set intrinsics stay behind the lanes.
xargs grep -lE 'immintrin\.h|emmintrin\.h|x86intrin\.h' < "$breaches.sources" |
    grep -v '^renderer/simd/' | sed 's/$/: intrinsics outside renderer\/simd/' >> "$breaches"

# libm picks variants of these by CPU, and the image must not depend on the CPU (math/elementary.h).
grep '^renderer/' "$breaches.sources" |
    grep -Ev '^renderer/(base|shims|color)/' |
    xargs grep -nE '(^|[^a-zA-Z0-9_])(sin|cos|tan|asin|acos|atan|atan2|exp|exp2|log|log2|log10|pow|cbrt|hypot)f? *\(' |
    grep -vE ':[0-9]+: *(//|\*)|// .*\(' | sed 's/$/: libm in what the image depends on/' >> "$breaches"

# A link in a document leads somewhere.
find . -name '*.md' -not -path './build*' | while read -r document; do
    grep -oE '\]\([^)#:]+' "$document" | sed 's/^](//' | while read -r link; do
        [ -e "$(dirname "$document")/$link" ] || echo "$document: links to $link, which is not there"
    done
done >> "$breaches"

if [ -n "$build" ] && [ -d "$build" ]; then
    find "$build/renderer" "$build/usda_loader" "$build/delegate" -name '*.a' 2> /dev/null |
        xargs nm -A --defined-only 2> /dev/null |
        awk -v kernels=':(traverse)[.]c[.]o' -f "$rules/symbols.awk" >> "$breaches"
fi

if [ -s "$breaches" ]; then
    sort "$breaches"
    echo "rules: $(wc -l < "$breaches") breaches" >&2
    exit 1
fi
echo "rules: kept by $(wc -l < "$breaches.sources") source files"
