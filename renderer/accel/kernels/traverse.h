// The traversal kernels, one per instruction set: accel/kernels/traverse.c compiled four times.

#ifndef CO_ACCEL_KERNELS_TRAVERSE_H
#define CO_ACCEL_KERNELS_TRAVERSE_H

#include "accel/accel.h"

CoTraverseFn co_accel_traverse_scalar;
CoTraverseFn co_accel_traverse_sse42;
CoTraverseFn co_accel_traverse_avx2;
CoTraverseFn co_accel_traverse_avx512;

CoNextFn co_accel_next_scalar;
CoNextFn co_accel_next_sse42;
CoNextFn co_accel_next_avx2;
CoNextFn co_accel_next_avx512;

#endif
