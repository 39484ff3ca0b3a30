// A second opinion: paths through Lambertian triangles under one rect light, in double precision,
// with nothing of Cohort in it. Every surface is two-sided; paths end after six segments; light is
// sampled at each vertex and seen by the camera alone, so no weights are shared between two ways of
// finding it.
//
// usage: double_tracer WIDTH SPP SEED OFFSET < SCENE
//
// SCENE is text: camera origin, right, up, back, tangent of half the field; light center, two half
// edges, normal, radiance; number of triangles, each with three points and an albedo; then blocks
// of 16 x 16 pixels as pairs of column and row. Prints each block and its mean. OFFSET: rays start
// OFFSET * (1 + largest coordinate) off a surface, as Mitsuba 3 has it; 0: on the surface, and only
// the triangle they leave is left out.

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum {
    LEAF = 4,
    BLOCK = 16,
    SEGMENTS = 6
};

typedef struct Vec {
    double x, y, z;
} Vec;

typedef struct Triangle {
    Vec a, edge1, edge2, normal;
    double albedo[3];
} Triangle;

typedef struct Node {
    double low[3], high[3];
    int first, count, right; // count 0: children are the next node and `right`
} Node;

static const double pi = 3.14159265358979323846;

static struct {
    Vec eye, right, up, back;
    double tangent;
    Vec light, light_u, light_v, light_normal;
    double light_area, radiance, offset;
    int width, triangle_count, node_count, sort_axis;
    Triangle *triangles;
    Node *nodes;
} scene;

static Vec add(Vec a, Vec b)
{
    return (Vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

static Vec scale(Vec a, double s)
{
    return (Vec){a.x * s, a.y * s, a.z * s};
}

static Vec sub(Vec a, Vec b)
{
    return add(a, scale(b, -1));
}

static double dot(Vec a, Vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static Vec cross(Vec a, Vec b)
{
    return (Vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static Vec unit(Vec a)
{
    return scale(a, 1 / sqrt(dot(a, a)));
}

// ---- Random numbers: xoshiro256** (Blackman, Vigna 2018), seeded by splitmix64 ------------------

typedef struct Random {
    uint64_t s[4];
} Random;

static Random random_from(uint64_t seed)
{
    Random r;
    for (int i = 0; i < 4; i++) {
        uint64_t z = seed += 0x9e3779b97f4a7c15;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
        z = (z ^ z >> 27) * 0x94d049bb133111eb;
        r.s[i] = z ^ z >> 31;
    }
    return r;
}

static double next(Random *r)
{
    uint64_t *s = r->s, five = s[1] * 5, t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = s[3] << 45 | s[3] >> 19;
    return (double)((five << 7 | five >> 57) * 9 >> 11) * 0x1p-53;
}

// ---- Tree: halves along the longest axis --------------------------------------------------------

static double middle(const Triangle *t, int axis)
{
    return (&t->a.x)[axis] + ((&t->edge1.x)[axis] + (&t->edge2.x)[axis]) / 3;
}

static int compare(const void *a, const void *b)
{
    double x = middle(a, scene.sort_axis), y = middle(b, scene.sort_axis);
    return (x > y) - (x < y);
}

static int build(int first, int count)
{
    int id = scene.node_count++;
    Node n = {{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}, first, count, 0};
    for (int i = first; i < first + count; i++) {
        const Triangle *t = &scene.triangles[i];
        Vec corners[3] = {t->a, add(t->a, t->edge1), add(t->a, t->edge2)};
        for (int c = 0; c < 9; c++) {
            double x = (&corners[c / 3].x)[c % 3];
            n.low[c % 3] = fmin(n.low[c % 3], x - 1e-9);
            n.high[c % 3] = fmax(n.high[c % 3], x + 1e-9);
        }
    }
    if (count > LEAF) {
        int axis = 0;
        for (int k = 1; k < 3; k++)
            if (n.high[k] - n.low[k] > n.high[axis] - n.low[axis])
                axis = k;
        scene.sort_axis = axis;
        qsort(scene.triangles + first, (size_t)count, sizeof(Triangle), compare);
        n.count = 0;
        build(first, count / 2);
        n.right = build(first + count / 2, count - count / 2);
    }
    scene.nodes[id] = n;
    return id;
}

static double least(double a, double b)
{
    return a < b ? a : b;
}

static double most(double a, double b)
{
    return a > b ? a : b;
}

static int enters(const Node *n, Vec org, Vec inverse, double far)
{
    double near = 0;
    for (int k = 0; k < 3; k++) {
        double o = (&org.x)[k], i = (&inverse.x)[k];
        double a = (n->low[k] - o) * i, b = (n->high[k] - o) * i;
        near = most(near, least(a, b));
        far = least(far, most(a, b));
    }
    return near <= far;
}

// Moeller and Trumbore 1997.
static double meet(const Triangle *t, Vec org, Vec dir)
{
    Vec p = cross(dir, t->edge2), s = sub(org, t->a), q = cross(s, t->edge1);
    double inverse = 1 / dot(t->edge1, p), u = dot(s, p) * inverse, v = dot(dir, q) * inverse;
    return u >= 0 && v >= 0 && u + v <= 1 ? dot(t->edge2, q) * inverse : -1;
}

// The nearest triangle but `left` before *far, which becomes its distance; -1 where there is none.
static int trace(Vec org, Vec dir, int left, double *far)
{
    Vec inverse = {1 / dir.x, 1 / dir.y, 1 / dir.z};
    int stack[64], size = 1, hit = -1;
    stack[0] = 0;
    while (size) {
        int id = stack[--size];
        const Node *n = &scene.nodes[id];
        if (!enters(n, org, inverse, *far))
            continue;
        if (n->count == 0) {
            stack[size++] = n->right;
            stack[size++] = id + 1;
        }
        for (int i = n->first; i < n->first + n->count; i++) {
            double t = i == left ? -1 : meet(&scene.triangles[i], org, dir);
            if (t > 1e-9 && t < *far) {
                *far = t;
                hit = i;
            }
        }
    }
    return hit;
}

// ---- Paths --------------------------------------------------------------------------------------

static int sees_light(Vec org, Vec dir, double far)
{
    double t = dot(sub(scene.light, org), scene.light_normal) / dot(dir, scene.light_normal);
    Vec q = sub(add(org, scale(dir, t)), scene.light);
    return dot(dir, scene.light_normal) < 0 && t > 0 && t < far + 1e-9 &&
           fabs(dot(q, scene.light_u)) < dot(scene.light_u, scene.light_u) &&
           fabs(dot(q, scene.light_v)) < dot(scene.light_v, scene.light_v);
}

// Light that reaches the point and leaves it, over its albedo.
static double direct(Vec p, Vec normal, int left, Random *r)
{
    Vec at = add(scene.light, scale(scene.light_u, 2 * next(r) - 1));
    Vec way = sub(add(at, scale(scene.light_v, 2 * next(r) - 1)), p);
    double d2 = dot(way, way), far = sqrt(d2) * (1 - 1e-9);
    Vec dir = unit(way);
    double cosine = dot(dir, normal), light_cosine = -dot(dir, scene.light_normal);
    if (cosine <= 0 || light_cosine <= 0 || trace(p, dir, left, &far) >= 0)
        return 0;
    return cosine * light_cosine * scene.light_area * scene.radiance / (pi * d2);
}

static Vec scatter(Vec n, Random *r)
{
    double u = next(r), angle = 2 * pi * next(r), s = sqrt(u);
    Vec e = unit(cross(fabs(n.x) > 0.5 ? (Vec){0, 1, 0} : (Vec){1, 0, 0}, n)), f = cross(n, e);
    return add(add(scale(e, s * cos(angle)), scale(f, s * sin(angle))), scale(n, sqrt(1 - u)));
}

static void add_path(double x, double y, Random *r, double sum[3])
{
    double right = (2 * x / scene.width - 1) * scene.tangent;
    double up = (1 - 2 * y / scene.width) * scene.tangent, weight[3] = {1, 1, 1};
    Vec org = scene.eye;
    Vec dir = unit(sub(add(scale(scene.right, right), scale(scene.up, up)), scene.back));
    for (int segment = 1, left = -1; segment < SEGMENTS; segment++) {
        double far = 1e300;
        int hit = trace(org, dir, left, &far);
        for (int k = 0; k < 3 && segment == 1 && sees_light(org, dir, far); k++)
            sum[k] += scene.radiance;
        if (hit < 0)
            return;
        const Triangle *t = &scene.triangles[hit];
        Vec normal = dot(t->normal, dir) > 0 ? scale(t->normal, -1) : t->normal;
        org = add(org, scale(dir, far));
        double largest = fmax(fabs(org.x), fmax(fabs(org.y), fabs(org.z)));
        org = add(org, scale(normal, scene.offset * (1 + largest)));
        left = scene.offset > 0 ? -1 : hit;
        double light = direct(org, normal, left, r);
        for (int k = 0; k < 3; k++) {
            weight[k] *= t->albedo[k];
            sum[k] += weight[k] * light;
        }
        dir = scatter(normal, r);
    }
}

// ---- Scene in, blocks out -----------------------------------------------------------------------

static double number(void)
{
    double x;
    if (scanf("%lf", &x) != 1)
        exit(1);
    return x;
}

static Vec vector(void)
{
    double x = number(), y = number();
    return (Vec){x, y, number()};
}

static void read_scene(void)
{
    scene.eye = vector();
    scene.right = vector();
    scene.up = vector();
    scene.back = vector();
    scene.tangent = number();
    scene.light = vector();
    scene.light_u = vector();
    scene.light_v = vector();
    scene.light_normal = vector();
    scene.radiance = number();
    Vec u = scene.light_u, v = scene.light_v;
    scene.light_area = 4 * sqrt(dot(u, u) * dot(v, v));
    scene.triangle_count = (int)number();
    scene.triangles = calloc((size_t)scene.triangle_count, sizeof(Triangle));
    scene.nodes = calloc(2 * (size_t)scene.triangle_count, sizeof(Node));
    for (int i = 0; i < scene.triangle_count; i++) {
        Triangle *t = &scene.triangles[i];
        t->a = vector();
        t->edge1 = sub(vector(), t->a);
        t->edge2 = sub(vector(), t->a);
        t->normal = unit(cross(t->edge1, t->edge2));
        for (int k = 0; k < 3; k++)
            t->albedo[k] = number();
    }
    build(0, scene.triangle_count);
}

int main(int argc, char **argv)
{
    if (argc != 5)
        return 2;
    scene.width = atoi(argv[1]);
    int spp = atoi(argv[2]), column, row;
    uint64_t seed = strtoull(argv[3], NULL, 10) << 40;
    scene.offset = atof(argv[4]);
    read_scene();
    while (scanf("%d %d", &column, &row) == 2) {
        double sum[3] = {0};
        for (int i = 0; i < BLOCK * BLOCK; i++) {
            int x = column * BLOCK + i % BLOCK, y = row * BLOCK + i / BLOCK;
            Random r = random_from(seed ^ (uint64_t)(y * scene.width + x));
            for (int k = 0; k < spp; k++) {
                double dx = next(&r);
                add_path(x + dx, y + next(&r), &r, sum);
            }
        }
        double n = (double)spp * BLOCK * BLOCK;
        printf("%d %d %.9g %.9g %.9g\n", column, row, sum[0] / n, sum[1] / n, sum[2] / n);
    }
    return 0;
}
