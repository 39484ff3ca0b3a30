#include "geometry/mesh_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

struct CoMeshBlock {
    CoMeshBlock *next;
    size_t size; // with this header
    char pad[48];
};
_Static_assert(sizeof(CoMeshBlock) == 64, "data behind the header stays aligned to 64");

void *co_mesh_block_alloc(CoMeshBlock **list, size_t count, size_t size)
{
    size_t bytes;
    if (!co_size_mul(count, size, &bytes) || bytes > SIZE_MAX - sizeof(CoMeshBlock))
        return NULL;
    CoMeshBlock *block = co_alloc_zero(CO_MEMORY_GEOMETRY, bytes + sizeof *block);
    if (!block)
        return NULL;
    block->size = bytes + sizeof *block;
    block->next = *list;
    *list = block;
    return block + 1;
}

void co_mesh_block_free(CoMeshBlock **list)
{
    for (CoMeshBlock *block = *list; block;) {
        CoMeshBlock *next = block->next;
        co_free(CO_MEMORY_GEOMETRY, block, block->size);
        block = next;
    }
    *list = NULL;
}

void co_mesh_block_drop(CoMeshBlock **list, const void *array)
{
    while (*list && (const void *)(*list + 1) != array)
        list = &(*list)->next;
    CoMeshBlock *block = *list;
    if (!block)
        return;
    *list = block->next;
    co_free(CO_MEMORY_GEOMETRY, block, block->size);
}

size_t co_mesh_block_bytes(const CoMeshBlock *list)
{
    size_t bytes = 0;
    for (; list; list = list->next)
        bytes += list->size;
    return bytes;
}

bool co_mesh_fail(CoMeshBuild *build, const char *where, CohortErrorCode code, const char *format,
                  ...)
{
    char text[192];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    co_error_set(build->err, where, code, "mesh %.60s: %s", build->path, text);
    co_error_place(build->err, NULL, 0, 0, build->path);
    return false;
}

void co_mesh_warn(CoMeshBuild *build, const char *format, ...)
{
    if (!build->warn)
        return;
    char text[256];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    build->warn(build->cookie, text);
}

// Of polygons; subdivision has found the box on the way.
static void find_box(CoMesh *mesh)
{
    if (mesh->tri_count == 0 || mesh->shading->grid != CO_GRID_POLYGON)
        return;
    const float *first = mesh->points + 3 * (size_t)mesh->indices[0];
    CoVec3 lo = co_vec3_load(first), hi = lo;
    for (size_t k = 0; k < 3 * (size_t)mesh->tri_count; k++) {
        CoVec3 p = co_vec3_load(mesh->points + 3 * (size_t)mesh->indices[k]);
        lo = co_vec3(fminf(lo.x, p.x), fminf(lo.y, p.y), fminf(lo.z, p.z));
        hi = co_vec3(fmaxf(hi.x, p.x), fmaxf(hi.y, p.y), fmaxf(hi.z, p.z));
    }
    mesh->box_min = lo;
    mesh->box_max = hi;
}

// Of polygons, in double. The plane is that of the largest of a few triangles.
static void find_flat(CoMesh *mesh)
{
    if (mesh->patches)
        return;
    double n[3] = {0.0, 0.0, 0.0}, at[3] = {0.0, 0.0, 0.0}, length = 0.0;
    for (uint32_t t = 0; t < mesh->tri_count && t < 16; t++) {
        uint32_t point[3];
        co_mesh_triangle(mesh, t, point);
        const float *p = mesh->points + 3 * (size_t)point[0];
        const float *q = mesh->points + 3 * (size_t)point[1];
        const float *r = mesh->points + 3 * (size_t)point[2];
        double cross[3], sum = 0.0;
        for (int k = 0; k < 3; k++) {
            int i = (k + 1) % 3, j = (k + 2) % 3;
            cross[k] = ((double)q[i] - (double)p[i]) * ((double)r[j] - (double)p[j]) -
                       ((double)q[j] - (double)p[j]) * ((double)r[i] - (double)p[i]);
            sum += cross[k] * cross[k];
        }
        for (int k = 0; k < 3 && sum > length; k++) {
            n[k] = cross[k];
            at[k] = (double)p[k];
        }
        length = sum > length ? sum : length;
    }
    double size = 0.0;
    for (int k = 0; k < 3; k++)
        size = fmax(size,
                    fmax(fabs((double)(&mesh->box_min.x)[k]), fabs((double)(&mesh->box_max.x)[k])));
    mesh->is_flat = length > 0.0;
    for (size_t i = 0; i < mesh->point_count && mesh->is_flat; i++) {
        const float *p = mesh->points + 3 * i;
        double height = n[0] * ((double)p[0] - at[0]) + n[1] * ((double)p[1] - at[1]) +
                        n[2] * ((double)p[2] - at[2]);
        mesh->is_flat = fabs(height) <= 0x1p-21 * size * sqrt(length);
    }
}

static bool build_mesh(CoMeshBuild *build)
{
    if (!co_mesh_check(build) || !co_mesh_build_materials(build) || !co_mesh_check_primvars(build))
        return false;
    build->shading->left_handed = build->desc->left_handed;
    build->shading->ptex_face_offset = build->desc->ptex_face_offset;
    if (build->desc->scheme == COHORT_SCHEME_NONE)
        return co_mesh_build_polygons(build);
    return co_mesh_build_subdivision(build);
}

bool co_mesh_create(const CohortMeshDesc *desc, CoMesh *out, CoMeshWarnFn *warn, void *cookie,
                    CohortError *err)
{
    CoMeshBlock *blocks = NULL;
    CoMeshShading *shading = co_mesh_block_alloc(&blocks, 1, sizeof *shading);
    CO_CHECK_MEMORY(shading, err);
    shading->blocks = blocks;
    CoMesh mesh = {.face_count = 0, .shading = shading};
    CoMeshBuild build = {.desc = desc,
                         .path = desc->path ? desc->path : "without a path",
                         .mesh = &mesh,
                         .shading = shading,
                         .warn = warn,
                         .cookie = cookie,
                         .err = err};
    bool ok = build_mesh(&build);
    co_mesh_block_free(&build.scratch);
    if (!ok) {
        co_mesh_destroy(&mesh);
        return false;
    }
    find_box(&mesh);
    find_flat(&mesh);
    mesh.bytes = co_mesh_block_bytes(shading->blocks);
    *out = mesh;
    return true;
}

void co_mesh_destroy(CoMesh *mesh)
{
    if (mesh->shading) {
        // The shading block is itself in the list it heads.
        CoMeshBlock *blocks = mesh->shading->blocks;
        co_mesh_block_free(&blocks);
    }
    memset(mesh, 0, sizeof *mesh);
}

static bool same_words(const uint32_t *a, const uint32_t *b, size_t count)
{
    return (!a && !b) || (a && b && memcmp(a, b, count * sizeof *a) == 0);
}

// Words, however they are kept.
static bool same_patch_words(const CoPatchTable *a, const CoPatchTable *b)
{
    if (a->words && b->words)
        return same_words(a->words, b->words, co_patch_word_count(a));
    for (uint32_t patch = 0; patch < a->count; patch++) {
        uint32_t left[CO_PATCH_WORDS], right[CO_PATCH_WORDS];
        if (memcmp(co_patch_words(a, patch, left), co_patch_words(b, patch, right),
                   a->stride * sizeof *left) != 0)
            return false;
    }
    return true;
}

static bool same_patches(const CoPatchTable *a, const CoPatchTable *b)
{
    return a->level == b->level && a->count == b->count && a->stride == b->stride &&
           a->fold == b->fold && a->is_triangular == b->is_triangular && same_patch_words(a, b) &&
           same_words(a->first_tri, b->first_tri, (size_t)a->count + 1);
}

bool co_mesh_same_topology(const CoMesh *a, const CoMesh *b)
{
    if (a->point_count != b->point_count || a->tri_count != b->tri_count ||
        !a->patches != !b->patches)
        return false;
    return a->patches ? same_patches(a->patches, b->patches)
                      : same_words(a->indices, b->indices, 3 * (size_t)a->tri_count);
}

// What an array of the mesh takes; 0 when it has no block to itself.
static size_t array_bytes(const CoMeshShading *shading, const void *array)
{
    for (const CoMeshBlock *b = shading->blocks; b && array; b = b->next)
        if ((const void *)(b + 1) == array)
            return b->size;
    return 0;
}

void co_mesh_memory(const CoMesh *mesh, CoMeshMemory *out)
{
    *out = (CoMeshMemory){0};
    const CoMeshShading *shading = mesh->shading;
    if (!shading)
        return;
    out->points = array_bytes(shading, mesh->points);
    out->topology = array_bytes(shading, mesh->indices);
    if (mesh->patches)
        out->topology += array_bytes(shading, mesh->patches->words) +
                         array_bytes(shading, mesh->patches->packs) +
                         array_bytes(shading, mesh->patches->packed) +
                         array_bytes(shading, mesh->patches->nears) +
                         array_bytes(shading, mesh->patches->fars) +
                         array_bytes(shading, mesh->patches->first_tri) +
                         array_bytes(shading, mesh->patches->tri_patch) +
                         array_bytes(shading, mesh->patches->first_tile);
    out->normals = array_bytes(shading, shading->limit_normals) +
                   array_bytes(shading, shading->own_normals) +
                   array_bytes(shading, shading->normals.values) +
                   array_bytes(shading, shading->normals.indices);
}
