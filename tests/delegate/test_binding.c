// Material bindings: strength, purpose, collections and subsets, as UsdShade resolves them.

#include "stage_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

// Opens a stage behind the materials </M1>, </M2> and </M3>, red by 0.1, 0.2 and 0.3.
static void open_bound(const char *body)
{
    char text[8192];
    int used = 0;
    for (int i = 1; i <= 3; i++)
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "def Material 'M%d' {"
                         "  token outputs:surface.connect = </M%d/S.outputs:surface>;"
                         "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface';"
                         "    color3f inputs:diffuseColor = (0.%d, 0, 0); token outputs:surface }"
                         "}",
                         i, i, i);
    used += snprintf(text + used, sizeof text - (size_t)used, "%s", body);
    assert_true((size_t)used < sizeof text);
    open_stage(text);
}

// Red of a material, -1 without one.
static float red_of(uint32_t material)
{
    return material == COHORT_INVALID_ID ? -1.0f : fake.materials[material].diffuse_color.value[0];
}

static float mesh_red(const char *path)
{
    const FakeObject *mesh = fake_mesh(path);
    assert_non_null(mesh);
    return red_of(mesh->material);
}

static void test_strength_and_purpose(void **state)
{
    (void)state;
    open_bound("def Xform 'Weak' { rel material:binding = </M1>;"
               "  def Mesh 'Own' { $triangle rel material:binding = </M2> }"
               "  def Mesh 'None' { $triangle }"
               "}"
               "def Xform 'Strong' {"
               "  rel material:binding = </M1> (bindMaterialAs = 'strongerThanDescendants');"
               "  def Mesh 'Own' { $triangle rel material:binding = </M2>"
               "    (bindMaterialAs = 'strongerThanDescendants') }"
               "}"
               "def Xform 'Full' { rel material:binding:full = </M3>;"
               "  def Mesh 'Own' { $triangle rel material:binding = </M2> }"
               "}"
               "def Mesh 'Preview' { $triangle rel material:binding:preview = </M3> }"
               "def Mesh 'Unbound' { $triangle }");
    assert_true(mesh_red("/Weak/Own") == 0.2f);
    assert_true(mesh_red("/Weak/None") == 0.1f);
    assert_true(mesh_red("/Strong/Own") == 0.1f); // of two strong ones the upper
    assert_true(mesh_red("/Full/Own") == 0.3f);
    assert_true(mesh_red("/Preview") == -1.0f);
    assert_true(mesh_red("/Unbound") == -1.0f);
}

// What is bound must be there and be a material; each is named.
static void test_bindings_to_nothing(void **state)
{
    (void)state;
    open_bound("def Xform 'X' {}"
               "def Mesh 'Lost' { $triangle rel material:binding = </Nowhere> }"
               "def Mesh 'Wrong' { $triangle rel material:binding = </X> }"
               "def Mesh 'Blocked' { $triangle rel material:binding = [] }");
    assert_true(mesh_red("/Lost") == -1.0f && is_reported("/Lost", "material:binding"));
    assert_true(mesh_red("/Wrong") == -1.0f && is_reported("/Wrong", "material:binding"));
    assert_true(mesh_red("/Blocked") == -1.0f && !is_reported("/Blocked", "material:binding"));
}

// On one prim a collection beats the direct binding; a weak one loses to what is bound below.
static void test_collections(void **state)
{
    (void)state;
    open_bound("def Xform 'C' { rel material:binding = </M1>;"
               "  rel material:binding:collection:some = [</C.collection:some>, </M2>];"
               "  rel collection:some:includes = [</C/In>];"
               "  rel collection:some:excludes = [</C/In/Not>];"
               "  def Xform 'In' {"
               "    def Mesh 'Yes' { $triangle }"
               "    def Mesh 'Not' { $triangle }"
               "    def Mesh 'Direct' { $triangle rel material:binding = </M3> }"
               "  }"
               "  def Mesh 'Out' { $triangle }"
               "  def Mesh 'Inn' { $triangle }" // begins like </C/In>
               "}");
    assert_true(mesh_red("/C/In/Yes") == 0.2f);
    assert_true(mesh_red("/C/In/Not") == 0.1f);
    assert_true(mesh_red("/C/In/Direct") == 0.3f);
    assert_true(mesh_red("/C/Out") == 0.1f);
    assert_true(mesh_red("/C/Inn") == 0.1f);
}

// A collection replaces the direct binding of its prim, which beat what is bound below; where it is
// too weak for that, the next that is strong counts. A binding to two materials is none.
static void test_collections_beside_direct_bindings(void **state)
{
    (void)state;
    open_bound("def Xform 'C' {"
               "  rel material:binding = </M1> (bindMaterialAs = 'strongerThanDescendants');"
               "  rel material:binding:collection:some = [</C.collection:some>, </M2>];"
               "  rel collection:some:includes = [</C/A>];"
               "  def Mesh 'A' { $triangle rel material:binding = </M3> }"
               "  def Mesh 'B' { $triangle rel material:binding = </M3> }"
               "}"
               "def Xform 'D' {"
               "  rel material:binding:collection:a = [</D.collection:a>, </M1>];"
               "  rel material:binding:collection:b = [</D.collection:a>, </M2>]"
               "    (bindMaterialAs = 'strongerThanDescendants');"
               "  rel collection:a:includes = [</D>];"
               "  def Mesh 'A' { $triangle rel material:binding = </M3> }"
               "  def Mesh 'B' { $triangle }"
               "}"
               "def Xform 'Two' { rel material:binding = </M1>;"
               "  def Mesh 'A' { $triangle rel material:binding = [</M2>, </M3>] }"
               "}");
    assert_true(mesh_red("/C/A") == 0.2f);
    assert_true(mesh_red("/C/B") == 0.1f);
    assert_true(mesh_red("/D/A") == 0.2f);
    assert_true(mesh_red("/D/B") == 0.1f);
    assert_true(mesh_red("/Two/A") == 0.1f && is_reported("/Two/A", "material:binding"));
}

static void test_strong_collections_win_below(void **state)
{
    (void)state;
    open_bound("def Xform 'C' {"
               "  rel material:binding:collection:some = [</C.collection:some>, </M2>]"
               "    (bindMaterialAs = 'strongerThanDescendants');"
               "  rel collection:some:includes = [</C/A>];"
               "  def Mesh 'A' { $triangle rel material:binding = </M3> }"
               "}");
    assert_true(mesh_red("/C/A") == 0.2f);
}

static void test_collections_of_collections(void **state)
{
    (void)state;
    open_bound("def Xform 'C' { rel material:binding = </M1>;"
               "  rel material:binding:collection:all = [</C.collection:all>, </M2>];"
               "  rel collection:all:includes = [</C.collection:a>, </C/Own>];"
               "  rel collection:all:excludes = [</C/A/Not>];"
               "  rel collection:a:includes = [</C/A>, </C.collection:b>];"
               "  rel collection:a:excludes = [</C/Own/Deep>];"
               "  rel collection:b:includes = [</C/B>, </C.collection:all>];" // a cycle
               "  def Xform 'A' { def Mesh 'Yes' { $triangle } def Mesh 'Not' { $triangle } }"
               "  def Xform 'Own' { def Mesh 'Yes' { $triangle } def Mesh 'Deep' { $triangle } }"
               "  def Mesh 'B' { $triangle }"
               "  def Mesh 'Out' { $triangle }"
               "}");
    assert_true(mesh_red("/C/A/Yes") == 0.2f);
    assert_true(mesh_red("/C/A/Not") == 0.1f);
    assert_true(mesh_red("/C/B") == 0.2f);
    assert_true(mesh_red("/C/Own/Yes") == 0.2f);
    assert_true(mesh_red("/C/Own/Deep") == 0.1f); // the included collection leaves it out
    assert_true(mesh_red("/C/Out") == 0.1f);
}

// includeRoot takes in all there is but what is excluded; explicitOnly only what it names, be it
// the root.
static void test_expansion_of_collections(void **state)
{
    (void)state;
    open_bound("def Xform 'C' {"
               "  rel material:binding:collection:all = [</C.collection:all>, </M2>];"
               "  bool collection:all:includeRoot = 1;"
               "  rel collection:all:excludes = [</C/Not>];"
               "  def Mesh 'A' { $triangle }"
               "  def Mesh 'Not' { $triangle }"
               "}"
               "def Xform 'E' {"
               "  rel material:binding:collection:few = [</E.collection:few>, </M3>];"
               "  uniform token collection:few:expansionRule = 'explicitOnly';"
               "  bool collection:few:includeRoot = 1;"
               "  rel collection:few:includes = [</E/X>, </E/Named>];"
               "  def Xform 'X' { def Mesh 'Below' { $triangle } }"
               "  def Mesh 'Named' { $triangle }"
               "}");
    assert_true(mesh_red("/C/A") == 0.2f);
    assert_true(mesh_red("/C/Not") == -1.0f);
    assert_true(mesh_red("/E/X/Below") == -1.0f);
    assert_true(mesh_red("/E/Named") == 0.3f);
}

static void test_subsets_have_their_own(void **state)
{
    (void)state;
    open_bound("def Mesh 'A' { $triangle rel material:binding = </M1>;"
               "  def GeomSubset 'S' { int[] indices = [0];"
               "    uniform token elementType = 'face'; uniform token familyName = 'materialBind';"
               "    rel material:binding = </M2> }"
               "}"
               "def Mesh 'B' { $triangle rel material:binding = </M1>;"
               "  def GeomSubset 'Heir' { int[] indices = [0];"
               "    uniform token elementType = 'face'; uniform token familyName = 'materialBind' }"
               "}");
    assert_true(mesh_red("/A") == 0.1f);
    assert_true(red_of(fake_mesh("/A")->subset_material) == 0.2f);
    assert_true(red_of(fake_mesh("/B")->subset_material) == 0.1f);
}

// Collections name prims below an instance by the path of the instance, not of the one whose
// children it shares; nested instances by that of all around them.
static void test_collections_reach_into_instances(void **state)
{
    (void)state;
    open_bound("class Xform 'P' { def Xform 'N' (instanceable = true; inherits = </Q>) {} }"
               "class Xform 'Q' { def Mesh 'A' { $triangle } def Mesh 'B' { $triangle } }"
               "def Xform 'W' {"
               "  rel material:binding:collection:x = [</W.collection:x>, </M1>];"
               "  rel material:binding:collection:y = [</W.collection:y>, </M2>];"
               "  rel collection:x:includes = [</W/I2>];"
               "  rel collection:y:includes = [</W/I3/N/B>];"
               "  def Xform 'I1' (instanceable = true; inherits = </P>) {}"
               "  def Xform 'I2' (instanceable = true; inherits = </P>) {}"
               "  def Xform 'I3' (instanceable = true; inherits = </P>) {}"
               "}");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 3);
    const float want[3][2] = {{-1.0f, -1.0f}, {0.1f, 0.1f}, {-1.0f, 0.2f}};
    for (int i = 0; i < 3; i++) {
        const FakeObject *outer = &fake.objects[root->instances[i].object];
        assert_int_equal(outer->instance_count, 1);
        const FakeObject *nested = &fake.objects[outer->instances[0].object];
        assert_int_equal(nested->instance_count, 2);
        for (int k = 0; k < 2; k++)
            assert_true(red_of(fake.objects[nested->instances[k].object].material) == want[i][k]);
    }
}

// Instances whose parts are bound differently by the places are told apart, others are not.
static void test_instances_by_binding(void **state)
{
    (void)state;
    open_bound("class Xform 'P' { def Mesh 'A' { $triangle } }"
               "def Xform 'One' (instanceable = true; inherits = </P>) {"
               "  rel material:binding = </M1> }"
               "def Xform 'Same' (instanceable = true; inherits = </P>) {"
               "  rel material:binding = </M1> }"
               "def Xform 'Other' (instanceable = true; inherits = </P>) {"
               "  rel material:binding = </M2> }");
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 3);
    assert_int_equal(fake.set_mesh_calls, 2);
    // By path: One, Other, Same.
    assert_int_equal(root->instances[0].object, root->instances[2].object);
    const float want[] = {0.1f, 0.2f};
    for (int i = 0; i < 2; i++) {
        const FakeObject *group = &fake.objects[root->instances[i].object];
        assert_true(red_of(fake.objects[group->instances[0].object].material) == want[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_strength_and_purpose, close_stage),
        cmocka_unit_test_teardown(test_bindings_to_nothing, close_stage),
        cmocka_unit_test_teardown(test_collections, close_stage),
        cmocka_unit_test_teardown(test_collections_beside_direct_bindings, close_stage),
        cmocka_unit_test_teardown(test_strong_collections_win_below, close_stage),
        cmocka_unit_test_teardown(test_collections_of_collections, close_stage),
        cmocka_unit_test_teardown(test_expansion_of_collections, close_stage),
        cmocka_unit_test_teardown(test_subsets_have_their_own, close_stage),
        cmocka_unit_test_teardown(test_collections_reach_into_instances, close_stage),
        cmocka_unit_test_teardown(test_instances_by_binding, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
