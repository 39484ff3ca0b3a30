// Lights of a stage: once for each instance that shows them, and a word where they cannot be
// placed.

#include "stage_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// Whatever else shows the same prototype, and wherever it is met first.
static void test_lights_of_point_instancers_are_named(void **state)
{
    (void)state;
    open_stage("class Xform 'P' { def SphereLight 'L' {} }"
               "class Xform 'Q' { def PointInstancer 'PI' {"
               "  rel prototypes = [</Q/PI/Lamp>]; int[] protoIndices = [0];"
               "  point3f[] positions = [(1,0,0)];"
               "  def Xform 'Lamp' { def DiskLight 'D' {} } } }"
               "def Xform 'A' (instanceable = true; inherits = </P>) {}"
               "def Xform 'B' (instanceable = true; inherits = </Q>) {}"
               "def PointInstancer 'C' { rel prototypes = [</C/Shared>, </C/Own>];"
               "  int[] protoIndices = [0, 1]; point3f[] positions = [(1,0,0), (2,0,0)];"
               "  def Xform 'Shared' (instanceable = true; inherits = </P>) {}"
               "  def Xform 'Own' { def RectLight 'R' {} } }");
    assert_int_equal(fake.light_count, 1); // of A
    assert_true(is_reported("/C/Shared", "instance"));
    assert_true(is_reported("/C/Own/R", "RectLight"));
    assert_true(is_reported("/B/PI/Lamp/D", "DiskLight"));
}

// What is never visible is no light, and the settings count the rest.
static void test_lights_are_counted(void **state)
{
    (void)state;
    open_stage("def RectLight 'R' {} def DistantLight 'H' { token visibility = 'invisible' }"
               "class Xform 'P' { def SphereLight 'L' { $at(0,1,0) } }"
               "def Xform 'I1' (instanceable = true; inherits = </P>) {}"
               "def Xform 'I2' (instanceable = true; inherits = </P>) { $at(5,0,0) }");
    assert_int_equal(fake.light_count, 3);
    CohortResolvedSettings settings;
    cohort_adapter_settings(stage.adapter, &settings);
    assert_int_equal(settings.light_count, 3);
    double sum[2] = {0.0, 0.0};
    for (uint32_t i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++)
            sum[k] += fake.lights[i].transform[3][k];
    assert_true(sum[0] == 5.0 && sum[1] == 2.0);
}

// Instances in instances show their lights as often as they are shown, lights below lights too, as
// outside of instances; what is never visible is no light.
static void test_lights_of_nested_instances(void **state)
{
    (void)state;
    open_stage("class Xform 'Lamp' { def SphereLight 'L' { def SphereLight 'Inner' {} }"
               "  def SphereLight 'Off' { token visibility = 'invisible' } }"
               "class Xform 'Street' {"
               "  def Xform 'A' (instanceable = true; inherits = </Lamp>) {}"
               "  def Xform 'B' (instanceable = true; inherits = </Lamp>) { $at(1,0,0) }"
               "  def Xform 'Dark' { def Mesh 'M' { $triangle } }"
               "}"
               "def Xform 'S1' (instanceable = true; inherits = </Street>) {}"
               "def Xform 'S2' (instanceable = true; inherits = </Street>) { $at(0,10,0) }");
    assert_int_equal(fake.light_count, 8);
    assert_int_equal(fake.set_mesh_calls, 1); // the mesh is shared nevertheless
    double sum[2] = {0.0, 0.0};
    for (uint32_t i = 0; i < 8; i++)
        for (int k = 0; k < 2; k++)
            sum[k] += fake.lights[i].transform[3][k];
    assert_true(sum[0] == 4.0 && sum[1] == 40.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_lights_of_point_instancers_are_named, close_stage),
        cmocka_unit_test_teardown(test_lights_are_counted, close_stage),
        cmocka_unit_test_teardown(test_lights_of_nested_instances, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
