// The patches of a quad grid (patch.h), from the layout of points.

#include "base/parallel.h"
#include "geometry/subdivide.h"

// Edge k of a face as patches have it: counted from its vertex k, or back towards it.
static uint32_t edge_word(const CoSubdivision *s, uint32_t face, uint32_t k, bool is_back)
{
    uint32_t edge = (uint32_t)co_osd_face_edges(s->osd, face)[k], ends[2];
    co_osd_edge_vertices(s->osd, edge, ends);
    bool is_forward = ends[0] == (uint32_t)s->indices[s->first[face] + k];
    uint32_t first = co_subdivision_edge_point(s, edge);
    return is_forward != is_back ? first - 1 : CO_PATCH_FLAG | (first + s->n - 1);
}

static uint32_t middle_of_edge(const CoSubdivision *s, uint32_t face, uint32_t k)
{
    return co_subdivision_face_edge_point(s, face, k, s->n / 2);
}

static void fill_quad(const CoSubdivision *s, uint32_t face, uint32_t *words)
{
    const int32_t *vertex = s->indices + s->first[face];
    for (int k = 0; k < 4; k++)
        words[CO_PATCH_CORNER + k] = (uint32_t)vertex[k];
    if (s->n == 1)
        return;
    for (uint32_t k = 0; k < 4; k++)
        words[CO_PATCH_EDGE + k] = edge_word(s, face, k, k >= 2);
    words[CO_PATCH_INNER] = s->face_point[face];
}

// Sub-quad k of an n-gon. Inside the face lie the center, then the spokes from the middle of each
// edge to the center, then the inner points of each sub-quad.
static void fill_sub_quad(const CoSubdivision *s, uint32_t face, uint32_t k, uint32_t *words)
{
    uint32_t valence = (uint32_t)s->counts[face], before = (k + valence - 1) % valence;
    uint32_t center = s->face_point[face], spoke = s->n / 2 - 1;
    words[CO_PATCH_CORNER] = (uint32_t)s->indices[s->first[face] + k];
    words[CO_PATCH_CORNER + 1] = middle_of_edge(s, face, k);
    words[CO_PATCH_CORNER + 2] = center;
    words[CO_PATCH_CORNER + 3] = middle_of_edge(s, face, before);
    words[CO_PATCH_EDGE] = edge_word(s, face, k, false);
    words[CO_PATCH_EDGE + 1] = center + k * spoke;
    words[CO_PATCH_EDGE + 2] = center + before * spoke;
    words[CO_PATCH_EDGE + 3] = edge_word(s, face, before, true);
    words[CO_PATCH_INNER] = CO_PATCH_FLAG | (center + 1 + valence * spoke + k * spoke * spoke);
}

static void fill_fan(const CoSubdivision *s, uint32_t face, uint32_t k, uint32_t *words)
{
    const int32_t *vertex = s->indices + s->first[face];
    words[0] = (uint32_t)vertex[k];
    words[1] = (uint32_t)vertex[(k + 1) % (uint32_t)s->counts[face]];
    words[2] = s->face_point[face];
    words[3] = CO_PATCH_NONE;
}

typedef struct PatchJob {
    const CoSubdivision *s;
    uint32_t *words;
    uint32_t stride;
} PatchJob;

static void fill_faces(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const PatchJob *job = context;
    const CoSubdivision *s = job->s;
    for (uint32_t f = (uint32_t)begin; f < end; f++) {
        if (!s->is_live[f])
            continue;
        uint32_t *words = job->words + (size_t)s->face_patch[f] * job->stride;
        if (!co_subdivision_is_split(s, f)) {
            fill_quad(s, f, words);
            continue;
        }
        for (uint32_t k = 0; k < (uint32_t)s->counts[f]; k++, words += job->stride) {
            if (s->n == 1)
                fill_fan(s, f, k, words);
            else
                fill_sub_quad(s, f, k, words);
        }
    }
}

static bool find_faces(CoSubdivision *s, CoPatchTable *table)
{
    if (table->count == s->build->desc->face_count && !s->has_split)
        return true;
    uint32_t *face = co_mesh_keep(s->build, table->count, sizeof *face);
    CO_MESH_CHECK_MEMORY(s->build, face);
    for (uint32_t f = 0; f < s->face_count; f++) {
        uint32_t count = s->is_live[f] ? co_subdivision_patch_count(s, f) : 0;
        for (uint32_t k = 0; k < count; k++)
            face[s->face_patch[f] + k] = co_subdivision_cage_face(s, f);
    }
    table->face = face;
    return true;
}

// Where patches are not all whole quads: their triangles, and back from triangles to patches.
static bool find_triangles(CoSubdivision *s, CoPatchTable *table)
{
    if (!s->has_split)
        return true;
    CoMeshBuild *build = s->build;
    uint32_t shift = 2 * table->level + 1, tri_count = build->mesh->tri_count, tri = 0;
    uint32_t *first = co_mesh_keep(build, table->count + 1, sizeof *first);
    uint32_t *back = co_mesh_keep(build, (tri_count >> shift) + 1, sizeof *back);
    uint32_t *face_patch = co_mesh_keep(build, build->desc->face_count, sizeof *face_patch);
    CO_MESH_CHECK_MEMORY(build, first);
    CO_MESH_CHECK_MEMORY(build, back);
    CO_MESH_CHECK_MEMORY(build, face_patch);
    for (uint32_t f = 0; f < s->face_count; f++) {
        uint32_t count = s->is_live[f] ? co_subdivision_patch_count(s, f) : 0;
        uint32_t tris = 1u << shift;
        if (co_subdivision_is_split(s, f))
            tris = s->n == 1 ? 1 : tris / 4;
        for (uint32_t k = 0; k < count; k++, tri += tris) {
            uint32_t patch = s->face_patch[f] + k;
            first[patch] = tri;
            for (uint32_t b = (tri + (1u << shift) - 1) >> shift; b << shift < tri + tris; b++)
                back[b] = patch;
        }
        face_patch[co_subdivision_cage_face(s, f)] = s->face_patch[f];
    }
    first[table->count] = tri;
    table->first_tri = first;
    table->tri_patch = back;
    build->shading->face_patch = face_patch;
    return true;
}

bool co_subdivision_make_patches(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    CoPatchTable *table = co_mesh_keep(build, 1, sizeof *table);
    CO_MESH_CHECK_MEMORY(build, table);
    table->level = build->desc->level;
    table->count = s->patch_count;
    table->stride = table->level == 0 ? 4 : CO_PATCH_WORDS;
    uint32_t *words = co_mesh_keep(build, table->count, table->stride * sizeof *words);
    CO_MESH_CHECK_MEMORY(build, words);
    table->words = words;
    PatchJob job = {s, words, table->stride};
    co_parallel_for(s->face_count, 256, fill_faces, &job);
    if (!find_faces(s, table) || !find_triangles(s, table))
        return false;
    build->mesh->patches = build->shading->patches = table;
    return true;
}
