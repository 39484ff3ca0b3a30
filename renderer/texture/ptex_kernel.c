#include "texture/ptex_kernel.h"

#include "math/bits.h"

#include <math.h>
#include <string.h>

// -floor(log2 w) from the exponent's bits; w is normal and at most 1.
static int resolution_of(float w)
{
    return 127 - (int)(co_float_bits(w) >> 23 & 255);
}

static float clamp_width(float w, int face_log2)
{
    float texel = 1.0f / (float)(1u << face_log2);
    w = w < 1.0f ? w : 1.0f; // also turns NaN into 1
    return w > texel ? w : texel;
}

int co_ptex_bilinear(float u, float w, int face_log2, int *log2, int *start, float *weights)
{
    *log2 = resolution_of(clamp_width(w, face_log2));
    float p = u * (float)(1u << *log2) - 0.5f, down = floorf(p), f = p - down;
    *start = (int)down;
    weights[0] = 1.0f - f;
    weights[1] = f;
    return 2;
}

int co_ptex_box(float u, float w, int face_log2, int *log2, int *start, float *weights)
{
    w = clamp_width(w, face_log2);
    *log2 = resolution_of(w);
    float n = (float)(1u << *log2), center = u * n, h = w * n;
    float a = center - 0.5f * h, b = center + 0.5f * h;
    float first = floorf(a), end = ceilf(b);
    float first_weight = 1.0f - (a - first), last_weight = 1.0f - (end - b);
    int count = (int)(end - first);
    *start = (int)first;
    if (count <= 1) {
        weights[0] = first_weight + last_weight - 1.0f;
        return 1;
    }
    weights[0] = first_weight;
    for (int i = 1; i < count - 1; i++)
        weights[i] = 1.0f;
    weights[count - 1] = last_weight;
    return count;
}

static float total(const float *weights, int count)
{
    float sum = 0;
    for (int i = 0; i < count; i++)
        sum += weights[i];
    return sum;
}

float co_ptex_weight(const CoPtexKernel *kernel)
{
    return total(kernel->ku, kernel->uw) * total(kernel->kv, kernel->vw);
}

// One axis of a kernel, so that u and v share their code.
typedef struct Axis {
    float *weights;
    int *start, *count, *log2;
} Axis;

static Axis axis_u(CoPtexKernel *k)
{
    return (Axis){k->ku, &k->u, &k->uw, &k->ulog2};
}

static Axis axis_v(CoPtexKernel *k)
{
    return (Axis){k->kv, &k->v, &k->vw, &k->vlog2};
}

static void drop_first(Axis axis, int n)
{
    *axis.count -= n;
    memmove(axis.weights, axis.weights + n, (size_t)*axis.count * sizeof(float));
}

static void strip(Axis axis)
{
    int zeros = 0;
    while (zeros < *axis.count - 1 && axis.weights[zeros] == 0)
        zeros++;
    *axis.start += zeros;
    drop_first(axis, zeros);
    while (*axis.count > 1 && axis.weights[*axis.count - 1] == 0)
        --*axis.count;
}

void co_ptex_strip_zeros(CoPtexKernel *kernel)
{
    strip(axis_u(kernel));
    strip(axis_v(kernel));
}

void co_ptex_split(CoPtexKernel *kernel, CoPtexEdge edge, CoPtexKernel *part)
{
    bool in_v = edge == CO_PTEX_BOTTOM || edge == CO_PTEX_TOP;
    *part = *kernel;
    Axis rest = in_v ? axis_v(kernel) : axis_u(kernel);
    Axis cut = in_v ? axis_v(part) : axis_u(part);
    int side = 1 << *rest.log2;
    bool is_high = edge == CO_PTEX_RIGHT || edge == CO_PTEX_TOP;
    int beyond = is_high ? *rest.start + *rest.count - side : -*rest.start;
    if (beyond >= *rest.count) { // all of it moves, and keeps its rotation
        *cut.start += is_high ? -side : side;
        *rest.start = *rest.count = 0;
        return;
    }
    part->rotation = 0;
    if (is_high) {
        drop_first(cut, *rest.count - beyond);
        *cut.start = 0;
        *rest.count -= beyond;
    } else {
        *cut.start = side - beyond;
        *cut.count = beyond;
        drop_first(rest, beyond);
        *rest.start = 0;
    }
}

void co_ptex_merge(CoPtexKernel *kernel, CoPtexEdge edge, bool is_black)
{
    bool in_v = edge == CO_PTEX_BOTTOM || edge == CO_PTEX_TOP;
    bool is_high = edge == CO_PTEX_RIGHT || edge == CO_PTEX_TOP;
    Axis axis = in_v ? axis_v(kernel) : axis_u(kernel);
    int side = 1 << *axis.log2;
    int beyond = is_high ? *axis.start + *axis.count - side : -*axis.start;
    if (beyond >= *axis.count) { // nothing inside: all or none of it is at the border
        axis.weights[0] = total(axis.weights, *axis.count);
        *axis.start = is_high ? side - 1 : 0;
        *axis.count = is_black ? 0 : 1;
        return;
    }
    int keep = *axis.count - beyond;
    if (is_high) {
        if (!is_black)
            axis.weights[keep - 1] += total(axis.weights + keep, beyond);
        *axis.count = keep;
    } else {
        float sum = total(axis.weights, beyond);
        drop_first(axis, beyond);
        *axis.start = 0;
        if (!is_black)
            axis.weights[0] += sum;
    }
}

static void flip(Axis axis)
{
    *axis.start = (1 << *axis.log2) - *axis.start - *axis.count;
    for (int i = 0, j = *axis.count - 1; i < j; i++, j--) {
        float weight = axis.weights[i];
        axis.weights[i] = axis.weights[j];
        axis.weights[j] = weight;
    }
}

static void swap_axes(CoPtexKernel *k)
{
    CoPtexKernel old = *k;
    k->ulog2 = old.vlog2, k->vlog2 = old.ulog2;
    k->u = old.v, k->v = old.u;
    k->uw = old.vw, k->vw = old.uw;
    memcpy(k->ku, old.kv, sizeof k->ku);
    memcpy(k->kv, old.ku, sizeof k->kv);
}

void co_ptex_rotate(CoPtexKernel *kernel, int quarter_turns)
{
    int turns = quarter_turns & 3;
    if (turns == 1 || turns == 2)
        flip(axis_u(kernel));
    if (turns == 2 || turns == 3)
        flip(axis_v(kernel));
    if (turns & 1)
        swap_axes(kernel);
    kernel->rotation = (kernel->rotation + turns) & 3;
}

static void refine(Axis axis)
{
    if (2 * *axis.count > CO_PTEX_KERNEL_MOST) // only a chain of senseless sub-faces comes here
        *axis.count = CO_PTEX_KERNEL_MOST / 2;
    for (int i = *axis.count - 1; i >= 0; i--)
        axis.weights[2 * i] = axis.weights[2 * i + 1] = 0.5f * axis.weights[i];
    *axis.start *= 2;
    *axis.count *= 2;
    ++*axis.log2;
}

// Pairs are those of even texels, so an odd first one stays alone, and so may the last.
static void coarsen(Axis axis)
{
    int from = 0, to = 0, count = *axis.count;
    if (count > 0 && *axis.start & 1)
        from = to = 1;
    for (; from < count; from += 2, to++)
        axis.weights[to] =
            from + 1 < count ? axis.weights[from] + axis.weights[from + 1] : axis.weights[from];
    *axis.count = to;
    *axis.start = *axis.start >= 0 ? *axis.start / 2 : -((1 - *axis.start) / 2);
    --*axis.log2;
}

void co_ptex_refine_u(CoPtexKernel *kernel)
{
    refine(axis_u(kernel));
}

void co_ptex_refine_v(CoPtexKernel *kernel)
{
    refine(axis_v(kernel));
}

void co_ptex_coarsen_u(CoPtexKernel *kernel)
{
    coarsen(axis_u(kernel));
}

void co_ptex_coarsen_v(CoPtexKernel *kernel)
{
    coarsen(axis_v(kernel));
}

void co_ptex_to_quarter(CoPtexKernel *kernel)
{
    if (kernel->ulog2 == 0)
        co_ptex_refine_u(kernel);
    if (kernel->vlog2 == 0)
        co_ptex_refine_v(kernel);
    kernel->ulog2--;
    kernel->vlog2--;
}

bool co_ptex_to_subface(CoPtexKernel *kernel, int edge)
{
    co_ptex_to_quarter(kernel);
    int side_u = 1 << kernel->ulog2, side_v = 1 << kernel->vlog2;
    bool is_primary;
    switch (edge & 3) {
    case CO_PTEX_BOTTOM:
        is_primary = kernel->u < side_u;
        kernel->v -= side_v;
        if (!is_primary)
            kernel->u -= side_u;
        return is_primary;
    case CO_PTEX_RIGHT:
        is_primary = kernel->v < side_v;
        if (!is_primary)
            kernel->v -= side_v;
        return is_primary;
    case CO_PTEX_TOP:
        is_primary = kernel->u >= side_u;
        if (is_primary)
            kernel->u -= side_u;
        return is_primary;
    default:
        is_primary = kernel->v >= side_v;
        kernel->u -= side_u;
        if (is_primary)
            kernel->v -= side_v;
        return is_primary;
    }
}

void co_ptex_to_main(CoPtexKernel *kernel, int edge)
{
    int side_u = 1 << kernel->ulog2, side_v = 1 << kernel->vlog2;
    edge &= 3;
    if (edge == 0 || edge == 3)
        kernel->v += side_v;
    if (edge == 2 || edge == 3)
        kernel->u += side_u;
    kernel->ulog2++;
    kernel->vlog2++;
}

float co_ptex_make_symmetric(CoPtexKernel *kernel, float weight)
{
    while (kernel->ulog2 > kernel->vlog2)
        co_ptex_coarsen_u(kernel);
    while (kernel->vlog2 > kernel->ulog2)
        co_ptex_coarsen_v(kernel);
    int count = kernel->uw < kernel->vw ? kernel->uw : kernel->vw;
    kernel->uw = kernel->vw = count;
    for (int i = 0; i < count; i++)
        kernel->ku[i] = kernel->kv[i] = kernel->ku[i] + kernel->kv[i];
    float now = co_ptex_weight(kernel);
    float scale = now == 0 ? 1.0f : weight / now;
    if (scale >= 1.0f)
        return now;
    float by = scale < -1.0f ? -1.0f : scale;
    for (int i = 0; i < count; i++)
        kernel->ku[i] *= by;
    return scale < -1.0f ? -now : weight;
}
