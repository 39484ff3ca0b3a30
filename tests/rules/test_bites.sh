#!/bin/sh
# Breaks each rule in a small tree and expects check.sh to name the breach, and to pass the tree mended.
set -u
rules=$(cd "$(dirname "$0")" && pwd)
tree=$(mktemp -d) || exit 2
trap 'rm -rf "$tree"' EXIT
failed=0

# expect NEEDLE: check.sh fails on the tree and says NEEDLE; then the broken files go.
expect() {
    if said=$(sh "$rules/check.sh" "$tree" 2>&1); then
        echo "passed, but should have said: $1"
        failed=1
    elif ! printf '%s\n' "$said" | grep -qF "$1"; then
        printf 'should have said: %s\nsaid:\n%s\n' "$1" "$said"
        failed=1
    fi
    rm -rf "$tree"/renderer/*/bad* "$tree"/*/bad* "$tree"/*/*/bad*
}

mkdir -p "$tree/renderer/base" "$tree/renderer/rays" "$tree/renderer/film" "$tree/usda_loader/lex" \
    "$tree/delegate/index" "$tree/delegate/prims" "$tree/delegate/stage_adapter" "$tree/cli"
cd "$tree" || exit 2
printf '#include "base/good.h"\n#include "cohort/render.h"\nint co_x;\n' > renderer/rays/good.c
printf '#include "index/index.h"\n' > delegate/prims/sync.c
printf '#include "prims/sync.h"\n#include "base/error.h"\n' > delegate/index/index.c
printf '#include "cohort/usda.h"\n#include "index/index.h"\n' > delegate/stage_adapter/walk.c
printf '#include "cohort/stage_adapter.h"\n#include "cli/options.h"\n' > cli/main.c
sh "$rules/check.sh" "$tree" 2> /dev/null || { echo "the mended tree should pass"; failed=1; }

echo '#include "film/film.h"' > renderer/rays/bad.c
expect 'renderer/rays/bad.c:1: includes "film/film.h": film comes after rays'
echo '#include "cohort/usda.h"' > renderer/rays/bad.c
expect 'renderer may not see this public header'
echo '#include "index/index.h"' > renderer/rays/bad.c
expect 'no room that renderer may use'
echo '#include "accel/accel.h"' > usda_loader/lex/bad.c
expect 'no room that usda_loader may use'
echo '#include "cohort/usda.h"' > delegate/index/bad.c
expect 'delegate may not see this public header'
echo '#include "stage_adapter/walk.h"' > delegate/prims/bad.c
expect 'stage_adapter comes after prims'
echo '#include "film/film.h"' > cli/bad.c
expect 'cli sees only the public headers and its own'
awk 'BEGIN { for (i = 0; i < 601; i++) print "// line" }' > renderer/film/bad.c
expect 'renderer/film/bad.c: 601 lines, at most 600'
{ printf 'void co_f(void)\n{\n'; awk 'BEGIN { for (i = 0; i < 81; i++) print "    ;" }'; echo '}'; } > renderer/film/bad.c
expect 'renderer/film/bad.c:2: a function of 81 lines, at most 80'
echo > renderer/film/bad.c
echo > renderer/rays/bad.c
expect 'bad.c: more than one file of this name'
word=TO; echo "// ${word}DO: later" > renderer/film/bad.c
expect 'unfinished work'
echo > renderer/film/bad.cpp
expect 'C++ outside the shims'
echo '#include <immintrin.h>' > renderer/film/bad.c
expect 'intrinsics outside renderer/simd'
echo 'float co_f(float x) { return sinf(x); }' > renderer/film/bad.c
expect 'libm in what the image depends on'
echo 'See [there](nowhere.md).' > renderer/film/bad.md
expect 'links to nowhere.md'

mkdir "$tree/tests"
for file in renderer/rays/good delegate/prims/sync delegate/index/index delegate/stage_adapter/walk; do
    echo > "tests/test_$(basename "$file").c"
done
echo '// Options, and main.c.' > tests/test_options.c
echo > renderer/film/bad.c
expect 'renderer/film/bad.c: no test_bad, and no test says that it tests bad.c'
rm -r "$tree/tests"

# Symbols, through the compiler at hand.
if command -v cc > /dev/null && command -v ar > /dev/null; then
    mkdir -p "$tree/build/renderer"
    echo 'int stray(void); int stray(void) { return 1; }' > "$tree/s.c"
    cc -c "$tree/s.c" -o "$tree/s.o" && ar rc "$tree/build/renderer/libs.a" "$tree/s.o"
    said=$(sh "$rules/check.sh" "$tree" "$tree/build" 2>&1)
    printf '%s\n' "$said" | grep -q 'stray: is neither cohort_ nor co_' || { echo "a stray symbol passed"; failed=1; }
    echo 'int co_table[2] = {1, 2};' > "$tree/traverse.c"
    rm -f "$tree/build/renderer/libs.a"
    cc -c "$tree/traverse.c" -o "$tree/traverse.c.o" && ar rc "$tree/build/renderer/libs.a" "$tree/traverse.c.o"
    said=$(sh "$rules/check.sh" "$tree" "$tree/build" 2>&1)
    printf '%s\n' "$said" | grep -q 'data in a kernel' || { echo "data in a kernel passed"; failed=1; }
fi

[ "$failed" -eq 0 ] && echo "rules: every breach was named"
exit "$failed"
