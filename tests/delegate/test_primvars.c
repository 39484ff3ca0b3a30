// Primvars from stage to mesh: which are read, their lengths and indices, and what is inherited.

#include "stage_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

// The primvar of a mesh by name; NULL: it has none.
static const FakePrimvar *primvar(const char *path, const char *name)
{
    const FakeObject *mesh = fake_mesh(path);
    assert_non_null(mesh);
    for (size_t i = 0; i < mesh->primvar_count; i++)
        if (strcmp(mesh->primvars[i].name, name) == 0)
            return &mesh->primvars[i];
    return NULL;
}

static void test_only_what_is_read_is_taken(void **state)
{
    (void)state;
    open_stage("def Mesh 'M' { $triangle"
               "  uniform token subdivisionScheme = 'none';"
               "  normal3f[] normals = [(0,0,1),(0,0,1),(0,0,1)];"
               "  color3f[] primvars:displayColor = [(1,0,0)];"
               "  texCoord2f[] primvars:st = [(0,0),(1,0),(0,1)] (interpolation = 'vertex');"
               "  float2[] primvars:unused = [(0,0)];"
               "  string primvars:displayOpacity = 'none'"
               "}");
    assert_int_equal(fake_mesh("/M")->primvar_count, 3);
    const FakePrimvar *normals = primvar("/M", "normals");
    assert_non_null(normals);
    assert_int_equal(normals->interpolation, COHORT_INTERPOLATION_VERTEX); // the attribute's own
    assert_int_equal(primvar("/M", "displayColor")->interpolation, COHORT_INTERPOLATION_CONSTANT);
    assert_int_equal(primvar("/M", "st")->components, 2);
}

// primvars:normals beats normals; subdivision makes its own.
static void test_normals(void **state)
{
    (void)state;
    open_stage("def Mesh 'Both' { $triangle uniform token subdivisionScheme = 'none';"
               "  normal3f[] normals = [(0,0,1),(0,0,1),(0,0,1)];"
               "  normal3f[] primvars:normals = [(1,0,0)] (interpolation = 'uniform') }"
               "def Mesh 'Smooth' { $triangle normal3f[] normals = [(0,0,1),(0,0,1),(0,0,1)] }");
    assert_int_equal(fake_mesh("/Both")->primvar_count, 1);
    assert_true(primvar("/Both", "normals")->first[0] == 1.0f);
    assert_int_equal(primvar("/Both", "normals")->interpolation, COHORT_INTERPOLATION_UNIFORM);
    assert_int_equal(fake_mesh("/Smooth")->primvar_count, 0);
}

// A triangle has 1 face, 3 points and 3 corners. Too much is cut, too little left out; both named.
static void test_lengths(void **state)
{
    (void)state;
    static const struct {
        const char *interpolation;
        size_t expected;
    } cases[] = {
        {"constant", 1}, {"uniform", 1}, {"varying", 3}, {"vertex", 3}, {"faceVarying", 3}};
    for (size_t i = 0; i < 5; i++)
        for (size_t count = 0; count < 5; count++) {
            char body[256], values[64] = "";
            for (size_t k = 0; k < count; k++)
                strcat(values, k ? ", (0,0)" : "(0,0)");
            snprintf(body, sizeof body,
                     "def Mesh 'M' { $triangle float2[] primvars:st = [%s] (interpolation = '%s') "
                     "}",
                     values, cases[i].interpolation);
            open_stage(body);
            const FakePrimvar *st = primvar("/M", "st");
            assert_int_equal(st != NULL, count >= cases[i].expected);
            if (st)
                assert_int_equal(st->value_count, cases[i].expected);
            assert_int_equal(is_reported("/M", "primvars:st"),
                             count > 0 && count != cases[i].expected);
            if (i != 4 || count != 4)
                close_stage(NULL);
        }
}

// With indices their number is what must fit; elementSize is not supported, and says so.
static void test_indices_and_element_size(void **state)
{
    (void)state;
    open_stage("def Mesh 'Fit' { $triangle"
               "  float2[] primvars:st = [(5,6)] (interpolation = 'faceVarying');"
               "  int[] primvars:st:indices = [0, 0, 0] }"
               "def Mesh 'Few' { $triangle"
               "  float2[] primvars:st = [(0,0),(0,0),(0,0)] (interpolation = 'faceVarying');"
               "  int[] primvars:st:indices = [0, 0] }"
               "def Mesh 'Group' { $triangle"
               "  float2[] primvars:st = [(0,0),(0,0)] (elementSize = 2) }");
    assert_int_equal(primvar("/Fit", "st")->index_count, 3);
    assert_int_equal(primvar("/Fit", "st")->value_count, 1);
    assert_null(primvar("/Few", "st"));
    assert_true(is_reported("/Few", "primvars:st"));
    assert_null(primvar("/Group", "st"));
    assert_true(is_reported("/Group", "primvars:st"));
}

// Constant ones come down, the nearest first; others stay where they are.
static void test_inheritance(void **state)
{
    (void)state;
    open_stage("def Xform 'A' {"
               "  color3f[] primvars:displayColor = [(1,0,0)];"
               "  float[] primvars:displayOpacity = [0.5] (interpolation = 'constant');"
               "  float2[] primvars:st = [(0,0),(0,0),(0,0)] (interpolation = 'vertex');"
               "  def Xform 'B' { color3f[] primvars:displayColor = [(0,1,0)];"
               "    def Mesh 'Heir' { $triangle }"
               "    def Mesh 'Own' { $triangle color3f[] primvars:displayColor = [(0,0,1)] }"
               "  }"
               "}");
    assert_int_equal(fake_mesh("/A/B/Heir")->primvar_count, 2);
    assert_true(primvar("/A/B/Heir", "displayColor")->first[1] == 1.0f);
    assert_true(primvar("/A/B/Heir", "displayOpacity")->first[0] == 0.5f);
    assert_true(primvar("/A/B/Own", "displayColor")->first[2] == 1.0f);
    assert_null(primvar("/A/B/Own", "st"));
}

// A constant color above the target of a PointInstancer is the meshes' own, on the instancer and
// above it too; one beyond a native instance is left to its placement.
static void test_colors_come_into_prototypes(void **state)
{
    (void)state;
    open_stage("def Xform 'A' { color3f[] primvars:displayColor = [(1,0,0)];"
               "  def PointInstancer 'PI' {"
               "    rel prototypes = [</A/PI/T>]; int[] protoIndices = [0];"
               "    point3f[] positions = [(1,0,0)];"
               "    def Xform 'T' { def Mesh 'M' { $triangle }"
               "      def Xform 'I' (instanceable = true; inherits = </C>) {} }"
               "  }"
               "  def PointInstancer 'Own' { color3f[] primvars:displayColor = [(0,1,0)];"
               "    rel prototypes = [</A/Own/M>]; int[] protoIndices = [0];"
               "    point3f[] positions = [(1,0,0)];"
               "    def Mesh 'M' { $triangle }"
               "  }"
               "}"
               "class Xform 'C' { def Mesh 'M' { $triangle } }");
    assert_true(primvar("/A/PI/T/M", "displayColor")->first[0] == 1.0f);
    assert_true(primvar("/A/Own/M", "displayColor")->first[1] == 1.0f);
    assert_null(primvar("/A/PI/T/I/M", "displayColor"));
    bool is_handed_down = false;
    for (size_t i = 0; i < fake.object_count; i++)
        for (size_t k = 0; k < fake.objects[i].instance_count; k++)
            is_handed_down = is_handed_down || (fake.objects[i].instances[k].display_color &&
                                                fake.objects[i].colors[k][0] == 1.0f);
    assert_true(is_handed_down);
}

// Halves and doubles arrive as floats.
static void test_precisions(void **state)
{
    (void)state;
    open_stage("def Mesh 'H' { $triangle texCoord2h[] primvars:st = [(0.5,0.25)] }"
               "def Mesh 'D' { $triangle texCoord2d[] primvars:st = [(0.5,1e300)] }"
               "def Mesh 'M' { $triangle matrix4d[] primvars:st = [((1,0,0,0),(0,1,0,0),"
               "(0,0,1,0),(0,0,0,1))] }");
    assert_true(primvar("/H", "st")->first[1] == 0.25f);
    assert_true(primvar("/D", "st")->first[0] == 0.5f);
    assert_null(primvar("/M", "st"));
}

// An opaque one would only make rays ask.
static void test_opacity_that_is_none(void **state)
{
    (void)state;
    open_stage("def Mesh 'Opaque' { $triangle float[] primvars:displayOpacity = [1] }"
               "def Mesh 'Glass' { $triangle float[] primvars:displayOpacity = [0.5] }");
    assert_null(primvar("/Opaque", "displayOpacity"));
    assert_non_null(primvar("/Glass", "displayOpacity"));
}

#define READER(name, extra) \
    "def Material '" name "' { token outputs:surface.connect = </" name "/S.outputs:surface>;" \
    "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface';" \
    "    color3f inputs:diffuseColor.connect = </" name "/R.outputs:result>;" \
    "    token outputs:surface }" \
    "  def Shader 'R' { uniform token info:id = 'UsdPrimvarReader_float3';" \
    "    string inputs:varname = 'tint'; " extra " float3 outputs:result } }"

// A mesh that lacks what its material reads is named, also where only a subset has that material.
static void test_missing_primvars_are_named(void **state)
{
    (void)state;
    open_stage(READER("M", "") READER(
        "Safe", "float3 inputs:fallback = (1,0,0);") "def Mesh 'Has' { $triangle rel "
                                                     "material:binding = </M>;"
                                                     "  color3f[] primvars:tint = [(1,0,0)] }"
                                                     "def Mesh 'Lacks' { $triangle rel "
                                                     "material:binding = </M> }"
                                                     "def Mesh 'Unbound' { $triangle }"
                                                     "def Mesh 'FallsBack' { $triangle rel "
                                                     "material:binding = </Safe> }"
                                                     "def Mesh 'Part' { $triangle def GeomSubset "
                                                     "'P' { int[] indices = [0];"
                                                     "  uniform token elementType = 'face'; "
                                                     "uniform token familyName = 'materialBind';"
                                                     "  rel material:binding = </M> } }");
    assert_true(is_reported("/Lacks", "primvars:tint"));
    assert_true(is_reported("/Part", "primvars:tint"));
    const CohortReportEntry *entries;
    assert_int_equal(cohort_delegate_report(stage.delegate, &entries), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_only_what_is_read_is_taken, close_stage),
        cmocka_unit_test_teardown(test_normals, close_stage),
        cmocka_unit_test_teardown(test_lengths, close_stage),
        cmocka_unit_test_teardown(test_indices_and_element_size, close_stage),
        cmocka_unit_test_teardown(test_colors_come_into_prototypes, close_stage),
        cmocka_unit_test_teardown(test_inheritance, close_stage),
        cmocka_unit_test_teardown(test_precisions, close_stage),
        cmocka_unit_test_teardown(test_opacity_that_is_none, close_stage),
        cmocka_unit_test_teardown(test_missing_primvars_are_named, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
