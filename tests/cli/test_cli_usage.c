// Help, options and their refusals. Also tests main.c, cat.c, diff.c, names.c and
// render_options.c.

#include "command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void help_of_every_command(void **state)
{
    (void)state;
    static const char *const commands[] = {"render", "cat", "tree", "check", "diff"};
    Ran ran;
    command_run(&ran, "--help");
    assert_int_equal(ran.code, 0);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        assert_non_null(strstr(ran.out, commands[i]));
        Ran own;
        command_run(&own, "%s --help", commands[i]);
        assert_int_equal(own.code, 0);
        assert_non_null(strstr(own.out, commands[i]));
        assert_non_null(strstr(own.out, "--help"));
        const char *codes = strstr(own.out, "\nExit codes: 0 ");
        assert_non_null(codes);
        assert_non_null(strstr(codes, " 4 "));
        for (const char *line = own.out; *line; line += strcspn(line, "\n") + 1)
            assert_in_range(strcspn(line, "\n"), 0, 100);
        assert_string_equal(own.err, "");
    }
}

static void help_of_render_is_complete(void **state)
{
    (void)state;
    static const char *const options[] = {"output",
                                          "camera",
                                          "list-cameras",
                                          "frames",
                                          "default-time",
                                          "size",
                                          "render-settings",
                                          "variant",
                                          "level",
                                          "edge-length",
                                          "env",
                                          "headlight",
                                          "hide-lights",
                                          "spp",
                                          "time-limit",
                                          "noise",
                                          "max-depth",
                                          "first-hit-samples",
                                          "light-samples",
                                          "preset",
                                          "filter",
                                          "seed",
                                          "aov",
                                          "sort",
                                          "sorter",
                                          "batch",
                                          "scratch",
                                          "memory",
                                          "threads",
                                          "isa",
                                          "ptex-reductions",
                                          "converted",
                                          "texture-level0",
                                          "ocio",
                                          "display",
                                          "view",
                                          "stats",
                                          "resume",
                                          "progress",
                                          "quiet",
                                          "verbose"};
    Ran ran;
    command_run(&ran, "render -h");
    assert_int_equal(ran.code, 0);
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        char name[64];
        snprintf(name, sizeof name, "--%s", options[i]);
        assert_non_null(strstr(ran.out, name));
    }
    assert_non_null(strstr(ran.out, "Exit codes"));
    assert_non_null(strstr(ran.out, "OUT.exr.film"));
}

static void version_names_the_libraries(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "--version");
    assert_int_equal(ran.code, 0);
    assert_non_null(strstr(ran.out, "OpenEXR"));
    assert_non_null(strstr(ran.out, "OpenColorIO"));
}

static void unknown_command(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "rendre");
    assert_ran(&ran, 2, "rendre");
    command_run(&ran, " ");
    assert_int_equal(ran.code, 2);
}

static void refused_options(void **state)
{
    (void)state;
    static const struct {
        const char *option, *said;
    } cases[] = {
        {"--bogus", "--bogus"},
        {"--spp", "needs a value"},
        {"--spp 0", "from 1 to 2147483648"},
        {"--spp 4x", "expected a whole number"},
        {"--size 0x10", "WIDTHxHEIGHT"},
        {"--size 70000x10", "WIDTHxHEIGHT"},
        {"--memory 1", "at least"},
        {"--threads 0", "from 1"},
        {"--variant size=small", "/Prim{set=selection}"},
        {"--variant /World/ball{size=huge}", "no such variant"},
        {"--variant /World/ball{shape=big}", "no such variant set"},
        {"--variant /Moon{size=big}", "no such prim"},
        {"--camera nope", "nope"},
        {"--render-settings /World", "/World"},
        {"--aov smell", "there are color"},
        {"--display Projector", "sRGB - Display"},
        {"--view Sepia", "Un-tone-mapped"},
        {"--frames 1:", "frame spec"},
        {"--frames 1:3", "placeholder"},
        {"-o a.tif", ".exr or .png"},
        {"-o x.exr", "named twice"},
        {"-o a.##.exr", "no --frames"},
        {"another.usda", "one stage"},
        {"--frames 1 --default-time", "exclude each other"},
        {"--level 2 --edge-length 3", "exclude each other"},
        {"--spp 1.5", "a whole number from 1"},
        {"--memory 4X", "such as 800M or 4G"},
        {"--memory 9e30", "such as 800M or 4G"},
        {"--mask /Moon", "--mask /Moon: there is no such prim"},
        {"--load /Moon", "no such prim"},
        {"--unload /Moon", "no such prim"},
        {"--camera nope", "but /World/cam and 1 more"},
        {"-o ./x.exr", "named twice"},
        {"-o folder/../x.exr", "named twice"},
        {"--stats x.exr", "writes that file itself"},
        {"--stats ./x.exr", "writes that file itself"},
        {"--stats x.exr.film", "writes that file itself"},
        {"--stats stage.usda", "that is the stage"},
        {"--stats link.usda", "that is the stage"},
        {"--stats x.##.json", "no --frames"},
    };
    assert_int_equal(mkdir("folder", 0777), 0);
    assert_int_equal(symlink("stage.usda", "link.usda"), 0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        Ran ran;
        command_run(&ran, "render stage.usda -o x.exr --spp 1 %s", cases[i].option);
        assert_ran(&ran, 2, cases[i].said);
        assert_int_equal(line_count(ran.err), 1);
        assert_false(file_exists("x.exr"));
    }
    Ran ran;
    command_run(&ran, "cat stage.usda"); // which nothing has written over
    assert_int_equal(ran.code, 0);
}

// A variable of a script that is not set.
static void empty_values(void **state)
{
    (void)state;
    static const char *const options[] = {"-o",       "--camera",  "--stats", "--scratch", "--env",
                                          "--frames", "--session", "--mask",  "--spp"};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        char command[512];
        snprintf(command, sizeof command, "%s render stage.usda -o x.exr --spp 1 %s '' 2> said.txt",
                 COHORT_COMMAND, options[i]);
        assert_int_equal(system(command), 2 << 8);
        assert_int_equal(system("grep -q 'has an empty value' said.txt"), 0);
    }
}

static void bytes_by_any_name(void **state)
{
    (void)state;
    static const char *const sizes[] = {"4G", "4GB", "4GiB", "4g", "2.5G", "4294967296", "1T"};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        Ran ran;
        command_run(&ran, "render stage.usda -o x.exr --spp 1 -q --memory %s", sizes[i]);
        assert_ran(&ran, 0, "");
    }
    assert_int_equal(unlink("x.exr"), 0);
}

static void refusals_of_cat_and_diff(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "cat");
    assert_ran(&ran, 2, "one layer");
    command_run(&ran, "cat nofile.usda");
    assert_ran(&ran, 3, "nofile.usda");
    assert_int_equal(line_count(ran.err), 1);
    command_run(&ran, "cat stage.usda -o nofolder/x.usda");
    assert_ran(&ran, 4, "nofolder");
    command_run(&ran, "diff a.exr");
    assert_ran(&ran, 2, "two images");
    command_run(&ran, "diff nofile.exr nofile.exr");
    assert_ran(&ran, 3, "nofile.exr");
    command_run(&ran, "diff stage.usda stage.usda");
    assert_ran(&ran, 3, "stage.usda");
    command_run(&ran, "diff a b -t -1");
    assert_ran(&ran, 2, "--tolerance");
}

// Which part of a stage is meant must be there, whatever is done with it.
static void parts_that_are_not_there(void **state)
{
    (void)state;
    static const char *const commands[] = {"render stage.usda -o x.exr", "cat stage.usda --flatten",
                                           "tree stage.usda", "check stage.usda"};
    static const char *const parts[] = {"--mask /Moon", "--load /Moon", "--unload /World/moon",
                                        "--mask World"};
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
        for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++) {
            Ran ran;
            command_run(&ran, "%s %s", commands[i], parts[k]);
            assert_ran(&ran, 2, "no");
            assert_int_equal(line_count(ran.err), 1);
            assert_string_equal(ran.out, "");
        }
    Ran ran;
    command_run(&ran, "cat stage.usda --mask /World");
    assert_ran(&ran, 2, "without --flatten");
    command_run(&ran, "cat stage.usda --flatten --mask /World/ball");
    assert_int_equal(ran.code, 0);
    assert_null(strstr(ran.out, "SphereLight"));
}

// Layers and folders may be right for other stages: one warning says that they change nothing here.
static void layers_and_folders_that_are_not_there(void **state)
{
    (void)state;
    static const char *const commands[] = {"render stage.usda -o x.exr --spp 1",
                                           "cat stage.usda --flatten", "tree stage.usda",
                                           "check stage.usda"};
    Ran plain, ran;
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        command_run(&plain, "%s", commands[i]);
        command_run(
            &ran, "%s --mute moon.usda --search-path /nonexistent --mute moon.usda --search-path .",
            commands[i]);
        assert_ran(&ran, plain.code, "warning: --mute moon.usda: ");
        assert_ran(&ran, plain.code, "warning: --search-path /nonexistent: ");
        assert_int_equal(line_count(ran.err), line_count(plain.err) + 2);
    }
}

// By paths from the stage's folder and from the current one.
static void muted_layers_are_found(void **state)
{
    (void)state;
    static const char *const commands[] = {
        "tree shot/whole.usda --mute part.usda", "tree shot/whole.usda --mute ./part.usda",
        "tree shot/whole.usda --mute shot/part.usda", "tree shot/whole.usda"};
    assert_int_equal(mkdir("shot", 0777), 0);
    write_text("shot/part.usda", "#usda 1.0\ndef Cube \"C\"\n{\n}\n");
    write_text("shot/whole.usda", "#usda 1.0\n(\n    subLayers = [@./part.usda@]\n)\n");
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        Ran ran;
        command_run(&ran, "%s", commands[i]);
        assert_int_equal(ran.code, 0);
        assert_string_equal(ran.err, "");
        assert_int_equal(strstr(ran.out, "Cube") != NULL, i == 3);
    }
}

static void cat_writes_what_it_reads(void **state)
{
    (void)state;
    Ran ran, again;
    command_run(&ran, "cat stage.usda");
    assert_int_equal(ran.code, 0);
    assert_non_null(strstr(ran.out, "variantSet \"size\""));
    command_run(&again, "cat stage.usda -o copy.usda");
    assert_int_equal(again.code, 0);
    assert_string_equal(again.out, "");
    command_run(&again, "cat copy.usda");
    assert_string_equal(again.out, ran.out);
    command_run(&again, "cat --flatten stage.usda");
    assert_int_equal(again.code, 0);
    assert_null(strstr(again.out, "variantSet \"size\""));
    assert_non_null(strstr(again.out, "double radius = 1"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(help_of_every_command),
        cmocka_unit_test(help_of_render_is_complete),
        cmocka_unit_test(version_names_the_libraries),
        cmocka_unit_test(unknown_command),
        cmocka_unit_test(refused_options),
        cmocka_unit_test(empty_values),
        cmocka_unit_test(bytes_by_any_name),
        cmocka_unit_test(refusals_of_cat_and_diff),
        cmocka_unit_test(parts_that_are_not_there),
        cmocka_unit_test(layers_and_folders_that_are_not_there),
        cmocka_unit_test(muted_layers_are_found),
        cmocka_unit_test(cat_writes_what_it_reads),
    };
    return cmocka_run_group_tests(tests, scratch_enter, scratch_leave);
}
