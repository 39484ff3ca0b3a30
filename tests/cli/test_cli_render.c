// Files that a render writes: pixels, channels, metadata, statistics, progress. Also tests
// frame.c, output.c, progress.c, render_command.c, stamp.c and stats_file.c.

#include "command.h"

#include "cohort/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void render(Ran *ran, const char *arguments)
{
    command_run(ran, "render stage.usda --spp 2 %s", arguments);
    if (ran->code)
        fail_msg("render %s: exit code %d: %s", arguments, ran->code, ran->err);
}

static void read_image(const char *path, CohortImage *image)
{
    CohortError err = {0};
    memset(image, 0, sizeof *image);
    if (!cohort_exr_read(path, image, &err))
        fail_msg("%s", err.message);
}

static const float *channel(const CohortImage *image, const char *name)
{
    int index = cohort_image_channel(image, name);
    if (index < 0)
        fail_msg("no channel %s", name);
    return image->pixels + (size_t)index * image->width * image->height;
}

static void assert_same(const char *a, const char *b)
{
    Ran ran;
    command_run(&ran, "diff %s %s", a, b);
    if (ran.code)
        fail_msg("%s and %s: %s%s", a, b, ran.out, ran.err);
}

static void several_outputs_of_one_render(void **state)
{
    (void)state;
    Ran ran;
    render(&ran, "-o a.exr -o b.EXR -o a.png");
    assert_int_equal(line_count(ran.err), 3);
    assert_same("a.exr", "b.EXR");
    CohortImage image;
    read_image("a.exr", &image);
    assert_int_equal(image.width, 24);
    assert_int_equal(image.height, 18);
    assert_int_equal(image.channel_count, 4);
    size_t center = 9 * 24 + 12;
    // The ball is orange, lit from the upper right, on nothing.
    assert_true(channel(&image, "R")[center] > 2.0f * channel(&image, "B")[center]);
    assert_float_equal(channel(&image, "A")[center], 1.0f, 1e-5f);
    assert_true(channel(&image, "A")[0] == 0.0f);
    assert_true(channel(&image, "R")[6 * 24 + 14] > 2.0f * channel(&image, "R")[12 * 24 + 9]);
    cohort_image_clear(&image);
    FILE *png = fopen("a.png", "rb");
    unsigned char magic[24] = {0};
    assert_non_null(png);
    assert_int_equal(fread(magic, 1, sizeof magic, png), sizeof magic);
    fclose(png);
    assert_memory_equal(magic, "\x89PNG\r\n\x1a\n", 8);
    assert_int_equal(magic[19], 24);
    assert_int_equal(magic[23], 18);
}

static void aovs_have_the_names_compositors_know(void **state)
{
    (void)state;
    static const char *const names[] = {"A",        "B",         "G",        "R",
                                        "Z",        "albedo.B",  "albedo.G", "albedo.R",
                                        "depth",    "elementId", "error",    "normal.X",
                                        "normal.Y", "normal.Z",  "primId",   "sampleCount"};
    Ran ran;
    render(&ran, "-o aovs.exr --aov depth --aov cameraDepth --aov normal --aov albedo --aov primId "
                 "--aov elementId --aov sampleCount --aov error");
    CohortImage image;
    read_image("aovs.exr", &image);
    assert_int_equal(image.channel_count, sizeof names / sizeof names[0]);
    for (size_t i = 0; i < image.channel_count; i++)
        assert_string_equal(image.names[i], names[i]);
    size_t center = 9 * 24 + 12;
    assert_float_equal(channel(&image, "Z")[center], 9.0f, 0.1f);
    assert_true(isinf(channel(&image, "Z")[0]));
    assert_true(channel(&image, "normal.Z")[center] > 0.9f);
    assert_true(channel(&image, "sampleCount")[center] == 2.0f);
    cohort_image_clear(&image);
    // Asking for more changes no pixel of the picture.
    render(&ran, "-o plain.exr");
    CohortImage plain, full;
    read_image("plain.exr", &plain);
    read_image("aovs.exr", &full);
    size_t bytes = sizeof(float) * 24 * 18;
    assert_memory_equal(channel(&plain, "R"), channel(&full, "R"), bytes);
    cohort_image_clear(&plain);
    cohort_image_clear(&full);
}

static void options_change_what_they_say(void **state)
{
    (void)state;
    Ran ran;
    CohortImage image;
    render(&ran, "-o small.exr --variant /World/ball{size=small}");
    read_image("small.exr", &image);
    assert_true(channel(&image, "A")[9 * 24 + 16] == 0.0f);
    cohort_image_clear(&image);
    render(&ran, "-o wide.exr --size 20x10 --camera side");
    read_image("wide.exr", &image);
    assert_int_equal(image.width, 20);
    assert_int_equal(image.height, 10);
    cohort_image_clear(&image);
    command_run(&ran, "render stage.usda --list-cameras");
    assert_int_equal(ran.code, 0);
    assert_string_equal(ran.out, "/World/cam (default)\n/World/side\n");
}

static void frames_are_files(void **state)
{
    (void)state;
    Ran ran;
    render(&ran, "-o f.##.exr --frames 4:1x-3 --stats f.##.json");
    assert_true(file_exists("f.04.exr") && file_exists("f.01.exr") && file_exists("f.01.json"));
    assert_false(file_exists("f.02.exr"));
    render(&ran, "-o earliest.exr");
    assert_same("earliest.exr", "f.01.exr");
    command_run(&ran, "diff f.01.exr f.04.exr");
    assert_int_equal(ran.code, 1);
    command_run(&ran, "diff f.01.exr f.04.exr -t 1000");
    assert_int_equal(ran.code, 0);
    render(&ran, "-o one.##.#.exr --frames 2.5");
    assert_true(file_exists("one.02.5.exr"));
}

static void the_product_names_the_file(void **state)
{
    (void)state;
    Ran ran;
    render(&ran, "");
    assert_true(file_exists("product.exr"));
    assert_non_null(strstr(ran.err, "product.exr"));
    write_text("null.usda", "#usda 1.0\n(\n    renderSettingsPrimPath = \"/S\"\n)\n"
                            "def RenderSettings \"S\"\n{\n    rel products = </S/P>\n"
                            "    def RenderProduct \"P\"\n    {\n"
                            "        token productName = \"husk:null_raster\"\n    }\n}\n");
    command_run(&ran, "render null.usda --spp 1 --size 8x8");
    assert_int_equal(ran.code, 0);
    assert_null(strstr(ran.err, "wrote"));
    assert_false(file_exists("husk:null_raster"));
    write_text("unnamed.usda", "#usda 1.0\n");
    command_run(&ran, "render unnamed.usda --spp 1");
    assert_ran(&ran, 2, "-o");
}

// Finds the bytes of an EXR attribute's value: name, type, size, value.
static const char *attribute(const char *header, size_t size, const char *name, const char *type)
{
    size_t n = strlen(name) + 1, k = strlen(type) + 1;
    for (size_t i = 0; i + n + k + 4 < size; i++)
        if (!memcmp(header + i, name, n) && !memcmp(header + i + n, type, k))
            return header + i + n + k + 4;
    fail_msg("the header has no attribute %s of type %s", name, type);
    return NULL;
}

// Where a point of the world lands, by a header's matrix of row vectors.
static void transform(const char *matrix, const double point[3], double out[3])
{
    float m[4][4];
    double p[4];
    memcpy(m, matrix, sizeof m);
    for (int c = 0; c < 4; c++)
        p[c] = point[0] * (double)m[0][c] + point[1] * (double)m[1][c] +
               point[2] * (double)m[2][c] + (double)m[3][c];
    for (int c = 0; c < 3; c++)
        out[c] = p[c] / p[3];
}

static void assert_lands(const char *matrix, double x, double y, double z, double to_x, double to_y,
                         double to_z)
{
    double out[3], point[3] = {x, y, z};
    transform(matrix, point, out);
    assert_true(fabs(out[0] - to_x) < 1e-4 && fabs(out[1] - to_y) < 1e-4 &&
                fabs(out[2] - to_z) < 1e-4);
}

static size_t read_header(const char *path, char *out, size_t size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t n = fread(out, 1, size, file);
    fclose(file);
    return n;
}

static void the_header_says_where_it_comes_from(void **state)
{
    (void)state;
    static char header[8192];
    static const char *const texts[] = {
        "cohort:version", "cohort:stage",        "cohort:stageHash", "cohort:camera",
        "cohort:filter",  "cohort:renderStatus", "cohort:isa",       "cohort:colorSpace",
        "cohort:display", "cohort:view",         "capDate",          "software"};
    Ran ran;
    render(&ran, "-o meta.exr -o meta.png --seed 9");
    size_t size = read_header("meta.exr", header, sizeof header);
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        attribute(header, size, texts[i], "string");
    assert_memory_equal(attribute(header, size, "cohort:renderStatus", "string"), "complete", 8);
    assert_memory_equal(attribute(header, size, "cohort:camera", "string"), "/World/cam", 10);
    int32_t number;
    memcpy(&number, attribute(header, size, "cohort:samplesPerPixel", "int"), 4);
    assert_int_equal(number, 2);
    memcpy(&number, attribute(header, size, "cohort:seed", "int"), 4);
    assert_int_equal(number, 9);
    float primaries[8], frame;
    memcpy(primaries, attribute(header, size, "chromaticities", "chromaticities"), 32);
    assert_float_equal(primaries[0], 0.64f, 1e-6f);
    assert_float_equal(primaries[7], 0.329f, 1e-6f);
    memcpy(&frame, attribute(header, size, "cohort:frame", "float"), 4);
    assert_true(frame == 1.0f);
}

static void the_header_has_the_camera(void **state)
{
    (void)state;
    static char header[8192];
    Ran ran;
    render(&ran, "-o lens.exr --frames 4");
    size_t size = read_header("lens.exr", header, sizeof header);
    // The camera stands at (3, 0, 10) and looks along -Z; its window is 0.4 x 0.3 at distance 1.
    // OpenEXR's camera space is left-handed: +Z forward, +X right, +Y up.
    const char *camera = attribute(header, size, "worldToCamera", "m44f");
    assert_lands(camera, 3, 0, 10, 0, 0, 0);
    assert_lands(camera, 3, 0, 8, 0, 0, 2);
    assert_lands(camera, 4, 1, 8, 1, 1, 2);
    // Near and far are 1 and 1e6, the defaults.
    const char *ndc = attribute(header, size, "worldToNDC", "m44f");
    assert_lands(ndc, 3, 0, 9, 0.5, 0.5, 0.0);
    assert_lands(ndc, 3 - 0.2, 0.15, 9, 0, 0, 0);
    assert_lands(ndc, 3 + 0.4, -0.3, 8, 1, 1, 0.5);
    float width, center[2];
    memcpy(&width, attribute(header, size, "screenWindowWidth", "float"), 4);
    memcpy(center, attribute(header, size, "screenWindowCenter", "v2f"), 8);
    assert_float_equal(width, 0.4f, 1e-6f);
    assert_true(center[0] == 0.0f && center[1] == 0.0f);
}

static void statistics_have_stable_keys(void **state)
{
    (void)state;
    static const char *const keys[] = {"version",
                                       "stage",
                                       "status",
                                       "rounds",
                                       "samples_per_pixel",
                                       "mean_error",
                                       "rays",
                                       "made",
                                       "camera",
                                       "bsdf",
                                       "light",
                                       "traced",
                                       "ended",
                                       "hit",
                                       "miss",
                                       "blocked",
                                       "bytes_per_ray",
                                       "batches",
                                       "per_bin",
                                       "bytes_written",
                                       "bytes_read",
                                       "traversal",
                                       "isa",
                                       "textures",
                                       "lookups",
                                       "film",
                                       "saturated",
                                       "dropped_not_finite",
                                       "seconds",
                                       "load",
                                       "sort_rays",
                                       "traverse",
                                       "sort_hits",
                                       "shade",
                                       "render",
                                       "total",
                                       "scene",
                                       "meshes",
                                       "instances",
                                       "triangles",
                                       "peak_resident_bytes",
                                       "builds",
                                       "materials_bound",
                                       "not_honored",
                                       "warnings"};
    Ran ran;
    static char text[16384];
    render(&ran, "-o s.exr --stats s.json");
    size_t size = read_header("s.json", text, sizeof text - 1);
    text[size] = 0;
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        char key[64];
        snprintf(key, sizeof key, "\"%s\": ", keys[i]);
        if (!strstr(text, key))
            fail_msg("the statistics have no %s", key);
    }
    assert_non_null(strstr(text, "\"status\": \"complete\""));
    int depth = 0;
    for (const char *p = text; *p; p++) {
        depth += *p == '{' || *p == '[';
        depth -= *p == '}' || *p == ']';
        assert_true(depth > 0 || p[1] == '\n' || !p[1]);
    }
    assert_int_equal(depth, 0);
}

static void progress_for_farms_only_rises(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "render stage.usda --spp 64 -o p.#.exr --frames 1:3 --progress alf -q");
    assert_int_equal(ran.code, 0);
    int last = -1, lines = 0;
    char *rest = ran.out;
    for (char *line; (line = strsep(&rest, "\n")) != NULL && line[0]; lines++) {
        int percent = -1;
        char end = 0;
        assert_int_equal(sscanf(line, "ALF_PROGRESS %d%c", &percent, &end), 2);
        assert_true(end == '%' && percent > last && percent <= 100);
        last = percent;
    }
    assert_int_equal(last, 100);
    assert_true(lines >= 3);
}

static void quiet_is_silent(void **state)
{
    (void)state;
    Ran ran;
    render(&ran, "-o q.exr -o q.png -q");
    assert_string_equal(ran.out, "");
    assert_string_equal(ran.err, "");
}

// Threads, batches, sorts, memory and instruction sets decide how fast, never what.
static void schedules_give_one_picture(void **state)
{
    (void)state;
    static const char *const schedules[] = {"--threads 1",  "--batch 256",
                                            "--sort none",  "--sorter exact --sort both",
                                            "--isa scalar", "--memory 256M"};
    Ran ran;
    render(&ran, "-o first.exr");
    for (size_t i = 0; i < sizeof schedules / sizeof schedules[0]; i++) {
        char arguments[128];
        snprintf(arguments, sizeof arguments, "-o other.exr %s", schedules[i]);
        render(&ran, arguments);
        assert_same("first.exr", "other.exr");
    }
}

// A limit that comes before the noise that was asked for is named.
static void noise_that_is_not_reached_is_said(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "render stage.usda -o n.exr --spp 4 --noise 1e-9");
    assert_ran(&ran, 0, "--spp ended it at a mean error of ");
    command_run(&ran, "render stage.usda -o n.exr --spp 1000000000 --noise 1e-9 --time-limit 0.2");
    assert_ran(&ran, 0, "--time-limit ended it");
    command_run(&ran, "render stage.usda -o n.exr --spp 4 --noise 1e-9 -q");
    assert_ran(&ran, 0, "");
    assert_string_equal(ran.err, "");
    command_run(&ran, "render stage.usda -o n.exr --spp 1000000000 --noise 0.9");
    assert_ran(&ran, 0, "wrote");
    assert_null(strstr(ran.err, "ended it"));
}

static void options_that_no_output_heeds(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "render stage.usda -o h.png --spp 1 --aov normal");
    assert_ran(&ran, 2, "--aov normal: only .exr outputs hold it");
    assert_false(file_exists("h.png"));
    command_run(&ran, "render stage.usda -o h.png -o h.exr --spp 1 --aov normal --view Raw");
    assert_ran(&ran, 0, "wrote h.exr");
    assert_null(strstr(ran.err, "warning"));
    command_run(&ran, "render stage.usda -o h.exr --spp 1 --view Raw");
    assert_ran(&ran, 0, "--view change .png outputs alone");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(several_outputs_of_one_render),
        cmocka_unit_test(aovs_have_the_names_compositors_know),
        cmocka_unit_test(options_change_what_they_say),
        cmocka_unit_test(frames_are_files),
        cmocka_unit_test(the_product_names_the_file),
        cmocka_unit_test(the_header_says_where_it_comes_from),
        cmocka_unit_test(the_header_has_the_camera),
        cmocka_unit_test(statistics_have_stable_keys),
        cmocka_unit_test(progress_for_farms_only_rises),
        cmocka_unit_test(quiet_is_silent),
        cmocka_unit_test(schedules_give_one_picture),
        cmocka_unit_test(noise_that_is_not_reached_is_said),
        cmocka_unit_test(options_that_no_output_heeds),
    };
    return cmocka_run_group_tests(tests, scratch_enter, scratch_leave);
}
