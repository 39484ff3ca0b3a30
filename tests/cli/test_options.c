// Option tables: what is taken, what is refused, and in which words.

#include "cli/cli.h"
#include "cli/options.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static char said[512];

// The command's own prints; this one keeps.
int usage_error(const char *command, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(said, sizeof said, format, args);
    va_end(args);
    return command ? EXIT_USAGE : EXIT_LOAD;
}

typedef struct Values {
    bool flag;
    int64_t whole, bytes;
    double number;
    const char *text, *choice;
    OptionList list;
    int first;
} Values;

static int parse(Values *v, const char *line)
{
    static char text[512];
    char *argv[128] = {text};
    int argc = 1;
    snprintf(text, sizeof text, "test %s", line);
    char *rest = strchr(text, ' ');
    *rest++ = 0;
    for (char *word; (word = strsep(&rest, " ")) != NULL;)
        if (word[0])
            argv[argc++] = word;
    memset(v, 0, sizeof *v);
    said[0] = 0;
    const Option table[] = {
        {"flag", 'f', OPTION_FLAG, &v->flag, 0, 0, NULL, NULL, "a flag"},
        {"whole", 'n', OPTION_INT, &v->whole, -5, 1e12, "N", NULL, "a whole number"},
        {"number", 0, OPTION_NUMBER, &v->number, 0, 0, "X", NULL, "any number"},
        {"bytes", 0, OPTION_BYTES, &v->bytes, 0, 0, "B", NULL, "bytes"},
        {"text", 't', OPTION_TEXT, &v->text, 0, 0, "T", NULL, "text"},
        {"choice", 0, OPTION_TEXT, &v->choice, 0, 0, NULL, "one|two|three", "a choice"},
        {"item", 'i', OPTION_LIST, &v->list, 0, 0, "I", NULL, "a list"},
    };
    return options_parse("test", table, sizeof table / sizeof table[0], argc, argv, &v->first);
}

static void values_arrive(void **state)
{
    (void)state;
    Values v;
    assert_int_equal(parse(&v, "a -f --whole=-5 --number 1e-3 -t x --choice two b -i 1 --item 2"),
                     0);
    assert_true(v.flag && v.whole == -5 && v.number == 1e-3);
    assert_string_equal(v.text, "x");
    assert_string_equal(v.choice, "two");
    assert_int_equal(v.list.count, 2);
    assert_string_equal(v.list.items[1], "2");
    // Of 15 words the two positional ones were moved to the end.
    assert_int_equal(v.first, 13);
}

static void sizes_have_units(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int64_t bytes;
    } cases[] = {{"0", 0},         {"12", 12},        {"12B", 12},
                 {"1K", 1024},     {"1.5k", 1536},    {"2M", 2 << 20},
                 {"1GB", 1 << 30}, {"1GiB", 1 << 30}, {"1T", (int64_t)1 << 40},
                 {"0.5g", 1 << 29}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        Values v;
        char line[64];
        snprintf(line, sizeof line, "--bytes %s", cases[i].text);
        assert_int_equal(parse(&v, line), 0);
        assert_true(v.bytes == cases[i].bytes);
    }
}

static void refusals(void **state)
{
    (void)state;
    static const struct {
        const char *line, *words;
    } cases[] = {
        {"--bogus", "--bogus is not an option"},
        {"-z", "is not an option"},
        {"--whole", "--whole needs a value"},
        {"-t", "-t needs a value"},
        {"--flag=1", "--flag"},
        {"--whole -6", "from -5 to"},
        {"--whole 1e13", "from -5 to"},
        {"--whole 1.5", "expected a whole number"},
        {"--whole x", "expected a whole number"},
        {"--whole 4x", "expected a whole number"},
        {"--whole nan", "expected a whole number"},
        {"--number inf", "expected a number"},
        {"--number 1e999", "expected a number"},
        {"--bytes -5", "expected bytes, such as"},
        {"--bytes 5Q", "expected bytes, such as"},
        {"--bytes 5KK", "expected bytes, such as"},
        {"--bytes 1e30T", "expected bytes, such as"},
        {"--bytes 0.3", "expected bytes, such as"},
        {"--number=", "--number has an empty value"},
        {"--choice=", "--choice has an empty value"},
        {"--choice four", "expected one of one|two|three"},
        {"--choice on", "expected one of"},
        {"--choice one|two", "expected one of"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        Values v;
        int code = parse(&v, cases[i].line);
        if (code != EXIT_USAGE || !strstr(said, cases[i].words))
            fail_msg("%s: code %d, \"%s\"", cases[i].line, code, said);
    }
}

static void trailing_blanks_are_no_unit(void **state)
{
    (void)state;
    int64_t bytes = 7;
    const Option table[] = {{"bytes", 0, OPTION_BYTES, &bytes, 0, 0, "B", NULL, ""}};
    char command[] = "test", option[] = "--bytes", value[] = "5 ";
    char *argv[] = {command, option, value, NULL};
    int first;
    assert_int_equal(options_parse("test", table, 1, 3, argv, &first), EXIT_USAGE);
    assert_int_equal(bytes, 7);
}

static void lists_are_finite(void **state)
{
    (void)state;
    Values v;
    char line[512] = "";
    for (int i = 0; i <= OPTION_LIST_MAX; i++)
        strcat(line, "-ix ");
    assert_int_equal(parse(&v, line), EXIT_USAGE);
    assert_non_null(strstr(said, "64 times"));
}

// Options first, then operands: one too few, as many as there shall be, one too many.
static void operands_are_counted(void **state)
{
    (void)state;
    bool flag = false, wants_help = false;
    const Option table[] = {{"flag", 'f', OPTION_FLAG, &flag, 0, 0, NULL, NULL, "a flag"},
                            {"help", 'h', OPTION_FLAG, &wants_help, 0, 0, NULL, NULL, "show this"}};
    const CommandHead head = {"test", "about\n", NULL, 2, "two things"};
    char command[] = "test", a[] = "a", b[] = "b", c[] = "c", option[] = "-f", none[] = "--none";
    for (int operands = 0; operands <= 3; operands++) {
        char *argv[] = {command, a, option, b, c, NULL};
        char *fewer[] = {command, option, a, NULL};
        int first = 0, argc = 2 + operands;
        int code =
            options_begin(&head, table, 2, &wants_help, argc, operands < 2 ? fewer : argv, &first);
        assert_int_equal(code, operands == 2 ? -1 : EXIT_USAGE);
        assert_true(flag);
        if (operands == 2)
            assert_true(first == 2 && strcmp(argv[first], "a") == 0 && strcmp(argv[3], "b") == 0);
        else
            assert_non_null(strstr(said, "expected two things"));
    }
    char *bad[] = {command, none, NULL};
    int first;
    assert_int_equal(options_begin(&head, table, 2, &wants_help, 2, bad, &first), EXIT_USAGE);
    assert_non_null(strstr(said, "not an option"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_arrive),    cmocka_unit_test(sizes_have_units),
        cmocka_unit_test(refusals),         cmocka_unit_test(trailing_blanks_are_no_unit),
        cmocka_unit_test(lists_are_finite), cmocka_unit_test(operands_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
