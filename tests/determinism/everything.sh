#!/bin/sh
# One image for every schedule: renders a small stage that has everything in it, again and again with
# other threads, batches, sorts, sorters and instruction sets, and interrupted and resumed, and
# expects every value of every channel to have the same bits.
# Usage: sh everything.sh COHORT STAGE
set -u
cohort=$1
stage=$2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
failed=0
compared=0

# The split at the first hit, cut-outs, and every AOV have to agree.
common="--size 64x48 --first-hit-samples 4 --aov depth --aov cameraDepth --aov normal --aov albedo
--aov primId --aov elementId --aov sampleCount --aov error --quiet"

render() {
    out=$1
    shift
    # shellcheck disable=SC2086
    "$cohort" render "$stage" -o "$work/$out.exr" $common --converted "$work/converted" \
        --scratch "$work" --spp 16 "$@"
}

# same NAME REFERENCE: the images agree in every bit.
same() {
    compared=$((compared + 1))
    said=$("$cohort" diff "$work/$1.exr" "$work/$2.exr") && return
    printf '%s differs from %s: %s\n' "$1" "$2" "$said"
    failed=1
}

# variant NAME OPTIONS...: another schedule, the same image.
variant() {
    name=$1
    shift
    if render "$name" "$@"; then
        same "$name" reference
    else
        echo "$name: the render failed"
        failed=1
    fi
}

# figure NAME FILE: one number of the statistics.
figure() {
    sed -n "s/^\"$1\": \\([0-9]*\\),*\$/\\1/p" "$2"
}

render reference --threads 1 --batch 1048576 --isa scalar --stats "$work/large.json" || exit 1

for threads in 1 2 4; do
    variant "threads-$threads" --threads "$threads"
done
for batch in 1024 16384 1048576; do
    variant "batch-$batch" --batch "$batch" --stats "$work/batch-$batch.json"
done
for sort in none rays hits both; do
    variant "sort-$sort" --sort "$sort" --batch 16384
    variant "sort-$sort-small" --sort "$sort" --batch 1024 --threads 2
done
variant memory --memory "${COHORT_TEST_MEMORY:-160M}" # sanitizers keep more resident
variant sorter-exact --sort both --sorter exact --batch 16384
for isa in sse42 avx2 avx512; do
    flag=$isa
    [ "$isa" = sse42 ] && flag=sse4_2
    [ "$isa" = avx512 ] && flag=avx512vl
    if grep -qsw "$flag" /proc/cpuinfo; then
        variant "isa-$isa" --isa "$isa" --batch 16384
    fi
done

# The comparison means something only if the schedules differ: many batches against few.
batches=$(sed -n '/"per_bin"/,/]/p' "$work/batch-1024.json" | awk '/^[0-9]/ { n += $1 } END { print n + 0 }')
if [ "$batches" -lt 50 ]; then
    echo "only $batches batches of 1024 rays"
    failed=1
fi

# No ray is lost, whatever the schedule: made, traced and ended are counted apart.
for stats in large batch-1024 batch-16384 batch-1048576; do
    made=$(figure made "$work/$stats.json")
    traced=$(figure traced "$work/$stats.json")
    ended=$(figure ended "$work/$stats.json")
    twice=$(figure blocks_read_twice_in_a_batch "$work/$stats.json")
    if [ -z "$made" ] || [ "$made" != "$traced" ] || [ "$made" != "$ended" ]; then
        echo "$stats: $made rays made, $traced traced, $ended ended"
        failed=1
    fi
    if [ "$twice" != 0 ]; then
        echo "$stats: $twice texture blocks read twice in a batch"
        failed=1
    fi
    if [ "$made" != "$(figure made "$work/large.json")" ]; then
        echo "$stats: $made rays, another schedule made $(figure made "$work/large.json")"
        failed=1
    fi
done

# interrupt SIGNAL PERCENT OPTIONS...: starts the long render, signals it once it is that far, and
# expects it to say that it was interrupted and to leave its film.
interrupt() {
    signal=$1
    percent=$2
    shift 2
    # Not through render(): the signal has to reach the program, not a shell around it.
    # shellcheck disable=SC2086
    "$cohort" render "$stage" -o "$work/resumed.exr" $common --converted "$work/converted" \
        --scratch "$work" --spp 192 --progress alf "$@" > "$work/progress" 2> "$work/said" &
    pid=$!
    reached=0
    while [ "$reached" -lt "$percent" ] && kill -0 "$pid" 2> /dev/null; do
        sleep 0.02
        reached=$(sed -n 's/^ALF_PROGRESS \([0-9]*\)%/\1/p' "$work/progress" | tail -n 1)
        reached=${reached:-0}
    done
    kill -s "$signal" "$pid" 2> /dev/null
    wait "$pid"
    code=$?
    if [ "$code" -ne 5 ] || [ ! -s "$work/resumed.exr.film" ]; then
        echo "interrupted by $signal: exit code $code, expected 5 and a film"
        cat "$work/said"
        failed=1
    fi
}

render whole --spp 192 || failed=1
interrupt INT 10
interrupt TERM 50 --resume --threads 1 --batch 16384
render resumed --spp 192 --resume --isa scalar || failed=1
same resumed whole
if "$cohort" diff "$work/whole.exr" "$work/reference.exr" > /dev/null; then
    echo "192 samples look like 16: the comparison sees nothing"
    failed=1
fi

[ "$failed" -eq 0 ] && echo "one image in $compared renders, $batches batches in one of them"
exit "$failed"
