// What the kernels make of one node and of one box, for each instruction set: rays alone and
// together.

#ifndef TESTS_ACCEL_KERNEL_CALLS_H
#define TESTS_ACCEL_KERNEL_CALLS_H

#include "accel/build.h"

enum {
    KERNEL_CALL_RAYS = 64
};

typedef struct KernelRay {
    float org[3], dir[3];
    float from, to;
} KernelRay;

// One bit per box, and where the ray, or the first of those that go together, enters those.
typedef struct KernelNode {
    uint32_t bits;
    float entry[CO_NODE_WIDTH];
} KernelNode;

typedef struct KernelAnswer {
    bool is_fit;  // whether the ray goes on at all
    bool is_huge; // goes alone, sees all children that are there
    KernelNode alone, together;
    KernelNode beam;     // what rays of the same signs are told of all of them
    uint32_t again;      // boxes entered when asked for one child at a time
    KernelNode interval; // of each box, by the canonical arithmetic
    float exit[CO_NODE_WIDTH];
} KernelAnswer;

// Sends rays [0, count), count <= KERNEL_CALL_RAYS, through a node with `boxes`, the root of a tree
// of that. `relative`: see ray_prepare.
typedef void KernelCalls(const CoBox *boxes, uint32_t box_count, float relative,
                         const KernelRay *rays, uint32_t count, KernelAnswer *out);

KernelCalls kernel_calls_scalar;
KernelCalls kernel_calls_sse42;
KernelCalls kernel_calls_avx2;
KernelCalls kernel_calls_avx512;

#endif
