// Groups may nest deeper than what is traced: what they place looks as if it stood in one group.

#include "support/scenes.h"

#include "base/memory.h"

#include <math.h>

enum {
    LEVELS = 100,
    SIDE = 256
};

static const float points[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const int32_t indices[] = {0, 1, 2, 3};
static const float yellow[3] = {1, 1, 0}, blue[3] = {0, 0, 1}, white[3] = {1, 1, 1};

// Turns by `angle` about z, then moves.
static void turn_and_move(double m[4][4], double angle, double x, double y)
{
    test_identity(m);
    m[0][0] = m[1][1] = cos(angle);
    m[0][1] = sin(angle);
    m[1][0] = -sin(angle);
    m[3][0] = x;
    m[3][1] = y;
}

static CohortInstanceDesc inner_place(uint32_t object, uint32_t level)
{
    CohortInstanceDesc place = test_place(object, 0, 0, 0, 1);
    turn_and_move(place.transform, 0.07, 0.09, 0.02);
    place.prim_id = 1000 + (int32_t)level;
    place.hidden_from = level == 50 ? COHORT_HIDDEN_FROM_CAMERA : 0;
    place.display_color = level == 20 ? blue : level % 2 ? yellow : NULL;
    place.color_yields = level % 2;
    return place;
}

static CohortInstanceDesc quad_place(uint32_t quad, uint32_t level)
{
    CohortInstanceDesc place = test_place(quad, 0, 0, 0, 0.03);
    place.prim_id = level % 3 ? -1 : (int32_t)level;
    return place;
}

// The root and two quads come first, then the innermost.
static uint32_t group_of(uint32_t level)
{
    return level ? LEVELS + 2 - level : 0;
}

// A quad of each level, each group within the one before.
static void nested(CohortScene *scene, const uint32_t quads[2], CohortError *err)
{
    uint32_t inner = COHORT_INVALID_ID;
    for (uint32_t level = LEVELS; level-- > 0;) {
        CohortInstanceDesc places[2] = {quad_place(quads[level % 5 == 0], level)};
        uint32_t count = 1;
        if (inner != COHORT_INVALID_ID)
            places[count++] = inner_place(inner, level);
        inner = level ? cohort_scene_new_object(scene, err) : 0;
        TEST_OK(cohort_scene_set_group(scene, inner, places, count, err), err);
    }
}

static void flat(CohortScene *scene, const uint32_t quads[2], CohortError *err)
{
    CohortInstanceDesc places[LEVELS];
    double angle = 0.0, x = 0.0, y = 0.0;
    const float *color = NULL, *firm = NULL;
    for (uint32_t level = 0; level < LEVELS; level++) {
        places[level] = quad_place(quads[level % 5 == 0], level);
        turn_and_move(places[level].transform, angle, x, y);
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++)
                places[level].transform[i][k] *= 0.03;
        if (level > 0 && places[level].prim_id < 0)
            places[level].prim_id = 999 + (int32_t)level;
        places[level].display_color = level % 5 == 0 ? firm : color;
        places[level].hidden_from = level > 50 ? COHORT_HIDDEN_FROM_CAMERA : 0;
        CohortInstanceDesc next = inner_place(0, level);
        x += 0.09 * cos(angle) - 0.02 * sin(angle);
        y += 0.09 * sin(angle) + 0.02 * cos(angle);
        angle += 0.07;
        color = next.display_color ? next.display_color : color;
        firm = next.display_color && !next.color_yields ? next.display_color : firm;
    }
    TEST_OK(cohort_scene_set_group(scene, 0, places, LEVELS, err), err);
}

typedef void MakeFn(CohortScene *scene, const uint32_t quads[2], CohortError *err);

static CohortScene *make_scene(MakeFn *make)
{
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t quads[2];
    for (int i = 0; i < 2; i++)
        quads[i] =
            test_quads(scene, points, 4, indices, 1, i ? white : NULL, COHORT_INVALID_ID, &err);
    make(scene, quads, &err);
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    test_identity(dome.transform);
    test_light(scene, &dome, &err);
    test_camera(scene, 0.5, 1.0, 4, 0.4, &err);
    return scene;
}

static void look(CohortScene *scene, float *color, int32_t *ids)
{
    CohortError err = {0};
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {.width = SIDE,
                                     .height = SIDE,
                                     .spp = 4,
                                     .max_depth = 2,
                                     .filter = COHORT_FILTER_BOX,
                                     .hide_lights = true,
                                     .aovs = COHORT_AOV_PRIM_ID};
    CohortRender *render = cohort_render_create(scene, &settings, &err);
    assert_non_null(render);
    while (!cohort_render_is_done(render))
        TEST_OK(cohort_render_round(render, &err), &err);
    assert_true(cohort_render_aov(render, COHORT_AOV_COLOR, color));
    assert_true(cohort_render_aov(render, COHORT_AOV_PRIM_ID, ids));
    cohort_render_destroy(render);
}

static float colors[2][SIDE * SIDE * 4];
static int32_t ids[2][SIDE * SIDE];

// The two pictures are the same, but for few pixels at the edges of quads.
static void compare(size_t least_seen)
{
    size_t seen = 0, others = 0, other_ids = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        bool is_other = false;
        for (size_t c = 0; c < 4; c++)
            is_other |= fabsf(colors[0][4 * i + c] - colors[1][4 * i + c]) > 0.02f;
        others += is_other;
        other_ids += ids[0][i] != ids[1][i];
        seen += ids[0][i] >= 0;
    }
    assert_true(seen >= least_seen);
    assert_true(others <= seen / 20);
    assert_true(other_ids <= seen / 20);
}

static void only_the_first_level_is_seen(void)
{
    for (size_t i = 0; i < SIDE * SIDE; i++)
        assert_true(ids[0][i] <= 0);
}

static void a_hundred_levels_are_as_one(void **state)
{
    (void)state;
    CohortScene *deep = make_scene(nested), *shallow = make_scene(flat);
    look(deep, colors[0], ids[0]);
    look(shallow, colors[1], ids[1]);
    compare(200);
    CohortSceneCounts counts;
    cohort_scene_counts(deep, &counts);
    assert_true(counts.group_builds <= 8);
    // Without the levels that the camera does not see, what it sees is the same; then only one is
    // left.
    CohortError err = {0};
    TEST_OK(cohort_scene_set_group(deep, group_of(52), NULL, 0, &err), &err);
    look(deep, colors[0], ids[0]);
    compare(200);
    TEST_OK(cohort_scene_set_group(deep, group_of(1), NULL, 0, &err), &err);
    look(deep, colors[0], ids[0]);
    only_the_first_level_is_seen();
    cohort_scene_destroy(deep);
    cohort_scene_destroy(shallow);
}

static void count_placements(void *cookie, uint32_t object, const double transform[4][4])
{
    (void)object;
    (void)transform;
    ++*(size_t *)cookie;
}

// Twelve levels of three: no more than few of these become one.
static void wide(CohortScene *scene, const uint32_t quads[2], CohortError *err)
{
    uint32_t inner = quads[0];
    for (uint32_t level = 12; level-- > 0;) {
        CohortInstanceDesc places[3];
        for (int i = 0; i < 3; i++)
            places[i] = test_place(inner, i - 1, 0.1 * i, 0, 0.33);
        inner = level ? cohort_scene_new_object(scene, err) : 0;
        TEST_OK(cohort_scene_set_group(scene, inner, places, 3, err), err);
    }
}

static void wide_groups_stay_shared(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = make_scene(wide);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortSceneCounts counts;
    cohort_scene_counts(scene, &counts);
    size_t placements = 0;
    cohort_scene_placements(scene, count_placements, &placements);
    assert_int_equal(placements, 531441);
    assert_true(counts.instance_count <= 4 * 9 + 4 * 3);
    cohort_scene_destroy(scene);
}

static void single(CohortScene *scene, const uint32_t quads[2], CohortError *err)
{
    const CohortInstanceDesc place = test_place(quads[0], 0, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, err), err);
}

// A group that is out of the scene while what it places is edited stands right when it is back.
static void groups_come_back(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = make_scene(single);
    uint32_t group = cohort_scene_new_object(scene, &err), quad = 1;
    CohortInstanceDesc place = test_place(quad, 0, 0, 0, 0.1);
    TEST_OK(cohort_scene_set_group(scene, group, &place, 1, &err), &err);
    CohortInstanceDesc places[2] = {test_place(group, 0.5, 1, 0, 1), place};
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, &err), &err);
    look(scene, colors[0], ids[0]);
    TEST_OK(cohort_scene_set_group(scene, 0, places + 1, 1, &err), &err);
    look(scene, colors[0], ids[0]);
    float moved[12];
    for (int i = 0; i < 12; i++)
        moved[i] = points[i] + (i % 3 ? 0.0f : 8.0f);
    const int32_t counts[1] = {4};
    CohortMeshDesc desc = test_cage(moved, 4, counts, 1, indices, 4);
    TEST_OK(cohort_scene_set_mesh(scene, quad, &desc, &err), &err);
    look(scene, colors[0], ids[0]);
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, &err), &err);
    look(scene, colors[0], ids[0]);
    assert_int_equal(ids[0][SIDE * SIDE / 2 + SIDE / 2], -1);
    assert_int_equal(ids[0][SIDE * SIDE / 2 + SIDE / 2 + SIDE / 4], quad); // 0.8 to the right
    cohort_scene_destroy(scene);
}

static void circles_are_refused(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = make_scene(nested);
    const CohortInstanceDesc back = test_place(0, 0, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(scene, group_of(LEVELS - 1), &back, 1, &err), &err);
    size_t placements = 0;
    cohort_scene_placements(scene, count_placements, &placements);
    assert_true(placements <= LEVELS);
    assert_false(cohort_scene_commit(scene, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_SCENE);
    cohort_scene_destroy(scene);
}

// Whatever is out of memory, it is said, and once there is some the scene is there.
static void memory_may_run_out(void **state)
{
    (void)state;
    CohortScene *scene = make_scene(nested);
    bool is_done = false;
    for (uint64_t n = 1; n < 2000 && !is_done; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        is_done = cohort_scene_commit(scene, NULL, &err);
        co_memory_fail_after(0);
        assert_true(is_done || err.code == COHORT_ERROR_OUT_OF_MEMORY);
    }
    assert_true(is_done);
    CohortSceneCounts counts;
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.instance_count, LEVELS + 7);
    cohort_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hundred_levels_are_as_one), cmocka_unit_test(wide_groups_stay_shared),
        cmocka_unit_test(groups_come_back), cmocka_unit_test(circles_are_refused),
        cmocka_unit_test(memory_may_run_out)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
