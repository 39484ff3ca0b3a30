#include "stats_file.h"

#include "cli.h"
#include "json_text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

// Prints JSON: a name opens a member, commas take care of themselves.
typedef struct Json {
    FILE *file;
    bool needs_comma;
} Json;

static void name(Json *j, const char *key)
{
    fputs(j->needs_comma ? ",\n" : "\n", j->file);
    if (key) {
        json_print_text(key, j->file);
        fputs(": ", j->file);
    }
    j->needs_comma = true;
}

static void open_scope(Json *j, const char *key, char bracket)
{
    name(j, key);
    fputc(bracket, j->file);
    j->needs_comma = false;
}

static void close_scope(Json *j, char bracket)
{
    fprintf(j->file, "\n%c", bracket);
    j->needs_comma = true;
}

static void count(Json *j, const char *key, uint64_t value)
{
    name(j, key);
    fprintf(j->file, "%llu", (unsigned long long)value);
}

static void number(Json *j, const char *key, double value)
{
    name(j, key);
    if (isfinite(value))
        fprintf(j->file, "%.9g", value);
    else
        fputs("null", j->file);
}

static void string(Json *j, const char *key, const char *value)
{
    name(j, key);
    json_print_text(value, j->file);
}

static void put_rays(Json *j, const CohortRenderStats *s)
{
    open_scope(j, "rays", '{');
    count(j, "made", s->rays_made);
    count(j, "camera", s->rays_camera);
    count(j, "bsdf", s->rays_bsdf);
    count(j, "light", s->rays_light);
    count(j, "traced", s->rays_traced);
    count(j, "ended", s->ends_hit + s->ends_miss + s->ends_blocked + s->ends_invalid);
    count(j, "hit", s->ends_hit);
    count(j, "miss", s->ends_miss);
    count(j, "blocked", s->ends_blocked);
    count(j, "invalid", s->ends_invalid);
    count(j, "light_reached", s->ends_light_reached);
    count(j, "bytes_per_ray", s->ray_bytes);
    count(j, "weight_overflows", s->weight_overflows);
    count(j, "weight_underflows", s->weight_underflows);
    close_scope(j, '}');
}

static void put_batches(Json *j, const CohortRenderStats *s)
{
    open_scope(j, "batches", '{');
    open_scope(j, "per_bin", '[');
    for (int i = 0; i < 6; i++)
        count(j, NULL, s->batches[i]);
    close_scope(j, ']');
    count(j, "drained", s->batches_drained);
    count(j, "ready_depth_peak", s->ready_depth_peak);
    count(j, "in_memory", s->bins_in_memory);
    count(j, "on_disk", s->bins_on_disk);
    count(j, "bytes_written", s->bytes_written);
    count(j, "bytes_read", s->bytes_read);
    number(j, "wait_seconds", s->wait_seconds);
    close_scope(j, '}');
    open_scope(j, "traversal", '{');
    string(j, "isa", s->isa);
    count(j, "groups", s->groups);
    count(j, "top_nodes_grouped", s->top_nodes_grouped);
    count(j, "top_nodes_single", s->top_nodes_single);
    close_scope(j, '}');
    open_scope(j, "textures", '{');
    count(j, "lookups", s->texture_lookups);
    count(j, "requests", s->texture_requests);
    count(j, "blocks_read", s->texture_blocks_read);
    count(j, "blocks_read_twice_in_a_batch", s->texture_blocks_twice);
    close_scope(j, '}');
    open_scope(j, "film", '{');
    count(j, "saturated", s->film_saturations);
    count(j, "dropped_not_finite", s->film_dropped);
    close_scope(j, '}');
}

static void put_seconds(Json *j, const StatsContext *c)
{
    const CohortRenderStats *s = &c->render;
    open_scope(j, "seconds", '{');
    number(j, "load", c->load_seconds);
    number(j, "camera", s->seconds_camera);
    number(j, "sort_rays", s->seconds_sort_rays);
    number(j, "traverse", s->seconds_traverse);
    number(j, "sort_hits", s->seconds_sort_hits);
    number(j, "texture", s->seconds_texture);
    number(j, "shade", s->seconds_shade);
    number(j, "render", s->seconds_total);
    number(j, "total", c->total_seconds);
    close_scope(j, '}');
}

// Where the bytes of meshes and trees go.
static void put_bytes(Json *j, const CohortSceneCounts *c)
{
    count(j, "geometry_bytes", c->geometry_bytes);
    count(j, "geometry_points_bytes", c->point_bytes);
    count(j, "geometry_topology_bytes", c->topology_bytes);
    count(j, "geometry_normals_bytes", c->normal_bytes);
    count(j, "geometry_primvars_bytes",
          c->geometry_bytes - c->point_bytes - c->topology_bytes - c->normal_bytes);
    count(j, "accel_bytes", c->accel_bytes);
    count(j, "accel_nodes_bytes", c->node_bytes);
    count(j, "accel_leaves_bytes", c->leaf_bytes);
    count(j, "accel_tops_bytes", c->accel_bytes - c->node_bytes - c->leaf_bytes);
}

static void put_scene(Json *j, const StatsContext *c)
{
    CohortSyncCounts counts;
    cohort_render_index_counts(c->index, &counts);
    struct rusage usage;
    open_scope(j, "scene", '{');
    count(j, "meshes", counts.scene.mesh_count);
    count(j, "instances", counts.scene.instance_count);
    count(j, "triangles", counts.scene.triangle_count);
    put_bytes(j, &counts.scene);
    if (getrusage(RUSAGE_SELF, &usage) == 0)
        count(j, "peak_resident_bytes", (uint64_t)usage.ru_maxrss * 1024);
    close_scope(j, '}');
    open_scope(j, "builds", '{');
    count(j, "meshes", counts.scene.mesh_builds);
    count(j, "meshes_refitted", counts.scene.mesh_refits);
    count(j, "meshes_displaced", counts.scene.displaced_meshes);
    count(j, "points_displaced", counts.scene.displaced_points);
    count(j, "groups", counts.scene.group_builds);
    count(j, "groups_refitted", counts.scene.group_refits);
    count(j, "lights", counts.scene.light_builds);
    count(j, "materials", counts.scene.material_builds);
    count(j, "materials_bound", counts.scene.material_binds);
    count(j, "cameras", counts.scene.camera_builds);
    count(j, "textures", counts.scene.texture_opens);
    close_scope(j, '}');
}

static void put_report(Json *j, const StatsContext *c)
{
    static const char *const severities[] = {"error", "warning", "info", "debug", "trace"};
    const CohortReportEntry *entries;
    size_t n = cohort_delegate_report(c->delegate, &entries);
    open_scope(j, "not_honored", '[');
    for (size_t i = 0; i < n; i++) {
        open_scope(j, NULL, '{');
        string(j, "severity", severities[entries[i].severity]);
        string(j, "prim", entries[i].prim_path);
        string(j, "name", entries[i].name);
        string(j, "value", entries[i].value);
        string(j, "action", entries[i].action);
        count(j, "count", entries[i].count);
        close_scope(j, '}');
    }
    close_scope(j, ']');
    const CohortDiagnostic *warnings;
    n = cohort_render_index_warnings(c->index, &warnings);
    open_scope(j, "warnings", '[');
    for (size_t i = 0; i < n; i++) {
        open_scope(j, NULL, '{');
        string(j, "severity", severities[warnings[i].severity]);
        string(j, "place", warnings[i].place);
        string(j, "text", warnings[i].text);
        count(j, "count", warnings[i].count);
        close_scope(j, '}');
    }
    close_scope(j, ']');
}

bool stats_write(const char *path, const StatsContext *c, CohortError *err)
{
    Json j = {fopen(path, "w"), false};
    if (!j.file)
        return fail(err, COHORT_ERROR_FILE_WRITE, "cannot write %s: %s", path, strerror(errno));
    fputc('{', j.file);
    string(&j, "version", cohort_version());
    string(&j, "stage", c->stage);
    string(&j, "status", c->status);
    count(&j, "rounds", c->render.rounds);
    count(&j, "samples_per_pixel", c->render.samples_per_pixel);
    number(&j, "mean_error", c->render.mean_error);
    put_rays(&j, &c->render);
    put_batches(&j, &c->render);
    put_seconds(&j, c);
    put_scene(&j, c);
    put_report(&j, c);
    fputs("\n}\n", j.file);
    struct stat info;
    bool is_file = lstat(path, &info) == 0 && S_ISREG(info.st_mode); // no link, as /dev/stdout is
    bool ok = fflush(j.file) == 0 && !ferror(j.file);
    ok = fclose(j.file) == 0 && ok;
    if (ok)
        return true;
    fail(err, COHORT_ERROR_FILE_WRITE, "cannot write %s: %s", path, strerror(errno));
    if (is_file)
        unlink(path); // half of one helps nobody
    return false;
}
