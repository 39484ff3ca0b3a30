// Meshes, their subdivision tags and subsets, and implicits, from stage to scene.

#include "stage_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void test_odd_tags_are_named(void **state)
{
    (void)state;
    open_stage("def Mesh 'C' { $triangle int[] cornerIndices = [0];"
               "  uniform token subdivisionScheme = 'spline'; uniform token orientation = 'up' }"
               "def Mesh 'Few' { $triangle int[] creaseIndices = [0, 1, 2];"
               "  int[] creaseLengths = [2]; float[] creaseSharpnesses = [1] }"
               "def Mesh 'One' { $triangle int[] creaseIndices = [0];"
               "  int[] creaseLengths = [1]; float[] creaseSharpnesses = [1] }"
               "def Mesh 'Per' { $triangle int[] creaseIndices = [0, 1, 2];"
               "  int[] creaseLengths = [3]; float[] creaseSharpnesses = [1, 2] }"
               "def Mesh 'Moves' { $triangle vector3f[] velocities = [(1,0,0),(1,0,0),(1,0,0)] }");
    assert_true(is_reported("/C", "cornerSharpnesses"));
    assert_true(is_reported("/C", "subdivisionScheme"));
    assert_true(is_reported("/C", "orientation"));
    assert_int_equal(fake_mesh("/C")->scheme, COHORT_SCHEME_CATMULL_CLARK);
    assert_true(is_reported("/Few", "creaseLengths"));
    assert_true(is_reported("/One", "creaseLengths"));
    assert_false(is_reported("/Per", "creaseLengths")); // a sharpness for each edge
    assert_true(is_reported("/Moves", "velocities"));
}

static void test_meshes_without_points_are_named(void **state)
{
    (void)state;
    open_stage("def Mesh 'Empty' {}"
               "def Mesh 'None' { int[] faceVertexCounts = []; point3f[] points = [] }"
               "def Mesh 'Flat' { int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0,1,2];"
               "  float2[] points = [(0,0),(1,0),(0,1)] }");
    static const char *const paths[] = {"/Empty", "/None", "/Flat"};
    for (int i = 0; i < 3; i++) {
        assert_true(is_reported(paths[i], "Mesh"));
        assert_null(root_instance(paths[i]));
    }
}

// Hydra does not subdivide what the loop scheme cannot take.
static void test_loop_takes_triangles(void **state)
{
    (void)state;
    open_stage("def Mesh 'T' { $triangle uniform token subdivisionScheme = 'loop' }"
               "def Mesh 'Q' { uniform token subdivisionScheme = 'loop';"
               "  int[] faceVertexCounts = [4]; int[] faceVertexIndices = [0,1,2,3];"
               "  point3f[] points = [(0,0,0),(1,0,0),(1,1,0),(0,1,0)] }");
    assert_int_equal(fake_mesh("/T")->scheme, COHORT_SCHEME_LOOP);
    assert_false(is_reported("/T", "subdivisionScheme"));
    assert_int_equal(fake_mesh("/Q")->scheme, COHORT_SCHEME_NONE);
    assert_true(is_reported("/Q", "subdivisionScheme"));
}

// A constant primvar: the nearest above counts, an array's first, none below zero.
static void test_ptex_face_offset(void **state)
{
    (void)state;
    open_stage("def Xform 'X' { int primvars:ptexFaceOffset = 9;"
               "  def Mesh 'Own' { $triangle int primvars:ptexFaceOffset = 5 }"
               "  def Mesh 'Heir' { $triangle }"
               "  def Mesh 'Array' { $triangle int[] primvars:ptexFaceOffset = [7, 8] }"
               "  def Mesh 'Below' { $triangle int primvars:ptexFaceOffset = -3 }"
               "}");
    assert_int_equal(fake_mesh("/X/Own")->ptex_face_offset, 5);
    assert_int_equal(fake_mesh("/X/Heir")->ptex_face_offset, 9);
    assert_int_equal(fake_mesh("/X/Array")->ptex_face_offset, 7);
    assert_int_equal(fake_mesh("/X/Below")->ptex_face_offset, 9);
}

static void test_hidden_from_some_rays(void **state)
{
    (void)state;
    open_stage("def Xform 'A' { int primvars:ri:attributes:visibility:camera = 0;"
               "  bool primvars:arnold:visibility:shadow = false;"
               "  def Mesh 'M' { $triangle }"
               "  def Mesh 'N' { $triangle int primvars:cohort:visibility:camera = 1;"
               "    int primvars:cohort:visibility:indirect = 0 }"
               "}"
               "def Mesh 'O' { $triangle }");
    assert_int_equal(root_instance("/A/M")->hidden_from,
                     COHORT_HIDDEN_FROM_CAMERA | COHORT_HIDDEN_FROM_SHADOW);
    assert_int_equal(root_instance("/A/N")->hidden_from,
                     COHORT_HIDDEN_FROM_SHADOW | COHORT_HIDDEN_FROM_INDIRECT);
    assert_int_equal(root_instance("/O")->hidden_from, 0);
}

// Of GeomSubsets those of faces in the family materialBind count, and of these those with faces.
static void test_subsets(void **state)
{
    (void)state;
    open_stage("def Mesh 'A' { $triangle"
               "  def GeomSubset 'Other' { int[] indices = [0, 0, 0]; uniform token familyName = "
               "'shapes' }"
               "  def GeomSubset 'None' { uniform token familyName = 'materialBind' }"
               "  def GeomSubset 'S' { int[] indices = [0]; uniform token elementType = 'face';"
               "    uniform token familyName = 'materialBind' }"
               "  def GeomSubset 'E' { int[] indices = [0]; uniform token elementType = 'edge';"
               "    uniform token familyName = 'materialBind' }"
               "}");
    assert_int_equal(fake_mesh("/A")->subset_faces, 1);
    assert_int_equal(fake_mesh("/A")->subset_material, COHORT_INVALID_ID);
    assert_true(is_reported("/A/E", "elementType"));
    assert_false(is_reported("/A/Other", "elementType"));
}

static void test_implicits(void **state)
{
    (void)state;
    open_stage("def Sphere 'S' {} def Cube 'C' { double size = 4 } def Cone 'N' {}"
               "def Cylinder 'Y' { uniform token axis = 'X' } def Capsule_1 'P' {}"
               "def Plane 'L' {} def Sphere 'Bad' { double radius = -1 }"
               "def Sphere 'Odd' { double radius = nan }");
    const char *const paths[] = {"/S", "/C", "/N", "/Y", "/P", "/L"};
    for (int i = 0; i < 6; i++)
        assert_true(fake_mesh(paths[i]) && fake_mesh(paths[i])->point_count >= 4);
    assert_true(fabsf(fake_mesh("/C")->first_point[0]) == 2.0f);
    assert_true(is_reported("/Bad", "Mesh"));
    assert_true(is_reported("/Odd", "Mesh"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_odd_tags_are_named, close_stage),
        cmocka_unit_test_teardown(test_meshes_without_points_are_named, close_stage),
        cmocka_unit_test_teardown(test_loop_takes_triangles, close_stage),
        cmocka_unit_test_teardown(test_ptex_face_offset, close_stage),
        cmocka_unit_test_teardown(test_hidden_from_some_rays, close_stage),
        cmocka_unit_test_teardown(test_subsets, close_stage),
        cmocka_unit_test_teardown(test_implicits, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
