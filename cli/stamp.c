#include "stamp.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static CohortAttribute *add(StampAttributes *a, const char *name, CohortAttributeType type)
{
    CohortAttribute *attribute = &a->list[a->count++];
    memset(attribute, 0, sizeof *attribute);
    attribute->name = name;
    attribute->type = type;
    return attribute;
}

static void add_text(StampAttributes *a, const char *name, const char *text)
{
    if (text && text[0])
        add(a, name, COHORT_ATTRIBUTE_STRING)->text = text;
}

static void add_int(StampAttributes *a, const char *name, int32_t value)
{
    add(a, name, COHORT_ATTRIBUTE_INT)->integer = value;
}

static void add_float(StampAttributes *a, const char *name, double value)
{
    add(a, name, COHORT_ATTRIBUTE_FLOAT)->numbers[0] = (float)value;
}

static void add_hex(StampAttributes *a, const char *name, uint64_t value)
{
    char *text = a->texts[a->text_count++];
    snprintf(text, sizeof a->texts[0], "%016llx", (unsigned long long)value);
    add_text(a, name, text);
}

static void add_seed_text(StampAttributes *a, uint32_t seed)
{
    char *text = a->texts[a->text_count++];
    snprintf(text, sizeof a->texts[0], "%u", (unsigned)seed);
    add_text(a, "cohort:seed", text);
}

static void add_matrix(StampAttributes *a, const char *name, double m[4][4])
{
    CohortAttribute *attribute = add(a, name, COHORT_ATTRIBUTE_M44F);
    for (int i = 0; i < 16; i++)
        attribute->numbers[i] = (float)(m[i / 4][i % 4] + 0.0); // no -0
}

// capDate and utcOffset, as OpenEXR has them: local time, and the seconds that lead to UTC.
static void add_date(StampAttributes *a)
{
    time_t seconds = time(NULL);
    struct tm local;
    char *text = a->texts[a->text_count++];
    if (!localtime_r(&seconds, &local) ||
        !strftime(text, sizeof a->texts[0], "%Y:%m:%d %H:%M:%S", &local))
        return;
    add_text(a, "capDate", text);
    add_float(a, "utcOffset", 0.0 - (double)local.tm_gmtoff);
}

// Inverse of an affine matrix of row vectors; false when it has none.
static bool invert_affine(const double m[4][4], double out[4][4])
{
    double det = 0.0;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out[c][r] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
            if (r == 0)
                det += m[0][c] * out[c][0];
        }
    if (det == 0.0 || !isfinite(1.0 / det))
        return false;
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            out[r][c] /= det;
        out[r][3] = 0.0;
    }
    for (int c = 0; c < 3; c++)
        out[3][c] = -(m[3][0] * out[0][c] + m[3][1] * out[1][c] + m[3][2] * out[2][c]);
    out[3][3] = 1.0;
    return true;
}

// OpenEXR's camera space to its NDC: (0, 0) is the top left of the display window, (1, 1) the
// bottom right; depth runs from 0 at the near plane to 1 at the far one.
static void camera_to_ndc(const CohortCameraDesc *lens, double out[4][4])
{
    const double *w = lens->window;
    double x = 1.0 / (w[1] - w[0]), y = 1.0 / (w[3] - w[2]);
    double near = lens->clip_near, depth = lens->clip_far - lens->clip_near;
    memset(out, 0, 16 * sizeof(double));
    out[0][0] = x;
    out[1][1] = -y;
    // The window lies at distance 1 in perspective, so its offset scales with z.
    int offset_row = lens->orthographic ? 3 : 2;
    out[offset_row][0] = -w[0] * x;
    out[offset_row][1] = w[3] * y;
    out[offset_row][3] = 1.0;
    out[2][2] = lens->orthographic ? 1.0 / depth : lens->clip_far / depth;
    out[3][2] = lens->orthographic ? -near / depth : -near * lens->clip_far / depth;
}

// OpenEXR's camera space is left-handed and looks along +Z; USD's cameras look along -Z.
static void add_camera(StampAttributes *a, const CohortCameraDesc *lens)
{
    const double *w = lens->window;
    CohortAttribute *center = add(a, "screenWindowCenter", COHORT_ATTRIBUTE_V2F);
    center->numbers[0] = (float)(0.5 * (w[0] + w[1]));
    center->numbers[1] = (float)(0.5 * (w[2] + w[3]));
    add_float(a, "screenWindowWidth", w[1] - w[0]);
    double camera[4][4], project[4][4], ndc[4][4] = {{0}};
    if (!invert_affine(lens->transform, camera))
        return;
    for (int r = 0; r < 4; r++)
        camera[r][2] = -camera[r][2];
    camera_to_ndc(lens, project);
    for (int r = 0; r < 4; r++)
        for (int c = 0; c < 4; c++)
            for (int k = 0; k < 4; k++)
                ndc[r][c] += camera[r][k] * project[k][c];
    add_matrix(a, "worldToCamera", camera);
    add_matrix(a, "worldToNDC", ndc);
}

static void add_view(StampAttributes *a, const CohortView *view)
{
    add_text(a, "cohort:display", cohort_view_display_name(view));
    add_text(a, "cohort:view", cohort_view_view_name(view));
    add_text(a, "cohort:ocioCacheId", cohort_view_config_cache_id(view));
}

bool stamp_attributes(const OutputStamp *s, StampAttributes *a, CohortError *err)
{
    a->count = a->text_count = 0;
    add_text(a, "software", "cohort");
    add_text(a, "cohort:version", cohort_version());
    add_text(a, "cohort:stage", s->stage);
    add_hex(a, "cohort:stageHash", s->stage_hash);
    add_text(a, "cohort:camera", s->camera);
    add_text(a, "cohort:filter", s->filter);
    add_text(a, "cohort:renderStatus", s->status);
    add_text(a, "cohort:isa", s->stats.isa);
    add_text(a, "cohort:ocioConfig", s->ocio_config);
    add_text(a, "cohort:renderingColorSpace", s->rendering_space);
    add_int(a, "cohort:samplesPerPixel", (int32_t)s->stats.samples_per_pixel);
    if (s->seed <= INT32_MAX)
        add_int(a, "cohort:seed", (int32_t)s->seed);
    else // a header holds no larger integer
        add_seed_text(a, s->seed);
    add_float(a, "cohort:meanError", s->stats.mean_error);
    add_float(a, "cohort:renderSeconds", s->stats.seconds_total);
    if (isfinite(s->time))
        add_float(a, "cohort:frame", s->time);
    if (s->frames_per_second > 0.0)
        add_float(a, "cohort:framesPerSecond", s->frames_per_second);
    add_date(a);
    if (s->has_lens)
        add_camera(a, &s->lens);
    if (s->view)
        add_view(a, s->view);
    CohortAttribute *primaries = add(a, "chromaticities", COHORT_ATTRIBUTE_CHROMATICITIES);
    if (!cohort_rendering_space(s->ocio_config, s->rendering_space, a->space, primaries->numbers,
                                err))
        return false;
    add_text(a, "cohort:colorSpace", a->space);
    return true;
}
