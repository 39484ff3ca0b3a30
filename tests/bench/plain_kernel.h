// Traversals that are not watertight, and those that know no options, for bench_stability alone.

#ifndef TESTS_BENCH_PLAIN_KERNEL_H
#define TESTS_BENCH_PLAIN_KERNEL_H

#include "accel/accel.h"

CoTraverseFn bench_moeller_avx2;
CoTraverseFn bench_inexact_avx2;
CoTraverseFn bench_bare_avx2;
CoTraverseFn bench_bare_avx512;

#endif
