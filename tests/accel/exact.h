// Rays and triangles in double, to judge hits by: how far a line passes a triangle, and where it
// meets its plane. Differences of floats are exact in double unless they are 2^29 times apart.

#ifndef TESTS_ACCEL_EXACT_H
#define TESTS_ACCEL_EXACT_H

#include "accel_scene.h"

// A triangle as seen from a ray's origin.
typedef struct ExactHit {
    double ulp;     // unit in the last place of the triangle's largest coordinate, in float
    double outside; // by how much the line passes it; below 0: by how much it does not
    double t;       // where it meets the plane, in units of the direction
    double slack;   // what a point 4 ulp off the plane is off by in t; not finite when edge-on
} ExactHit;

// Distance from the origin to a segment of the plane.
static inline double segment_distance(const double a[2], const double b[2])
{
    double d[2] = {b[0] - a[0], b[1] - a[1]}, square = d[0] * d[0] + d[1] * d[1];
    double s = square > 0.0 ? -(a[0] * d[0] + a[1] * d[1]) / square : 0.0;
    s = fmin(fmax(s, 0.0), 1.0);
    return hypot(a[0] + s * d[0], a[1] + s * d[1]);
}

static inline double exact_ulp(double x)
{
    return x > 0.0 ? fmax(ldexp(1.0, ilogb(x) - 23), 0x1p-149) : 0x1p-149;
}

// Plane of p as seen from the origin: where dir meets it.
static inline void exact_plane(const double p[3][3], const double dir[3], ExactHit *hit)
{
    double n[3], sum = 0.0, along = 0.0, at = 0.0;
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] =
            (p[1][i] - p[0][i]) * (p[2][j] - p[0][j]) - (p[1][j] - p[0][j]) * (p[2][i] - p[0][i]);
        sum += fabs(n[k]);
        along += n[k] * dir[k];
        at += n[k] * p[0][k];
    }
    hit->t = at / along;
    hit->slack = 4.0 * hit->ulp * sum / fabs(along);
}

static inline ExactHit exact_hit(const TestMesh *mesh, uint32_t tri, const CoRayBatch *rays,
                                 size_t ray)
{
    double dir[3] = {(double)rays->dir_x[ray], (double)rays->dir_y[ray], (double)rays->dir_z[ray]};
    double org[3] = {(double)rays->org_x[ray], (double)rays->org_y[ray], (double)rays->org_z[ray]};
    double largest = 0.0, scale = 0.0, p[3][3], flat[3][2], edge[3];
    for (int k = 0; k < 3; k++)
        scale = fmax(scale, fabs(dir[k]));
    int z = fabs(dir[0]) == scale ? 0 : fabs(dir[1]) == scale ? 1 : 2;
    int x = (z + 1) % 3, y = (z + 2) % 3;
    for (int c = 0; c < 3; c++) {
        const float *point = mesh->points + 3 * (size_t)mesh->indices[3 * (size_t)tri + (size_t)c];
        for (int k = 0; k < 3; k++) {
            p[c][k] = (double)point[k] - org[k];
            largest = fmax(largest, fabs(p[c][k]));
        }
        flat[c][0] = p[c][x] - dir[x] / dir[z] * p[c][z];
        flat[c][1] = p[c][y] - dir[y] / dir[z] * p[c][z];
    }
    ExactHit hit = {.ulp = exact_ulp(largest), .outside = (double)INFINITY};
    for (int c = 0; c < 3; c++) {
        const double *a = flat[c], *b = flat[(c + 1) % 3];
        edge[c] = a[0] * b[1] - a[1] * b[0];
        hit.outside = fmin(hit.outside, segment_distance(a, b));
    }
    bool is_inside = (edge[0] >= 0 && edge[1] >= 0 && edge[2] >= 0) ||
                     (edge[0] <= 0 && edge[1] <= 0 && edge[2] <= 0);
    if (is_inside && edge[0] + edge[1] + edge[2] != 0.0)
        hit.outside = -hit.outside;
    exact_plane((const double(*)[3])p, dir, &hit);
    return hit;
}

// By how many units in the last place the ray's line passes a triangle; 0 inside.
static inline double miss_ulps(const TestMesh *mesh, uint32_t tri, const CoRayBatch *rays,
                               size_t ray)
{
    ExactHit hit = exact_hit(mesh, tri, rays, ray);
    return fmax(hit.outside, 0.0) / hit.ulp;
}

// How a ray's hit compares with a search over all triangles in double.
typedef struct ExactVerdict {
    double miss_ulps; // of the triangle hit
    double t_ulps;    // distance from its plane, in ulp of its largest coordinate, 0 for a miss
    bool is_nearest;  // nothing lies certainly before it: 4 ulp from its edges and in depth
} ExactVerdict;

// For rays that are not limited.
static inline ExactVerdict exact_judge(const TestMesh *mesh, const CoRayBatch *rays,
                                       const CoHitBatch *hits, size_t ray)
{
    ExactVerdict verdict = {.is_nearest = true};
    double limit = (double)INFINITY;
    uint32_t tri = hits->tri[ray];
    if (tri != COHORT_INVALID_ID) {
        ExactHit hit = exact_hit(mesh, tri, rays, ray);
        double off = fmax(fabs((double)hits->t[ray] - hit.t) - 0x1p-149, 0.0);
        verdict.miss_ulps = fmax(hit.outside, 0.0) / hit.ulp;
        if (isfinite(hit.slack))
            verdict.t_ulps = off / hit.slack * 4.0;
        limit = (double)hits->t[ray];
    }
    for (uint32_t i = 0; i < mesh->mesh.tri_count; i++) {
        ExactHit other = exact_hit(mesh, i, rays, ray);
        if (other.outside < -4.0 * other.ulp && other.t > other.slack &&
            other.t + other.slack < limit && i != tri)
            verdict.is_nearest = false;
    }
    return verdict;
}

#endif
