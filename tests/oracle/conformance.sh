#!/bin/sh
# Compares the reader with the reference implementation over part of the shared corpus.
# Usage: conformance.sh COHORT SHARED GLOB [options of the comparison].  Exit 77 (skipped) without the reference or the corpus.
set -eu
cohort=$1 shared=$2 glob=$3
shift 3

command -v python3 >/dev/null && python3 -c 'import pxr' 2>/dev/null || {
    echo "skipped: usd-core is not installed"
    exit 77
}
[ -f "$shared/oracle/run_conformance.py" ] || {
    echo "skipped: no shared data in $shared"
    exit 77
}
exec python3 "$shared/oracle/run_conformance.py" --cohort "$cohort" --only "$glob" --jobs 2 -q "$@"
