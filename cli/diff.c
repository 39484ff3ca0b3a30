// cohort diff: how far apart two EXR images are.

#include "cli.h"
#include "options.h"

#include "cohort/image.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// relMSE = mean of (a - b)^2 / (b^2 + 0.01) over pixels and channels; b is the reference.
typedef struct Difference {
    double relmse, largest;
    size_t different, broken, count;
    uint32_t x, y; // of the largest
} Difference;

static void compare_channel(const CohortImage *a, const CohortImage *b, const char *name,
                            Difference *d)
{
    size_t pixels = (size_t)a->width * a->height;
    const float *p = a->pixels + pixels * (size_t)cohort_image_channel(a, name);
    const float *q = b->pixels + pixels * (size_t)cohort_image_channel(b, name);
    for (size_t i = 0; i < pixels; i++) {
        double x = (double)p[i], y = (double)q[i];
        bool same = memcmp(&p[i], &q[i], sizeof p[i]) == 0;
        d->different += !same;
        d->count++;
        if (!isfinite(x) || !isfinite(y)) {
            d->broken += !same;
            continue;
        }
        double delta = x - y;
        d->relmse += delta * delta / (y * y + 0.01);
        if (fabs(delta) > d->largest) {
            d->largest = fabs(delta);
            d->x = (uint32_t)(i % a->width);
            d->y = (uint32_t)(i / a->width);
        }
    }
}

static int report(const CohortImage *a, const CohortImage *b, double tolerance)
{
    if (a->width != b->width || a->height != b->height) {
        printf("different sizes: %u x %u and %u x %u\n", a->width, a->height, b->width, b->height);
        return EXIT_DIFFERENT;
    }
    Difference color = {0}, all = {0};
    bool same_channels = a->channel_count == b->channel_count;
    for (size_t i = 0; i < a->channel_count; i++) {
        const char *name = a->names[i];
        if (cohort_image_channel(b, name) < 0) {
            printf("only in the first: %s\n", name);
            same_channels = false;
            continue;
        }
        compare_channel(a, b, name, &all);
        if (!strcmp(name, "R") || !strcmp(name, "G") || !strcmp(name, "B"))
            compare_channel(a, b, name, &color);
    }
    for (size_t i = 0; i < b->channel_count; i++)
        if (cohort_image_channel(a, b->names[i]) < 0)
            printf("only in the second: %s\n", b->names[i]);
    Difference *shown = color.count ? &color : &all;
    double relmse = shown->count ? shown->relmse / (double)shown->count : 0.0;
    printf("relMSE %.6g, largest difference %.6g at (%u, %u), %zu of %zu values differ", relmse,
           all.largest, all.x, all.y, all.different, all.count);
    printf(all.broken ? ", %zu of them not finite\n" : "\n", all.broken);
    bool ok = same_channels &&
              (tolerance > 0.0 ? relmse <= tolerance && !all.broken : all.different == 0);
    return ok ? EXIT_WRITTEN : EXIT_DIFFERENT;
}

int command_diff(int argc, char **argv)
{
    double tolerance = 0.0;
    bool wants_help = false;
    const Option table[] = {
        {"tolerance", 't', OPTION_NUMBER, &tolerance, 0.0, 1e9, "X", NULL,
         "largest relMSE that counts as equal; 0 = every bit equal (the default)"},
        {"help", 'h', OPTION_FLAG, &wants_help, 0, 0, NULL, NULL, "show this"},
    };
    static const CommandHead head = {
        "diff",
        "cohort diff A.exr B.exr [options]\n\n"
        "Prints relMSE = mean (A - B)^2 / (B^2 + 0.01) of R, G, B, the largest difference of\n"
        "any channel, and how many values differ in any bit.\n\n",
        "\nExit codes: 0 equal within the tolerance, 1 different, 2 usage, 3 a file cannot be\n"
        "read, 4 standard output cannot be written.\n",
        2, "two images"};
    int first, code = options_begin(&head, table, sizeof table / sizeof table[0], &wants_help, argc,
                                    argv, &first);
    if (code >= 0)
        return code;
    CohortError err = {0};
    CohortImage a = {0}, b = {0};
    code = EXIT_LOAD;
    if (cohort_exr_read(argv[first], &a, &err) && cohort_exr_read(argv[first + 1], &b, &err))
        code = report(&a, &b, tolerance);
    else
        print_failure("error", &err);
    cohort_image_clear(&a);
    cohort_image_clear(&b);
    return code;
}
