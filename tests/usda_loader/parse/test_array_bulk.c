// Long arrays are read in blocks by several threads: what they hold, and what is reported of
// them, must be what one loop over the text finds. Also tests array_plain.c.

#include "usda_loader/parse/support.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

enum {
    ELEMENTS = 60000,
    TEXT_BYTES = 4 << 20
};

typedef struct Sample {
    const char *type, *before, *after; // what stands around an element's number
    const char *head; // an element that no loop takes, behind which one loop reads the rest
    size_t size;
} Sample;

static const Sample samples[] = {
    {"int", "", "", "1e0", 4},
    {"float", "", ".0625", "nan", 4},
    {"double", "-", ".123456789012", "nan", 8},
    {"half2", "(", ", 2.5)", "(nan, 0)", 4},
    {"point3f", "(", ".5, -0.25,\n 1e2)", "(0, nan, 0)", 12},
    {"double4", "( ", ", 1 ,2, 3.75 )", "(0, 0, 0, nan)", 32},
};

// An array of ELEMENTS elements, the one of number `at` replaced.
static size_t write_array(char *text, const Sample *sample, const char *head, size_t at,
                          const char *odd)
{
    size_t length =
        (size_t)sprintf(text, "#usda 1.0\ndef \"A\"\n{\n    %s[] a = [%s\n", sample->type, head);
    for (size_t i = 0; i < ELEMENTS; i++) {
        int number = (int)(i * 37 % 100000);
        if (i)
            length += (size_t)sprintf(text + length, i % 7 ? ", " : ",\n    ");
        length += i == at ? (size_t)sprintf(text + length, "%s", odd)
                          : (size_t)sprintf(text + length, "%s%d%s", sample->before, number,
                                            sample->after);
    }
    return length + (size_t)sprintf(text + length, "]\n}\n");
}

static const CoValue *value_of(const CoLayer *layer)
{
    const CoSpec *prim = co_spec_child(layer->root, token("A"));
    const CoSpec *attribute = prim ? co_spec_property(prim, token("a")) : NULL;
    const CoField *field = attribute ? co_spec_field(attribute, token("default")) : NULL;
    assert_non_null(field);
    return &field->value;
}

static CoLayer *parse_with(const char *text, size_t size, uint32_t threads, Reports *reports)
{
    CohortError err;
    const CohortStageOptions options = {.threads = threads};
    return parse_bytes(text, size, &options, reports, &err);
}

static void assert_same(const CoLayer *layer, const Reports *reports, const CoLayer *other,
                        const Reports *others, size_t skipped, size_t size)
{
    assert_int_equal(!layer, !other);
    assert_int_equal(reports->count, others->count);
    assert_int_equal(reports->line, others->line);
    assert_int_equal(reports->column, others->column);
    assert_string_equal(reports->text, others->text);
    if (!layer)
        return;
    const CoValue *a = value_of(layer), *b = value_of(other);
    assert_int_equal(a->count + skipped, b->count);
    assert_memory_equal(a->data, (const char *)b->data + skipped * size, a->count * size);
}

// One loop reads the array with a head before it; blocks and threads must agree with that.
static void compare(const Sample *sample, size_t at, const char *odd)
{
    char *text = malloc(TEXT_BYTES), head[64];
    Reports expected, reports;
    assert_non_null(text);
    snprintf(head, sizeof head, "%s,", sample->head);
    CoLayer *one = parse_with(text, write_array(text, sample, head, at, odd), 1, &expected);
    size_t size = write_array(text, sample, "", at, odd);
    for (uint32_t threads = 1; threads <= 4; threads++) {
        CoLayer *layer = parse_with(text, size, threads, &reports);
        assert_same(layer, &reports, one, &expected, 1, sample->size);
        co_layer_destroy(layer);
    }
    co_layer_destroy(one);
    free(text);
}

static void plain_arrays_are_the_same(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof samples / sizeof *samples; i++)
        compare(&samples[i], ELEMENTS, "");
}

static void oddities_are_judged_in_their_place(void **state)
{
    (void)state;
    static const char *const numbers[] = {
        "nan",       "1e3",        "# a ] comment\n 7",
        "7 /* ] */", "2147483648", "0.000000000000000000001",
        "",          "+1",         "1.0f",
        "7 7",       "(7)",        "7, [7]",
        "7]",        ")",          "--7",
        "7,,7",      "\"x\"",
    };
    static const size_t places[] = {0, 1, 7001, 20000, 45677, ELEMENTS - 2, ELEMENTS - 1};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        for (size_t j = 0; j < sizeof places / sizeof *places; j++)
            compare(&samples[(i + j) % 3], places[j], numbers[i]);
}

static void odd_tuples_are_judged_in_their_place(void **state)
{
    (void)state;
    static const char *const tuples[] = {
        "(1, 2, nan)", "(1, 2, 3,)",      "(1,\n2\n, 3)",        "(1, 2)",     "(1, 2, 3, 4)",
        "(1, 2, 3",    "1, 2, 3)",        "((1, 2), 3)",         "(1, (2, 3)", "()",
        "5",           "(1, 2, # )\n 3)", "(1, 2, 3) (1, 2, 3)",
    };
    static const size_t places[] = {0, 3333, 30000, ELEMENTS - 1};
    for (size_t i = 0; i < sizeof tuples / sizeof *tuples; i++)
        for (size_t j = 0; j < sizeof places / sizeof *places; j++)
            compare(&samples[4], places[j], tuples[i]);
}

// Text that claims elements it does not hold must not be given memory for them.
static void brackets_alone_take_no_memory(void **state)
{
    (void)state;
    char *text = malloc(TEXT_BYTES);
    assert_non_null(text);
    size_t head = (size_t)sprintf(text, "#usda 1.0\ndef \"A\"\n{\n    double4[] a = [");
    memset(text + head, '(', TEXT_BYTES - head);
    Reports reports;
    size_t before = co_memory_peak(CO_MEMORY_USDA);
    assert_null(parse_with(text, TEXT_BYTES, 2, &reports));
    assert_true(co_memory_peak(CO_MEMORY_USDA) < before + TEXT_BYTES);
    memset(text + head, ',', TEXT_BYTES - head);
    assert_null(parse_with(text, TEXT_BYTES, 2, &reports));
    assert_true(co_memory_peak(CO_MEMORY_USDA) < before + TEXT_BYTES);
    free(text);
}

static void limits_hold(void **state)
{
    (void)state;
    char *text = malloc(TEXT_BYTES);
    assert_non_null(text);
    size_t size = write_array(text, &samples[0], "", ELEMENTS, "");
    for (uint64_t most = ELEMENTS - 1; most <= ELEMENTS + 1; most++) {
        Reports reports;
        CohortError err;
        const CohortStageOptions options = {.threads = 2, .max_array_length = most};
        CoLayer *layer = parse_bytes(text, size, &options, &reports, &err);
        assert_int_equal(layer != NULL, most >= ELEMENTS);
        assert_int_equal(err.code, layer ? COHORT_OK : COHORT_ERROR_LIMIT);
        co_layer_destroy(layer);
    }
    free(text);
}

static void failing_memory_is_reported(void **state)
{
    (void)state;
    char *text = malloc(TEXT_BYTES);
    assert_non_null(text);
    size_t size = write_array(text, &samples[1], "", 30000, "nan");
    bool done = false;
    for (uint64_t n = 1; n < 50 && !done; n++) {
        Reports reports;
        co_memory_fail_after(n);
        CoLayer *layer = parse_with(text, size, 2, &reports);
        co_memory_fail_after(0);
        done = layer != NULL;
        if (layer)
            assert_int_equal(value_of(layer)->count, ELEMENTS);
        else
            assert_non_null(strstr(reports.text, "out of memory"));
        co_layer_destroy(layer);
    }
    assert_true(done);
    free(text);
}

static void a_stop_ends_the_reading(void **state)
{
    (void)state;
    char *text = malloc(TEXT_BYTES);
    static const char head[] = "#usda 1.0\n(\n    customLayerData = {\n        int[] a = [";
    size_t length = (size_t)sprintf(text, "%s", head);
    for (int i = 0; i < ELEMENTS; i++)
        length += (size_t)sprintf(text + length, "%d, ", i);
    length += (size_t)sprintf(text + length, "0]\n    }\n)\n");
    for (uint32_t threads = 1; threads <= 2; threads++) {
        volatile int stop = 0;
        const CohortStageOptions options = {.threads = threads, .stop = &stop};
        Reports reports;
        CohortError err;
        CoLayer *layer = parse_bytes(text, length, &options, &reports, &err);
        assert_non_null(layer);
        co_layer_destroy(layer);
        stop = 1;
        assert_null(parse_bytes(text, length, &options, &reports, &err));
        assert_int_equal(err.code, COHORT_ERROR_CANCELLED);
        assert_int_equal(reports.count, 0);
    }
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_arrays_are_the_same),
        cmocka_unit_test(oddities_are_judged_in_their_place),
        cmocka_unit_test(odd_tuples_are_judged_in_their_place),
        cmocka_unit_test(brackets_alone_take_no_memory),
        cmocka_unit_test(limits_hold),
        cmocka_unit_test(failing_memory_is_reported),
        cmocka_unit_test(a_stop_ends_the_reading),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
