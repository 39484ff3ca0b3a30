// Patches: points between corners, few bytes per face, codes of normals near what they code.

#include "subdivision_fixture.h"

#include "base/hash.h"
#include "geometry/unit_code.h"

// On a bilinear surface every grid point lies where its place between the corners says.
static void points_lie_between_corners(void **state)
{
    (void)state;
    static Cage cage;
    for (uint32_t k = 0; k < 10; k++) {
        uint32_t level = k / 2;
        make_torus(&cage, k % 2 == 0, k % 2 == 1); // with other faces, or of triangles alone
        CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_BILINEAR, level);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_int_equal(open_edges(&mesh), 0);
        const CoPatchTable *table = mesh.patches;
        assert_int_equal(table->fold, k % 2 ? 3 : 0);
        uint32_t tri = 0;
        for (uint32_t patch = 0; patch < table->count; patch++) {
            uint32_t room[CO_PATCH_WORDS];
            const uint32_t *words = co_patch_words(table, patch, room);
            assert_int_equal(co_patch_first_tri(table, patch), tri);
            if (co_patch_is_fan(table, words)) {
                assert_int_equal(co_patch_of(table, tri), patch);
                tri++;
                continue;
            }
            uint32_t m = 1u << co_patch_shift(table, words);
            CoVec3 q[4];
            for (int c = 0; c < 4; c++)
                q[c] = co_vec3_load(mesh.points + 3 * words[c]);
            for (uint32_t at = 0; at < (m + 1) * (m + 1); at++) {
                uint32_t i = at % (m + 1), j = at / (m + 1);
                float u = (float)i / (float)m, v = (float)j / (float)m;
                CoVec3 p = co_lerp3(co_lerp3(q[0], q[1], u), co_lerp3(q[3], q[2], u), v);
                CoVec3 got = co_vec3_load(mesh.points + 3 * co_patch_point(table, words, m, i, j));
                assert_vec_near(got, (double)p.x, (double)p.y, (double)p.z, 2e-6);
            }
            for (uint32_t end = tri + 2 * m * m; tri < end; tri++)
                assert_int_equal(co_patch_of(table, tri), patch);
        }
        assert_int_equal(tri, mesh.tri_count);
        co_mesh_destroy(&mesh);
    }
}

// What a face may take, the hierarchy apart (accel has that): points, normals and how to find them.
static void faces_are_small(void **state)
{
    (void)state;
    // Bytes per triangle, of a torus of 96 quads, and of one of 192 triangles in either scheme.
    const size_t most[3][4] = {{10, 13, 10, 9}, {11, 12, 10, 9}, {14, 11, 10, 9}};
    static Cage cage;
    for (uint32_t k = 0; k < 12; k++) {
        make_torus(&cage, false, k / 4 > 0);
        CohortScheme scheme = k / 4 == 1 ? COHORT_SCHEME_LOOP : COHORT_SCHEME_CATMULL_CLARK;
        CohortMeshDesc desc = cage_desc(&cage, scheme, k % 4);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_null(mesh.indices);
        assert_true(mesh.bytes <= most[k / 4][k % 4] * mesh.tri_count + 800);
        co_mesh_destroy(&mesh);
    }
}

static void codes_are_near(void **state)
{
    (void)state;
    double worst = 0.0;
    for (uint64_t k = 0; k < 300000; k++) {
        CoVec3 v;
        for (int c = 0; c < 3; c++)
            (&v.x)[c] = (float)(co_hash64(3 * k + (uint64_t)c) >> 40) * 0x1p-23f - 1.0f;
        v = co_normalize(v);
        worst = fmax(worst, (double)co_length(co_sub(v, co_unit_decode(co_unit_encode(v)))));
    }
    assert_true(worst < 7e-5);
    for (int c = 0; c < 6; c++) {
        CoVec3 axis = co_vec3_splat(0.0f);
        (&axis.x)[c % 3] = c < 3 ? 1.0f : -1.0f;
        CoVec3 got = co_unit_decode(co_unit_encode(axis));
        assert_vec_near(got, (double)axis.x, (double)axis.y, (double)axis.z, 0.0);
    }
    assert_int_equal(co_unit_encode(co_vec3_splat(0.0f)), CO_UNIT_NONE);
    assert_int_equal(co_unit_encode(co_vec3(NAN, 0.0f, 1.0f)), CO_UNIT_NONE);
    assert_vec_near(co_unit_decode(CO_UNIT_NONE), 0, 0, 0, 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_lie_between_corners),
        cmocka_unit_test(faces_are_small),
        cmocka_unit_test(codes_are_near),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
