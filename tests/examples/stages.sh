#!/bin/sh
# Renders each example stage, tiny, and expects a picture with nothing left out and nothing to warn of.
# Usage: sh stages.sh COHORT FOLDER
set -u
cohort=$1
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
failed=0
rendered=0

complain() {
    echo "$stage: $1"
    failed=1
}

# is_empty LIST: nothing stands between its brackets in the statistics.
is_empty() {
    [ "$(sed -n "/^\"$1\": \\[/,/^\\]/p" "$work/stats.json" | wc -l)" -eq 2 ]
}

for stage in "$2"/*.usda; do
    if ! "$cohort" render "$stage" -o "$work/out.exr" -o "$work/out.png" --size 48x32 --spp 2 \
        --converted "$work/converted" --stats "$work/stats.json" --quiet; then
        complain "does not render"
        continue
    fi
    rendered=$((rendered + 1))
    grep -q '^"status": "complete"' "$work/stats.json" || complain "not complete"
    is_empty not_honored || complain "asks for what is not honored"
    is_empty warnings || complain "gives warnings"
    "$cohort" cat "$stage" --flatten > "$work/flat.usda" || complain "does not flatten"
done

[ "$rendered" -ge 2 ] || { echo "only $rendered stages in $2"; failed=1; }
exit "$failed"
