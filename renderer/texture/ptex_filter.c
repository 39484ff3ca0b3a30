#include "texture/ptex_filter.h"

#include <math.h>
#include <string.h>

// A hostile file can make faces refer to each other without end.
#define MOST_STEPS 256
#define MOST_DEPTH 12
#define MOST_LOG2 24
#define MOST_VALENCE 10

typedef struct Walk {
    const CoPtexFile *file;
    bool no_edge_blend;
    CoPtexPartFn *fn;
    void *context;
    float weight;
    int steps, depth;
} Walk;

static void split_and_apply(Walk *walk, CoPtexKernel *kernel, uint32_t face);

static const CoPtexFace *face_at(const Walk *walk, uint32_t face)
{
    return &walk->file->faces[face];
}

static bool is_subface(const CoPtexFace *face)
{
    return face->flags & CO_PTEX_SUBFACE;
}

// Drops texels outside the face: only broken adjacency leaves any.
static void clip(float *weights, int *start, int *count, int side)
{
    if (*start < 0) {
        int out = -*start < *count ? -*start : *count;
        *count -= out;
        memmove(weights, weights + out, (size_t)*count * sizeof(float));
        *start = 0;
    }
    if (*count > side - *start)
        *count = side - *start > 0 ? side - *start : 0;
}

static void apply(Walk *walk, CoPtexKernel *kernel, uint32_t face)
{
    const CoPtexFace *info = face_at(walk, face);
    if (kernel->uw <= 0 || kernel->vw <= 0 || kernel->ulog2 > MOST_LOG2 ||
        kernel->vlog2 > MOST_LOG2 || walk->steps++ > MOST_STEPS)
        return;
    while (kernel->ulog2 > info->ulog2)
        co_ptex_coarsen_u(kernel);
    while (kernel->vlog2 > info->vlog2)
        co_ptex_coarsen_v(kernel);
    clip(kernel->ku, &kernel->u, &kernel->uw, 1 << kernel->ulog2);
    clip(kernel->kv, &kernel->v, &kernel->vw, 1 << kernel->vlog2);
    if (kernel->uw > 0 && kernel->vw > 0)
        walk->fn(walk->context, face, kernel);
}

// Into the neighbor: sub-faces cut the kernel again, because half of it may lie in the next one.
static void enter(Walk *walk, CoPtexKernel *kernel, uint32_t face)
{
    if (is_subface(face_at(walk, face)))
        split_and_apply(walk, kernel, face);
    else
        apply(walk, kernel, face);
}

static void apply_across(Walk *walk, CoPtexKernel *kernel, uint32_t face, int edge)
{
    const CoPtexFace *from = face_at(walk, face);
    uint32_t to = (uint32_t)from->adjfaces[edge];
    const CoPtexFace *info = face_at(walk, to);
    int to_edge = co_ptex_adjedge(from, edge), turns = edge - to_edge + 2;
    if (!is_subface(from) && is_subface(info)) {
        if (!co_ptex_to_subface(kernel, edge)) { // it lies in the secondary one, next to it
            int next_edge = (to_edge + 3) & 3;
            int32_t next = info->adjfaces[next_edge];
            if (next < 0)
                return;
            to_edge = co_ptex_adjedge(info, next_edge);
            to = (uint32_t)next;
            turns += next_edge - to_edge + 2;
        }
    } else if (is_subface(from) && !is_subface(info)) {
        int is_primary = info->adjfaces[to_edge] == (int32_t)face;
        co_ptex_to_main(kernel, edge - is_primary);
    }
    co_ptex_rotate(kernel, turns);
    enter(walk, kernel, to);
}

static void apply_to_corner_face(Walk *walk, CoPtexKernel *kernel, uint32_t face, int edge,
                                 uint32_t corner, int corner_edge)
{
    bool from_sub = is_subface(face_at(walk, face)), to_sub = is_subface(face_at(walk, corner));
    if (to_sub && !from_sub)
        co_ptex_to_subface(kernel, edge + 3);
    else if (from_sub && !to_sub)
        co_ptex_to_main(kernel, edge + 3);
    co_ptex_rotate(kernel, edge - corner_edge + 2);
    enter(walk, kernel, corner);
}

// Walks clockwise round the vertex at the start of `edge` and gives the corner part to the faces
// opposite: one at valence 4, a symmetric share to each of several, none at valence 3 and borders.
static void apply_to_corner(Walk *walk, CoPtexKernel *kernel, uint32_t face, int edge)
{
    uint32_t corners[MOST_VALENCE];
    int edges[MOST_VALENCE];
    int count = 0;
    uint32_t at = face;
    int at_edge = edge;
    bool was_subface = is_subface(face_at(walk, face));
    for (int i = 0; i < MOST_VALENCE; i++) {
        uint32_t previous = at;
        const CoPtexFace *info = face_at(walk, at);
        int32_t next = info->adjfaces[at_edge];
        at_edge = (co_ptex_adjedge(info, at_edge) + 1) & 3;
        if (next < 0 || ((uint32_t)next == face && at_edge == edge)) {
            count = i - 2;
            break;
        }
        at = (uint32_t)next;
        corners[i] = at;
        edges[i] = at_edge;
        info = face_at(walk, at);
        if (was_subface && !is_subface(info) &&
            info->adjfaces[(at_edge + 3) & 3] == (int32_t)previous) {
            // The vertex is in the middle of this face's edge.
            int is_primary = i == 1;
            co_ptex_to_main(kernel, edge + 2 * is_primary);
            co_ptex_rotate(kernel, edge - at_edge + 3 - is_primary);
            split_and_apply(walk, kernel, at);
            return;
        }
        was_subface = is_subface(info);
    }
    if (count == 1) {
        apply_to_corner_face(walk, kernel, face, edge, corners[1], edges[1]);
    } else if (count > 1) {
        co_ptex_rotate(kernel, edge + 2);
        float old_weight = co_ptex_weight(kernel);
        float new_weight = co_ptex_make_symmetric(kernel, old_weight);
        for (int i = 1; i <= count; i++) {
            CoPtexKernel copy = *kernel;
            apply_to_corner_face(walk, &copy, face, 2, corners[i], edges[i]);
        }
        walk->weight += new_weight * (float)count - old_weight;
    } else {
        walk->weight -= co_ptex_weight(kernel);
    }
}

static bool is_beyond(const CoPtexKernel *kernel, CoPtexEdge edge)
{
    switch (edge) {
    case CO_PTEX_BOTTOM:
        return kernel->v < 0;
    case CO_PTEX_RIGHT:
        return kernel->u + kernel->uw > 1 << kernel->ulog2;
    case CO_PTEX_TOP:
        return kernel->v + kernel->vw > 1 << kernel->vlog2;
    case CO_PTEX_LEFT:
        break;
    }
    return kernel->u < 0;
}

static void merge(const Walk *walk, CoPtexKernel *kernel, CoPtexEdge edge)
{
    bool in_u = edge == CO_PTEX_LEFT || edge == CO_PTEX_RIGHT;
    CoPtexBorder border = in_u ? walk->file->u_border : walk->file->v_border;
    co_ptex_merge(kernel, edge, border == CO_PTEX_BLACK);
}

// Left and right: the part beyond first loses its own corners, then crosses.
static void split_side(Walk *walk, CoPtexKernel *kernel, uint32_t face, CoPtexEdge edge)
{
    const CoPtexFace *info = face_at(walk, face);
    if (info->adjfaces[edge] < 0) {
        merge(walk, kernel, edge);
        return;
    }
    bool is_top = is_beyond(kernel, CO_PTEX_TOP), is_bottom = is_beyond(kernel, CO_PTEX_BOTTOM);
    CoPtexKernel side, corner;
    co_ptex_split(kernel, edge, &side);
    if (is_top && info->adjfaces[CO_PTEX_TOP] >= 0) {
        co_ptex_split(&side, CO_PTEX_TOP, &corner);
        apply_to_corner(walk, &corner, face, edge == CO_PTEX_RIGHT ? 2 : 3);
    } else if (is_top) {
        merge(walk, &side, CO_PTEX_TOP);
    }
    if (is_bottom && info->adjfaces[CO_PTEX_BOTTOM] >= 0) {
        co_ptex_split(&side, CO_PTEX_BOTTOM, &corner);
        apply_to_corner(walk, &corner, face, edge == CO_PTEX_RIGHT ? 1 : 0);
    } else if (is_bottom) {
        merge(walk, &side, CO_PTEX_BOTTOM);
    }
    apply_across(walk, &side, face, (int)edge);
}

static void split_end(Walk *walk, CoPtexKernel *kernel, uint32_t face, CoPtexEdge edge)
{
    if (face_at(walk, face)->adjfaces[edge] < 0) {
        merge(walk, kernel, edge);
        return;
    }
    CoPtexKernel part;
    co_ptex_split(kernel, edge, &part);
    apply_across(walk, &part, face, (int)edge);
}

static void split_and_apply(Walk *walk, CoPtexKernel *kernel, uint32_t face)
{
    if (kernel->uw <= 0 || kernel->vw <= 0 || kernel->ulog2 > MOST_LOG2 ||
        kernel->vlog2 > MOST_LOG2 || walk->depth >= MOST_DEPTH || walk->steps++ > MOST_STEPS)
        return;
    static const CoPtexEdge order[4] = {CO_PTEX_RIGHT, CO_PTEX_LEFT, CO_PTEX_TOP, CO_PTEX_BOTTOM};
    bool is_out[4];
    for (int i = 0; i < 4; i++)
        is_out[i] = is_beyond(kernel, order[i]);
    walk->depth++;
    for (int i = 0; i < 4; i++) {
        if (!is_out[i])
            continue;
        if (walk->no_edge_blend)
            merge(walk, kernel, order[i]);
        else if (i < 2)
            split_side(walk, kernel, face, order[i]);
        else
            split_end(walk, kernel, face, order[i]);
    }
    walk->depth--;
    apply(walk, kernel, face);
}

// A coordinate under its border mode; false: the result is black.
static bool wrap(float *u, CoPtexBorder border)
{
    switch (border) {
    case CO_PTEX_CLAMP:
        *u = *u < 0 ? 0 : *u > 1 ? 1 : *u;
        return true;
    case CO_PTEX_PERIODIC:
        *u -= floorf(*u);
        return true;
    case CO_PTEX_BLACK:
        break;
    }
    return *u > -1 && *u < 2;
}

static void build(CoPtexKernel *k, CoPtexFilterKind kind, const float at[2], const float width[2],
                  const int log2s[2])
{
    if (kind == CO_PTEX_FILTER_BOX) {
        k->uw = co_ptex_box(at[0], width[0], log2s[0], &k->ulog2, &k->u, k->ku);
        k->vw = co_ptex_box(at[1], width[1], log2s[1], &k->vlog2, &k->v, k->kv);
    } else {
        k->uw = co_ptex_bilinear(at[0], width[0], log2s[0], &k->ulog2, &k->u, k->ku);
        k->vw = co_ptex_bilinear(at[1], width[1], log2s[1], &k->vlog2, &k->v, k->kv);
    }
}

static void build_kernel(CoPtexKernel *kernel, const CoPtexFace *face, CoPtexFilterKind kind,
                         const CoPtexQuery *query, float u, float v)
{
    float uw = fabsf(query->uw1) + fabsf(query->uw2), vw = fabsf(query->vw1) + fabsf(query->vw2);
    kernel->rotation = 0;
    if (!is_subface(face)) {
        const float at[2] = {u, v};
        const float width[2] = {uw * query->width + query->blur, vw * query->width + query->blur};
        build(kernel, kind, at, width, (const int[2]){face->ulog2, face->vlog2});
        return;
    }
    // A sub-face is a quarter of a face of twice its resolution.
    const float at[2] = {0.5f * u, 0.5f * v};
    const float width[2] = {0.5f * (uw * query->width + 2 * query->blur),
                            0.5f * (vw * query->width + 2 * query->blur)};
    build(kernel, kind, at, width, (const int[2]){face->ulog2 + 1, face->vlog2 + 1});
    co_ptex_to_quarter(kernel);
}

static float finite_or_zero(float x)
{
    return fabsf(x) < 1e30f ? x : 0;
}

float co_ptex_filter(const CoPtexFile *file, const CoPtexFilter *filter, const CoPtexQuery *query,
                     CoPtexPartFn *fn, void *context)
{
    const CoPtexFace *face = &file->faces[query->face];
    CoPtexKernel kernel;
    if (face->flags & CO_PTEX_NEIGHBORS_CONSTANT) {
        kernel = (CoPtexKernel){.uw = 1, .vw = 1, .ku = {1}, .kv = {1}};
        fn(context, query->face, &kernel);
        return 1;
    }
    float u = finite_or_zero(query->u), v = finite_or_zero(query->v);
    if (!wrap(&u, file->u_border) || !wrap(&v, file->v_border))
        return 0;
    build_kernel(&kernel, face, filter->kind, query, u, v);
    co_ptex_strip_zeros(&kernel);
    Walk walk = {.file = file,
                 .no_edge_blend = filter->no_edge_blend,
                 .fn = fn,
                 .context = context,
                 .weight = co_ptex_weight(&kernel)};
    split_and_apply(&walk, &kernel, query->face);
    return walk.weight;
}

void co_ptex_turn(const CoPtexFile *file, int rotation, uint32_t count, float *sum)
{
    if (!file->is_tangent || count < 2 || rotation == 0)
        return;
    float x = sum[0], y = sum[1];
    sum[0] = rotation == 1 ? -y : rotation == 2 ? -x : y;
    sum[1] = rotation == 1 ? x : rotation == 2 ? -y : -x;
}
