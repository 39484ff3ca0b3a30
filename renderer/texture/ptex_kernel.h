// Kernels of the Ptex filters: weights over the texels of one face, before and after it is cut.
//
// Source: the separable filters of the reference Ptex library 2.4. All arithmetic is float32 in the
// given order: a different rounding can pick another resolution.

#ifndef CO_TEXTURE_PTEX_KERNEL_H
#define CO_TEXTURE_PTEX_KERNEL_H

#include "texture/ptex_file.h"

#define CO_PTEX_KERNEL_MOST 24 // texels per axis: 10, doubled at most once, and some room

// Weights ku[i] * kv[j] of texels (u + i, v + j) at resolution 2^ulog2 x 2^vlog2; texels may lie
// outside the face until the kernel is split at its edges. An empty kernel has uw or vw 0.
typedef struct CoPtexKernel {
    int ulog2, vlog2;
    int u, v, uw, vw;
    int rotation; // quarter turns since the last split, 0 to 3
    float ku[CO_PTEX_KERNEL_MOST], kv[CO_PTEX_KERNEL_MOST];
} CoPtexKernel;

typedef enum CoPtexEdge { // of a quad, counter-clockwise
    CO_PTEX_BOTTOM = 0,
    CO_PTEX_RIGHT,
    CO_PTEX_TOP,
    CO_PTEX_LEFT
} CoPtexEdge;

// Weights along one axis at u (face coordinate) for a filter width w; face_log2 = its resolution.
// Returns the count; *log2 and *start receive the resolution and the first texel.
int co_ptex_bilinear(float u, float w, int face_log2, int *log2, int *start, float *weights);
int co_ptex_box(float u, float w, int face_log2, int *log2, int *start, float *weights);

float co_ptex_weight(const CoPtexKernel *kernel);
void co_ptex_strip_zeros(CoPtexKernel *kernel);

// Moves what lies beyond an edge into `part`, in the frame of the neighbor on that side, unrotated.
void co_ptex_split(CoPtexKernel *kernel, CoPtexEdge edge, CoPtexKernel *part);

// Drops what lies beyond an edge; its weight goes to the border texels unless `is_black`.
void co_ptex_merge(CoPtexKernel *kernel, CoPtexEdge edge, bool is_black);

void co_ptex_rotate(CoPtexKernel *kernel, int quarter_turns);
void co_ptex_refine_u(CoPtexKernel *kernel); // to twice the resolution
void co_ptex_refine_v(CoPtexKernel *kernel);
void co_ptex_coarsen_u(CoPtexKernel *kernel); // to half of it
void co_ptex_coarsen_v(CoPtexKernel *kernel);

// From a face to a quarter of it: the same texels, which are half the resolution there.
void co_ptex_to_quarter(CoPtexKernel *kernel);

// From a face to half-size sub-faces across `edge`; true when it lands in the primary one.
bool co_ptex_to_subface(CoPtexKernel *kernel, int edge);
void co_ptex_to_main(CoPtexKernel *kernel, int edge);

// Makes both axes alike, keeping the weight where that is possible. Returns the new weight.
float co_ptex_make_symmetric(CoPtexKernel *kernel, float weight);

#endif
