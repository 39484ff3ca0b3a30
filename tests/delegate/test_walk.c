// The walk over a stage: what is drawn, which places share a prototype, and what is named instead.

#include "stage_fixture.h"

#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

// ---- Purpose -----------------------------------------------------------------------------------

// The nearest authored purpose counts, and by default those of a final frame are drawn.
static void test_purposes(void **state)
{
    (void)state;
    static const char body[] = "def Xform 'P' { uniform token purpose = 'proxy';"
                               "  def Mesh 'M' { $triangle }"
                               "  def Mesh 'R' { $triangle uniform token purpose = 'render' }"
                               "}"
                               "def Mesh 'G' { $triangle uniform token purpose = 'guide' }"
                               "def Mesh 'D' { $triangle }";
    open_stage(body);
    assert_null(fake_mesh("/P/M"));
    assert_non_null(fake_mesh("/P/R"));
    assert_null(fake_mesh("/G"));
    assert_non_null(fake_mesh("/D"));
    close_stage(NULL);
    CohortAdapterOptions options = {.purposes = COHORT_PURPOSE_PROXY};
    open_stage_with(body, &options);
    assert_non_null(fake_mesh("/P/M"));
    assert_null(fake_mesh("/P/R"));
    assert_null(fake_mesh("/D"));
}

// Neither transform nor visibility nor purpose comes from a prim without a type, no transform from
// a Scope: as UsdGeom computes them, and what is authored there is named.
static void test_what_a_type_does_not_have(void **state)
{
    (void)state;
    open_stage("def 'T' { $at(5,0,0) token visibility = 'invisible';"
               "  uniform token purpose = 'guide';"
               "  def Mesh 'M' { $triangle }"
               "}"
               "def Scope 'S' { $at(0,5,0) def Mesh 'M' { $triangle }"
               "  def Scope 'H' { token visibility = 'invisible'; def Mesh 'M' { $triangle } }"
               "}");
    assert_true(is_at(root_instance("/T/M"), 0, 0, 0));
    assert_false(root_instance("/T/M")->hidden);
    assert_true(is_at(root_instance("/S/M"), 0, 0, 0));
    assert_null(fake_mesh("/S/H/M"));
    assert_true(is_reported("/T", "xformOpOrder") && is_reported("/T", "visibility") &&
                is_reported("/T", "purpose"));
    assert_true(is_reported("/S", "xformOpOrder"));
    assert_false(is_reported("/S/H", "visibility"));
}

// ---- Native instances --------------------------------------------------------------------------

// Three placements of a prototype with two parts, one of them invisible.
static void test_native_instances_share(void **state)
{
    (void)state;
    open_stage("class Xform 'P' { def Mesh 'A' { $triangle } def Mesh 'B' { $triangle } }"
               "def Xform 'I1' (instanceable = true; inherits = </P>) {}"
               "def Xform 'I2' (instanceable = true; inherits = </P>) { $at(3,0,0) }"
               "def Xform 'I3' (instanceable = true; inherits = </P>) {"
               "  token visibility.timeSamples = { 1: 'invisible' } }");
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
    open_stage("class Xform 'P' { def Mesh 'A' { $triangle } }"
               "def Material 'M' {}"
               "def Xform 'I1' (instanceable = true; inherits = </P>) {"
               "  color3f[] primvars:displayColor = [(1,0,0)] }"
               "def Xform 'I2' (instanceable = true; inherits = </P>) {"
               "  color3f[] primvars:displayColor = [(0,1,0)] }"
               "def Xform 'Bound' (prepend apiSchemas = ['MaterialBindingAPI']) {"
               "  rel material:binding = </M>;"
               "  def Xform 'I3' (instanceable = true; inherits = </P>) {"
               "    color3f[] primvars:displayColor = [(0,0,1)] }"
               "}");
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
    open_stage("def Xform 'Lib' { token visibility = 'invisible';"
               "  def Xform 'Leaf' { def Mesh 'A' { $triangle } }"
               "  def Xform 'Tree' {"
               "    def Xform 'L1' (instanceable = true; references = </Lib/Leaf>) { $at(1,0,0) }"
               "    def Xform 'L2' (instanceable = true; references = </Lib/Leaf>) {}"
               "  }"
               "}"
               "def Xform 'T1' (instanceable = true; references = </Lib/Tree>) {}"
               "def Xform 'T2' (instanceable = true; references = </Lib/Tree>) {}");
    assert_int_equal(fake.set_mesh_calls, 1);
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 2);
    const FakeObject *tree = &fake.objects[root->instances[1].object];
    assert_int_equal(tree->instance_count, 2);
    assert_true(is_at(&tree->instances[0], 1, 0, 0));
    assert_int_equal(tree->instances[0].object, tree->instances[1].object);
}

// ---- What is not drawn -------------------------------------------------------------------------

static void test_unsupported_prims_are_named(void **state)
{
    (void)state;
    open_stage("def BasisCurves 'B' {} def Points 'P' {} def CylinderLight 'C' {}"
               "def Xform 'Hidden' { token visibility = 'invisible'; def Points 'P' {} }"
               "def Mesh 'L' (prepend apiSchemas = ['MeshLightAPI', 'SkelBindingAPI']) {"
               "  $triangle }"
               "def Sphere 'Lamp' (prepend apiSchemas = ['LightAPI']) {}"
               "def SphereLight 'Bulb' (prepend apiSchemas = ['LightAPI']) {}"
               "def Material 'M' { def Mesh 'Inside' { $triangle } }");
    assert_true(is_reported("/B", "BasisCurves"));
    assert_true(is_reported("/P", "Points"));
    assert_true(is_reported("/C", "CylinderLight"));
    assert_false(is_reported("/Hidden/P", "Points"));
    assert_true(is_reported("/L", "MeshLightAPI"));
    assert_true(is_reported("/Lamp", "LightAPI"));
    assert_false(is_reported("/Bulb", "LightAPI"));
    assert_true(is_reported("/L", "SkelBindingAPI"));
    assert_int_equal(fake.set_mesh_calls, 2);
}

static void test_preview_bindings_are_named(void **state)
{
    (void)state;
    open_stage("def Material 'P' {} def Material 'M' {}"
               "def Xform 'W' { rel material:binding:preview = </P>;"
               "  def Mesh 'Only' { $triangle }"
               "  def Mesh 'Both' { $triangle rel material:binding = </M> } }"
               "def Mesh 'None' { $triangle }");
    assert_true(is_reported("/W/Only", "material:binding:preview"));
    assert_false(is_reported("/W/Both", "material:binding:preview"));
    assert_false(is_reported("/None", "material:binding:preview"));
}

// A chain of instancers, each the prototype of the one before, and a mesh.
static void open_chain(int count)
{
    static char body[1 << 17];
    size_t used = 0;
    for (int i = 0; i < count; i++)
        used += (size_t)snprintf(body + used, sizeof body - used,
                                 "def PointInstancer 'I%d' { rel prototypes = [</I%d>];"
                                 "int[] protoIndices = [0]; point3f[] positions = [(0,0,0)] }",
                                 i, i + 1);
    snprintf(body + used, sizeof body - used, "def Mesh 'I%d' { $triangle }", count);
    open_stage(body);
}

static void test_nesting_ends(void **state)
{
    (void)state;
    open_chain(100);
    assert_false(is_reported("/I99", "instancing"));
    const FakeObject *group = &fake.objects[0];
    for (int depth = 0; depth < 100; depth++)
        group = &fake.objects[group->instances[0].object];
    assert_int_equal(group->instance_count, 1);
    close_stage(NULL);
    open_chain(600);
    assert_true(is_reported("/I512", "instancing"));
}

// ---- Memory ------------------------------------------------------------------------------------

static void test_allocation_failures(void **state)
{
    (void)state;
    static const char body[] = "class Xform 'P' { def Mesh 'A' { $triangle } }"
                               "def Xform 'I' (instanceable = true; inherits = </P>) {}"
                               "def SphereLight 'L' {} def Camera 'C' {}"
                               "def PointInstancer 'PI' { rel prototypes = [</PI/T>];"
                               "  int[] protoIndices = [0]; point3f[] positions = [(0,0,0)];"
                               "  def Mesh 'T' { $triangle } }";
    open_stage(body);
    cohort_adapter_destroy(stage.adapter);
    stage.adapter = NULL;
    CohortError err = {0};
    bool has_ended = false;
    uint64_t n;
    for (n = 1; n < 1000 && !has_ended; n++) {
        CohortAdapter *adapter = cohort_adapter_open(stage.delegate, stage.path, NULL, NULL);
        assert_non_null(adapter);
        err = (CohortError){0};
        co_memory_fail_after(n);
        has_ended = cohort_adapter_populate(adapter, &err);
        co_memory_fail_after(0);
        if (!has_ended)
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        cohort_adapter_destroy(adapter);
    }
    assert_true(has_ended && n > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_purposes, close_stage),
        cmocka_unit_test_teardown(test_what_a_type_does_not_have, close_stage),
        cmocka_unit_test_teardown(test_native_instances_share, close_stage),
        cmocka_unit_test_teardown(test_native_instances_inherit, close_stage),
        cmocka_unit_test_teardown(test_nested_native_instances, close_stage),
        cmocka_unit_test_teardown(test_unsupported_prims_are_named, close_stage),
        cmocka_unit_test_teardown(test_preview_bindings_are_named, close_stage),
        cmocka_unit_test_teardown(test_nesting_ends, close_stage),
        cmocka_unit_test_teardown(test_allocation_failures, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
