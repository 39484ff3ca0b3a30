#!/bin/sh
# cohort tree and cohort check on small stages: what they print and how they exit.
# Tests check.c, check_mesh.c, check_prim.c, findings.c and tree.c.
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
expect 0 '^    local .*liverps.usda:35$' tree "$data/liverps.usda" --composition /P
expect 0 '^    hidden: specialize .*liverps.usda:[0-9]' tree "$data/liverps.usda" --composition /P
expect 3 'no prim /Absent' tree "$data/liverps.usda" --composition /Absent
expect 3 'error' tree "$data/absent.usda"
expect 2 'expected one stage' tree
expect 1 'unsound.usda:9: error: face 1 has 2 corners \[topology\]' check "$data/unsound.usda"
expect 1 '    at /M.faceVertexCounts' check "$data/unsound.usda"
expect 1 ':10: error: 3 indices for faces with 5 corners' check "$data/unsound.usda"
expect 1 'index 2 at 2 is outside the 2 points' check "$data/unsound.usda"
expect 1 ':12: error: 1 elements where faceVarying interpolation asks for 3' check "$data/unsound.usda"
expect 1 ':15: error: @nope.png@ does not exist' check "$data/unsound.usda"
expect 1 ':11: warning: targets </Gone>, but there is no such prim' check "$data/unsound.usda"
expect 1 ':19: error: the reference to @missing.usda@ is left out: cannot open' check "$data/unsound.usda"
expect 1 'error: there is no default prim "Nope"' check "$data/unsound.usda"
expect 1 'warning: no metersPerUnit' check "$data/unsound.usda"
expect 1 'NurbsPatch: not supported: not drawn' check "$data/unsound.usda"
expect 1 '^7 errors, 4 warnings$' check "$data/unsound.usda"
expect 1 '"prim": "/M", "property": "x", "prims": 1' check --json "$data/unsound.usda"
expect 1 '"errors": 7, "warnings": 4' check --json "$data/unsound.usda"
expect 1 'xformOpOrder names xformOp:gone' check "$data/suspicious.usda"
expect 1 'point 2 is not finite' check "$data/suspicious.usda"
expect 1 ':26: error: 3 points at time 2, but 4 at first' check "$data/suspicious.usda"
expect 1 'index 7 at 3 is outside the 2 values' check "$data/suspicious.usda"
expect 1 'index 5 at 0 is outside the 1 faces' check "$data/suspicious.usda"
expect 1 'points lie up to 3 outside the authored extent' check "$data/suspicious.usda"
expect 1 'connected to </World/Absent.outputs:rgb>, but there is no such prim' check "$data/suspicious.usda"
expect 1 'targets </World/Still.outputs:rgb>, but that prim has no outputs:rgb' check "$data/suspicious.usda"
expect 1 'targets </World/Off>, but that prim is not active' check "$data/suspicious.usda"
expect 1 'focalLength 0.5 with horizontalAperture 20.955 sees 175 degrees' check "$data/suspicious.usda"
expect 1 'fStop is 2.8, but there is no focusDistance' check "$data/suspicious.usda"
expect 1 'there are cameras but no light' check "$data/suspicious.usda"
expect 1 'the stage is 4e+06 m across' check "$data/suspicious.usda"
expect 1 'its backslashes are no folders here' check "$data/suspicious.usda"
expect 1 'the transform is flat' check "$data/suspicious.usda"
expect 1 '/World/Twice1 and 1 more' check "$data/suspicious.usda"
expect 0 'nothing found' check "$data/sound.usda"
expect 0 '"errors": 0, "warnings": 0, "findings": \[\]' check --json "$data/sound.usda"
expect 1 'no upAxis' check --strict "$data/liverps.usda"
expect 3 ':3:11: error: found .5., expected a line end' check "$data/../usda_faults/three.usda"
expect 3 '^              ^$' check "$data/../usda_faults/three.usda"
expect 3 '^3 errors, 0 warnings$' check "$data/../usda_faults/three.usda"
expect 0 'no upAxis' check "$data/liverps.usda"
expect 3 'error' check "$data/absent.usda"
expect 2 'expected one stage' check
expect 0 '^  T2 ' tree --mask /World/T2 "$data/instances.usda"
expect 0 'def "T2"' cat --flatten --mask /World/T2 "$data/instances.usda"
expect 2 'mask path "World"' tree --mask World "$data/instances.usda"
expect 3 'absent.usda' tree --session "$data/absent.usda" "$data/instances.usda"
expect 0 '^P' tree --mute "$data/liverps_ref.usda" --no-payloads --load /P "$data/liverps.usda"
expect 0 'is muted' tree --mute "$data/liverps_ref.usda" "$data/liverps.usda"
expect 0 '^P' tree --unload /P --search-path "$data" "$data/liverps.usda"

[ "$failures" -eq 0 ] || exit 1
