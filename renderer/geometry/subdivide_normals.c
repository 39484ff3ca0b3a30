// Normals where faces that meet do not share them: evaluated per corner element, kept per point for
// as many faces as agree, and by element for the others.

#include "base/parallel.h"
#include "geometry/grid.h"
#include "geometry/subdivide.h"
#include "geometry/unit_code.h"

#include <string.h>

// Radians. Neighbors find the same normal within a step or two of its code, and less nearly where
// OpenSubdiv approaches the ends of creases.
#define SHARED 1e-3f
#define DERIVED 2e-4f

typedef struct Sharing {
    const CoSubdivision *s;
    uint32_t *codes;     // by corner element; then CO_UNIT_SHARED where the point's is the same
    uint32_t *points;    // of elements; UINT32_MAX: no triangle asks for it
    uint32_t *at_points; // of points
} Sharing;

// A patch and its corner elements.
typedef struct Patch {
    const CoPatchTable *table;
    uint32_t room[CO_PATCH_WORDS];
    const uint32_t *words;
    uint32_t m, first; // squares a side, element of (0, 0)
    bool is_fan;
} Patch;

static void open_patch(const CoSubdivision *s, uint32_t face, uint32_t k, Patch *out)
{
    const CoPatchTable *table = s->build->mesh->patches;
    out->table = table;
    out->words = co_patch_words(table, s->face_patch[face] + k, out->room);
    out->is_fan = !table->is_triangular && co_patch_is_fan(table, out->words);
    out->m = out->is_fan ? 1 : 1u << co_patch_shift(table, out->words);
    uint32_t each = table->is_triangular || out->is_fan ? 0 : (out->m + 1) * (out->m + 1);
    out->first = s->corner_first[co_subdivision_cage_face(s, face)] + k * each;
}

static uint32_t element_at(const Patch *patch, uint32_t i, uint32_t j)
{
    if (patch->table->is_triangular)
        return patch->first + co_grid_triangle_point(patch->m, i - j, j);
    return patch->first + j * (patch->m + 1) + i;
}

static void find_patch_points(const Patch *patch, uint32_t *points)
{
    const uint32_t m = patch->m;
    for (uint32_t j = 0; j <= m; j++) {
        for (uint32_t i = patch->table->is_triangular ? j : 0; i <= m; i++) {
            uint32_t a = i, b = j, *point = &points[element_at(patch, i, j)];
            co_patch_settle(patch->table, patch->words, m, &a, &b);
            bool is_asked_for = a == i && b == j;
            *point =
                is_asked_for ? co_patch_point(patch->table, patch->words, m, a, b) : UINT32_MAX;
        }
    }
}

static CoVec3 plane_normal(const Sharing *sharing, const uint32_t element[3])
{
    CoVec3 p[3];
    for (int c = 0; c < 3; c++)
        p[c] = co_vec3_load(sharing->s->points + 3 * (size_t)sharing->points[element[c]]);
    return co_normalize(co_cross(co_sub(p[1], p[0]), co_sub(p[2], p[0])));
}

static bool is_near(CoVec3 a, CoVec3 b, float most)
{
    return co_length(co_cross(a, b)) < most && co_dot(a, b) > 0.0f;
}

// Whether the normals of a patch are those of its triangles.
static bool is_faceted(const Sharing *sharing, const Patch *patch)
{
    const uint32_t m = patch->m, count = m * m * (patch->table->is_triangular ? 1 : 2);
    for (uint32_t local = 0; local < count; local++) {
        uint32_t i[3], j[3], element[3];
        co_patch_corners(patch->table, patch->words, local, i, j);
        for (int c = 0; c < 3; c++)
            element[c] = element_at(patch, i[c], j[c]);
        CoVec3 normal = plane_normal(sharing, element);
        for (int c = 0; c < 3; c++)
            if (!is_near(normal, co_unit_decode(sharing->codes[element[c]]), DERIVED))
                return false;
    }
    return true;
}

// Whether they are those of the bilinear patch between its corners.
static bool is_bilinear(const Sharing *sharing, const Patch *patch)
{
    CoVec3 q[4];
    for (int k = 0; k < 4; k++)
        q[k] = co_vec3_load(sharing->s->points + 3 * (size_t)patch->words[CO_PATCH_CORNER + k]);
    const float scale = 1.0f / (float)patch->m;
    for (uint32_t j = 0; j <= patch->m; j++) {
        for (uint32_t i = 0; i <= patch->m; i++) {
            CoVec3 normal = co_bilinear_normal(q, (float)i * scale, (float)j * scale);
            if (!is_near(normal, co_unit_decode(sharing->codes[element_at(patch, i, j)]), DERIVED))
                return false;
        }
    }
    return true;
}

// The same of a triangle of a fan, elements of whose corners are not in a row.
static bool is_faceted_fan(const Sharing *sharing, const Patch *patch, uint32_t k, uint32_t valence)
{
    const uint32_t first = patch->first;
    const uint32_t element[3] = {first + k, first + (k + 1) % valence, first + valence};
    CoVec3 normal = plane_normal(sharing, element);
    for (int c = 0; c < 3; c++)
        if (!is_near(normal, co_unit_decode(sharing->codes[element[c]]), DERIVED))
            return false;
    return true;
}

// Finds the points of a face's elements, and whether its normals follow from points.
static void look_at_face(const Sharing *sharing, uint32_t face)
{
    const CoSubdivision *s = sharing->s;
    const uint32_t count = co_subdivision_patch_count(s, face);
    const uint32_t first = s->corner_first[co_subdivision_cage_face(s, face)];
    uint32_t end = first;
    Patch patch;
    for (uint32_t k = 0; k < count; k++) {
        open_patch(s, face, k, &patch);
        end = patch.is_fan ? first + count + 1 : element_at(&patch, patch.m, patch.m) + 1;
        if (!patch.is_fan) {
            find_patch_points(&patch, sharing->points);
            continue;
        }
        sharing->points[first + k] = patch.words[0];
        sharing->points[first + count] = patch.words[2];
    }
    bool is_derived = true;
    for (uint32_t k = 0; is_derived && k < count; k++) {
        open_patch(s, face, k, &patch);
        is_derived = patch.is_fan           ? is_faceted_fan(sharing, &patch, k, count)
                     : s->counts[face] == 4 ? is_bilinear(sharing, &patch)
                                            : is_faceted(sharing, &patch);
    }
    for (uint32_t e = first; is_derived && e < end; e++)
        sharing->codes[e] = CO_UNIT_DERIVED;
}

static void look_at_faces(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const Sharing *sharing = context;
    for (size_t f = begin; f < end; f++)
        if (sharing->s->is_live[f])
            look_at_face(sharing, (uint32_t)f);
}

// The first face at a point has its say.
static void choose_for_points(const Sharing *sharing)
{
    for (uint32_t e = sharing->s->corner_count; e-- > 0;)
        if (sharing->points[e] != UINT32_MAX)
            sharing->at_points[sharing->points[e]] = sharing->codes[e];
}

static bool is_same_code(uint32_t a, uint32_t b)
{
    bool is_special = a >= CO_UNIT_SHARED || b >= CO_UNIT_SHARED;
    return a == b || (!is_special && is_near(co_unit_decode(a), co_unit_decode(b), SHARED));
}

static void find_shared(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const Sharing *sharing = context;
    for (size_t e = begin; e < end; e++) {
        const uint32_t point = sharing->points[e];
        if (point == UINT32_MAX || is_same_code(sharing->codes[e], sharing->at_points[point]))
            sharing->codes[e] = CO_UNIT_SHARED;
    }
}

// Marks the elements that keep normals, and moves these to where they stay.
static void keep_own(const Sharing *sharing, CoOwnNormals *own, uint32_t *normals)
{
    const CoSubdivision *s = sharing->s;
    uint32_t next = s->point_count;
    for (uint32_t e = 0; e < s->corner_count; e++) {
        CoOwnNormals *of = &own[e / CO_OWN_ELEMENTS];
        if (e % CO_OWN_ELEMENTS == 0)
            of->first = next;
        if (sharing->codes[e] == CO_UNIT_SHARED)
            continue;
        of->has[e / 32 % 2] |= 1u << e % 32;
        normals[next++] = sharing->codes[e];
    }
}

bool co_subdivision_share_normals(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    CoMeshShading *shading = build->shading;
    Sharing sharing = {.s = s, .codes = s->normals};
    sharing.points = co_mesh_scratch(build, s->corner_count, sizeof *sharing.points);
    sharing.at_points = co_mesh_scratch(build, s->point_count, sizeof *sharing.at_points);
    CO_MESH_CHECK_MEMORY(build, sharing.points);
    CO_MESH_CHECK_MEMORY(build, sharing.at_points);
    co_parallel_for(s->face_count, 64, look_at_faces, &sharing);
    choose_for_points(&sharing);
    co_parallel_for(s->corner_count, 4096, find_shared, &sharing);
    size_t own_count = 0;
    for (uint32_t e = 0; e < s->corner_count; e++)
        own_count += sharing.codes[e] != CO_UNIT_SHARED;
    for (uint32_t p = 0; p < s->point_count; p++)
        shading->has_derived_normals |= sharing.at_points[p] == CO_UNIT_DERIVED;
    shading->has_corner_normals = own_count > 0;
    size_t word_count = (s->corner_count + (size_t)CO_OWN_ELEMENTS - 1) / CO_OWN_ELEMENTS;
    CoOwnNormals *own = own_count ? co_mesh_keep(build, word_count, sizeof *own) : NULL;
    uint32_t *normals = co_mesh_keep(build, s->point_count + own_count, sizeof *normals);
    if (own_count)
        CO_MESH_CHECK_MEMORY(build, own);
    CO_MESH_CHECK_MEMORY(build, normals);
    memcpy(normals, sharing.at_points, s->point_count * sizeof *normals);
    if (own)
        keep_own(&sharing, own, normals);
    shading->limit_normals = normals;
    shading->own_normals = own;
    return true;
}
