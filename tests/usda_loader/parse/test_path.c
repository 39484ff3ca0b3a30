// Which paths and path expressions a layer may hold; the verdicts are those of usd-core 26.11.
// Also tests path_expression.c.

#include "parse/parser.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

typedef struct Verdict {
    const char *text;
    bool good;
} Verdict;

static const Verdict paths[] = {
    {"/", true},
    {"/A", true},
    {"/A/B", true},
    {"A", true},
    {"A/B.c", true},
    {"../A", true},
    {"../../A.b", true},
    {"..", true},
    {".a", true},
    {"/A.b:c:d", true},
    {"/A{s=v}", true},
    {"/A{s=v}B", true},
    {"/A{s=v}{t=w}B/C", true},
    {"/A{s=}", true},
    {"/A{s=.v-1|2}", true},
    {"/A.r[/B]", true},
    {"/A.r[/B].x", true},
    {"/A.r.mapper[/B]", true},
    {"/A.r[/B.c].x:y", true},
    {"/Caf\xc3\xa9", true},
    {"", false},
    {".", false},
    {"/A/", false},
    {"//A", false},
    {"/A//B", false},
    {"/A/../B", false},
    {"/A.b.c", false},
    {"/A.", false},
    {"/1", false},
    {" /A", false},
    {"/A B", false},
    {"/A{s}", false},
    {"/A{=v}", false},
    {"/A.r[/B", false},
    {"/A.r[]", false},
    {"/A.r[/B].", false},
    {"/.a", false},
    {"/A:b", false},
    {"/A.b/C", false},
    {"\xff", false},
};

static const Verdict expressions[] = {
    {"", true},
    {"/", true},
    {"//", true},
    {"//*", true},
    {"/a", true},
    {"a/b", true},
    {".", true},
    {"..", true},
    {"../a", true},
    {"/a.b", true},
    {"/a.b:c", true},
    {"/a//", true},
    {"/a//b", true},
    {"/a*", true},
    {"/a?[bc]", true},
    {"/a[!b]", true},
    {"/a{x}", true},
    {"/a{isa:Mesh}", true},
    {"/a{f(1,2)}", true},
    {"/a{f(a=1)}", true},
    {"/a{not x}", true},
    {"/a{x and y or not (z)}", true},
    {"/a{x y}", true},
    {"/a{isa:\"s\"}", true},
    {"/a{isa:1.5,2}", true},
    {"/a+/b", true},
    {"/a - /b", true},
    {"~/a", true},
    {"(/a)", true},
    {"( /a /b )", true},
    {"%_", true},
    {"%:x", true},
    {"%/a:x", true},
    {"%../a:x", true},
    {"/a ~/b", true},
    {"(/a /b) & /c", true},
    {"//{x}", true},
    {"/a.{x}", true},
    {"/a.b{x}", true},
    {"{x}", true},
    {"/a\t/b", true},
    {"/a\n/b", true},
    {" /a", true},
    {"/a ", true},
    {"./a", false},
    {"/a/..", false},
    {"/a.b.c", false},
    {"/a/", false},
    {"/a///b", false},
    {"/a[b", false},
    {"/a{}", false},
    {"/a{x", false},
    {"/a{\"s\"}", false},
    {"()", false},
    {"/a,/b", false},
    {"%", false},
    {"%x", false},
    {"%/a", false},
    {"%/a:", false},
    {"+ /a", false},
    {"/a +", false},
    {"/a | /b", false},
    {"//.x", false},
    {"/.x", false},
    {".x", false},
    {"/a{x}{y}", false},
    {"/a:b", false},
    {"/a//.b", false},
    {"/a.b//c", false},
    {"~~/a", false},
    {"/a(b)", false},
    {"/a{x,y}", false},
    {"%/:x", false},
    {"%a/b:x", false},
    {"../.a", false},
    {"  ", false},
};

static void paths_are_judged(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        CoSlice slice = {paths[i].text, strlen(paths[i].text)};
        CoPathInfo info;
        size_t bad;
        if (co_path_check(slice, &info, &bad) != paths[i].good)
            fail_msg("<%s> should %sbe a path", paths[i].text, paths[i].good ? "" : "not ");
        assert_true(bad <= slice.length);
    }
}

static CoPathInfo info_of(const char *text)
{
    CoPathInfo info;
    size_t bad;
    assert_true(co_path_check((CoSlice){text, strlen(text)}, &info, &bad));
    return info;
}

static void what_a_path_names(void **state)
{
    (void)state;
    assert_true(info_of("/").is_root);
    assert_true(info_of("/A").is_absolute && !info_of("/A").is_root);
    assert_false(info_of("../A").is_absolute);
    assert_true(info_of("/A.b").is_property);
    assert_true(info_of("/A{s=v}").is_variant && info_of("/A{s=v}").has_variant);
    assert_true(!info_of("/A{s=v}B").is_variant && info_of("/A{s=v}B").has_variant);
    assert_true(info_of("/A.r[/B]").is_target);
    assert_false(info_of("/A.r[/B].x").is_target);
    assert_false(info_of("/A.r.mapper[/B]").is_target);
}

static void expressions_are_judged(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof expressions / sizeof *expressions; i++) {
        size_t bad, length = strlen(expressions[i].text);
        if (co_expression_check(expressions[i].text, length, &bad) != expressions[i].good)
            fail_msg("'%s' should %sbe an expression", expressions[i].text,
                     expressions[i].good ? "" : "not ");
        assert_true(bad <= length);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_are_judged),
        cmocka_unit_test(what_a_path_names),
        cmocka_unit_test(expressions_are_judged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
