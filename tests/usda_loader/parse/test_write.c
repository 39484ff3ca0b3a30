// Writing: shortest numbers, and that what is written reads back as what was read. Also tests
// format.c, opaque.c, write_field.c, write_layer.c and write_value.c.

#include "usda_loader/parse/support.h"

#include "base/hash.h"
#include "lex/number.h"
#include "parse/writer.h"

#include <fcntl.h>
#include <math.h>

static void numbers_are_short(void **state)
{
    (void)state;
    static const struct {
        double value;
        const char *text;
    } cases[] = {
        {0.0, "0"},
        {-0.0, "-0"},
        {0.1, "0.1"},
        {1e22, "1e22"},
        {1e16, "10000000000000000"},
        {1e-7, "1e-7"},
        {123456789, "123456789"},
        {0.0001, "0.0001"},
        {1.0 / 3.0, "0.3333333333333333"},
        {-1.5e300, "-1.5e300"},
        {5e-324, "5e-324"},
        {HUGE_VAL, "inf"},
        {-HUGE_VAL, "-inf"},
        {(double)NAN, "nan"},
        {100, "100"},
    };
    char text[CO_NUMBER_TEXT];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t length = co_format_double(cases[i].value, text);
        assert_string_equal(text, cases[i].text);
        assert_int_equal(length, strlen(text));
    }
    co_format_float(0.1f, text);
    assert_string_equal(text, "0.1");
    co_format_float(16777216.0f, text);
    assert_string_equal(text, "16777216");
    co_format_half(0x2e66, text);
    assert_string_equal(text, "0.1");
    co_format_half(0x7bff, text);
    assert_string_equal(text, "65504");
}

static void numbers_read_back_and_no_shorter_ones_do(void **state)
{
    (void)state;
    char text[CO_NUMBER_TEXT], shorter[64];
    for (uint64_t i = 0; i < 20000; i++) {
        uint64_t bits = co_hash64(i);
        uint32_t low = (uint32_t)bits;
        double value;
        float single;
        memcpy(&value, &bits, sizeof value);
        memcpy(&single, &low, sizeof single);
        if (isfinite(value)) {
            co_format_double(value, text);
            assert_true(strtod(text, NULL) == value);
        }
        if (!isfinite(single))
            continue;
        co_format_float(single, text);
        assert_true((float)strtod(text, NULL) == single);
        int digits = 0;
        for (const char *p = text; *p && *p != 'e'; p++)
            digits += *p >= '0' && *p <= '9';
        if (strchr(text, 'e') && digits > 1) {
            snprintf(shorter, sizeof shorter, "%.*e", digits - 2, (double)single);
            assert_true((float)strtod(shorter, NULL) != single);
        }
    }
    for (uint32_t half = 0; half < 0x7c00; half++) {
        co_format_half((uint16_t)half, text);
        assert_int_equal(co_half_from_float((float)strtod(text, NULL)), half);
    }
}

// ---- Equality of layers ------------------------------------------------------------------------

static void same_value(const CoValue *a, const CoValue *b);

static void same_dict(const CoDict *a, const CoDict *b)
{
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; i++) {
        assert_ptr_equal(a->entries[i].key, b->entries[i].key);
        same_value(a->entries[i].value, b->entries[i].value);
    }
}

static void same_list(const CoListOp *a, const CoListOp *b)
{
    assert_int_equal(a->is_explicit, b->is_explicit);
    for (int i = 0; i < CO_LIST_KIND_COUNT; i++)
        assert_int_equal(a->list[i].count, b->list[i].count);
}

static void same_strings(const CohortString *a, const CohortString *b, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(a[i].length, b[i].length);
        assert_memory_equal(a[i].text, b[i].text, a[i].length);
    }
}

static void same_value(const CoValue *a, const CoValue *b)
{
    assert_int_equal(a->type, b->type);
    assert_int_equal(a->is_array, b->is_array);
    assert_int_equal(a->count, b->count);
    const CoTypeInfo *info = co_type_info(a->type);
    if (a->type == COHORT_TYPE_DICTIONARY || a->type == COHORT_TYPE_VARIANT_SELECTION) {
        same_dict(a->data, b->data);
    } else if (a->type == COHORT_TYPE_TIME_SAMPLES) {
        const CoTimeSamples *x = a->data, *y = b->data;
        assert_int_equal(x->count, y->count);
        for (size_t i = 0; i < x->count; i++) {
            assert_true(x->times[i] == y->times[i]);
            same_value(&x->values[i], &y->values[i]);
        }
    } else if (a->type >= COHORT_TYPE_TOKEN_LIST_OP && a->type <= COHORT_TYPE_PAYLOAD_LIST_OP) {
        same_list(a->data, b->data);
    } else if (info->scalar >= CO_SCALAR_STRING ||
               (a->type == COHORT_TYPE_OPAQUE && !a->is_array)) {
        same_strings(a->data, b->data, a->count);
    } else if (info->scalar) {
        assert_memory_equal(a->data, b->data, a->count * co_type_size(a->type));
    }
}

static void same_spec(const CoSpec *a, const CoSpec *b)
{
    assert_int_equal(a->kind, b->kind);
    assert_ptr_equal(a->name, b->name);
    assert_ptr_equal(a->type_name, b->type_name);
    assert_int_equal(a->specifier, b->specifier);
    assert_true(a->is_custom == b->is_custom && a->is_uniform == b->is_uniform);
    assert_int_equal(a->field_count, b->field_count);
    for (size_t i = 0; i < a->field_count; i++) {
        const CoField *other = co_spec_field(b, a->fields[i].name);
        assert_non_null(other);
        same_value(&a->fields[i].value, &other->value);
    }
    const CoContents *in = co_spec_contents(a), *other = co_spec_contents(b);
    assert_int_equal(in->child_count, other->child_count);
    assert_int_equal(in->property_count, other->property_count);
    assert_int_equal(in->variant_set_count, other->variant_set_count);
    for (size_t i = 0; i < in->child_count; i++)
        same_spec(in->children[i], other->children[i]);
    for (size_t i = 0; i < in->property_count; i++)
        same_spec(in->properties[i], other->properties[i]);
    for (size_t i = 0; i < in->variant_set_count; i++)
        same_spec(in->variant_sets[i], other->variant_sets[i]);
}

static void a_layer_survives_and_is_written_the_same_twice(void **state)
{
    (void)state;
    static const char in[] = COHORT_TEST_DATA_DIR "/usda/everything.usda";
    const char *once = in_folder("once.usda"), *twice = in_folder("twice.usda");
    CohortError err = {0};
    assert_true(cohort_layer_cat(in, once, NULL, &err));
    assert_true(cohort_layer_cat(once, twice, NULL, &err));
    size_t first_size, second_size;
    char *first = test_read_file(once, &first_size);
    char *second = test_read_file(twice, &second_size);
    assert_true(first && second);
    assert_int_equal(first_size, second_size);
    assert_memory_equal(first, second, first_size);
    CoLayer *original = co_layer_open(in, NULL, NULL, NULL, &err);
    CoLayer *written = co_layer_open(once, NULL, NULL, NULL, &err);
    assert_non_null(original);
    assert_non_null(written);
    same_spec(original->root, written->root);
    co_layer_destroy(original);
    co_layer_destroy(written);
    free(first);
    free(second);
}

// Values of a kind that the field or type is not made for, as far as the reference takes them.
static void what_is_unusual_is_kept(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"( active = yes )\n", "active = yes\n"}, // of prims, so unknown here
        {"def \"A\" ( active = yes )\n{}\n", "active = true\n"},
        {"def \"A\" ( active = </B> )\n{}\n", "active = </B>\n"},
        {"def \"A\" ( doc = \"a\"\n documentation = { int b = 1 } )\n{}\n", "documentation = {\n"},
        {"def \"A\" ( defaultPrim = [1, a] )\n{}\n", "defaultPrim = [1, a]\n"},
        {"( add active = [true] )\n", "add active = [true]\n"},
        {"( inheritPaths = 1 )\n", "inheritPaths = 1\n"},
        {"def \"A\" {\n int a ( primOrder = \"b\" )\n}\n", "primOrder = \"b\"\n"},
        {"def \"A\" ( prepend apiSchemas = [\"a\"]\n append apiSchemas = [\"b\", \"b\"] )\n{}\n",
         "(\n    prepend apiSchemas = [\"a\"]\n)"},
        {"def \"A\" ( prepend apiSchemas = [\"a\"]\n prepend apiSchemas = None )\n{}\n",
         "(\n    add apiSchemas = None\n)"},
        {"def \"A\" {\n rel r\n varying rel r = </B>\n}\n", "varying rel r = "},
        {"def \"A\" {\n rel r = </B>\n rel r[</C>]\n}\n", "rel r = [</B>]\n"},
        {"def \"A\" {\n int a = 1\n rel a = [</B>, </C>]\n}\n", "rel a = [</B>, </C>]\n"},
        {"def \"A\" {\n double x.spline = { bezier, pre: sloped(2), loop: (1, 3, 0, 2, 0.5), 1: 5, "
         "3: 7 }\n}\n",
         "loop: (1, 3, 0, 2, 0.5),\n"},
        {"def \"A\" ( customData = { int a = <../../../B> } )\n{}\n", " a = <../../../B>\n"},
        {"( relocates = { </A/B>: <../C> } )\n", "</A/B>: <>,\n"},
        {"def \"A\\0B\" {\n}\n", "def \"A\"\n"},
        {"def \"A\" {\n int[] a = <../../..>\n}\n", "int[] a = <../../..>\n"},
        {"def \"A\" {\n zork a.timeSamples = { 0: </B>, 1: 2, 2: None }\n}\n", "1: 2,\n"},
    };
    const char *in = in_folder("in.usda"), *out = in_folder("out.usda");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        CohortError err = {0};
        size_t size;
        char whole[512];
        snprintf(whole, sizeof whole, "#usda 1.0\n%s", cases[i].text);
        test_write_text(in, whole);
        if (!cohort_layer_cat(in, out, NULL, &err))
            fail_msg("%s: %s", cases[i].text, err.message);
        char *text = test_read_file(out, &size);
        if (!text || !strstr(text, cases[i].says))
            fail_msg("%s became %s", cases[i].text, text ? text : "nothing");
        free(text);
    }
}

static void strings_survive(void **state)
{
    (void)state;
    char source[2048] = "#usda 1.0\ndef \"A\" {\n string s = \"";
    for (int c = 1; c < 256; c++) {
        char escape[8];
        snprintf(escape, sizeof escape, "\\x%02x", (unsigned)c);
        strcat(source, escape);
    }
    strcat(source, "\"\n asset a = @@@x@@y\\@@@z@@@\n}\n");
    Reports reports;
    CohortError err;
    CoLayer *layer = parse_bytes(source, strlen(source), NULL, &reports, &err);
    assert_non_null(layer);
    const char *path = in_folder("strings.usda");
    assert_true(co_layer_write(layer, path, &err));
    CoLayer *back = co_layer_open(path, NULL, NULL, NULL, &err);
    assert_non_null(back);
    same_spec(layer->root, back->root);
    co_layer_destroy(layer);
    co_layer_destroy(back);
}

static void a_file_is_replaced_whole(void **state)
{
    (void)state;
    CohortError err = {0};
    const char *path = in_folder("old.usda");
    char beside[400];
    test_write_text(path, "old");
    int fd = open(path, O_RDONLY);
    assert_true(fd >= 0);
    assert_true(cohort_layer_cat(COHORT_TEST_DATA_DIR "/usda/everything.usda", path, NULL, &err));
    struct stat old, new;
    assert_int_equal(fstat(fd, &old), 0);
    assert_int_equal(stat(path, &new), 0);
    assert_int_equal(old.st_size, 3); // who has it open keeps what was there
    assert_int_equal(old.st_nlink, 0);
    assert_true(new.st_size > 100);
    snprintf(beside, sizeof beside, "%s.%ld.tmp", path, (long)getpid());
    assert_int_not_equal(access(beside, F_OK), 0);
    close(fd);
}

static void a_place_that_cannot_be_written_is_named(void **state)
{
    (void)state;
    CohortError err = {0};
    static const char in[] = COHORT_TEST_DATA_DIR "/usda/everything.usda";
    assert_false(cohort_layer_cat(in, "/nowhere/out.usda", NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    assert_string_equal(err.file, "/nowhere/out.usda");
    err = (CohortError){0};
    assert_false(cohort_layer_cat(in, "/dev/full", NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    err = (CohortError){0};
    assert_false(cohort_layer_cat(NULL, NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_short),
        cmocka_unit_test(numbers_read_back_and_no_shorter_ones_do),
        cmocka_unit_test(a_layer_survives_and_is_written_the_same_twice),
        cmocka_unit_test(what_is_unusual_is_kept),
        cmocka_unit_test(strings_survive),
        cmocka_unit_test(a_file_is_replaced_whole),
        cmocka_unit_test(a_place_that_cannot_be_written_is_named),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
