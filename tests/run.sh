#!/bin/sh
# Installs what is missing, builds Cohort and its benchmarks in build/ and runs every test.
# Usage: sh tests/run.sh [arguments for ctest]
set -eu
cd "$(dirname "$0")/.."

sh examples/setup.sh
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DCOHORT_TESTS=ON
cmake --build build --parallel "$(nproc)" --target all benchmarks
exec ctest --test-dir build --output-on-failure "$@"
