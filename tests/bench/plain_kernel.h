// Traversals that are not watertight, for bench_stability alone.

#ifndef TESTS_BENCH_PLAIN_KERNEL_H
#define TESTS_BENCH_PLAIN_KERNEL_H

#include "accel/accel.h"

CoTraverseFn bench_moeller_avx2;
CoTraverseFn bench_inexact_avx2;

#endif
