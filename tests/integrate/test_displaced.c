// Displaced meshes in a scene: textures with a seam at every edge, and no ray that gets out.

#include "support/scenes.h"
#include "texture/ptex_write.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#define HEIGHTS COHORT_TEST_DATA_DIR "/../../examples/stages/textures/heights.png"

enum {
    SIZE = 16,
    CUBE = 1
};

// A cube whose every face has the whole texture.
static uint32_t make_cube(CohortScene *scene, CohortScheme scheme, uint32_t level,
                          const uint8_t *edge_levels, uint32_t material, CohortError *err)
{
    static const float st[] = {0, 0, 1, 0, 1, 1, 0, 1};
    static const int32_t counts[] = {4, 4, 4, 4, 4, 4};
    int32_t corners[24];
    for (int k = 0; k < 24; k++)
        corners[k] = k % 4;
    CohortPrimvarDesc primvar = {"st", COHORT_INTERPOLATION_FACE_VARYING, 2, st, 4, corners, 24};
    CohortMeshDesc desc = test_cage(test_box_points, 8, counts, 6, test_box_indices, 24);
    desc.scheme = scheme;
    desc.level = level;
    desc.edge_levels = edge_levels;
    desc.primvars = &primvar;
    desc.primvar_count = 1;
    desc.material = material;
    uint32_t id = test_mesh(scene, &desc, err);
    CohortInstanceDesc place = test_place(id, 0, 0, 0, 2.0);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, err), err);
    return id;
}

// Emission 0.3 and albedo 0.7, displaced by a texture.
static uint32_t make_material(CohortScene *scene, const char *path, bool is_ptex, float scale,
                              CohortError *err)
{
    CohortTextureDesc texture = {.path = path,
                                 .asset = path,
                                 .is_ptex = is_ptex,
                                 .color_space = COHORT_COLOR_RAW,
                                 .wrap_s = COHORT_WRAP_REPEAT,
                                 .wrap_t = COHORT_WRAP_REPEAT};
    CohortLookupDesc lookup = {.texture = cohort_scene_new_texture(scene, &texture, err),
                               .scale = {scale, 1, 1, 1}};
    CohortMaterialDesc desc = cohort_material_default();
    for (int i = 0; i < 3; i++) {
        desc.diffuse_color.value[i] = 0.7f;
        desc.emissive_color.value[i] = 0.3f;
    }
    desc.lambert = true;
    desc.displacement = (CohortInput){.kind = COHORT_INPUT_TEXTURE};
    desc.lookups = &lookup;
    desc.lookup_count = 1;
    uint32_t id = cohort_scene_new_material(scene, err);
    TEST_OK(cohort_scene_set_material(scene, id, &desc, err), err);
    return id;
}

// A scene of one cube, displaced by a texture: object 1, material 0.
static CohortScene *make_scene(CohortScheme scheme, uint32_t level, const uint8_t *edge_levels,
                               const char *path, float scale, CohortError *err)
{
    CohortScene *scene = test_scene(err);
    bool is_ptex = strstr(path, ".ptx") != NULL;
    uint32_t material = make_material(scene, path, is_ptex, scale, err);
    assert_int_equal(make_cube(scene, scheme, level, edge_levels, material, err), CUBE);
    return scene;
}

static CohortSceneCounts commit(CohortScene *scene, CohortError *err)
{
    char folder[64];
    snprintf(folder, sizeof folder, "/tmp/test_displaced_%d", (int)getpid());
    CohortSceneOptions options = {.converted_folder = folder};
    test_camera(scene, 0, 0, 0, 1.0, err);
    TEST_OK(cohort_scene_commit(scene, &options, err), err);
    char command[96];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    assert_int_equal(system(command), 0);
    CohortSceneCounts counts;
    cohort_scene_counts(scene, &counts);
    return counts;
}

// Seen from inside, the closed mesh is 0.3 (1 + 0.7 + 0.49 + ...) = 1, less what is lost where
// shading normals are not those of the triangles; and no ray leaves it.
static void check_furnace(const CohortScene *scene, double least, CohortError *err)
{
    CohortRenderSettings settings = {.width = SIZE,
                                     .height = SIZE,
                                     .spp = 64,
                                     .max_depth = 40,
                                     .filter = COHORT_FILTER_BOX,
                                     .batch = 1u << 16};
    CohortRenderStats stats;
    float *pixels = test_render(scene, &settings, &stats, err);
    double sum = 0.0;
    for (int k = 0; k < SIZE * SIZE; k++)
        sum += (double)pixels[4 * k] / (SIZE * SIZE);
    free(pixels);
    assert_int_equal(stats.ends_miss, 0);
    assert_int_equal(stats.ends_invalid, 0);
    if (!(sum > least && sum < 1.003))
        fail_msg("%g instead of 1", sum);
}

static void image_seams_leak_nothing(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = make_scene(COHORT_SCHEME_CATMULL_CLARK, 5, NULL, HEIGHTS, 0.4f, &err);
    CohortSceneCounts counts = commit(scene, &err);
    assert_int_equal(counts.displaced_meshes, 1);
    assert_true(counts.displaced_points > 6000);
    double box[6];
    assert_true(cohort_scene_bounds(scene, box));
    assert_true(box[3] > 2.0); // the limit surface alone ends at 1.7
    check_furnace(scene, 0.9, &err);
    // A commit does it once.
    counts = commit(scene, &err);
    assert_int_equal(counts.displaced_meshes, 1);
    double again[6];
    assert_true(cohort_scene_bounds(scene, again));
    assert_memory_equal(box, again, sizeof box);
    cohort_scene_destroy(scene);
}

// Edges of all levels up to 5, and those that two faces disagree about.
static void coarse_edges_leak_nothing(void **state)
{
    (void)state;
    CohortError err = {0};
    uint8_t levels[24];
    for (uint8_t k = 0; k < 24; k++)
        levels[k] = (uint8_t)(k * 7 % 23 % 6);
    CohortScene *scene = make_scene(COHORT_SCHEME_CATMULL_CLARK, 0, levels, HEIGHTS, 0.4f, &err);
    CohortSceneCounts counts = commit(scene, &err);
    assert_in_range(counts.displaced_points, 1000, 6000);
    check_furnace(scene, 0.85, &err);
    cohort_scene_destroy(scene);
}

// Six faces of constant heights, without neighbors: the filter sees nothing of the others.
static void write_heights(const char *path, CohortError *err)
{
    CoPtexWriteDesc desc = {.face_count = 6, .type = CO_PTEX_F32, .channels = 1};
    CoPtexWriter *writer = co_ptex_writer_create(path, &desc, err);
    assert_non_null(writer);
    for (uint32_t face = 0; face < 6; face++) {
        float texels[16];
        for (int k = 0; k < 16; k++)
            texels[k] = 0.1f * (float)(face + 1) + (k % 3 == 0 ? 0.2f : 0.0f);
        CoPtexFace info = {.ulog2 = 2, .vlog2 = 2, .adjfaces = {-1, -1, -1, -1}};
        TEST_OK(co_ptex_writer_face(writer, face, &info, (const void *const[]){texels}, 1, err),
                err);
    }
    TEST_OK(co_ptex_writer_finish(writer, err), err);
}

static void ptex_borders_leak_nothing(void **state)
{
    (void)state;
    CohortError err = {0};
    char path[64];
    snprintf(path, sizeof path, "/tmp/test_displaced_%d.ptx", (int)getpid());
    write_heights(path, &err);
    CohortScene *scene = make_scene(COHORT_SCHEME_CATMULL_CLARK, 4, NULL, path, 1.0f, &err);
    CohortSceneCounts counts = commit(scene, &err);
    assert_int_equal(remove(path), 0);
    assert_true(counts.displaced_points > 1500);
    check_furnace(scene, 0.9, &err);
    cohort_scene_destroy(scene);
}

// Facets have no other normals: nothing is lost.
static void facets_are_a_furnace(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = make_scene(COHORT_SCHEME_NONE, 0, NULL, HEIGHTS, 0.4f, &err);
    CohortSceneCounts counts = commit(scene, &err);
    assert_int_equal(counts.displaced_points, 8);
    check_furnace(scene, 0.997, &err);
    cohort_scene_destroy(scene);
}

// Six faces for the mesh's twelve: it is said, and the others stay.
static void faces_a_file_lacks_stay(void **state)
{
    (void)state;
    CohortError err = {0};
    char path[64];
    snprintf(path, sizeof path, "/tmp/test_displaced_few_%d.ptx", (int)getpid());
    write_heights(path, &err);
    CohortScene *scene = make_scene(COHORT_SCHEME_CATMULL_CLARK, 2, NULL, path, 1.0f, &err);
    int32_t counts[12], indices[48];
    float points[48];
    for (int k = 0; k < 48; k++) {
        counts[k / 4] = 4;
        indices[k] = test_box_indices[k % 24] + 8 * (k / 24);
        points[k] = test_box_points[k % 24] + (k / 24 && k % 3 == 0 ? 4.0f : 0.0f);
    }
    CohortMeshDesc desc = test_cage(points, 16, counts, 12, indices, 48);
    desc.scheme = COHORT_SCHEME_CATMULL_CLARK;
    desc.level = 2;
    desc.material = 0; // displaces
    TEST_OK(cohort_scene_set_mesh(scene, CUBE, &desc, &err), &err);
    CohortSceneCounts counted = commit(scene, &err);
    assert_int_equal(remove(path), 0);
    assert_int_equal(counted.displaced_points, 98); // of one cube at level 2
    const CohortDiagnostic *warnings;
    size_t warning_count = cohort_scene_warnings(scene, &warnings);
    bool is_said = false;
    for (size_t k = 0; k < warning_count; k++)
        is_said = is_said || strstr(warnings[k].text, "the mesh it displaces has 12");
    assert_true(is_said);
    cohort_scene_destroy(scene);
}

// Faces that a Ptex file does not have, and files that are not there, move nothing.
static void missing_ptex_is_no_height(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene =
        make_scene(COHORT_SCHEME_CATMULL_CLARK, 3, NULL, "/nowhere.ptx", 1.0f, &err);
    CohortSceneCounts counts = commit(scene, &err);
    assert_int_equal(counts.displaced_points, 0);
    cohort_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coarse_edges_leak_nothing), cmocka_unit_test(image_seams_leak_nothing),
        cmocka_unit_test(ptex_borders_leak_nothing), cmocka_unit_test(facets_are_a_furnace),
        cmocka_unit_test(faces_a_file_lacks_stay),   cmocka_unit_test(missing_ptex_is_no_height),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
