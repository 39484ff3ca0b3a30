// Places in a stage: what transforms and visibility come from above, through prototypes too.

#include "stage_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void test_transforms_multiply_up(void **state)
{
    (void)state;
    open_stage("def Xform 'A' { $at(1,2,3)"
               "  def Xform 'B' {"
               "    float xformOp:rotateZ = 90;"
               "    uniform token[] xformOpOrder = ['xformOp:rotateZ'];"
               "    def Mesh 'M' { $triangle $at(5,0,0) }"
               "    def Mesh 'R' { $triangle"
               "      double3 xformOp:translate = (7,0,0);"
               "      uniform token[] xformOpOrder = ['!resetXformStack!', 'xformOp:translate']"
               "    }"
               "  }"
               "}");
    assert_true(is_at(root_instance("/A/B/M"), 1, 7, 3));
    assert_true(is_at(root_instance("/A/B/R"), 7, 0, 0));
}

// Below a PointInstancer's target the group is the target's: what stands above comes with the
// instancer, once.
static void test_prototypes_end_a_transform(void **state)
{
    (void)state;
    open_stage("def Xform 'A' { $at(100,0,0)"
               "  def PointInstancer 'PI' { $at(0,10,0)"
               "    rel prototypes = [</A/PI/Lib/T>]; int[] protoIndices = [0];"
               "    point3f[] positions = [(0,0,1)];"
               "    def Xform 'Lib' { $at(0,0,500)"
               "      def Xform 'T' { $at(1,0,0)"
               "        def Mesh 'M' { $triangle $at(2,0,0) }"
               "      }"
               "    }"
               "  }"
               "}");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 1);
    assert_true(is_at(&root->instances[0], 100, 10, 1));
    assert_true(is_at(&fake.objects[root->instances[0].object].instances[0], 3, 0, 0));
}

// Lights are of the world, so their transforms go through every prototype around them.
static void test_lights_go_through_prototypes(void **state)
{
    (void)state;
    open_stage("class Xform 'Leaf' { def SphereLight 'L' { $at(1,0,0) } }"
               "class Xform 'Tree' { def Xform 'Twig' (instanceable = true; inherits = </Leaf>) {"
               "  $at(0,10,0) } }"
               "def Xform 'T1' (instanceable = true; inherits = </Tree>) { $at(0,0,100) }"
               "def Xform 'T2' (instanceable = true; inherits = </Tree>) {"
               "  token visibility.timeSamples = { 1: 'invisible' }"
               "}");
    assert_int_equal(fake.light_count, 2);
    bool is_hidden[2] = {fake.lights[0].hidden, fake.lights[1].hidden};
    assert_true(is_hidden[0] != is_hidden[1]);
    const CohortLightDesc *shown = &fake.lights[is_hidden[0]];
    assert_true(shown->transform[3][0] == 1.0 && shown->transform[3][1] == 10.0 &&
                shown->transform[3][2] == 100.0);
}

// "inherited" below "invisible" shows nothing; what may become visible is there, but hidden.
static void test_visibility_is_pruning(void **state)
{
    (void)state;
    open_stage("def Xform 'A' { token visibility = 'invisible';"
               "  def Mesh 'M' { $triangle token visibility = 'inherited' }"
               "}"
               "def Xform 'V' {"
               "  token visibility.timeSamples = { 1: 'invisible', 2: 'inherited' };"
               "  def Mesh 'M' { $triangle }"
               "}");
    assert_null(fake_mesh("/A/M"));
    assert_true(root_instance("/V/M")->hidden); // at the earliest time
    assert_true(cohort_adapter_set_time(stage.adapter, 2.0, NULL));
    assert_true(cohort_render_index_sync(stage.index, NULL));
    assert_false(root_instance("/V/M")->hidden);
    assert_int_equal(fake.set_mesh_calls, 1); // nothing was built again
}

// Samples anywhere above a prim make it vary, and nothing else does.
static void test_what_varies_gets_dirty(void **state)
{
    (void)state;
    open_stage("def Xform 'A' {"
               "  double3 xformOp:translate.timeSamples = { 1: (0,0,0), 3: (4,0,0) };"
               "  uniform token[] xformOpOrder = ['xformOp:translate'];"
               "  def Xform 'B' { def Mesh 'M' { $triangle } }"
               "}"
               "def Mesh 'Still' { $triangle $at(1,0,0) }"
               "def Mesh 'D' {"
               "  int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0,1,2];"
               "  point3f[] points.timeSamples = { 1: [(0,0,0),(1,0,0),(0,1,0)],"
               "                                   3: [(2,0,0),(1,0,0),(0,1,0)] }"
               "}");
    assert_true(is_at(root_instance("/A/B/M"), 0, 0, 0));
    assert_true(cohort_adapter_set_time(stage.adapter, 2.0, NULL));
    CohortRenderIndex *index = stage.index;
    assert_int_equal(cohort_render_index_dirty_bits(index, "/A/B/M"), COHORT_DIRTY_TRANSFORM);
    assert_int_equal(cohort_render_index_dirty_bits(index, "/Still"), 0);
    assert_int_equal(cohort_render_index_dirty_bits(index, "/D"), COHORT_DIRTY_POINTS);
    assert_true(cohort_render_index_sync(index, NULL));
    assert_true(is_at(root_instance("/A/B/M"), 2, 0, 0));
    assert_true(fake_mesh("/D")->first_point[0] == 1.0f);
    assert_int_equal(fake.set_mesh_calls, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_transforms_multiply_up, close_stage),
        cmocka_unit_test_teardown(test_prototypes_end_a_transform, close_stage),
        cmocka_unit_test_teardown(test_lights_go_through_prototypes, close_stage),
        cmocka_unit_test_teardown(test_visibility_is_pruning, close_stage),
        cmocka_unit_test_teardown(test_what_varies_gets_dirty, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
