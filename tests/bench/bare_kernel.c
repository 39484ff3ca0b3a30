// The traversal without what options.h has: hits begin where rays do, and nothing is hidden.

#include "plain_kernel.h"

#define CO_ACCEL_KERNELS_OPTIONS_H
#define start_of(group, slot) ((void)(group), (void)(slot), 0.0f)
#define starts_of(group, j) ((void)(group), (void)(j), co_wide_set1(0.0f))
#define is_hidden(group, ray, placed) ((void)(group), (void)(ray), (void)(placed), false)
#define not_hidden(group, rays, active, placed) ((void)(rays), (void)(placed), (active))
#define co_accel_traverse bench_bare

#include "accel/kernels/traverse.c"
