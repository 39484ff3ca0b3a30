// PointInstancers and native instances from stage to groups: who is placed where, in which color,
// and what of bad arrays is left out.

#include "stage_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

// ---- Native instances --------------------------------------------------------------------------

// Placements hand their colors down, each its own, to meshes that have none.
static void test_placements_hand_colors_down(void **state)
{
    (void)state;
    open_stage("class Xform 'P' { def Mesh 'A' { $triangle } }"
               "class Xform 'Q' { def Mesh 'A' { $triangle"
               "  color3f[] primvars:displayColor = [(0.5,0.5,0.5)] } }"
               "def Xform 'I1' (instanceable = true; inherits = </P>) {"
               "  color3f[] primvars:displayColor = [(1,0,0)] }"
               "def Xform 'I2' (instanceable = true; inherits = </Q>) {"
               "  color3f[] primvars:displayColor = [(0,1,0)] }"
               "def Xform 'I3' (instanceable = true; inherits = </P>) {}");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 3);
    assert_true(root->colors[0][0] == 1.0f);
    assert_non_null(root->instances[0].display_color);
    assert_true(root->colors[1][1] == 1.0f);
    assert_true(root->instances[0].color_yields && root->instances[1].color_yields);
    assert_null(root->instances[2].display_color);
}

// A placement's color is chosen by its index, and may be of any precision.
static void test_indexed_colors_are_handed_down(void **state)
{
    (void)state;
    open_stage("class Xform 'P' { def Mesh 'A' { $triangle } }"
               "def Xform 'I1' (instanceable = true; inherits = </P>) {"
               "  color3f[] primvars:displayColor = [(1,0,0), (0,1,0)];"
               "  int[] primvars:displayColor:indices = [1] }"
               "def Xform 'I2' (instanceable = true; inherits = </P>) {"
               "  color3d[] primvars:displayColor = [(0,0,1)] }"
               "def Xform 'I3' (instanceable = true; inherits = </P>) {"
               "  color3f[] primvars:displayColor = [(1,0,0)];"
               "  int[] primvars:displayColor:indices = [-1] }");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 3);
    assert_true(root->colors[0][0] == 0.0f && root->colors[0][1] == 1.0f);
    assert_non_null(root->instances[1].display_color);
    assert_true(root->colors[1][2] == 1.0f);
    assert_null(root->instances[2].display_color);
}

// ---- PointInstancers ---------------------------------------------------------------------------

static void test_every_array_counts(void **state)
{
    (void)state;
    open_stage("def PointInstancer 'PI' (inactiveIds = [12]) { $at(0,0,9)"
               "  rel prototypes = [</PI/Protos/A>, </PI/Protos/B>];"
               "  int[] protoIndices = [0, 1, 0, 7, 1];"
               "  int64[] ids = [10, 11, 12, 13, 14];"
               "  int64[] invisibleIds = [11];"
               "  point3f[] positions = [(1,0,0), (2,0,0), (3,0,0), (4,0,0), (5,0,0)];"
               "  quath[] orientations = [(1,0,0,0), (1,0,0,0), (1,0,0,0), (1,0,0,0),"
               "                          (0.70710678,0,0,0.70710678)];"
               "  float3[] scales = [(1,1,1), (1,1,1), (1,1,1), (1,1,1), (2,2,2)];"
               "  color3f[] primvars:displayColor = [(1,0,0),(0,1,0),(0,0,1),(0,0,0),(0.5,0.5,0.5)]"
               "    (interpolation = 'vertex');"
               "  def Scope 'Protos' {"
               "    def Xform 'A' { $at(0,1,0) def Mesh 'M' { $triangle } }"
               "    def Mesh 'B' { $triangle }"
               "  }"
               "}");
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
    assert_true(is_reported("/PI", "protoIndices"));
}

// A prototype that is switched off is not drawn, though it is still a target.
static void test_inactive_prototypes_are_left_out(void **state)
{
    (void)state;
    open_stage("def PointInstancer 'PI' {"
               "  rel prototypes = [</PI/A>, </PI/B>]; int[] protoIndices = [0, 1, 1];"
               "  point3f[] positions = [(1,0,0), (2,0,0), (3,0,0)];"
               "  def Mesh 'A' (active = false) { $triangle }"
               "  def Mesh 'B' { $triangle }"
               "}");
    assert_int_equal(fake.set_mesh_calls, 1);
    assert_int_equal(fake.objects[0].instance_count, 2);
    assert_true(is_at(&fake.objects[0].instances[0], 2, 0, 0));
}

static void test_nested_point_instancers(void **state)
{
    (void)state;
    open_stage("def PointInstancer 'Outer' {"
               "  rel prototypes = [</Outer/Inner>]; int[] protoIndices = [0, 0];"
               "  point3f[] positions = [(1,0,0), (2,0,0)];"
               "  def PointInstancer 'Inner' {"
               "    rel prototypes = [</Outer/Inner/T>]; int[] protoIndices = [0, 0, 0];"
               "    point3f[] positions = [(0,1,0), (0,2,0), (0,3,0)];"
               "    def Mesh 'T' { $triangle }"
               "  }"
               "}");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 2);
    const FakeObject *inner = &fake.objects[root->instances[0].object];
    assert_int_equal(inner->instance_count, 3);
    assert_int_equal(fake.set_mesh_calls, 1);
}

// What two prototypes place is one object; where each inherits otherwise, two.
static void test_prototypes_are_shared_across_levels(void **state)
{
    (void)state;
    open_stage("def Xform 'Lib' {"
               "  def Xform 'Leaf' { def Mesh 'M' { $triangle } }"
               "  def PointInstancer 'A' { rel prototypes = </Lib/Leaf>; int[] protoIndices = [0];"
               "    point3f[] positions = [(1,0,0)] }"
               "  def PointInstancer 'B' { rel prototypes = </Lib/Leaf>; int[] protoIndices = [0];"
               "    point3f[] positions = [(2,0,0)] }"
               "}"
               "def PointInstancer 'Top' { rel prototypes = [</Lib/A>, </Lib/B>];"
               "  int[] protoIndices = [0, 1]; point3f[] positions = [(0,0,0), (0,1,0)] }");
    assert_int_equal(fake.set_mesh_calls, 2); // in the library itself, and as a prototype
}

// Prototypes that place each other end, and there are not more of them with each level.
static void test_circles_of_prototypes_end(void **state)
{
    (void)state;
    open_stage("def Xform 'A' { def Mesh 'M' { $triangle } def PointInstancer 'I' {"
               "  rel prototypes = [</A>, </B>]; int[] protoIndices = [0, 1];"
               "  point3f[] positions = [(1,0,0), (2,0,0)] } }"
               "def Xform 'B' { def PointInstancer 'I' {"
               "  rel prototypes = [</A>, </B>]; int[] protoIndices = [0, 1];"
               "  point3f[] positions = [(1,0,0), (2,0,0)] } }");
    assert_true(is_reported("/A/I", "instancing"));
    assert_true(is_reported("/B/I", "instancing"));
    assert_true(fake.set_mesh_calls < 8);
}

// A prototype that is a native instance, the first of its kind, is no circle.
static void test_a_native_instance_is_a_prototype(void **state)
{
    (void)state;
    open_stage("class Xform 'C' { def Mesh 'M' { $triangle } }"
               "def PointInstancer 'I' { rel prototypes = </I/P>; int[] protoIndices = [0, 0];"
               "  point3f[] positions = [(1,0,0), (2,0,0)];"
               "  def Xform 'P' (instanceable = true; references = </C>) {} }");
    assert_false(is_reported("/I/P", "instancing"));
    assert_int_equal(fake.set_mesh_calls, 1);
}

static void test_instancers_without_sense_are_named(void **state)
{
    (void)state;
    open_stage("def PointInstancer 'Short' { rel prototypes = [</Short/T>];"
               "  int[] protoIndices = [0, 0]; point3f[] positions = [(1,0,0)];"
               "  def Mesh 'T' { $triangle } }"
               "def PointInstancer 'Lost' { rel prototypes = [</Nowhere>];"
               "  int[] protoIndices = [0]; point3f[] positions = [(1,0,0)] }"
               "def PointInstancer 'Self' { rel prototypes = [</Self>];"
               "  int[] protoIndices = [0]; point3f[] positions = [(1,0,0)] }"
               "def PointInstancer 'Empty' {}");
    assert_true(is_reported("/Short", "PointInstancer"));
    assert_true(is_reported("/Lost", "prototypes"));
    assert_true(is_reported("/Self", "instancing"));
    assert_int_equal(fake.set_mesh_calls, 1);
}

// Two instances of one triangle, with more attributes.
static void open_two(const char *more)
{
    char body[1024];
    snprintf(body, sizeof body,
             "def PointInstancer 'P' { rel prototypes = [</P/T>]; def Mesh 'T' { $triangle }"
             "int[] protoIndices = [0, 0]; %s }",
             more);
    open_stage(body);
}

// An instance whose place is no place is left out; the other stays.
static void test_places_that_are_none(void **state)
{
    (void)state;
    static const char *const senseless[] = {
        "point3f[] positions = [(nan,0,0), (1,2,3)]", "point3f[] positions = [(0,-inf,0), (1,2,3)]",
        "point3f[] positions = [(0,0,0), (1,2,3)]; float3[] scales = [(1,nan,1), (1,1,1)]"};
    for (int i = 0; i < 3; i++) {
        open_two(senseless[i]);
        assert_int_equal(fake.objects[0].instance_count, 1);
        assert_true(is_at(&fake.objects[0].instances[0], 1, 2, 3));
        assert_true(is_reported("/P", "positions"));
        close_stage(NULL);
    }
    // No rotation at all, and one of no length: none.
    open_two("point3f[] positions = [(0,0,0), (1,2,3)];"
             "quath[] orientations = [(0,0,0,0), (2,0,0,0)]");
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++)
            assert_true(fake.objects[0].instances[i].transform[k][k] == 1.0);
}

// Arrays of another length than protoIndices are named and ignored; ids are then the indices.
static void test_arrays_of_other_lengths(void **state)
{
    (void)state;
    open_two("point3f[] positions = [(1,0,0), (2,0,0)]; float3[] scales = [(9,9,9)];"
             "quath[] orientations = [(0,1,0,0), (0,1,0,0), (0,1,0,0)];"
             "int64[] ids = [7]; int64[] invisibleIds = [1];"
             "color3f[] primvars:displayColor = [(1,0,0)] (interpolation = 'vertex')");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 2);
    assert_true(root->instances[0].transform[0][0] == 1.0);
    assert_true(root->instances[0].transform[1][1] == 1.0);
    assert_false(root->instances[0].hidden);
    assert_true(root->instances[1].hidden);
    assert_null(root->instances[0].display_color);
    static const char *const names[] = {"scales", "orientations", "ids", "primvars:displayColor"};
    for (int i = 0; i < 4; i++)
        assert_true(is_reported("/P", names[i]));
}

// orientationsf wins over orientations; colors may be indexed, by indices that fit.
static void test_fine_orientations_and_indexed_colors(void **state)
{
    (void)state;
    open_two("point3f[] positions = [(1,0,0), (2,0,0)];"
             "quath[] orientations = [(1,0,0,0), (1,0,0,0)];"
             "quatf[] orientationsf = [(0,0,0,1), (0,0,0,1)];"
             "color3f[] primvars:displayColor = [(1,0,0), (0,1,0)] (interpolation = 'varying');"
             "int[] primvars:displayColor:indices = [1, 0]");
    const FakeObject *root = &fake.objects[0];
    assert_true(root->instances[0].transform[0][0] == -1.0); // half a turn about Z
    assert_true(root->colors[0][1] == 1.0f && root->colors[1][0] == 1.0f);
    close_stage(NULL);
    open_two("point3f[] positions = [(1,0,0), (2,0,0)];"
             "color3f[] primvars:displayColor = [(1,0,0)] (interpolation = 'varying');"
             "int[] primvars:displayColor:indices = [0, 1]");
    assert_null(fake.objects[0].instances[0].display_color);
    assert_true(is_reported("/P", "primvars:displayColor"));
}

static void test_motion_is_named(void **state)
{
    (void)state;
    open_two("point3f[] positions = [(1,0,0), (2,0,0)]; vector3f[] velocities = [(1,0,0),(1,0,0)];"
             "float[] primvars:age = [1, 2] (interpolation = 'vertex')");
    assert_true(is_reported("/P", "velocities"));
    assert_true(is_reported("/P", "primvars:age"));
    assert_int_equal(fake.objects[0].instance_count, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_placements_hand_colors_down, close_stage),
        cmocka_unit_test_teardown(test_indexed_colors_are_handed_down, close_stage),
        cmocka_unit_test_teardown(test_every_array_counts, close_stage),
        cmocka_unit_test_teardown(test_inactive_prototypes_are_left_out, close_stage),
        cmocka_unit_test_teardown(test_nested_point_instancers, close_stage),
        cmocka_unit_test_teardown(test_prototypes_are_shared_across_levels, close_stage),
        cmocka_unit_test_teardown(test_circles_of_prototypes_end, close_stage),
        cmocka_unit_test_teardown(test_a_native_instance_is_a_prototype, close_stage),
        cmocka_unit_test_teardown(test_instancers_without_sense_are_named, close_stage),
        cmocka_unit_test_teardown(test_places_that_are_none, close_stage),
        cmocka_unit_test_teardown(test_arrays_of_other_lengths, close_stage),
        cmocka_unit_test_teardown(test_fine_orientations_and_indexed_colors, close_stage),
        cmocka_unit_test_teardown(test_motion_is_named, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
