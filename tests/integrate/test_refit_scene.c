// Edits that leave the shape of a tree: points that move, placements that move. The picture is that
// of a scene made so from the beginning, and nothing is built that need not be.

#include "support/scenes.h"

#include "base/memory.h"
#include "integrate/scene_data.h"

#include <math.h>

enum {
    SIDE = 24, // quads a side
    POINTS = (SIDE + 1) * (SIDE + 1),
    PLACES = 12,
    STRIPS = 300
};

typedef struct Sheet {
    float points[3 * POINTS];
    int32_t counts[SIDE * SIDE], indices[4 * SIDE * SIDE];
} Sheet;

static void fill_sheet(Sheet *sheet, float bulge)
{
    for (int i = 0; i < POINTS; i++) {
        float x = (float)(i % (SIDE + 1)) / SIDE - 0.5f, y = (float)(i / (SIDE + 1)) / SIDE - 0.5f;
        float p[3] = {x, y, bulge * (0.5f - x * x - y * y)};
        memcpy(&sheet->points[3 * i], p, sizeof p);
    }
    for (int q = 0; q < SIDE * SIDE; q++) {
        int32_t a = q / SIDE * (SIDE + 1) + q % SIDE;
        int32_t quad[4] = {a, a + 1, a + SIDE + 2, a + SIDE + 1};
        sheet->counts[q] = 4;
        memcpy(&sheet->indices[4 * q], quad, sizeof quad);
    }
}

static void set_sheet(CohortScene *scene, uint32_t object, CohortScheme scheme, float bulge,
                      size_t faces)
{
    static Sheet sheet;
    CohortError err = {0};
    fill_sheet(&sheet, bulge);
    CohortMeshDesc desc =
        test_cage(sheet.points, POINTS, sheet.counts, faces, sheet.indices, 4 * faces);
    desc.scheme = scheme;
    desc.material = test_matte(scene, 0.0f, 0.5f, &err);
    TEST_OK(cohort_scene_set_mesh(scene, object, &desc, &err), &err);
}

static void set_places(CohortScene *scene, uint32_t object, double shift)
{
    CohortError err = {0};
    CohortInstanceDesc places[PLACES];
    for (int i = 0; i < PLACES; i++)
        places[i] = test_place(object, i % 4 - 1.5 + shift * i, i / 4 - 1.0 - shift * i, 0, 0.8);
    TEST_OK(cohort_scene_set_group(scene, 0, places, PLACES, &err), &err);
}

static CohortScene *make_scene(CohortScheme scheme, float bulge, double shift, uint32_t *object)
{
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    *object = cohort_scene_new_object(scene, &err);
    set_sheet(scene, *object, scheme, bulge, SIDE * SIDE);
    set_places(scene, *object, shift);
    CohortCameraDesc camera = {.window = {-2, 2, -2, 2}, .clip_near = 0.1, .clip_far = 100};
    camera.orthographic = true;
    test_identity(camera.transform);
    camera.transform[3][2] = 5.0;
    TEST_OK(cohort_scene_set_camera(scene, &camera, &err), &err);
    return scene;
}

static float *picture(CohortScene *scene)
{
    CohortError err = {0};
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {
        .width = 48, .height = 48, .spp = 2, .max_depth = 2, .filter = COHORT_FILTER_BOX};
    return test_render(scene, &settings, NULL, &err);
}

static void expect_same(CohortScene *edited, CohortScheme scheme, float bulge, double shift)
{
    uint32_t object;
    CohortScene *anew = make_scene(scheme, bulge, shift, &object);
    float *a = picture(edited), *b = picture(anew);
    float sum = 0.0f;
    for (int i = 0; i < 48 * 48; i++)
        sum += a[4 * i];
    assert_true(sum > 100.0f);
    assert_memory_equal(a, b, 48 * 48 * 4 * sizeof *a);
    free(a);
    free(b);
    cohort_scene_destroy(anew);
}

static void moved_points_and_places_are_refitted(void **state)
{
    (void)state;
    const CohortScheme schemes[] = {COHORT_SCHEME_NONE, COHORT_SCHEME_CATMULL_CLARK};
    for (size_t s = 0; s < 2; s++) {
        uint32_t object;
        CohortSceneCounts counts;
        CohortScene *scene = make_scene(schemes[s], 0.2f, 0.0, &object);
        free(picture(scene));
        set_sheet(scene, object, schemes[s], 0.3f, SIDE * SIDE);
        expect_same(scene, schemes[s], 0.3f, 0.0);
        cohort_scene_counts(scene, &counts);
        assert_int_equal(counts.mesh_refits, 1);
        assert_int_equal(counts.group_refits, 1); // its mesh has another box
        set_places(scene, object, 0.01);
        expect_same(scene, schemes[s], 0.3f, 0.01);
        cohort_scene_counts(scene, &counts);
        assert_true(counts.point_bytes >= 12 * POINTS && counts.topology_bytes > 0);
        assert_true(counts.point_bytes + counts.topology_bytes + counts.normal_bytes <
                    counts.geometry_bytes);
        assert_true(counts.node_bytes > 0 &&
                    counts.node_bytes + counts.leaf_bytes < counts.accel_bytes);
        assert_int_equal(counts.mesh_builds, 2);
        assert_int_equal(counts.mesh_refits, 1);
        assert_int_equal(counts.group_builds, 1);
        assert_int_equal(counts.group_refits, 2);
        cohort_scene_destroy(scene);
    }
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), 0);
}

// Long quads in all directions across each other, turned by so much: their boxes are of shards.
static void set_strips(CohortScene *scene, uint32_t object, double turn)
{
    float points[12 * STRIPS];
    int32_t counts[STRIPS], indices[4 * STRIPS];
    CohortError err = {0};
    for (int32_t i = 0; i < STRIPS; i++) {
        double phi = 2.399963 * i + turn, up = (i + 0.5) / STRIPS - 0.5;
        double along[3] = {0.6 * cos(phi), 0.6 * sin(phi), up}, across[3] = {-sin(phi), cos(phi)};
        counts[i] = 4;
        for (int32_t c = 0; c < 4; c++) {
            double end = c % 3 ? 1.0 : -1.0, side = c < 2 ? 0.003 : -0.003;
            indices[4 * i + c] = 4 * i + c;
            for (int k = 0; k < 3; k++)
                points[12 * i + 3 * c + k] = (float)(end * along[k] + side * across[k]);
        }
    }
    CohortMeshDesc desc = test_cage(points, 4 * STRIPS, counts, STRIPS, indices, 4 * STRIPS);
    desc.material = test_matte(scene, 0.0f, 0.5f, &err);
    TEST_OK(cohort_scene_set_mesh(scene, object, &desc, &err), &err);
}

// A tree over shards is no good for points that have moved.
static void shards_that_move_are_built_anew(void **state)
{
    (void)state;
    uint32_t object;
    CohortSceneCounts counts;
    CohortScene *moved = make_scene(COHORT_SCHEME_NONE, 0.2f, 0.0, &object);
    set_strips(moved, object, 0.0);
    float *before = picture(moved);
    set_strips(moved, object, 0.5);
    float *after = picture(moved);
    cohort_scene_counts(moved, &counts);
    assert_int_equal(counts.mesh_refits, 0);
    CohortScene *anew = make_scene(COHORT_SCHEME_NONE, 0.2f, 0.0, &object);
    set_strips(anew, object, 0.5);
    float *wanted = picture(anew), sum = 0.0f;
    for (int i = 0; i < 48 * 48; i++)
        sum += wanted[4 * i];
    assert_true(sum > 100.0f);
    assert_memory_equal(after, wanted, 48 * 48 * 4 * sizeof *wanted);
    assert_memory_not_equal(before, wanted, 48 * 48 * 4 * sizeof *wanted);
    free(before);
    free(after);
    free(wanted);
    cohort_scene_destroy(moved);
    cohort_scene_destroy(anew);
}

// Two edits before one commit; then a face less, which is another topology.
static void other_topologies_are_built(void **state)
{
    (void)state;
    uint32_t object;
    CohortSceneCounts counts;
    CohortScene *scene = make_scene(COHORT_SCHEME_NONE, 0.1f, 0.0, &object);
    free(picture(scene));
    set_sheet(scene, object, COHORT_SCHEME_NONE, 0.4f, SIDE * SIDE);
    set_sheet(scene, object, COHORT_SCHEME_NONE, 0.2f, SIDE * SIDE);
    expect_same(scene, COHORT_SCHEME_NONE, 0.2f, 0.0);
    set_sheet(scene, object, COHORT_SCHEME_NONE, 0.2f, SIDE * SIDE - 1);
    free(picture(scene));
    set_sheet(scene, object, COHORT_SCHEME_NONE, 0.2f, SIDE * SIDE);
    cohort_scene_clear_object(scene, object);
    set_sheet(scene, object, COHORT_SCHEME_NONE, 0.2f, SIDE * SIDE);
    expect_same(scene, COHORT_SCHEME_NONE, 0.2f, 0.0);
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.mesh_refits, 1);
    cohort_scene_destroy(scene);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), 0);
    assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), 0);
}

// Whatever is refused memory on the way, the next commit makes good.
static void failures_on_the_way_are_made_good(void **state)
{
    (void)state;
    uint32_t object;
    CohortScene *scene = make_scene(COHORT_SCHEME_NONE, 0.2f, 0.0, &object);
    free(picture(scene));
    bool is_done = false;
    for (uint64_t n = 1; n < 400 && !is_done; n++) {
        CohortError err = {0};
        set_sheet(scene, object, COHORT_SCHEME_NONE, n % 2 ? 0.25f : 0.3f, SIDE * SIDE);
        co_memory_fail_after(n);
        is_done = cohort_scene_commit(scene, NULL, &err);
        co_memory_fail_after(0);
        assert_true(is_done || err.code == COHORT_ERROR_OUT_OF_MEMORY);
    }
    assert_true(is_done);
    set_sheet(scene, object, COHORT_SCHEME_NONE, 0.3f, SIDE * SIDE);
    expect_same(scene, COHORT_SCHEME_NONE, 0.3f, 0.0);
    cohort_scene_destroy(scene);
}

// A commit that is stopped has moved nothing yet; the next one does.
static void stopped_commits_are_made_good(void **state)
{
    (void)state;
    const CohortScheme schemes[] = {COHORT_SCHEME_NONE, COHORT_SCHEME_CATMULL_CLARK};
    for (size_t s = 0; s < 2; s++) {
        uint32_t object;
        CohortSceneCounts counts;
        CohortError err = {0};
        CohortScene *scene = make_scene(schemes[s], 0.2f, 0.0, &object);
        free(picture(scene));
        set_sheet(scene, object, schemes[s], 0.3f, SIDE * SIDE);
        scene->objects[object].is_settled = true; // stopped once points are where they belong
        volatile int stop = 1;
        CohortSceneOptions options = {.stop = &stop};
        assert_false(cohort_scene_commit(scene, &options, &err));
        assert_int_equal(err.code, COHORT_ERROR_CANCELLED);
        cohort_scene_counts(scene, &counts);
        assert_int_equal(counts.mesh_refits, 0);
        expect_same(scene, schemes[s], 0.3f, 0.0);
        cohort_scene_counts(scene, &counts);
        assert_int_equal(counts.mesh_refits, 1);
        cohort_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moved_points_and_places_are_refitted),
        cmocka_unit_test(shards_that_move_are_built_anew),
        cmocka_unit_test(other_topologies_are_built),
        cmocka_unit_test(failures_on_the_way_are_made_good),
        cmocka_unit_test(stopped_commits_are_made_good),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
