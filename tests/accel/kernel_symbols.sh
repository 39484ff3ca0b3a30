#!/bin/sh
# Kernel objects hold functions only: no data but the literals of the code, and nothing from libm.
# Usage: kernel_symbols.sh nm object...
nm=$1
shift
[ $# -gt 0 ] || exit 1
for object; do
    "$nm" "$object" >"${TMPDIR:-/tmp}/symbols.$$" || exit 1
    grep -qE ' T co_[a-z_]*_(scalar|sse42|avx2|avx512)' "${TMPDIR:-/tmp}/symbols.$$" || { echo "$object: no kernel"; exit 1; }
    if grep -E ' [bBcCdDgGrRsSvV] ' "${TMPDIR:-/tmp}/symbols.$$" | grep -v ' r \.LC'; then
        echo "$object: data symbols"
        exit 1
    fi
    if grep -E ' U ' "${TMPDIR:-/tmp}/symbols.$$" | grep -vE ' U (mem(set|cpy|move)|__stack_chk_fail|__popcountdi2|__asan_.*|__ubsan_.*|__tsan_.*|_GLOBAL_OFFSET_TABLE_)$'; then
        echo "$object: calls out"
        exit 1
    fi
    rm -f "${TMPDIR:-/tmp}/symbols.$$"
done
