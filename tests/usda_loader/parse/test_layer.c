// What a parsed layer holds: specs, fields, every kind of value. Also tests array.c,
// array_edit.c, dictionary.c, layer_metadata.c, listop.c, metadata.c, prim.c, property.c,
// samples.c, spec.c, spline.c, store.c, token.c, types.c and value.c.

#include "usda_loader/parse/support.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static CoLayer *everything;
static const CoSpec *world;

static int load(void **state)
{
    (void)state;
    CohortError err = {0};
    Reports reports = {0};
    everything = co_layer_open(COHORT_TEST_DATA_DIR "/usda/everything.usda", NULL, keep_report,
                               &reports, &err);
    if (!everything) {
        fprintf(stderr, "%u:%u: %s\n", reports.line, reports.column, reports.text);
        return -1;
    }
    world = co_spec_child(everything->root, token("World"));
    return world ? 0 : -1;
}

static int unload(void **state)
{
    (void)state;
    co_layer_destroy(everything);
    return 0;
}

static const CoValue *field(const CoSpec *spec, const char *name)
{
    const CoField *found = co_spec_field(spec, token(name));
    assert_non_null(found);
    return &found->value;
}

static const CoValue *value(const char *name)
{
    const CoSpec *property = co_spec_property(world, token(name));
    assert_non_null(property);
    return field(property, "default");
}

static const CoListOp *list(const CoSpec *spec, const char *name, CohortType type)
{
    const CoValue *found = field(spec, name);
    assert_int_equal(found->type, type);
    return found->data;
}

static const char *text(const CoValue *found)
{
    return ((const CohortString *)found->data)->text;
}

static void layer_metadata(void **state)
{
    (void)state;
    const CoSpec *root = everything->root;
    assert_string_equal(text(field(root, "comment")), "a comment of the layer");
    assert_string_equal(text(field(root, "documentation")), "two\nlines");
    assert_int_equal(field(root, "metersPerUnit")->type, COHORT_TYPE_DOUBLE);
    const CoValue *sublayers = field(root, "subLayers");
    assert_int_equal(sublayers->count, 2);
    const CoArc *arcs = sublayers->data;
    assert_string_equal(arcs[0].asset, "a.usda");
    assert_true(arcs[0].offset == 2.0 && arcs[0].scale == 0.5);
    assert_string_equal(arcs[1].asset, "b@c.usda");
    const CoRelocate *relocates = field(root, "relocates")->data;
    assert_string_equal(relocates[0].target, "/World/B");
    assert_string_equal(relocates[1].target, "");
    const CoDict *data = field(root, "customLayerData")->data;
    assert_int_equal(data->count, 1);
    const CoDict *inner = data->entries[0].value->data;
    assert_string_equal(inner->entries[1].key, "b c");
    assert_int_equal(inner->entries[1].value->count, 2);
}

static void prim_metadata(void **state)
{
    (void)state;
    assert_string_equal(world->type_name, "Xform");
    assert_int_equal(world->line, 23);
    const CoListOp *references = list(world, "references", COHORT_TYPE_REFERENCE_LIST_OP);
    assert_false(references->is_explicit);
    const CoArc *arcs = references->list[CO_LIST_PREPENDED].items;
    assert_int_equal(references->list[CO_LIST_PREPENDED].count, 2);
    assert_string_equal(arcs[0].prim, "/Ref");
    assert_non_null(arcs[0].custom_data);
    assert_string_equal(arcs[1].asset, "");
    assert_int_equal(references->list[CO_LIST_DELETED].count, 1);
    assert_true(list(world, "payload", COHORT_TYPE_PAYLOAD_LIST_OP)->is_explicit);
    const CoListOp *inherits = list(world, "inheritPaths", COHORT_TYPE_PATH_LIST_OP);
    const CohortString *paths = inherits->list[CO_LIST_PREPENDED].items;
    assert_string_equal(paths[0].text, "/_class");
    const CoListOp *ids = list(world, "inactiveIds", COHORT_TYPE_INT64_LIST_OP);
    assert_int_equal(((const int64_t *)ids->list[CO_LIST_PREPENDED].items)[1], -2);
    const CoDict *selection = field(world, "variantSelection")->data;
    assert_string_equal(selection->entries[0].key, "look");
    assert_string_equal(text(selection->entries[0].value), "red");
    assert_string_equal(text(field(world, "unknown")), "[1, \"a\", (2, 3), @x@]");
    assert_int_equal(field(world, "primOrder")->count, 2);
}

static void scalar_values(void **state)
{
    (void)state;
    assert_true(*(const bool *)value("flag")->data);
    assert_int_equal(*(const uint8_t *)value("u")->data, 255);
    assert_true(*(const int64_t *)value("big")->data == INT64_MIN);
    assert_true(*(const uint64_t *)value("huge")->data == UINT64_MAX);
    assert_int_equal(*(const uint16_t *)value("h")->data, 0x2e66);
    assert_true(*(const float *)value("f")->data == 0.1f);
    assert_true(*(const double *)value("d")->data == 0.1);
    assert_true(*(const double *)value("tiny")->data == 4.9406564584124654e-324);
    assert_string_equal(text(value("s")), "it's \"quoted\"\ttab");
    assert_string_equal(text(value("file")), "./a b.png");
    const float *q = value("q")->data;
    assert_true(q[0] == 2 && q[1] == 3 && q[2] == 4 && q[3] == 1);
    assert_true(((const double *)value("m")->data)[2] == 3.0);
    assert_int_equal(value("blocked")->type, COHORT_TYPE_BLOCK);
    assert_string_equal(text(value("strange")), "(1, bar)");
}

static void array_values(void **state)
{
    (void)state;
    const uint16_t *halves = value("hs")->data;
    assert_int_equal(halves[1], 0x7bff);
    assert_int_equal(halves[2], 0x7c00);
    assert_int_equal(halves[3], 0x8000);
    const CoValue *points = value("points");
    assert_int_equal(points->type, COHORT_TYPE_POINT3F);
    assert_true(points->is_array);
    assert_int_equal(points->count, 3);
    const float *p = points->data;
    assert_true(p[4] == -1.5f && p[5] == 2e-3f && isnan(p[6]) && isinf(p[8]) && p[8] < 0);
    const int32_t *nested = value("nested")->data;
    assert_int_equal(value("nested")->count, 4);
    assert_int_equal(nested[3], 4);
    assert_int_equal(value("empty")->count, 0);
    assert_int_equal(value("files")->count, 2);
    assert_int_equal(value("ms")->count, 1);
    const CoArrayEdit *edit = value("edited")->data;
    assert_int_equal(value("edited")->type, COHORT_TYPE_ARRAY_EDIT);
    assert_int_equal(edit->count, 5);
    assert_int_equal(edit->items[1].source, 0);
    assert_int_equal(edit->items[1].at_or_size, -1);
    assert_non_null(edit->items[4].literal);
}

static void samples_are_sorted_and_the_last_wins(void **state)
{
    (void)state;
    const CoSpec *property = co_spec_property(world, token("value"));
    const CoTimeSamples *samples = field(property, "timeSamples")->data;
    assert_int_equal(samples->count, 3);
    assert_true(samples->times[0] == -1 && samples->times[1] == 0.5 && samples->times[2] == 1);
    assert_int_equal(samples->values[1].type, COHORT_TYPE_BLOCK);
    assert_true(*(const double *)samples->values[2].data == 7.0);
    const CoSpline *spline = field(co_spec_property(world, token("curve")), "spline")->data;
    assert_int_equal(spline->count, 2);
    assert_string_equal(spline->post.mode, "loop oscillate");
    assert_true(spline->knots[1].has_pre_value && spline->knots[1].pre_value == 9.5);
}

static void paths_are_absolute(void **state)
{
    (void)state;
    const CoSpec *target = co_spec_property(world, token("target"));
    const CoListOp *op = list(target, "targetPaths", COHORT_TYPE_PATH_LIST_OP);
    const CohortString *paths = op->list[CO_LIST_EXPLICIT].items;
    assert_string_equal(paths[0].text, "/World/Mesh");
    assert_string_equal(paths[1].text, "/Elsewhere.prop");
    assert_string_equal(paths[2].text, "/Sibling");
    op = list(co_spec_property(world, token("in")), "connectionPaths", COHORT_TYPE_PATH_LIST_OP);
    assert_false(op->is_explicit); // the deletion came after the whole list
    paths = op->list[CO_LIST_DELETED].items;
    assert_string_equal(paths[0].text, "/World.old");
    assert_string_equal(paths[1].text, "/World/Mesh.older");
}

static void variants_nest(void **state)
{
    (void)state;
    assert_int_equal(world->contents->variant_set_count, 1);
    const CoSpec *set = world->contents->variant_sets[0];
    assert_int_equal(set->contents->child_count, 2);
    const CoSpec *red = set->contents->children[0];
    assert_int_equal(red->kind, CO_SPEC_VARIANT);
    assert_string_equal(text(field(red, "kind")), "group");
    const CoListOp *op =
        list(co_spec_property(red, token("r")), "targetPaths", COHORT_TYPE_PATH_LIST_OP);
    assert_string_equal(((const CohortString *)op->list[0].items)->text, "/World/Inside");
    assert_string_equal(red->contents->variant_sets[0]->contents->children[1]->name, "small-1|x");
}

static void an_attribute_spoken_of_as_a_relationship_stays_one(void **state)
{
    (void)state;
    static const char source[] = "#usda 1.0\ndef \"A\" {\n double a = 1\n rel a = </A>\n}\n";
    Reports reports;
    CohortError err;
    CoLayer *layer = parse_bytes(source, sizeof source - 1, NULL, &reports, &err);
    assert_non_null(layer);
    const CoSpec *a = co_spec_property(co_spec_child(layer->root, token("A")), token("a"));
    assert_int_equal(a->kind, CO_SPEC_ATTRIBUTE);
    assert_true(a->is_uniform);
    assert_string_equal(a->type_name, "double");
    co_layer_destroy(layer);
}

static void a_type_may_be_metadata(void **state)
{
    (void)state;
    static const char source[] = "#usda 1.0\ndef Mesh \"A\" (\n typeName = \"Xform\"\n)\n{\n}\n";
    Reports reports;
    CohortError err;
    CoLayer *layer = parse_bytes(source, sizeof source - 1, NULL, &reports, &err);
    assert_non_null(layer);
    assert_string_equal(co_spec_child(layer->root, token("A"))->type_name, "Xform");
    co_layer_destroy(layer);
}

static void long_lists_are_found_by_name(void **state)
{
    (void)state;
    char *source = malloc(200000);
    assert_non_null(source);
    size_t length = (size_t)sprintf(source, "#usda 1.0\n");
    for (int i = 0; i < 3000; i++)
        length += (size_t)sprintf(source + length, "def \"p%d\" {}\n", i);
    Reports reports;
    CohortError err;
    CoLayer *layer = parse_bytes(source, length, NULL, &reports, &err);
    assert_non_null(layer);
    for (int i = 0; i < 3000; i += 7) {
        char name[16];
        snprintf(name, sizeof name, "p%d", i);
        assert_ptr_equal(co_spec_child(layer->root, token(name)),
                         layer->root->contents->children[i]);
    }
    assert_null(co_spec_child(layer->root, token("p3000")));
    co_layer_destroy(layer);
    length += (size_t)sprintf(source + length, "def \"p1234\" {}\n");
    assert_null(parse_bytes(source, length, NULL, &reports, &err));
    assert_int_equal(reports.line, 3002);
    free(source);
}

static void type_names(void **state)
{
    (void)state;
    for (CohortType type = COHORT_TYPE_BOOL; type <= COHORT_TYPE_TEXCOORD3D; type++) {
        CohortType found;
        bool is_array;
        const char *name = co_type_name(type);
        assert_true(co_type_from_name(name, strlen(name), &found, &is_array));
        assert_int_equal(found, type);
        assert_true(co_type_size(type) > 0);
    }
    assert_int_equal(co_type_size(COHORT_TYPE_POINT3F), 12);
    assert_int_equal(co_type_size(COHORT_TYPE_MATRIX4D), 128);
    CohortType found;
    bool is_array;
    assert_true(co_type_from_name("PointFloat[]", 12, &found, &is_array));
    assert_int_equal(found, COHORT_TYPE_POINT3F);
    assert_true(is_array);
    assert_false(co_type_from_name("dictionary", 10, &found, &is_array));
    assert_false(co_type_from_name("opaque[]", 8, &found, &is_array));
    assert_ptr_equal(token("abc"), token("abc"));
    assert_ptr_not_equal(token("abc"), token("abd"));
}

// More names in one place than are searched in order, each said twice.
static void many_names_are_told_apart(void **state)
{
    (void)state;
    enum {
        COUNT = 500
    };
    size_t room = 64 * COUNT * 4, used = 0;
    char *text = malloc(room);
    assert_non_null(text);
    used += (size_t)snprintf(text, room, "#usda 1.0\ndef \"A\" (\n");
    for (int i = 0; i < 2 * COUNT; i++)
        used += (size_t)snprintf(text + used, room - used, "f%d = %d\n", i % COUNT, i);
    used += (size_t)snprintf(text + used, room - used, ") {\n");
    for (int i = 0; i < 2 * COUNT; i++)
        used += (size_t)snprintf(text + used, room - used, "variantSet \"s%d\" = { \"v%d\" {} }\n",
                                 i % COUNT, i);
    used += (size_t)snprintf(text + used, room - used, "}\n");
    Reports reports;
    CohortError err;
    CoLayer *layer = parse_bytes(text, used, NULL, &reports, &err);
    free(text);
    assert_non_null(layer);
    const CoSpec *prim = co_spec_child(layer->root, token("A"));
    assert_int_equal(prim->field_count, COUNT);
    const CoContents *in = co_spec_contents(prim);
    assert_int_equal(in->variant_set_count, COUNT);
    for (int i = 0; i < COUNT; i++) {
        char name[16], said[16];
        snprintf(name, sizeof name, "f%d", i);
        snprintf(said, sizeof said, "%d", i + COUNT);
        const CoField *field = co_spec_field(prim, token(name));
        assert_non_null(field);
        assert_string_equal(((const CohortString *)field->value.data)->text, said);
        const CoContents *set = co_spec_contents(in->variant_sets[i]);
        assert_int_equal(set->child_count, 1);
        assert_int_equal(strtol(set->children[0]->name + 1, NULL, 10), i + COUNT);
    }
    co_layer_destroy(layer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layer_metadata),
        cmocka_unit_test(prim_metadata),
        cmocka_unit_test(scalar_values),
        cmocka_unit_test(array_values),
        cmocka_unit_test(samples_are_sorted_and_the_last_wins),
        cmocka_unit_test(paths_are_absolute),
        cmocka_unit_test(variants_nest),
        cmocka_unit_test(an_attribute_spoken_of_as_a_relationship_stays_one),
        cmocka_unit_test(a_type_may_be_metadata),
        cmocka_unit_test(long_lists_are_found_by_name),
        cmocka_unit_test(many_names_are_told_apart),
        cmocka_unit_test(type_names),
    };
    return cmocka_run_group_tests(tests, load, unload);
}
