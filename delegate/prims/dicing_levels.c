// Levels of the edges and faces of one mesh.

#include "prims/dicing.h"

#include "base/parallel.h"
#include "math/vec.h"

enum {
    LEVEL_MAX = 8 // as cohort:complexity
};

typedef struct LevelJob {
    const CoDicing *dicing;
    const CoDicingView *view;
    const double (*to_world)[4]; // of the placement looked at; NULL: by density alone
    const CohortMeshDesc *desc;
    const uint32_t *first; // [face_count] first face-vertex
    uint8_t *edge_levels, *face_levels;
} LevelJob;

typedef struct Point {
    double x[3];
} Point;

static Point sub(Point a, Point b)
{
    return (Point){{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}};
}

static Point cross(Point a, Point b)
{
    return (Point){{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2],
                    a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}

static double dot(Point a, Point b)
{
    return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

static double length(Point a)
{
    return sqrt(dot(a, a));
}

static Point middle(Point a, Point b)
{
    return (Point){{0.5 * (a.x[0] + b.x[0]), 0.5 * (a.x[1] + b.x[1]), 0.5 * (a.x[2] + b.x[2])}};
}

// Vertex k of a face: in the world, or its own.
static Point load_point(const LevelJob *job, uint32_t face, uint32_t k)
{
    uint32_t count = (uint32_t)job->desc->face_vertex_counts[face];
    size_t vertex = (size_t)job->desc->face_vertex_indices[job->first[face] + k % count];
    const float *p = job->desc->points + 3 * vertex;
    Point own = {{(double)p[0], (double)p[1], (double)p[2]}}, out;
    if (!job->to_world)
        return own;
    co_dicing_to_world(job->to_world, own.x, out.x);
    return out;
}

// ---- Distances from the camera -----------------------------------------------------------------

static Point eye_of(const LevelJob *job)
{
    const double *e = job->dicing->eye;
    return (Point){{e[0], e[1], e[2]}};
}

static double edge_distance(const LevelJob *job, Point a, Point b)
{
    Point way = sub(b, a), to_eye = sub(eye_of(job), a);
    double square = dot(way, way);
    double t = square > 0.0 ? fmin(fmax(dot(to_eye, way) / square, 0.0), 1.0) : 0.0;
    for (int k = 0; k < 3; k++)
        to_eye.x[k] -= t * way.x[k];
    return length(to_eye);
}

// From a triangle, where that is not nearest at an edge; else infinite.
static double inner_distance(const LevelJob *job, Point a, Point b, Point c)
{
    Point n = cross(sub(b, a), sub(c, a)), eye = eye_of(job);
    double whole = dot(n, n);
    double from_a = dot(n, cross(sub(c, b), sub(eye, b)));
    double from_b = dot(n, cross(sub(a, c), sub(eye, c)));
    if (!(whole > 0.0) || from_a < 0.0 || from_b < 0.0 || from_a + from_b > whole)
        return HUGE_VAL;
    return fabs(dot(n, sub(eye, a))) / sqrt(whole);
}

// ---- Levels ------------------------------------------------------------------------------------

static void raise_level(const LevelJob *job, double size, double distance, Point center,
                        double radius, uint8_t *level)
{
    const CoDicing *d = job->dicing;
    double pixels = size * job->view->density;
    if (job->to_world)
        pixels = size * co_dicing_pixels_at(d, distance) * co_dicing_share(d, center.x, radius);
    if (!isfinite(pixels))
        return;
    uint8_t own = 0;
    for (; pixels > d->edge_length && own < LEVEL_MAX; own++)
        pixels *= 0.5;
    *level = own > *level ? own : *level;
}

static void raise_face_levels(const LevelJob *job, uint32_t face)
{
    uint32_t count = (uint32_t)job->desc->face_vertex_counts[face];
    Point center = {{0.0, 0.0, 0.0}}, corner = load_point(job, face, 0);
    for (uint32_t k = 0; k < count; k++)
        for (int c = 0; c < 3; c++)
            center.x[c] += load_point(job, face, k).x[c] / count;
    double size = 0.0, distance = HUGE_VAL, radius = 0.0;
    for (uint32_t k = 0; k < count; k++) {
        Point a = load_point(job, face, k), b = load_point(job, face, k + 1), m = middle(a, b);
        double own = length(sub(b, a)), nearest = edge_distance(job, a, b);
        raise_level(job, own, nearest, m, 0.5 * own, &job->edge_levels[job->first[face] + k]);
        size = fmax(size, own);
        // Faces that are no quads are split from here to their center.
        if (count != 4 && job->desc->scheme != COHORT_SCHEME_LOOP)
            size = fmax(size, 2.0 * length(sub(m, center)));
        distance = fmin(distance, fmin(nearest, inner_distance(job, corner, a, b)));
        radius = fmax(radius, length(sub(a, center)));
    }
    raise_level(job, size, distance, center, radius, &job->face_levels[face]);
}

static void find_levels(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    LevelJob job = *(const LevelJob *)context;
    for (uint32_t f = (uint32_t)begin; f < end; f++) {
        uint32_t count = (uint32_t)job.desc->face_vertex_counts[f];
        job.face_levels[f] = 0;
        for (uint32_t k = 0; k < count; k++)
            job.edge_levels[job.first[f] + k] = 0;
        if (count == 0)
            continue;
        for (uint32_t k = 0; k < co_dicing_places(job.view); k++) {
            job.to_world = (const double(*)[4])job.view->to_world[k];
            raise_face_levels(&job, f);
        }
        job.to_world = NULL;
        if (job.view->density > 0.0)
            raise_face_levels(&job, f);
    }
}

// Where the vertices of each face begin; false for descriptions that will be refused.
static bool find_first(const CohortMeshDesc *desc, uint32_t *first)
{
    size_t next = 0;
    for (size_t f = 0; f < desc->face_count; f++) {
        int32_t count = desc->face_vertex_counts[f];
        if (count < 0 || (size_t)count > desc->face_vertex_index_count - next)
            return false;
        first[f] = (uint32_t)next;
        next += (size_t)count;
    }
    for (size_t k = 0; k < next; k++)
        if (desc->face_vertex_indices[k] < 0 ||
            (size_t)desc->face_vertex_indices[k] >= desc->point_count)
            return false;
    return next == desc->face_vertex_index_count && next < UINT32_MAX;
}

bool co_dicing_set_levels(const CohortRenderIndex *index, const CoPrim *prim, CohortPull *pull,
                          CohortMeshDesc *desc)
{
    const CoDicing *d = &index->dicing;
    if (prim->view == 0 || prim->id >= d->view_count || d->views[prim->id].placements == 0 ||
        desc->scheme == COHORT_SCHEME_NONE || !desc->points || desc->face_count == 0)
        return true;
    LevelJob job = {.dicing = d, .view = &d->views[prim->id], .desc = desc};
    uint32_t *first = cohort_pull_array(pull, desc->face_count, sizeof *first);
    job.edge_levels = cohort_pull_array(pull, desc->face_vertex_index_count, 1);
    job.face_levels = cohort_pull_array(pull, desc->face_count, 1);
    if (!first || !job.edge_levels || !job.face_levels)
        return false;
    job.first = first;
    if (!find_first(desc, first))
        return true;
    co_parallel_for(desc->face_count, 1024, find_levels, &job);
    desc->edge_levels = job.edge_levels;
    desc->face_levels = job.face_levels;
    return true;
}
