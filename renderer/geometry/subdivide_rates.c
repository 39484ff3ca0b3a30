// How fine the edges and faces of a cage become. An edge has one level, the finest that a face
// beside it asks for, and a face the level of its finest edge or a finer one of its own: so
// neighbors agree on the points between them (Moreton, "Watertight Tessellation Using Forward
// Differencing", 2001, has the idea of rates that belong to edges; patch.h how a face meets an edge
// that is coarser than itself).

#include "geometry/subdivide.h"

static uint32_t wanted_level(const CohortMeshDesc *desc, uint32_t face_vertex)
{
    uint32_t level = desc->edge_levels ? desc->edge_levels[face_vertex] : 0;
    return level > desc->level ? level : desc->level;
}

uint32_t co_subdivision_finest(const CohortMeshDesc *desc)
{
    uint32_t level = desc->level;
    for (size_t k = 0; desc->edge_levels && k < desc->face_vertex_index_count; k++)
        level = desc->edge_levels[k] > level ? desc->edge_levels[k] : level;
    for (size_t f = 0; desc->face_levels && f < desc->face_count; f++)
        level = desc->face_levels[f] > level ? desc->face_levels[f] : level;
    return level;
}

// Of an edge of a face that is no quad the middle is a corner of two patches, whatever it asks for.
static void find_edge_levels(CoSubdivision *s)
{
    for (uint32_t f = 0; f < s->face_count; f++) {
        const int32_t *edges = co_osd_face_edges(s->osd, f);
        for (uint32_t k = 0; k < (uint32_t)s->counts[f]; k++) {
            uint32_t fv = s->first[f] + k;
            uint32_t level = wanted_level(s->build->desc, s->cage_fv ? s->cage_fv[fv] : fv);
            uint32_t least = co_subdivision_is_split(s, f) ? 1 : 0;
            uint8_t *own = &s->edge_level[edges[k]];
            level = level > least ? level : least;
            *own = (uint8_t)(level > *own ? level : *own);
        }
    }
}

// Returns whether all edges of all faces have the same level.
static bool find_face_levels(CoSubdivision *s)
{
    const uint8_t *own = s->build->desc->face_levels;
    uint8_t least = UINT8_MAX, most = 0;
    for (uint32_t f = 0; f < s->face_count; f++) {
        const int32_t *edges = co_osd_face_edges(s->osd, f);
        s->face_level[f] = own ? own[co_subdivision_cage_face(s, f)] : 0;
        for (int32_t k = 0; k < s->counts[f]; k++) {
            uint8_t level = s->edge_level[edges[k]];
            s->face_level[f] = level > s->face_level[f] ? level : s->face_level[f];
            least = level < least ? level : least;
        }
        most = s->face_level[f] > most ? s->face_level[f] : most;
    }
    s->level = most;
    return least == most;
}

bool co_subdivision_make_rates(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    if (s->level > build->desc->level) {
        uint32_t edge_count = co_osd_edge_count(s->osd);
        s->edge_level = co_mesh_scratch(build, edge_count, 1);
        s->face_level = co_mesh_scratch(build, s->face_count, 1);
        s->edge_point = co_mesh_scratch(build, edge_count, sizeof *s->edge_point);
        CO_MESH_CHECK_MEMORY(build, s->edge_level);
        CO_MESH_CHECK_MEMORY(build, s->face_level);
        CO_MESH_CHECK_MEMORY(build, s->edge_point);
        find_edge_levels(s);
        if (find_face_levels(s)) {
            s->edge_level = s->face_level = NULL;
            s->edge_point = NULL;
        }
    }
    build->shading->level = s->level;
    return true;
}
