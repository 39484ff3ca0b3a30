// The patches of a subdivided mesh (patch.h), from the layout of points.

#include "base/parallel.h"
#include "geometry/patch_tile.h"
#include "geometry/subdivide.h"

// Edge k of a face as patches have it: counted from its vertex k, or back towards it.
static uint32_t edge_word(const CoSubdivision *s, uint32_t face, uint32_t k, bool is_back)
{
    uint32_t edge = (uint32_t)co_osd_face_edges(s->osd, face)[k], ends[2];
    co_osd_edge_vertices(s->osd, edge, ends);
    bool is_forward = ends[0] == (uint32_t)s->indices[s->first[face] + k];
    uint32_t first = co_subdivision_edge_point(s, edge);
    uint32_t count = (1u << co_subdivision_edge_level(s, edge)) - 1;
    return is_forward != is_back ? first - 1 : CO_PATCH_FLAG | (first + count);
}

// By how many halvings an edge is coarser than its face.
static uint32_t edge_drop(const CoSubdivision *s, uint32_t face, uint32_t k)
{
    uint32_t edge = (uint32_t)co_osd_face_edges(s->osd, face)[k];
    return co_subdivision_face_level(s, face) - co_subdivision_edge_level(s, edge);
}

static uint32_t middle_of_edge(const CoSubdivision *s, uint32_t face, uint32_t k)
{
    uint32_t edge = (uint32_t)co_osd_face_edges(s->osd, face)[k];
    return co_subdivision_face_edge_point(s, face, k,
                                          1u << co_subdivision_edge_level(s, edge) >> 1);
}

// A quad, or a triangle of a Loop mesh, whose last edge runs back from the third corner.
static void fill_whole(const CoSubdivision *s, uint32_t face, uint32_t stride, uint32_t *words)
{
    const int32_t *vertex = s->indices + s->first[face];
    uint32_t count = (uint32_t)s->counts[face], rates = co_subdivision_face_level(s, face);
    for (uint32_t k = 0; k < count; k++)
        words[CO_PATCH_CORNER + k] = (uint32_t)vertex[k];
    if (s->level == 0)
        return;
    for (uint32_t k = 0; k < count; k++) {
        words[CO_PATCH_EDGE + k] = edge_word(s, face, k, k >= 2);
        rates |= edge_drop(s, face, k) << (4 + 4 * k);
    }
    words[count == 3 ? CO_PATCH_INNER_TRIANGULAR : CO_PATCH_INNER] = s->face_point[face];
    if (s->edge_level)
        words[stride - 1] = rates;
}

// Sub-quad k of an n-gon. Inside the face lie the center, then the spokes from the middle of each
// edge to the center, then the inner points of each sub-quad.
static void fill_sub_quad(const CoSubdivision *s, uint32_t face, uint32_t k, uint32_t stride,
                          uint32_t *words)
{
    uint32_t level = co_subdivision_face_level(s, face);
    uint32_t valence = (uint32_t)s->counts[face], before = (k + valence - 1) % valence;
    uint32_t center = s->face_point[face], spoke = (1u << level) / 2 - 1;
    words[CO_PATCH_CORNER] = (uint32_t)s->indices[s->first[face] + k];
    words[CO_PATCH_CORNER + 1] = middle_of_edge(s, face, k);
    words[CO_PATCH_CORNER + 2] = center;
    words[CO_PATCH_CORNER + 3] = middle_of_edge(s, face, before);
    if (stride == CO_PATCH_EDGE) // corners are all there is
        return;
    words[CO_PATCH_EDGE] = edge_word(s, face, k, false);
    words[CO_PATCH_EDGE + 1] = center + k * spoke;
    words[CO_PATCH_EDGE + 2] = center + before * spoke;
    words[CO_PATCH_EDGE + 3] = edge_word(s, face, before, true);
    words[CO_PATCH_INNER] = (s->has_whole || s->edge_level ? CO_PATCH_FLAG : 0) |
                            (center + 1 + valence * spoke + k * spoke * spoke);
    if (s->edge_level)
        words[stride - 1] =
            (level - 1) | edge_drop(s, face, k) << 4 | edge_drop(s, face, before) << 16;
}

// A face of a folded table.
static void fill_folded(const CoSubdivision *s, uint32_t face, uint32_t stride, uint32_t *words)
{
    const uint32_t n = (uint32_t)s->counts[face];
    for (uint32_t k = 0; k < n; k++) {
        words[k] = (uint32_t)s->indices[s->first[face] + k];
        if (s->level > 0)
            words[n + k] = edge_word(s, face, k, false);
    }
    words[stride - 1] = s->face_point[face];
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
    uint32_t stride, fold;
} PatchJob;

static void fill_faces(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const PatchJob *job = context;
    const CoSubdivision *s = job->s;
    for (uint32_t f = (uint32_t)begin; f < end; f++) {
        if (!s->is_live[f])
            continue;
        size_t at = s->face_patch[f] / (job->fold ? 3 : 1);
        uint32_t *words = job->words + at * job->stride;
        if (job->fold) {
            fill_folded(s, f, job->stride, words);
            continue;
        }
        if (!co_subdivision_is_split(s, f)) {
            fill_whole(s, f, job->stride, words);
            continue;
        }
        for (uint32_t k = 0; k < (uint32_t)s->counts[f]; k++, words += job->stride) {
            if (s->level == 0)
                fill_fan(s, f, k, words);
            else
                fill_sub_quad(s, f, k, job->stride, words);
        }
    }
}

// Patches of each face of the description, if all have as many; else 0.
static uint32_t even_patches(const CoSubdivision *s)
{
    if (s->face_count != s->build->desc->face_count)
        return 0;
    for (uint32_t f = 0; f < s->face_count; f++)
        if (!s->is_live[f] || co_subdivision_patch_count(s, f) != co_subdivision_patch_count(s, 0))
            return 0;
    return co_subdivision_patch_count(s, 0);
}

static bool find_faces(CoSubdivision *s, CoPatchTable *table)
{
    table->per_face = even_patches(s);
    if (table->per_face)
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

// First patches, where they do not follow from the face.
static bool find_face_patches(CoSubdivision *s, const CoPatchTable *table)
{
    s->build->shading->face_patch = NULL; // of a layout whose faces had an infinite surface
    if (!table->is_mixed && (table->per_face || !s->has_split))
        return true;
    uint32_t *first = co_mesh_keep(s->build, s->build->desc->face_count, sizeof *first);
    CO_MESH_CHECK_MEMORY(s->build, first);
    for (uint32_t f = 0; f < s->face_count; f++)
        if (s->is_live[f])
            first[co_subdivision_cage_face(s, f)] = s->face_patch[f];
    s->build->shading->face_patch = first;
    return true;
}

static uint32_t first_live(const CoSubdivision *s)
{
    uint32_t face = 0;
    while (!s->is_live[face])
        face++;
    return face;
}

// log2 of triangles of each patch of a face; a fan's triangles are patches of 2^0.
static uint32_t patch_tri_shift(const CoSubdivision *s, uint32_t face)
{
    uint32_t level = co_subdivision_face_level(s, face);
    if (s->grid == CO_GRID_TRIANGLE)
        return 2 * level;
    if (!co_subdivision_is_split(s, face))
        return 2 * level + 1;
    return level == 0 ? 0 : 2 * level - 1;
}

// Back from triangles to patches, about as many entries as there are patches.
static bool find_units(CoMeshBuild *build, CoPatchTable *table, const uint32_t *first)
{
    uint32_t tri_count = build->mesh->tri_count, patch = 0;
    while (table->is_mixed && table->unit_shift > 0 &&
           tri_count >> table->unit_shift < table->count)
        table->unit_shift--;
    size_t count = ((size_t)tri_count >> table->unit_shift) + 2;
    uint32_t *back = co_mesh_keep(build, count, sizeof *back);
    CO_MESH_CHECK_MEMORY(build, back);
    for (size_t k = 0; k < count; k++) {
        while (patch + 1 < table->count && first[patch + 1] <= k << table->unit_shift)
            patch++;
        back[k] = patch;
    }
    table->tri_patch = back;
    return true;
}

// Where patches do not all have the same number of triangles: their triangles and tiles.
static bool find_triangles(CoSubdivision *s, CoPatchTable *table)
{
    CoMeshBuild *build = s->build;
    if (!table->is_mixed && !(s->has_split && s->has_whole)) {
        table->unit_shift = table->count ? patch_tri_shift(s, first_live(s)) : 0;
        return true;
    }
    table->unit_shift = 2 * table->level + (s->grid == CO_GRID_QUAD);
    bool has_tiles = table->level > CO_PATCH_TILE_SHIFT;
    uint32_t *first = co_mesh_keep(build, table->count + (size_t)1, sizeof *first);
    uint32_t *tile = has_tiles ? co_mesh_keep(build, table->count + (size_t)1, sizeof *tile) : NULL;
    CO_MESH_CHECK_MEMORY(build, first);
    if (has_tiles)
        CO_MESH_CHECK_MEMORY(build, tile);
    for (uint32_t f = 0; f < s->face_count; f++) {
        if (!s->is_live[f])
            continue;
        uint32_t patch = s->face_patch[f], end = patch + co_subdivision_patch_count(s, f);
        for (; patch < end; patch++) {
            uint32_t room[CO_PATCH_WORDS];
            uint32_t shift = co_patch_shift(table, co_patch_words(table, patch, room));
            first[patch + 1] = first[patch] + (1u << patch_tri_shift(s, f));
            if (tile)
                tile[patch + 1] = tile[patch] + co_patch_tiles(table, shift);
        }
    }
    table->first_tri = first;
    table->first_tile = tile;
    return find_units(build, table, first);
}

// Only triangles are worth it: others are few, and few of a kind.
static bool is_folded(const CoSubdivision *s, const CoPatchTable *table)
{
    if (table->is_mixed || s->has_whole || !s->has_split)
        return false;
    for (uint32_t f = 0; f < s->face_count; f++)
        if (s->is_live[f] && s->counts[f] != 3)
            return false;
    return true;
}

static uint32_t stride_of(const CoSubdivision *s, const CoPatchTable *table)
{
    if (table->fold)
        return table->fold * (s->level > 0 ? 2 : 1) + 1;
    if (table->level == 0)
        return table->is_triangular ? 3 : 4;
    uint32_t words = table->is_triangular ? CO_PATCH_WORDS_TRIANGULAR : CO_PATCH_WORDS;
    return words + (table->is_mixed ? 1 : 0);
}

static bool make_words(CoSubdivision *s, CoPatchTable *table)
{
    CoMeshBuild *build = s->build;
    const bool is_short = co_subdivision_is_short(table);
    uint32_t *words = co_subdivision_alloc_words(build, table, is_short);
    CO_MESH_CHECK_MEMORY(build, words);
    PatchJob job = {s, words, table->stride, table->fold};
    co_parallel_for(s->face_count, 256, fill_faces, &job);
    if (!is_short) {
        table->words = words;
        return true;
    }
    bool ok = co_subdivision_shorten_words(build, table, words);
    co_mesh_block_drop(&build->scratch, words);
    return ok;
}

bool co_subdivision_make_patches(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    CoPatchTable *table = co_mesh_keep(build, 1, sizeof *table);
    CO_MESH_CHECK_MEMORY(build, table);
    table->is_triangular = s->grid == CO_GRID_TRIANGLE;
    table->is_mixed = s->edge_level != NULL;
    bool is_all_split = s->has_split && !s->has_whole && !table->is_mixed;
    table->level = s->level - (is_all_split && s->level > 0 ? 1 : 0);
    table->count = s->patch_count;
    table->fold = is_folded(s, table) ? 3 : 0;
    table->stride = stride_of(s, table);
    if (!make_words(s, table) || !find_faces(s, table) || !find_face_patches(s, table) ||
        !find_triangles(s, table))
        return false;
    build->mesh->patches = build->shading->patches = table;
    return true;
}
