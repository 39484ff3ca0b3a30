// Meshes, transforms, visibility, purpose and instancing, from stage to scene.

#include "stage_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static StageFixture f;

static void open_stage(const char *body)
{
    CohortError err = {0};
    if (!stage_fixture_open(&f, body, NULL, &err))
        fail_msg("%s", err.message);
}

static int teardown(void **state)
{
    (void)state;
    stage_fixture_close(&f);
    return 0;
}

// The instance in the root group whose object is the mesh at a path.
static const CohortInstanceDesc *root_instance(const char *path)
{
    const FakeObject *root = &fake.objects[0], *mesh = fake_mesh(path);
    for (size_t i = 0; mesh && i < root->instance_count; i++)
        if (&fake.objects[root->instances[i].object] == mesh)
            return &root->instances[i];
    return NULL;
}

static bool is_at(const CohortInstanceDesc *d, double x, double y, double z)
{
    return d && fabs(d->transform[3][0] - x) < 1e-9 && fabs(d->transform[3][1] - y) < 1e-9 &&
           fabs(d->transform[3][2] - z) < 1e-9;
}

static void test_transforms_multiply_up(void **state)
{
    (void)state;
    open_stage("def Xform \"A\" { double3 xformOp:translate = (1,2,3)\n"
               "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"
               "def Xform \"B\" { float xformOp:rotateZ = 90\n"
               "uniform token[] xformOpOrder = [\"xformOp:rotateZ\"]\n" TRIANGLE(
                   "M", "double3 xformOp:translate = (5,0,0)\n"
                        "uniform token[] xformOpOrder = [\"xformOp:translate\"]")
                   TRIANGLE("R", "double3 xformOp:translate = (7,0,0)\n"
                                 "uniform token[] xformOpOrder = [\"!resetXformStack!\", "
                                 "\"xformOp:translate\"]") "} }\n");
    assert_true(is_at(root_instance("/A/B/M"), 1, 7, 3));
    assert_true(is_at(root_instance("/A/B/R"), 7, 0, 0));
}

static void test_visibility_and_purpose(void **state)
{
    (void)state;
    open_stage("def Xform \"A\" { token visibility = \"invisible\"\n" TRIANGLE(
        "M",
        "token visibility = \"inherited\"") "}\n"
                                            "def Xform \"P\" { uniform token purpose = "
                                            "\"proxy\"\n" TRIANGLE("M", "") TRIANGLE(
                                                "R",
                                                "uniform token purpose = "
                                                "\"render\"") "}\n" TRIANGLE("G",
                                                                             "uniform token "
                                                                             "purpose = \"guide\"")
                                                TRIANGLE("V", "token visibility.timeSamples = { 1: "
                                                              "\"invisible\", 2: \"inherited\" }"));
    assert_null(fake_mesh("/A/M"));
    assert_null(fake_mesh("/P/M"));
    assert_non_null(fake_mesh("/P/R"));
    assert_null(fake_mesh("/G"));
    assert_null(fake_mesh("/O"));
    assert_true(root_instance("/V")->hidden); // at the earliest time
    assert_true(cohort_adapter_set_time(f.adapter, 2.0, NULL));
    assert_true(cohort_render_index_sync(f.index, NULL));
    assert_false(root_instance("/V")->hidden);
    assert_int_equal(fake.set_mesh_calls, 2); // nothing was built again
}

static void test_hidden_from_some_rays(void **state)
{
    (void)state;
    open_stage("def Xform \"A\" { int primvars:ri:attributes:visibility:camera = 0\n"
               "bool primvars:arnold:visibility:shadow = false\n" TRIANGLE("M", "")
                   TRIANGLE("N", "int primvars:cohort:visibility:camera = 1\n"
                                 "int primvars:cohort:visibility:indirect = 0") "}\n"
               TRIANGLE("O", ""));
    assert_int_equal(root_instance("/A/M")->hidden_from,
                     COHORT_HIDDEN_FROM_CAMERA | COHORT_HIDDEN_FROM_SHADOW);
    assert_int_equal(root_instance("/A/N")->hidden_from,
                     COHORT_HIDDEN_FROM_SHADOW | COHORT_HIDDEN_FROM_INDIRECT);
    assert_int_equal(root_instance("/O")->hidden_from, 0);
}

static void test_asked_purposes_win(void **state)
{
    (void)state;
    CohortAdapterOptions options = {.purposes = COHORT_PURPOSE_PROXY};
    CohortError err = {0};
    assert_true(stage_fixture_open(
        &f, TRIANGLE("P", "uniform token purpose = \"proxy\"") TRIANGLE("D", ""), &options, &err));
    assert_non_null(fake_mesh("/P"));
    assert_null(fake_mesh("/D"));
}

static void test_time_moves_and_deforms(void **state)
{
    (void)state;
    open_stage(
        "def Xform \"A\" { double3 xformOp:translate.timeSamples = { 1: (0,0,0), 3: (4,0,0) }\n"
        "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n" TRIANGLE(
            "M", "") "}\n"
                     "def Mesh \"D\" { int[] faceVertexCounts = [3]\n int[] faceVertexIndices = "
                     "[0,1,2]\n"
                     "point3f[] points.timeSamples = { 1: [(0,0,0),(1,0,0),(0,1,0)], "
                     "3: [(2,0,0),(1,0,0),(0,1,0)] } }\n");
    assert_true(is_at(root_instance("/A/M"), 0, 0, 0));
    assert_true(cohort_adapter_set_time(f.adapter, 2.0, NULL));
    assert_int_equal(cohort_render_index_dirty_bits(f.index, "/A/M"), COHORT_DIRTY_TRANSFORM);
    assert_int_equal(cohort_render_index_dirty_bits(f.index, "/D"), COHORT_DIRTY_POINTS);
    assert_true(cohort_render_index_sync(f.index, NULL));
    assert_true(is_at(root_instance("/A/M"), 2, 0, 0));
    assert_true(fake_mesh("/D")->first_point[0] == 1.0f);
    assert_int_equal(fake.set_mesh_calls, 3);
}

// What a frame of a range shows is what it shows alone, wherever the sampled attribute stands.
static void test_frame_of_a_range_is_that_frame(void **state)
{
    (void)state;
    static const char
        body
            [] =
                "def Xform \"Parent\" { color3f[] primvars:displayColor.timeSamples = "
                "{ 1: [(1,0,0)], 2: [(0,1,0)] }\n" TRIANGLE("M", "") "}\n" TRIANGLE(
                    "S",
                    "def GeomSubset \"G\" { int[] indices.timeSamples = { 1: [], 2: [0] }\n"
                    "uniform token elementType = \"face\"\n"
                    "uniform token familyName = \"materialBind\" }") "class Xform \"P\" "
                                                                     "{\n" TRIANGLE("A",
                                                                                    "") "}\n"
                                                                                        "def Xform "
                                                                                        "\"I\" "
                                                                                        "(instancea"
                                                                                        "ble = "
                                                                                        "true\n "
                                                                                        "inherits "
                                                                                        "= </P>) "
                                                                                        "{\n"
                                                                                        "color3f[] "
                                                                                        "primvars:"
                                                                                        "displayCol"
                                                                                        "or."
                                                                                        "timeSample"
                                                                                        "s = { 1: "
                                                                                        "[(1,0,0)],"
                                                                                        " 2: "
                                                                                        "[(0,0,1)] "
                                                                                        "} }\n";
    FakeObject objects[8];
    for (int range = 0; range < 2; range++) {
        CohortAdapterOptions options = {.time_choice = COHORT_TIME_AT, .time = range ? 1.0 : 2.0};
        CohortError err = {0};
        fake_reset();
        assert_true(stage_fixture_open(&f, body, &options, &err));
        if (range) {
            assert_true(cohort_adapter_set_time(f.adapter, 2.0, NULL));
            assert_true(cohort_render_index_sync(f.index, NULL));
        }
        assert_true(fake_mesh("/Parent/M")->first_color[1] == 1.0f);
        assert_int_equal(fake_mesh("/S")->subset_faces, 1);
        const FakeObject *root = &fake.objects[0];
        bool found = false;
        for (size_t i = 0; i < root->instance_count; i++)
            found = found || (root->instances[i].prim_id < 0 && root->colors[i][2] == 1.0f);
        assert_true(found);
        assert_true(fake.object_count <= 8);
        for (uint32_t i = 0; range && i < fake.object_count; i++)
            assert_memory_equal(objects[i].colors, fake.objects[i].colors,
                                sizeof objects[i].colors);
        memcpy(objects, fake.objects, sizeof objects);
        if (!range)
            stage_fixture_close(&f);
    }
}

// One placement whose prototype has a color of its own takes no color from the others.
static void test_placements_keep_their_colors(void **state)
{
    (void)state;
    open_stage("class Xform \"P\" {\n" TRIANGLE(
        "A", "") "}\n"
                 "class Xform \"Q\" {\n" TRIANGLE(
                     "A",
                     "color3f[] primvars:displayColor = [(0.5,0.5,0.5)]") "}\n"
                                                                          "def Xform \"I1\" "
                                                                          "(instanceable = true\n "
                                                                          "inherits = </P>) {\n"
                                                                          "color3f[] "
                                                                          "primvars:displayColor = "
                                                                          "[(1,0,0)] }\n"
                                                                          "def Xform \"I2\" "
                                                                          "(instanceable = true\n "
                                                                          "inherits = </Q>) {\n"
                                                                          "color3f[] "
                                                                          "primvars:displayColor = "
                                                                          "[(0,1,0)] }\n"
                                                                          "def Xform \"I3\" "
                                                                          "(instanceable = true\n "
                                                                          "inherits = </P>) {}\n");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 3);
    assert_true(root->colors[0][0] == 1.0f);
    assert_non_null(root->instances[0].display_color);
    assert_null(root->instances[1].display_color);
    assert_null(root->instances[2].display_color);
}

// Three placements of a prototype with two parts, one of them invisible.
static void test_native_instances_share(void **state)
{
    (void)state;
    open_stage("class Xform \"P\" {\n" TRIANGLE("A", "")
                   TRIANGLE("B", "") "}\n"
                                     "def Xform \"I1\" (instanceable = true\n inherits = </P>) {}\n"
                                     "def Xform \"I2\" (instanceable = true\n inherits = </P>) {\n"
                                     "double3 xformOp:translate = (3,0,0)\n"
                                     "uniform token[] xformOpOrder = [\"xformOp:translate\"] }\n"
                                     "def Xform \"I3\" (instanceable = true\n inherits = </P>) {\n"
                                     "token visibility.timeSamples = { 1: \"invisible\" } }\n");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(fake.set_mesh_calls, 2);
    assert_int_equal(root->instance_count, 3);
    assert_int_equal(root->instances[0].object, root->instances[1].object);
    assert_int_equal(fake.objects[root->instances[0].object].instance_count, 2);
    assert_true(is_at(&root->instances[1], 3, 0, 0));
    assert_true(root->instances[2].hidden);
    assert_int_equal(fake.objects[root->instances[0].object].instances[1].prim_id, 1);
}

// What instances inherit differently cannot be shared; a displayColor travels with the placement.
static void test_native_instances_inherit(void **state)
{
    (void)state;
    open_stage("class Xform \"P\" {\n" TRIANGLE(
        "A", "") "}\n"
                 "def Material \"M\" {}\n"
                 "def Xform \"I1\" (instanceable = true\n inherits = </P>) {\n"
                 "color3f[] primvars:displayColor = [(1,0,0)] }\n"
                 "def Xform \"I2\" (instanceable = true\n inherits = </P>) {\n"
                 "color3f[] primvars:displayColor = [(0,1,0)] }\n"
                 "def Xform \"Bound\" (prepend apiSchemas = [\"MaterialBindingAPI\"]) {\n"
                 "rel material:binding = </M>\n"
                 "def Xform \"I3\" (instanceable = true\n inherits = </P>) {\n"
                 "color3f[] primvars:displayColor = [(0,0,1)] } }\n");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(fake.set_mesh_calls, 2);
    assert_int_equal(root->instance_count, 3);
    int shared = 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < i; k++)
            shared += root->instances[i].object == root->instances[k].object;
    assert_int_equal(shared, 1);
    assert_true(root->colors[0][2] == 1.0f); // /Bound/I3 is the first by path
    assert_true(root->colors[1][0] == 1.0f);
    assert_true(root->colors[2][1] == 1.0f);
}

static void test_nested_native_instances(void **state)
{
    (void)state;
    open_stage(
        "def Xform \"Lib\" { token visibility = \"invisible\"\n"
        "def Xform \"Leaf\" {\n" TRIANGLE(
            "A", "") "}\n"
                     "def Xform \"Tree\" {\n"
                     "def Xform \"L1\" (instanceable = true\n references = </Lib/Leaf>) {\n"
                     "double3 xformOp:translate = (1,0,0)\n"
                     "uniform token[] xformOpOrder = [\"xformOp:translate\"] }\n"
                     "def Xform \"L2\" (instanceable = true\n references = </Lib/Leaf>) {}\n} }\n"
                     "def Xform \"T1\" (instanceable = true\n references = </Lib/Tree>) {}\n"
                     "def Xform \"T2\" (instanceable = true\n references = </Lib/Tree>) {}\n");
    assert_int_equal(fake.set_mesh_calls, 1);
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 2);
    const FakeObject *tree = &fake.objects[root->instances[1].object];
    assert_int_equal(tree->instance_count, 2);
    assert_true(is_at(&tree->instances[0], 1, 0, 0));
    assert_int_equal(tree->instances[0].object, tree->instances[1].object);
}

static const char points_stage[] =
    "def PointInstancer \"PI\" (inactiveIds = [12]) {\n"
    "rel prototypes = [</PI/Protos/A>, </PI/Protos/B>]\n"
    "int[] protoIndices = [0, 1, 0, 7, 1]\n"
    "int64[] ids = [10, 11, 12, 13, 14]\n"
    "int64[] invisibleIds = [11]\n"
    "point3f[] positions = [(1,0,0), (2,0,0), (3,0,0), (4,0,0), (5,0,0)]\n"
    "quath[] orientations = [(1,0,0,0), (1,0,0,0), (1,0,0,0), (1,0,0,0), "
    "(0.70710678,0,0,0.70710678)]\n"
    "float3[] scales = [(1,1,1), (1,1,1), (1,1,1), (1,1,1), (2,2,2)]\n"
    "double3 xformOp:translate = (0,0,9)\n"
    "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"
    "color3f[] primvars:displayColor = [(1,0,0),(0,1,0),(0,0,1),(0,0,0),(0.5,0.5,0.5)] "
    "(interpolation "
    "= \"vertex\")\n"
    "def Scope \"Protos\" {\n"
    "def Xform \"A\" { double3 xformOp:translate = (0,1,0)\n"
    "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n" TRIANGLE("M", "") "}\n" TRIANGLE(
        "B", "") "}\n}\n";

static void test_point_instancer(void **state)
{
    (void)state;
    open_stage(points_stage);
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(fake.set_mesh_calls, 2);
    assert_int_equal(root->instance_count, 3); // ids 10, 11 and 14
    assert_true(is_at(&root->instances[0], 1, 0, 9));
    assert_true(root->instances[1].hidden);
    assert_false(root->instances[2].hidden);
    assert_true(root->colors[2][0] == 0.5f);
    // Scaled by 2 and turned by 90 degrees about Z: x goes to y.
    assert_true(fabs(root->instances[2].transform[0][1] - 2.0) < 1e-3);
    assert_true(fabs(root->instances[2].transform[0][0]) < 1e-3);
    // The prototype's own transform comes first.
    const FakeObject *a = &fake.objects[root->instances[0].object];
    assert_true(is_at(&a->instances[0], 0, 1, 0));
    assert_true(stage_fixture_reports(&f, "/PI", "protoIndices"));
}

static void test_nested_point_instancers(void **state)
{
    (void)state;
    open_stage("def PointInstancer \"Outer\" {\n"
               "rel prototypes = [</Outer/Inner>]\n int[] protoIndices = [0, 0]\n"
               "point3f[] positions = [(1,0,0), (2,0,0)]\n"
               "def PointInstancer \"Inner\" {\n"
               "rel prototypes = [</Outer/Inner/T>]\n int[] protoIndices = [0, 0, 0]\n"
               "point3f[] positions = [(0,1,0), (0,2,0), (0,3,0)]\n" TRIANGLE("T", "") "} }\n");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 2);
    const FakeObject *inner = &fake.objects[root->instances[0].object];
    assert_int_equal(inner->instance_count, 3);
    assert_int_equal(fake.set_mesh_calls, 1);
}

static void test_bad_instancers(void **state)
{
    (void)state;
    open_stage("def PointInstancer \"Short\" {\n rel prototypes = [</Short/T>]\n"
               "int[] protoIndices = [0, 0]\n point3f[] positions = [(1,0,0)]\n" TRIANGLE(
                   "T", "") "}\n"
                            "def PointInstancer \"Lost\" {\n rel prototypes = [</Nowhere>]\n"
                            "int[] protoIndices = [0]\n point3f[] positions = [(1,0,0)] }\n"
                            "def PointInstancer \"Self\" {\n rel prototypes = [</Self>]\n"
                            "int[] protoIndices = [0]\n point3f[] positions = [(1,0,0)] }\n"
                            "def PointInstancer \"Empty\" {}\n");
    assert_true(stage_fixture_reports(&f, "/Short", "PointInstancer"));
    assert_true(stage_fixture_reports(&f, "/Lost", "prototypes"));
    assert_true(stage_fixture_reports(&f, "/Self", "instancing"));
}

static void test_mesh_attributes(void **state)
{
    (void)state;
    open_stage(
        TRIANGLE("A", "uniform token subdivisionScheme = \"none\"\n"
                      "normal3f[] normals = [(0,0,1),(0,0,1),(0,0,1)]\n"
                      "color3f[] primvars:displayColor = [(1,0,0)]\n"
                      "float2[] primvars:unused = [(0,0)]\n"
                      "int primvars:ptexFaceOffset = 5")
            TRIANGLE(
                "B",
                "color3f[] primvars:displayColor = [(1,0,0),(0,1,0)] (interpolation = \"vertex\")")
                TRIANGLE("C",
                         "int[] cornerIndices = [0]\n uniform token subdivisionScheme = "
                         "\"spline\"") "def Mesh \"Empty\" {}\n"
                                       "def Xform \"X\" { color3f[] primvars:displayColor = "
                                       "[(1,1,0)]\n"
                                       "int primvars:ptexFaceOffset = 9\n" TRIANGLE("M", "") "}\n");
    assert_int_equal(fake_mesh("/A")->primvar_count, 2);
    assert_int_equal(fake_mesh("/A")->ptex_face_offset, 5);
    assert_int_equal(fake_mesh("/B")->primvar_count, 0); // two values for three points
    assert_true(stage_fixture_reports(&f, "/B", "primvars:displayColor"));
    assert_true(stage_fixture_reports(&f, "/C", "cornerSharpnesses"));
    assert_true(stage_fixture_reports(&f, "/C", "subdivisionScheme"));
    assert_true(stage_fixture_reports(&f, "/Empty", "Mesh"));
    assert_null(root_instance("/Empty"));
    assert_int_equal(fake_mesh("/X/M")->primvar_count, 1);
    assert_int_equal(fake_mesh("/X/M")->ptex_face_offset, 9);
}

// Hydra does not subdivide what the loop scheme cannot take.
static void test_loop_takes_triangles(void **state)
{
    (void)state;
    open_stage(TRIANGLE(
        "T", "uniform token subdivisionScheme = \"loop\"") "def Mesh \"Q\" { uniform token "
                                                           "subdivisionScheme = \"loop\"\n"
                                                           "int[] faceVertexCounts = [4]\n int[] "
                                                           "faceVertexIndices = [0,1,2,3]\n"
                                                           "point3f[] points = "
                                                           "[(0,0,0),(1,0,0),(1,1,0),(0,1,0)] }\n");
    assert_int_equal(fake_mesh("/T")->scheme, COHORT_SCHEME_LOOP);
    assert_false(stage_fixture_reports(&f, "/T", "subdivisionScheme"));
    assert_int_equal(fake_mesh("/Q")->scheme, COHORT_SCHEME_NONE);
    assert_true(stage_fixture_reports(&f, "/Q", "subdivisionScheme"));
}

static void test_implicits(void **state)
{
    (void)state;
    open_stage("def Sphere \"S\" {}\n def Cube \"C\" { double size = 4 }\n def Cone \"N\" {}\n"
               "def Cylinder \"Y\" { uniform token axis = \"X\" }\n def Capsule_1 \"P\" {}\n"
               "def Plane \"L\" {}\n def BasisCurves \"B\" {}\n def Sphere \"Bad\" { double radius "
               "= -1 }\n");
    const char *const paths[] = {"/S", "/C", "/N", "/Y", "/P", "/L"};
    for (int i = 0; i < 6; i++)
        assert_true(fake_mesh(paths[i]) && fake_mesh(paths[i])->point_count >= 4);
    assert_true(fabsf(fake_mesh("/C")->first_point[0]) == 2.0f);
    assert_true(stage_fixture_reports(&f, "/B", "BasisCurves"));
    assert_true(stage_fixture_reports(&f, "/Bad", "Mesh"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_transforms_multiply_up, teardown),
        cmocka_unit_test_teardown(test_visibility_and_purpose, teardown),
        cmocka_unit_test_teardown(test_hidden_from_some_rays, teardown),
        cmocka_unit_test_teardown(test_asked_purposes_win, teardown),
        cmocka_unit_test_teardown(test_time_moves_and_deforms, teardown),
        cmocka_unit_test_teardown(test_frame_of_a_range_is_that_frame, teardown),
        cmocka_unit_test_teardown(test_placements_keep_their_colors, teardown),
        cmocka_unit_test_teardown(test_native_instances_share, teardown),
        cmocka_unit_test_teardown(test_native_instances_inherit, teardown),
        cmocka_unit_test_teardown(test_nested_native_instances, teardown),
        cmocka_unit_test_teardown(test_point_instancer, teardown),
        cmocka_unit_test_teardown(test_nested_point_instancers, teardown),
        cmocka_unit_test_teardown(test_bad_instancers, teardown),
        cmocka_unit_test_teardown(test_mesh_attributes, teardown),
        cmocka_unit_test_teardown(test_loop_takes_triangles, teardown),
        cmocka_unit_test_teardown(test_implicits, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
