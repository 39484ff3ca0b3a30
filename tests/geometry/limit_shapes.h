// Cages that cover what limit surfaces can meet: creases, sharp corners, holes, boundary rules,
// valences from 3 to 100, n-gons, triangles, edges and vertices that are not manifold.

#ifndef TEST_LIMIT_SHAPES_H
#define TEST_LIMIT_SHAPES_H

#include "subdivision_fixture.h"

#define SHAPE_CREASES_MAX 64

typedef struct Shape {
    const char *name;
    Cage cage;
    CohortMeshDesc desc; // all but its level
    int32_t crease_indices[2 * SHAPE_CREASES_MAX], crease_lengths[SHAPE_CREASES_MAX];
    float crease_sharpnesses[SHAPE_CREASES_MAX];
    int32_t corners[8], holes[8];
    float corner_sharpnesses[8];
} Shape;

static inline void shape_point(Cage *cage, double x, double y, double z)
{
    float *p = cage->points + 3 * cage->point_count++;
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
}

static inline void shape_crease(Shape *s, int32_t a, int32_t b, float sharpness)
{
    size_t k = s->desc.crease_count++;
    s->crease_indices[2 * k] = a;
    s->crease_indices[2 * k + 1] = b;
    s->crease_lengths[k] = 2;
    s->crease_sharpnesses[k] = sharpness;
    s->desc.crease_index_count = 2 * s->desc.crease_count;
    s->desc.crease_sharpness_count = s->desc.crease_count;
}

static inline void shape_corner(Shape *s, int32_t vertex, float sharpness)
{
    s->corners[s->desc.corner_count] = vertex;
    s->corner_sharpnesses[s->desc.corner_count++] = sharpness;
}

// A cube of 2 x 2 x 2 with edges of its own sharpness around two faces.
static inline void shape_cube(Shape *s, const float sharpness[8])
{
    Cage *c = &s->cage;
    for (int k = 0; k < 8; k++)
        shape_point(c, (double)cube_points[3 * k] + 0.05 * k, (double)cube_points[3 * k + 1],
                    (double)cube_points[3 * k + 2] - 0.03 * k * k);
    for (int f = 0; f < 6; f++)
        cage_face(c, 4, cube_indices + 4 * f);
    for (int k = 0; k < 8 && sharpness; k++)
        if (sharpness[k] > 0.0f)
            shape_crease(s, cube_indices[k], cube_indices[k % 4 == 3 ? k - 3 : k + 1],
                         sharpness[k]);
}

// Quads (or triangles) around one vertex.
static inline void shape_umbrella(Shape *s, int32_t valence, bool triangles)
{
    Cage *c = &s->cage;
    shape_point(c, 0.1, -0.05, 0.7);
    for (int32_t k = 0; k < 2 * valence; k++) {
        double a = 3.141592653589793 * k / valence, r = k % 2 ? 1.5 : 1.0 + 0.1 * sin(3 * a);
        shape_point(c, r * cos(a), r * sin(a), 0.3 * cos(2 * a) - 0.2 * (k % 3));
    }
    for (int32_t k = 0; k < valence; k++) {
        int32_t a = 1 + 2 * k, b = 2 + 2 * k, d = 1 + (2 * k + 2) % (2 * valence);
        const int32_t quad[] = {0, a, b, d}, inner[] = {0, a, d}, outer[] = {a, b, d};
        if (triangles) {
            cage_face(c, 3, inner);
            cage_face(c, 3, outer);
        } else {
            cage_face(c, 4, quad);
        }
    }
}

// One n-gon in a ring of quads.
static inline void shape_ngon(Shape *s, int32_t valence)
{
    Cage *c = &s->cage;
    int32_t ring[128];
    for (int32_t k = 0; k < valence; k++) {
        double a = 6.283185307179586 * k / valence;
        shape_point(c, cos(a), sin(a), 0.2 * sin(3 * a));
        ring[k] = k;
    }
    for (int32_t k = 0; k < valence; k++) {
        double a = 6.283185307179586 * k / valence;
        shape_point(c, 1.6 * cos(a + 0.1), 1.5 * sin(a), -0.5);
    }
    cage_face(c, valence, ring);
    for (int32_t k = 0; k < valence; k++) {
        int32_t next = (k + 1) % valence;
        const int32_t quad[] = {k, valence + k, valence + next, next};
        cage_face(c, 4, quad);
    }
}

// Three walls, two faces wide and two high, that meet in two edges.
static inline void shape_fins(Shape *s, bool triangles)
{
    Cage *c = &s->cage;
    for (int z = 0; z < 3; z++)
        shape_point(c, 0.1 * z, 0.0, z);
    for (int fin = 0; fin < 3; fin++)
        for (int z = 0; z < 3; z++)
            for (int r = 1; r < 3; r++)
                shape_point(c, r * cos(2.1 * fin), r * sin(2.1 * fin), z + 0.2 * r * (fin - 1));
    for (int fin = 0; fin < 3; fin++) {
        int32_t p[3][3];
        for (int z = 0; z < 3; z++)
            for (int r = 0; r < 3; r++)
                p[z][r] = r == 0 ? z : 3 + 6 * fin + 2 * z + r - 1;
        for (int k = 0; k < 4; k++) {
            int z = k / 2, r = k % 2;
            const int32_t quad[] = {p[z][r], p[z][r + 1], p[z + 1][r + 1], p[z + 1][r]};
            const int32_t second[] = {quad[0], quad[2], quad[3]};
            cage_face(c, triangles ? 3 : 4, quad);
            if (triangles)
                cage_face(c, 3, second);
        }
    }
}

// Two pieces of a grid that share one vertex.
static inline void shape_bow_tie(Shape *s)
{
    Cage *c = &s->cage;
    shape_point(c, 0.0, 0.0, 0.3);
    const double places[][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 0}, {-1, -1}, {0, -1}};
    for (int k = 0; k < 6; k++)
        shape_point(c, places[k][0], places[k][1], 0.1 * k);
    const int32_t faces[][4] = {{0, 1, 2, 3}, {0, 4, 5, 6}};
    for (int k = 0; k < 2; k++)
        cage_face(c, 4, faces[k]);
}

static inline void shape_torus(Shape *s, bool mixed, bool triangles)
{
    make_torus(&s->cage, mixed, triangles);
    for (size_t k = 0; k < 3 * s->cage.point_count; k++)
        s->cage.points[k] += 0.1f * (float)((k * 7) % 11) / 11.0f;
}

static inline void shape_patch(Shape *s, CohortInterpolateBoundary rule, bool triangles)
{
    make_grid(&s->cage, 4, triangles);
    for (size_t k = 0; k < s->cage.point_count; k++)
        s->cage.points[3 * k + 2] = (float)((k * 5) % 7) / 7.0f;
    s->desc.interpolate_boundary = rule;
}

#define SHAPE_COUNT 30

// Makes shape `number`, below SHAPE_COUNT.
static inline void make_shape(Shape *s, int number)
{
    static const float hard[8] = {10, 10, 10, 10, 0, 0, 0, 0};
    static const float soft[8] = {1.3f, 2.7f, 1.3f, 0.6f, 3.1f, 3.1f, 3.1f, 3.1f};
    static const float last[8] = {9.5f, 0, 6.2f, 4.1f, 5, 5, 5, 5};
    static const float some[8] = {10, 0, 10, 0, 2, 0.5f, 10, 0};
    static const int32_t valences[] = {3, 5, 6, 7, 12, 30, 100};
    memset(s, 0, sizeof *s);
    bool is_loop = number >= 25;
    switch (number) {
    case 0:
        s->name = "long creases";
        shape_cube(s, last);
        break;
    case 1: s->name = "hard creases"; shape_cube(s, hard); break;
    case 2: s->name = "semi-sharp creases"; shape_cube(s, soft); break;
    case 3: s->name = "creases that end"; shape_cube(s, some); break;
    case 4:
        s->name = "sharp corners";
        shape_cube(s, NULL);
        shape_corner(s, 0, 10.0f);
        shape_corner(s, 3, 1.5f);
        shape_corner(s, 6, 4.0f);
        break;
    case 5:
        s->name = "holes";
        shape_torus(s, true, false);
        for (int k = 0; k < 3; k++)
            s->holes[s->desc.hole_count++] = 7 * k + 3;
        break;
    case 6: case 7: case 8: case 9: case 10: case 11: case 12:
        s->name = "umbrella of quads";
        shape_umbrella(s, valences[number - 6], false);
        break;
    case 13: s->name = "7-gon"; shape_ngon(s, 7); break;
    case 14: s->name = "40-gon"; shape_ngon(s, 40); break;
    case 15: s->name = "mixed faces"; shape_torus(s, true, false); break;
    case 16: s->name = "triangles"; shape_torus(s, false, true); break;
    case 17:
        s->name = "triangles, smooth rule";
        shape_torus(s, false, true);
        s->desc.triangle_rule_smooth = true;
        break;
    case 18: s->name = "boundary"; shape_patch(s, COHORT_BOUNDARY_EDGE_AND_CORNER, false); break;
    case 19: s->name = "boundary, edges"; shape_patch(s, COHORT_BOUNDARY_EDGE_ONLY, false); break;
    case 20: s->name = "boundary, none"; shape_patch(s, COHORT_BOUNDARY_NONE, false); break;
    case 21: s->name = "non-manifold edges"; shape_fins(s, false); break;
    case 22: s->name = "non-manifold vertex"; shape_bow_tie(s); break;
    case 23:
        s->name = "bilinear";
        shape_torus(s, true, false);
        s->desc.scheme = COHORT_SCHEME_BILINEAR;
        break;
    case 24: s->name = "non-manifold triangles"; shape_fins(s, true); break;
    case 25: s->name = "loop"; shape_torus(s, false, true); break;
    case 26: s->name = "loop, valence 30"; shape_umbrella(s, 30, true); break;
    case 27: s->name = "loop, boundary"; shape_patch(s, COHORT_BOUNDARY_EDGE_ONLY, true); break;
    case 28: s->name = "loop, non-manifold"; shape_fins(s, true); break;
    default:
        s->name = "loop, creases";
        shape_torus(s, false, true);
        for (int32_t k = 0; k < 12; k++)
            shape_crease(s, k, (k + 1) % 12, k < 6 ? 10.0f : 1.7f);
        break;
    }
    CohortMeshDesc topology = cage_desc(&s->cage, s->desc.scheme, 0);
    s->desc.path = s->name;
    s->desc.scheme = is_loop ? COHORT_SCHEME_LOOP : s->desc.scheme;
    s->desc.points = topology.points;
    s->desc.point_count = topology.point_count;
    s->desc.face_vertex_counts = topology.face_vertex_counts;
    s->desc.face_count = topology.face_count;
    s->desc.face_vertex_indices = topology.face_vertex_indices;
    s->desc.face_vertex_index_count = topology.face_vertex_index_count;
    s->desc.crease_indices = s->crease_indices;
    s->desc.crease_lengths = s->crease_lengths;
    s->desc.crease_sharpnesses = s->crease_sharpnesses;
    s->desc.corner_indices = s->corners;
    s->desc.corner_sharpnesses = s->corner_sharpnesses;
    s->desc.hole_indices = s->holes;
}

#endif
