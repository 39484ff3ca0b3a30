#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

void progress_begin(Progress *p, bool is_alf, bool is_quiet, size_t frame_count)
{
    memset(p, 0, sizeof *p);
    p->has_alf = is_alf;
    p->has_bar = !is_quiet && isatty(STDERR_FILENO);
    p->last_percent = -1;
    p->frame_count = frame_count;
}

static void format_time(double seconds, char *out, size_t size)
{
    int s = seconds < 0.0 ? 0 : seconds > 359999.0 ? 359999 : (int)seconds;
    if (s >= 3600)
        snprintf(out, size, "%d:%02d:%02d", s / 3600, s / 60 % 60, s % 60);
    else
        snprintf(out, size, "%d:%02d", s / 60, s % 60);
}

static void draw_bar(const Progress *p, double fraction, double seconds,
                     const CohortRenderStats *stats)
{
    char bar[25], left[16] = "-";
    int full = (int)(fraction * 24.0);
    for (int i = 0; i < 24; i++)
        bar[i] = i < full ? '=' : ' ';
    bar[24] = 0;
    if (fraction > 0.02)
        format_time(seconds * (1.0 - fraction) / fraction, left, sizeof left);
    double rate =
        stats->seconds_total > 0.0 ? (double)stats->rays_traced / stats->seconds_total : 0.0;
    fprintf(stderr, "\r[%s] %3d%%  %llu spp  %.2f Mrays/s  error %.4f  %s left ", bar,
            (int)(fraction * 100.0), (unsigned long long)stats->samples_per_pixel, rate * 1e-6,
            stats->samples_per_pixel > 1 ? stats->mean_error : 0.0, left);
    if (p->frame_count > 1)
        fprintf(stderr, " frame %zu/%zu ", p->frame + 1, p->frame_count);
    fflush(stderr);
}

void progress_update(Progress *p, double fraction, double seconds, const CohortRenderStats *stats)
{
    if (p->has_bar)
        draw_bar(p, fraction, seconds, stats);
    double overall = ((double)p->frame + fraction) / (double)p->frame_count;
    int percent = (int)(overall * 100.0 + 1e-9);
    if (p->has_alf && percent > p->last_percent) {
        printf("ALF_PROGRESS %d%%\n", percent);
        fflush(stdout);
        p->last_percent = percent;
    }
}

void progress_end(Progress *p)
{
    if (p->has_bar)
        fprintf(stderr, "\r%100s\r", "");
}
