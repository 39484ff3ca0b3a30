// Bad input: one clear line with place and remedy, the right exit code, and never a crash. What
// can be rendered is rendered, with a counted warning. Also tests messages.c and source_line.c.

#include "command.h"

#include "cohort/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int without_output(void **state)
{
    (void)state;
    unlink("x.exr");
    return 0;
}

static void run_stage(Ran *ran, const char *text, const char *arguments)
{
    write_text("bad.usda", text);
    unlink("x.exr");
    command_run(ran, "render bad.usda -o x.exr --spp 1 --size 16x16 %s", arguments);
}

// Nothing is written, and one message says why, if need be with the line it is about and a caret.
static void assert_refused(const Ran *ran, int code, const char *said)
{
    assert_ran(ran, code, said);
    int lines = line_count(ran->err);
    assert_true(lines == 1 || (lines == 3 && strstr(ran->err, "^\n")));
    assert_ptr_equal(strstr(ran->err, "cohort: "), ran->err);
    assert_false(file_exists("x.exr"));
}

static void assert_rendered(const Ran *ran, const char *said)
{
    assert_ran(ran, 0, said);
    assert_true(file_exists("x.exr"));
}

static void stages_that_cannot_be_read(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "render nofile.usda -o x.exr");
    assert_refused(&ran, 3, "nofile.usda");
    assert_null(strstr(strstr(ran.err, "nofile.usda") + 1, "nofile.usda"));
    assert_int_equal(mkdir("folder.usda", 0777), 0);
    command_run(&ran, "render folder.usda -o x.exr");
    assert_refused(&ran, 3, "irectory");
    command_run(&ran, "render /dev/zero -o x.exr");
    assert_refused(&ran, 3, "a pipe or a device");
    run_stage(&ran, "", "");
    assert_refused(&ran, 3, "bad.usda:1:1");
    run_stage(&ran, "PXR-USDC", "");
    assert_refused(&ran, 3, "binary crate");
    assert_non_null(strstr(ran.err, "usdcat"));
    run_stage(&ran, "hello\n", "");
    assert_refused(&ran, 3, "#usda 1.0");
    run_stage(&ran, "#usda 1.0\n\ndef Sphere \"a\"\n{\n    double radius = = 2\n}\n", "");
    assert_refused(&ran, 3, "bad.usda:5:21");
    run_stage(&ran, "#usda 1.0\ndef Sphere \"a\"\n{\n    double x = = 2\n    double y = = 3\n}\n",
              "");
    assert_ran(&ran, 3, "bad.usda:4:");
    assert_non_null(strstr(ran.err, "bad.usda:5:"));
    assert_int_equal(line_count(ran.err), 6);
    run_stage(&ran, "#usda 1.0\ndef Sphere \"a\"\n{\n", "");
    assert_refused(&ran, 3, "bad.usda:");
}

// Thousands of prims may name one file.
static void warnings_in_the_same_words_are_counted(void **state)
{
    (void)state;
    enum {
        PRIMS = 20
    };
    char text[4096];
    int length = snprintf(text, sizeof text, "#usda 1.0\n");
    for (int i = 0; i < PRIMS; i++)
        length += snprintf(text + length, sizeof text - (size_t)length,
                           "def Sphere \"P%d\" (references = @./absent.usda@) {\n}\n", i);
    Ran ran;
    run_stage(&ran, text, "--env sky");
    assert_rendered(&ran, "</P11>: warning: the reference to @./absent.usda@");
    assert_null(strstr(ran.err, "</P12>"));
    assert_non_null(strstr(ran.err, "cohort: 8 more warnings"));
    run_stage(&ran, text, "--env sky --verbose");
    assert_rendered(&ran, "</P19>: warning: the reference to @./absent.usda@");
    assert_null(strstr(ran.err, "more warnings"));
    command_run(&ran, "tree bad.usda");
    assert_ran(&ran, 0, "cohort: 8 more warnings");
}

static void limits_name_the_flag_that_moves_them(void **state)
{
    (void)state;
    Ran ran;
    run_stage(&ran, "#usda 1.0\ndef \"a\" {\n}\ndef \"b\" {\n}\n", "--max-prims 1");
    assert_refused(&ran, 3, "bad.usda:4:1");
    assert_non_null(strstr(ran.err, "raise --max-prims to"));
    command_run(&ran, "check bad.usda --max-prims 1");
    assert_int_equal(ran.code, 3);
    assert_non_null(strstr(ran.out, "raise --max-prims to read it [limit]"));
}

static void arcs_that_lead_nowhere(void **state)
{
    (void)state;
    Ran ran;
    run_stage(&ran,
              "#usda 1.0\ndef Cube \"ok\"\n{\n}\ndef \"a\" (\n    references = @./none.usda@\n"
              ")\n{\n}\n",
              "--headlight");
    assert_rendered(&ran, "none.usda");
    assert_non_null(strstr(ran.err, "warning"));
    assert_null(strstr(ran.err, "error"));
    run_stage(&ran, "#usda 1.0\n(\n    subLayers = [@./none.usda@]\n)\n", "--headlight");
    assert_rendered(&ran, "none.usda");
    run_stage(&ran, "#usda 1.0\ndef \"a\" (\n    references = </a>\n)\n{\n}\n", "--headlight");
    assert_rendered(&ran, "</a>");
}

static const char plane[] =
    "    int[] faceVertexCounts = [4]\n    int[] faceVertexIndices = [0, 1, 2, 3]\n"
    "    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]\n"
    "    uniform token subdivisionScheme = \"none\"\n";

static void textured(char *out, size_t size, const char *shader)
{
    snprintf(
        out, size,
        "#usda 1.0\ndef Mesh \"m\" (\n    prepend apiSchemas = [\"MaterialBindingAPI\"]\n)\n{\n"
        "%s    rel material:binding = </M>\n}\ndef Material \"M\"\n{\n"
        "    token outputs:surface.connect = </M/S.outputs:surface>\n"
        "    def Shader \"S\"\n    {\n        uniform token info:id = \"UsdPreviewSurface\"\n"
        "        color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>\n"
        "        token outputs:surface\n    }\n    def Shader \"T\"\n    {\n%s    }\n}\n",
        plane, shader);
}

static void textures(void **state)
{
    (void)state;
    Ran ran;
    char text[2048];
    textured(text, sizeof text,
             "        uniform token info:id = \"UsdUVTexture\"\n"
             "        asset inputs:file = @none.png@\n        float3 outputs:rgb\n");
    run_stage(&ran, text, "--headlight");
    assert_rendered(&ran, "none.png");
    assert_int_equal(line_count(ran.err), 2); // and that it was written
    run_stage(&ran, text, "--headlight -v");
    assert_rendered(&ran, "</M/T> inputs:file = none.png");
    assert_int_equal(line_count(ran.err), 2);
    write_text("garbage.png", "\x89PNG\r\n\x1a\nrubbish");
    textured(text, sizeof text,
             "        uniform token info:id = \"UsdUVTexture\"\n"
             "        asset inputs:file = @garbage.png@\n        float3 outputs:rgb\n");
    run_stage(&ran, text, "--headlight");
    assert_rendered(&ran, "garbage.png");
    write_text("garbage.ptx", "Ptex rubbish");
    textured(text, sizeof text,
             "        uniform token info:id = \"HwPtexTexture_1\"\n"
             "        asset inputs:file = @garbage.ptx@\n        float3 outputs:rgb\n");
    run_stage(&ran, text, "--headlight");
    assert_rendered(&ran, "garbage.ptx");
}

// A copy of the command alone does all but read images: a picture without any of them is none.
static void without_the_image_module(void **state)
{
    (void)state;
    char text[2048];
    write_text("image.png", "\x89PNG\r\n\x1a\nrubbish");
    write_text("image.1001.png", "\x89PNG\r\n\x1a\nrubbish");
    assert_int_equal(mkdir("alone", 0777), 0);
    assert_int_equal(system("cp " COHORT_COMMAND " alone/cohort"), 0);
    assert_int_equal(system("alone/cohort cat stage.usda > said.txt && grep -q Sphere said.txt"),
                     0);
    assert_int_equal(system("alone/cohort render stage.usda --spp 1 -q -o x.exr -o x.png"), 0);
    assert_int_equal(unlink("x.exr"), 0);
    static const char said_once[] = "test $(wc -l < said.txt) = 1 && "
                                    "grep -q 'error: .*cohort_oiio.so.*lib/cohort' said.txt";
    static const char *const files[] = {"image.png", "image.<UDIM>.png"};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        char shader[256];
        snprintf(shader, sizeof shader,
                 "        uniform token info:id = \"UsdUVTexture\"\n"
                 "        asset inputs:file = @%s@\n        float3 outputs:rgb\n",
                 files[i]);
        textured(text, sizeof text, shader);
        write_text("bad.usda", text);
        assert_int_equal(system("alone/cohort render bad.usda --spp 1 --size 8x8 --headlight "
                                "-o x.exr 2> said.txt"),
                         3 << 8);
        assert_int_equal(system(said_once), 0);
        assert_false(file_exists("x.exr"));
    }
    assert_int_equal(system("alone/cohort render stage.usda --spp 1 --size 8x8 --env image.png "
                            "-o x.exr 2> said.txt"),
                     3 << 8);
    assert_int_equal(system(said_once), 0);
    assert_false(file_exists("x.exr"));
}

static void a_ptex_file_of_another_mesh(void **state)
{
    (void)state;
    const char *file = COHORT_SHARED_DIR "/ptex/goldens/cube_f16_c1.ptx";
    if (!file_exists(file))
        skip();
    Ran ran;
    char text[2560], shader[512];
    snprintf(shader, sizeof shader,
             "        uniform token info:id = \"HwPtexTexture_1\"\n"
             "        asset inputs:file = @%s@\n        float3 outputs:rgb\n",
             file);
    textured(text, sizeof text, shader);
    run_stage(&ran, text, "--headlight");
    assert_rendered(&ran, "faces");
}

static void meshes(void **state)
{
    (void)state;
    static const struct {
        const char *mesh, *said;
    } cases[] = {
        {"int[] faceVertexCounts = [3]\n    int[] faceVertexIndices = [0, 1, 2]\n"
         "    point3f[] points = [(0, 0, 0), (1, 0, 0), (nan, 1, 0)]\n",
         "NaN"},
        {"int[] faceVertexCounts = [3, 4]\n    int[] faceVertexIndices = [0, 1, 2]\n"
         "    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n",
         "faceVertexCounts"},
        {"int[] faceVertexCounts = [3]\n    int[] faceVertexIndices = [0, 1, 9]\n"
         "    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n",
         "/bad"},
        {"int[] faceVertexCounts = [-3]\n    int[] faceVertexIndices = [0, 1, 2]\n"
         "    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n",
         "/bad"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        Ran ran;
        char text[2048];
        snprintf(text, sizeof text,
                 "#usda 1.0\ndef Cube \"ok\"\n{\n}\ndef Mesh \"bad\"\n{\n    %s"
                 "    uniform token subdivisionScheme = \"none\"\n}\n",
                 cases[i].mesh);
        run_stage(&ran, text, "--headlight");
        assert_rendered(&ran, cases[i].said);
    }
}

static void lights_without_area(void **state)
{
    (void)state;
    static const char *const lights[] = {
        "RectLight \"key\"\n{\n    float inputs:width = 0\n}\n",
        "RectLight \"key\"\n{\n    float inputs:height = -1\n}\n",
        "DiskLight \"key\"\n{\n    float inputs:radius = 0\n}\n",
        "SphereLight \"key\"\n{\n    float inputs:radius = nan\n}\n"};
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) {
        Ran ran;
        char text[512];
        snprintf(text, sizeof text, "#usda 1.0\ndef Cube \"ok\"\n{\n}\ndef %s", lights[i]);
        run_stage(&ran, text, "");
        assert_rendered(&ran, "/key");
    }
}

static void matrices_without_inverse(void **state)
{
    (void)state;
    static const char *const scales[] = {"(1, 0, 1)", "(nan, 1, 1)", "(inf, 1, 1)", "(1, 1, 1e20)"};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        Ran ran;
        char text[512];
        snprintf(text, sizeof text,
                 "#usda 1.0\ndef Cube \"ok\"\n{\n}\ndef Sphere \"flat\"\n{\n"
                 "    float3 xformOp:scale = %s\n"
                 "    uniform token[] xformOpOrder = [\"xformOp:scale\"]\n}\n",
                 scales[i]);
        run_stage(&ran, text, "--headlight");
        assert_rendered(&ran, "</flat> transform: left out");
    }
}

static void no_camera_frames_the_stage(void **state)
{
    (void)state;
    Ran ran;
    run_stage(&ran, "#usda 1.0\ndef Cube \"ok\"\n{\n    double size = 300\n}\n",
              "--env sky --hide-lights");
    assert_rendered(&ran, "wrote");
    CohortImage image = {0};
    assert_true(cohort_exr_read("x.exr", &image, NULL));
    const float *alpha = image.pixels + (size_t)cohort_image_channel(&image, "A") * 256;
    assert_true(alpha[8 * 16 + 8] > 0.99f && alpha[0] < 0.5f);
    cohort_image_clear(&image);
}

static void no_lights_are_dark(void **state)
{
    (void)state;
    Ran ran;
    run_stage(&ran, "#usda 1.0\ndef Cube \"ok\"\n{\n}\n", "");
    assert_rendered(&ran, "no lights");
    assert_non_null(strstr(ran.err, "--env sky or --headlight"));
    run_stage(&ran, "#usda 1.0\n", "--headlight");
    assert_rendered(&ran, "wrote");
}

// A value is told where it is that of all.
static void what_is_grouped_keeps_its_value(void **state)
{
    (void)state;
    static const char *const files[] = {"none.png", "other.png"};
    static const char *const said[] = {"</M0/T> and 1 more: inputs:file = none.png: no such file",
                                       "</M0/T> and 1 more: inputs:file: no such file"};
    for (size_t i = 0; i < 2; i++) {
        char text[4096] = "#usda 1.0\n";
        for (int m = 0; m < 2; m++) {
            size_t used = strlen(text);
            snprintf(text + used, sizeof text - used,
                     "def Mesh \"m%d\" (\n    prepend apiSchemas = [\"MaterialBindingAPI\"]\n)\n{\n"
                     "%s    rel material:binding = </M%d>\n}\ndef Material \"M%d\"\n{\n"
                     "    token outputs:surface.connect = </M%d/S.outputs:surface>\n"
                     "    token outputs:displacement.connect = </M%d/S.outputs:displacement>\n"
                     "    def Shader \"S\"\n    {\n"
                     "        uniform token info:id = \"UsdPreviewSurface\"\n"
                     "        float inputs:displacement.connect = </M%d/T.outputs:r>\n"
                     "        token outputs:surface\n        token outputs:displacement\n    }\n"
                     "    def Shader \"T\"\n    {\n"
                     "        uniform token info:id = \"UsdUVTexture\"\n"
                     "        asset inputs:file = @%s@\n        float outputs:r\n    }\n}\n",
                     m, plane, m, m, m, m, m, files[i * (size_t)m]);
        }
        Ran ran;
        run_stage(&ran, text, "--headlight");
        assert_rendered(&ran, said[i]);
    }
}

// What one prim has twice, by two values, is not told of two prims.
static void values_of_one_prim_are_no_prims(void **state)
{
    (void)state;
    Ran ran;
    run_stage(&ran,
              "#usda 1.0\ndef PointInstancer \"pi\"\n{\n    rel prototypes = </pi/p>\n"
              "    int[] protoIndices = [0, -1, 7]\n"
              "    point3f[] positions = [(0, 0, 0), (3, 0, 0), (6, 0, 0)]\n"
              "    def Cube \"p\"\n    {\n    }\n}\n",
              "--headlight");
    assert_rendered(&ran, "</pi> protoIndices: no such prototype");
    assert_null(strstr(ran.err, "more"));
}

// Equal things of many prims are one line, unless all are asked for.
static void what_is_not_honored_is_grouped(void **state)
{
    (void)state;
    static const char curves[] =
        "#usda 1.0\ndef BasisCurves \"a\"\n{\n}\ndef BasisCurves \"b\"\n{\n}\n"
        "def BasisCurves \"c\"\n{\n}\n";
    Ran ran;
    run_stage(&ran, curves, "--headlight");
    assert_rendered(&ran, "</a> and 2 more: BasisCurves");
    assert_int_equal(line_count(ran.err), 2);
    run_stage(&ran, curves, "--headlight -v");
    assert_rendered(&ran, "</c> BasisCurves");
    assert_int_equal(line_count(ran.err), 4);
    run_stage(&ran, curves, "--headlight -q");
    assert_rendered(&ran, "");
    assert_string_equal(ran.err, "");
}

static void outputs_that_cannot_be_written(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "render stage.usda --spp 1 -o nofolder/x.exr");
    assert_refused(&ran, 4, "nofolder");
    assert_int_equal(mkdir("taken.exr", 0777), 0);
    assert_int_equal(mkdir("taken.png", 0777), 0);
    command_run(&ran, "render stage.usda --spp 1 -o taken.exr");
    assert_refused(&ran, 4, "taken.exr: it is a folder");
    command_run(&ran, "render stage.usda --spp 1 -o taken.png");
    assert_refused(&ran, 4, "taken.png: it is a folder");
    command_run(&ran, "render stage.usda --spp 1 -o x.exr --stats nofolder/x.json");
    assert_refused(&ran, 4, "nofolder");
    command_run(&ran, "render stage.usda --spp 1 -o x.exr --stats taken.exr");
    assert_refused(&ran, 4, "taken.exr: it is a folder");
    char name[300] = "render stage.usda --spp 1 -o ";
    memset(name + strlen(name), 'n', 245);
    command_run(&ran, "%s.exr", name);
    assert_refused(&ran, 4, "the name is too long");
    // Of a range, each frame's files are looked at before the first renders.
    assert_int_equal(mkdir("f.0002.exr", 0777), 0);
    command_run(&ran, "render stage.usda --spp 1 -o f.####.exr --frames 1:3");
    assert_refused(&ran, 4, "f.0002.exr: it is a folder");
    assert_false(file_exists("f.0001.exr"));
    command_run(&ran, "render stage.usda --spp 1 -o f.##.exr --frames 1:3 --stats f.json");
    assert_refused(&ran, 2, "f.json: several frames need a placeholder");
    assert_int_equal(symlink("/proc/self/fd/1", "out.json"), 0);
    command_run(&ran, "render stage.usda --spp 1 -q -o x.exr --stats out.json");
    assert_ran(&ran, 0, "");
    assert_non_null(strstr(ran.out, "\"version\""));
    unlink("x.exr");
    if (geteuid() == 0) // whom permissions do not stop
        return;
    assert_int_equal(mkdir("locked", 0555), 0);
    command_run(&ran, "render stage.usda --spp 1 -o locked/x.exr");
    assert_refused(&ran, 4, "locked");
}

static void files_that_do_not_fit(void **state)
{
    (void)state;
    Ran ran;
    // Little memory, so that rays have to go to disk: what is named when there is too little.
    char text[2048];
    const char *asked = "render stage.usda --spp 1 --size 256x256 --first-hit-samples 100 -o x.exr";
    command_run(&ran, "%s --memory 1M", asked);
    assert_refused(&ran, 2, "--memory");
    const char *named = strstr(ran.err, "at least ");
    assert_non_null(named);
    snprintf(text, sizeof text, "%s --memory %ldM", asked, strtol(named + 9, NULL, 10) + 3);
    command_run_limited(&ran, 16384, text);
    assert_refused(&ran, 4, "--scratch");
    command_run_limited(&ran, 16384, "render stage.usda --spp 1 --env sky -o x.exr");
    assert_refused(&ran, 4, "TMPDIR");
    // The scratch files of such batches fit, the picture does not.
    command_run_limited(&ran, 16384,
                        "render stage.usda --spp 1 --batch 256 --size 128x128 -o x.exr");
    assert_refused(&ran, 4, "x.exr");
    assert_int_equal(system("ls | grep -q partial"), 256);
    // Nor does the converted form of a texture, which is left out.
    command_run(&ran, "render stage.usda --spp 1 -q -o image.png");
    textured(text, sizeof text,
             "        uniform token info:id = \"UsdUVTexture\"\n"
             "        asset inputs:file = @image.png@\n        float3 outputs:rgb\n");
    write_text("bad.usda", text);
    command_run_limited(&ran, 65536,
                        "render bad.usda --spp 1 --batch 256 --size 8x8 --headlight "
                        "--converted converted -o x.exr");
    assert_rendered(&ran, "image.png: warning: its converted form");
    assert_int_equal(system("ls converted | grep -q ."), 256);
}

// Statistics that cannot be written to the end are none.
static void statistics_that_do_not_fit(void **state)
{
    (void)state;
    Ran ran;
    FILE *stage = fopen("many.usda", "w");
    assert_non_null(stage);
    fprintf(stage, "#usda 1.0\n");
    for (int i = 0; i < 400; i++) // each is named in the statistics
        fprintf(stage, "def BasisCurves \"curve_%d\"\n{\n}\n", i);
    assert_int_equal(fclose(stage), 0);
    command_run_limited(&ran, 16384,
                        "render many.usda --headlight --spp 1 --batch 256 --size 8x8 -q "
                        "-o x.exr --stats x.json");
    assert_ran(&ran, 4, "x.json");
    assert_false(file_exists("x.json"));
    assert_int_equal(symlink("elsewhere.json", "link.json"), 0);
    command_run_limited(&ran, 16384,
                        "render many.usda --headlight --spp 1 --batch 256 --size 8x8 -q "
                        "-o x.exr --stats link.json");
    assert_ran(&ran, 4, "link.json");
    assert_int_equal(unlink("link.json"), 0); // a link, /dev/stdout for one, stays what it is
}

// A stream that cannot be written, or is closed, is said so, and no file takes its place.
static void standard_streams_that_fail(void **state)
{
    (void)state;
    static const char *const arguments[] = {"cat stage.usda",
                                            "tree stage.usda",
                                            "check stage.usda",
                                            "--version",
                                            "--help",
                                            "render --help",
                                            "render stage.usda --list-cameras"};
    for (size_t i = 0; i < sizeof arguments / sizeof arguments[0]; i++) {
        char command[512];
        snprintf(command, sizeof command, "%s %s > /dev/full 2> said.txt", COHORT_COMMAND,
                 arguments[i]);
        assert_int_equal(system(command), 4 << 8);
        assert_int_equal(system("grep -q 'error:' said.txt"), 0);
        snprintf(command, sizeof command, "%s %s >&- 2> said.txt", COHORT_COMMAND, arguments[i]);
        assert_int_equal(system(command), 4 << 8);
    }
    assert_int_equal(system(COHORT_COMMAND " render stage.usda --spp 1 -q -o open.exr"), 0);
    assert_int_equal(system(COHORT_COMMAND " render stage.usda --spp 1 -o x.exr <&- >&- 2>&-"), 0);
    assert_int_equal(system(COHORT_COMMAND " diff x.exr open.exr > said.txt"), 0);
}

static void names_of_any_bytes(void **state)
{
    (void)state;
    assert_int_equal(system("cp stage.usda \"$(printf 'caf\\351 \\377.usda')\""), 0);
    assert_int_equal(system(COHORT_COMMAND " render \"$(printf 'caf\\351 \\377.usda')\" --spp 1 -q "
                                           "-o \"$(printf 'o\\351.exr')\" --stats x.json"),
                     0);
    assert_int_equal(system("test -s \"$(printf 'o\\351.exr')\""), 0);
    assert_int_equal(system("grep -q 'caf.ufffd .ufffd.usda' x.json"), 0);
}

static void folders_and_files_of_options(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "render stage.usda --spp 1 -o x.exr --scratch nofolder");
    assert_refused(&ran, 4, "--scratch");
    command_run(&ran, "render stage.usda --spp 1 -o x.exr --env none.hdr");
    assert_refused(&ran, 3, "none.hdr");
    assert_int_equal(system("TMPDIR=/nofolder " COHORT_COMMAND
                            " render stage.usda --spp 1 -o x.exr "
                            "--scratch . --env sky 2> said.txt"),
                     4 << 8);
    assert_int_equal(system("grep -q '/nofolder.*TMPDIR' said.txt"), 0);
    command_run(&ran, "render stage.usda --spp 1 -o x.exr --env stage.usda");
    assert_refused(&ran, 3, "--env stage.usda: cannot use image");
    command_run(&ran, "render stage.usda --spp 1 -o x.exr -o x.png --ocio none.ocio");
    assert_refused(&ran, 3, "none.ocio");
}

static void absurd_work_can_be_stopped(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "render stage.usda --spp 2147483648 --time-limit 0.1 -o x.exr");
    assert_rendered(&ran, "wrote");
    unlink("x.exr");
    command_run(&ran, "render stage.usda --spp 1 --size 65536x65536 --memory 100M -o x.exr");
    assert_int_not_equal(ran.code, 0);
    assert_true(ran.code < 6);
    assert_int_equal(line_count(ran.err), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(stages_that_cannot_be_read, without_output),
        cmocka_unit_test_setup(warnings_in_the_same_words_are_counted, without_output),
        cmocka_unit_test_setup(limits_name_the_flag_that_moves_them, without_output),
        cmocka_unit_test_setup(arcs_that_lead_nowhere, without_output),
        cmocka_unit_test_setup(textures, without_output),
        cmocka_unit_test_setup(without_the_image_module, without_output),
        cmocka_unit_test_setup(a_ptex_file_of_another_mesh, without_output),
        cmocka_unit_test_setup(meshes, without_output),
        cmocka_unit_test_setup(lights_without_area, without_output),
        cmocka_unit_test_setup(matrices_without_inverse, without_output),
        cmocka_unit_test_setup(no_camera_frames_the_stage, without_output),
        cmocka_unit_test_setup(no_lights_are_dark, without_output),
        cmocka_unit_test_setup(what_is_grouped_keeps_its_value, without_output),
        cmocka_unit_test_setup(values_of_one_prim_are_no_prims, without_output),
        cmocka_unit_test_setup(what_is_not_honored_is_grouped, without_output),
        cmocka_unit_test_setup(outputs_that_cannot_be_written, without_output),
        cmocka_unit_test_setup(files_that_do_not_fit, without_output),
        cmocka_unit_test_setup(statistics_that_do_not_fit, without_output),
        cmocka_unit_test_setup(standard_streams_that_fail, without_output),
        cmocka_unit_test_setup(names_of_any_bytes, without_output),
        cmocka_unit_test_setup(folders_and_files_of_options, without_output),
        cmocka_unit_test_setup(absurd_work_can_be_stopped, without_output),
    };
    return cmocka_run_group_tests(tests, scratch_enter, scratch_leave);
}
