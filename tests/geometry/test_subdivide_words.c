// What subdivide_words.c keeps of patches: their points, whether these are near each other or far
// apart, in no more bytes than plain words.

#include "subdivision_fixture.h"

#include "base/hash.h"

enum {
    SIDE = 240, // so that rows that close the torus are too far apart
    POINTS = SIDE * SIDE,
    FACES = 2 * POINTS
};

typedef struct Large {
    float points[3 * POINTS];
    int32_t counts[FACES], indices[3 * FACES];
} Large;

static void shuffle(uint32_t *order, uint32_t count, uint32_t seed)
{
    for (uint32_t k = 0; k < count; k++)
        order[k] = k;
    for (uint32_t k = count; k-- > 1;) {
        const uint32_t other = co_hash32(k + seed) % (k + 1), swapped = order[k];
        order[k] = order[other];
        order[other] = swapped;
    }
}

// A torus of triangles, its faces and points in rows or in any order.
static CohortMeshDesc make_large(Large *cage, CohortScheme scheme, uint32_t level, bool is_shuffled)
{
    static uint32_t order[FACES], number[POINTS];
    shuffle(order, FACES, 1);
    shuffle(number, POINTS, 2);
    for (int32_t k = 0; k < POINTS; k++) {
        const int32_t i = k % SIDE, j = k / SIDE, next = (i + 1) % SIDE, up = (j + 1) % SIDE;
        const int32_t quad[4] = {k, j * SIDE + next, up * SIDE + next, up * SIDE + i};
        const int32_t halves[6] = {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]};
        const double a = 6.283185307179586 * i / SIDE, b = 6.283185307179586 * j / SIDE;
        float *point = cage->points + 3 * (is_shuffled ? number[k] : (uint32_t)k);
        point[0] = (float)((3 + cos(b)) * cos(a));
        point[1] = (float)((3 + cos(b)) * sin(a));
        point[2] = (float)sin(b);
        for (int32_t f = 0; f < 2; f++) {
            const uint32_t face = is_shuffled ? order[2 * k + f] : (uint32_t)(2 * k + f);
            for (uint32_t c = 0; c < 3; c++) {
                const int32_t vertex = halves[3 * f + (int32_t)c];
                cage->indices[3 * face + c] = is_shuffled ? (int32_t)number[vertex] : vertex;
            }
            cage->counts[face] = 3;
        }
    }
    return (CohortMeshDesc){.scheme = scheme,
                            .level = level,
                            .points = cage->points,
                            .point_count = POINTS,
                            .face_vertex_counts = cage->counts,
                            .face_count = FACES,
                            .face_vertex_indices = cage->indices,
                            .face_vertex_index_count = 3 * FACES};
}

// The middle of the edge between two points, the same for both of its faces and for no other edge.
typedef struct Edges {
    uint32_t low[3 * FACES], high[3 * FACES], middle[3 * FACES]; // by slot; low == high: none
} Edges;

static void assert_middle(Edges *edges, uint32_t a, uint32_t b, uint32_t middle)
{
    const uint32_t low = a < b ? a : b, high = a < b ? b : a;
    uint32_t slot = co_hash32(low * 31u + co_hash32(high)) % (3 * FACES);
    while (edges->low[slot] != edges->high[slot] &&
           (edges->low[slot] != low || edges->high[slot] != high))
        slot = (slot + 1) % (3 * FACES);
    if (edges->low[slot] == edges->high[slot]) {
        edges->low[slot] = low;
        edges->high[slot] = high;
        edges->middle[slot] = middle;
    }
    assert_int_equal(edges->middle[slot], middle);
}

// Of level 1: corners as the cage has them, middles that neighbors share, centers in order.
static void check_faces(const CoMesh *mesh, const CohortMeshDesc *desc)
{
    static Edges edges;
    static uint8_t times[4 * POINTS + FACES];
    const CoPatchTable *table = mesh->patches;
    memset(&edges, 0, sizeof edges);
    memset(times, 0, sizeof times);
    for (uint32_t face = 0; face < FACES; face++) {
        uint32_t points[7], room[CO_PATCH_WORDS];
        if (table->fold) {
            assert_int_equal(co_patch_face_points(table, face, points), 7);
            assert_int_equal(points[6], 4 * POINTS + face);
            times[points[6]]++;
        } else {
            const uint32_t *words = co_patch_words(table, face, room);
            const uint32_t at[6][2] = {{0, 0}, {2, 0}, {2, 2}, {1, 0}, {2, 1}, {1, 1}};
            for (int k = 0; k < 6; k++)
                points[k] = co_patch_point(table, words, 2, at[k][0], at[k][1]);
        }
        for (uint32_t c = 0; c < 3; c++) {
            assert_int_equal(points[c], desc->face_vertex_indices[3 * face + c]);
            assert_middle(&edges, points[c], points[(c + 1) % 3], points[3 + c]);
            times[points[3 + c]]++;
        }
    }
    for (uint32_t p = POINTS; p < mesh->point_count; p++)
        assert_int_equal(times[p], p < 4 * POINTS ? 2 : 1);
}

static void far_points_are_found(void **state)
{
    (void)state;
    static Large cage;
    for (uint32_t k = 0; k < 4; k++) {
        const bool is_shuffled = k % 2;
        // Bilinear: edges and centers as under Catmull-Clark.
        const CohortScheme scheme = k / 2 ? COHORT_SCHEME_BILINEAR : COHORT_SCHEME_LOOP;
        const CohortMeshDesc desc = make_large(&cage, scheme, 1, is_shuffled);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_int_equal(mesh.patches->fold, k / 2 ? 3 : 0);
        assert_true(is_shuffled ? !mesh.patches->nears : mesh.patches->nears && mesh.patches->fars);
        check_faces(&mesh, &desc);
        CoMeshMemory memory;
        co_mesh_memory(&mesh, &memory);
        const size_t plain = 7 * sizeof(uint32_t) * FACES;
        assert_true(is_shuffled ? memory.topology < plain + 100 : memory.topology < plain / 5 * 3);
        CoMesh same;
        make_mesh(&desc, &same);
        assert_true(co_mesh_same_topology(&mesh, &same));
        co_mesh_destroy(&same);
        co_mesh_destroy(&mesh);
    }
}

// Of level 0, packed but for cages that are less than a pack.
static void corners_are_those_of_the_cage(void **state)
{
    (void)state;
    static Large cage;
    for (uint32_t k = 0; k < 2; k++) {
        CohortMeshDesc desc = make_large(&cage, COHORT_SCHEME_LOOP, 0, k);
        CoMesh mesh, other;
        make_mesh(&desc, &mesh);
        assert_non_null(mesh.patches->packs);
        CoMeshMemory memory;
        co_mesh_memory(&mesh, &memory);
        assert_true(2 * memory.topology < (size_t)(k ? 17 : 6) * FACES);
        for (uint32_t tri = 0; tri < FACES; tri++) {
            uint32_t points[3];
            co_mesh_triangle(&mesh, tri, points);
            assert_memory_equal(points, desc.face_vertex_indices + 3 * (size_t)tri, sizeof points);
        }
        cage.indices[3 * FACES / 2] = (cage.indices[3 * FACES / 2] + 7) % POINTS;
        make_mesh(&desc, &other);
        assert_false(co_mesh_same_topology(&mesh, &other));
        co_mesh_destroy(&other);
        co_mesh_destroy(&mesh);
        desc.face_count = 1;
        desc.face_vertex_index_count = 3;
        make_mesh(&desc, &mesh);
        assert_true(mesh.patches->words && !mesh.patches->packs);
        co_mesh_destroy(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(far_points_are_found),
        cmocka_unit_test(corners_are_those_of_the_cage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
