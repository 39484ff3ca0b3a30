// Tessellated points against OpenSubdiv's other evaluation, and neighbors that share their edges.
// With a number, that many points of every shape are compared, and a table is printed.

#include "limit_check.h"

#include <stdlib.h>

static size_t point_goal = 10000;
static bool prints;

// ---- Limit positions ---------------------------------------------------------------------------

static void limit_points_are_those_of_opensubdiv(void **state)
{
    (void)state;
    static Shape shape;
    uint64_t seed = 1;
    for (int number = 0; number < SHAPE_COUNT; number++) {
        make_shape(&shape, number);
        FarReference *reference = far_reference_create(&shape.desc);
        assert_non_null(reference);
        double worst = 0.0;
        for (uint32_t level = 0; level <= 6; level += 2) {
            CoMesh mesh;
            shape.desc.level = level;
            make_mesh(&shape.desc, &mesh);
            assert_true(mesh.tri_count > 0);
            double distance = worst_distance(&mesh, reference, point_goal / 4, &seed);
            worst = fmax(worst, distance / box_size(&mesh));
            co_mesh_destroy(&mesh);
        }
        far_reference_destroy(reference);
        if (prints)
            printf("%2d %-24s %zu points, largest distance %.2g of the box\n", number, shape.name,
                   point_goal / 4 * 4, worst);
        if (!(worst <= 1e-6))
            fail_msg("%s (%d): %g of the box away", shape.name, number, worst);
    }
}

// ---- Shared edges ------------------------------------------------------------------------------

// Edges of the cage by the number of faces with triangles at them.
static void cage_edges(const Cage *cage, const CoMesh *mesh, size_t out[8])
{
    static bool is_live[CAGE_MAX_FACES];
    memset(is_live, 0, sizeof is_live);
    for (uint32_t t = 0; t < mesh->tri_count; t++)
        is_live[co_mesh_tri_face(mesh, t)] = true;
    EdgeTable table = edge_table(cage->index_count);
    const int32_t *v = cage->indices;
    for (size_t f = 0; f < cage->face_count; v += cage->counts[f++])
        for (int32_t k = 0; is_live[f] && k < cage->counts[f]; k++)
            edge_add(&table, (uint32_t)v[k], (uint32_t)v[(k + 1) % cage->counts[f]]);
    edge_histogram(&table, out);
}

// An edge of the cage at which k faces meet is as many edges of triangles as it has segments, each
// met by k triangles: points that were not shared would make edges of one triangle.
static void neighbors_share_every_edge(void **state)
{
    (void)state;
    static Shape shape;
    static float st[2 * 6 * CAGE_MAX_FACES];
    for (size_t k = 0; k < COUNT(st); k++)
        st[k] = (float)(k % 97);
    for (int number = 0; number < SHAPE_COUNT; number++) {
        make_shape(&shape, number);
        // Texture coordinates with a seam at every edge.
        CohortPrimvarDesc seams = {
            "st", COHORT_INTERPOLATION_FACE_VARYING, 2, st, shape.cage.index_count, NULL, 0};
        shape.desc.primvars = &seams;
        shape.desc.primvar_count = 1;
        for (uint32_t level = 0; level <= 5; level++) {
            CoMesh mesh;
            shape.desc.level = level;
            make_mesh(&shape.desc, &mesh);
            size_t got[8], want[8];
            EdgeTable table = edge_table(3 * (size_t)mesh.tri_count);
            for (uint32_t t = 0; t < mesh.tri_count; t++) {
                uint32_t p[3];
                co_mesh_triangle(&mesh, t, p);
                for (int c = 0; c < 3; c++)
                    edge_add(&table, p[c], p[(c + 1) % 3]);
            }
            edge_histogram(&table, got);
            cage_edges(&shape.cage, &mesh, want);
            for (int k = 0; k < 8; k++)
                if (got[k] != want[k] << level)
                    fail_msg("%s, level %u: %zu edges of %d triangles, not %zu", shape.name, level,
                             got[k], k, want[k] << level);
            co_mesh_destroy(&mesh);
        }
    }
}

int main(int argc, char **argv)
{
    if (argc > 1) {
        point_goal = (size_t)strtoull(argv[1], NULL, 10);
        prints = true;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limit_points_are_those_of_opensubdiv),
        cmocka_unit_test(neighbors_share_every_edge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
