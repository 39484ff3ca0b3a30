#!/bin/sh
# cohort tree and cohort check on small stages: what they print and how they exit.
# usage: test_commands.sh COHORT DATA
cohort=$1
data=$2/compose
failures=0

# expect EXIT PATTERN ARGUMENT...: that exit status, and the pattern in what is printed.
expect() {
    wanted=$1
    pattern=$2
    shift 2
    out=$("$cohort" "$@" 2>&1)
    code=$?
    if [ "$code" -ne "$wanted" ] || ! printf '%s\n' "$out" | grep -q -e "$pattern"; then
        echo "cohort $*: exit $code, expected $wanted and \"$pattern\" in:"
        printf '%s\n' "$out"
        failures=$((failures + 1))
    fi
}

expect 0 '^World$' tree "$data/instances.usda"
expect 0 '  T2 (instance of /World/T1) <- reference instances.usda' tree "$data/instances.usda"
expect 0 '{look=red} <- inherit liverps.usda' tree "$data/liverps.usda"
expect 0 '^  local .*liverps.usda:[0-9]' tree "$data/liverps.usda" --composition /P
expect 0 '^  payload .*liverps_payload.usda:[0-9]' tree "$data/liverps.usda" --composition /P
expect 3 'no prim /Absent' tree "$data/liverps.usda" --composition /Absent
expect 3 'error' tree "$data/absent.usda"
expect 2 'expected one stage' tree
expect 1 'unsound.usda:9: error: face 1 has 2 corners at /M.faceVertexCounts' check "$data/unsound.usda"
expect 1 ':10: error: 3 indices for faces with 5 corners' check "$data/unsound.usda"
expect 1 'index 2 at 2 is outside the 2 points' check "$data/unsound.usda"
expect 1 ':12: error: 1 elements where faceVarying interpolation asks for 3' check "$data/unsound.usda"
expect 1 ':15: error: @nope.png@ does not exist' check "$data/unsound.usda"
expect 1 ':11: warning: there is no target </Gone>' check "$data/unsound.usda"
expect 1 'warning: the reference to @missing.usda@' check "$data/unsound.usda"
expect 1 'error: there is no default prim "Nope"' check "$data/unsound.usda"
expect 1 'warning: no metersPerUnit' check "$data/unsound.usda"
expect 1 'a NurbsPatch is not rendered' check "$data/unsound.usda"
expect 1 '"prim": "/M.x"' check --json "$data/unsound.usda"
expect 0 'no upAxis' check "$data/liverps.usda"
expect 3 'error' check "$data/absent.usda"
expect 2 'expected one stage' check
expect 0 '^  T2 ' tree --mask /World/T2 "$data/instances.usda"
expect 0 'def "T2"' cat --flatten --mask /World/T2 "$data/instances.usda"
expect 3 'mask path "World"' tree --mask World "$data/instances.usda"
expect 3 'absent.usda' tree --session "$data/absent.usda" "$data/instances.usda"
expect 0 '^P' tree --mute "$data/liverps_ref.usda" --no-payloads --load /P "$data/liverps.usda"
expect 0 'is muted' tree --mute "$data/liverps_ref.usda" "$data/liverps.usda"
expect 0 '^P' tree --unload /P --search-path "$data" "$data/liverps.usda"

[ "$failures" -eq 0 ] || exit 1
