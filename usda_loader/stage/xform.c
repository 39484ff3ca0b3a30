// UsdGeomXformable: xformOpOrder to one matrix.
//
// Row vectors: a point is transformed by p * M, and the order lists the outermost op first, so the
// ops are multiplied from the last to the first. Angles are in degrees.

#include "stage/stage_data.h"

#include "math/elementary.h"

#include <math.h>
#include <string.h>

typedef double CoMatrix[4][4];

static void set_identity(CoMatrix m)
{
    memset(m, 0, sizeof(CoMatrix));
    for (int i = 0; i < 4; i++)
        m[i][i] = 1;
}

// out = a * b; out may be either.
static void multiply(CoMatrix a, CoMatrix b, CoMatrix out)
{
    CoMatrix product;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            product[i][j] =
                a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] + a[i][3] * b[3][j];
    memcpy(out, product, sizeof product);
}

static void set_rotation(CoMatrix m, int axis, double degrees)
{
    set_identity(m);
    double s, c;
    // Quarter turns are exact.
    double quarter = fmod(degrees, 360) / 90;
    if (quarter == floor(quarter)) {
        static const double sines[4] = {0, 1, 0, -1};
        int q = ((int)quarter + 4) & 3;
        s = sines[q];
        c = sines[(q + 1) & 3];
    } else {
        co_sincos_d(degrees * 0.017453292519943295, &s, &c);
    }
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    m[u][u] = c;
    m[u][v] = s;
    m[v][u] = -s;
    m[v][v] = c;
}

// The first letter's rotation is applied first.
static void set_euler(CoMatrix m, const char *axes, const double *degrees)
{
    set_identity(m);
    for (int i = 0; i < 3; i++) {
        CoMatrix one;
        set_rotation(one, axes[i] - 'X', degrees[axes[i] - 'X']);
        multiply(m, one, m);
    }
}

// q = (x, y, z, w), of any length but zero.
static void set_quaternion(CoMatrix m, const double *q)
{
    set_identity(m);
    double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(n > 0))
        return;
    double s = 2 / n, x = q[0], y = q[1], z = q[2], w = q[3];
    m[0][0] = 1 - s * (y * y + z * z);
    m[0][1] = s * (x * y + z * w);
    m[0][2] = s * (x * z - y * w);
    m[1][0] = s * (x * y - z * w);
    m[1][1] = 1 - s * (x * x + z * z);
    m[1][2] = s * (y * z + x * w);
    m[2][0] = s * (x * z + y * w);
    m[2][1] = s * (y * z - x * w);
    m[2][2] = 1 - s * (x * x + y * y);
}

// By Gauss-Jordan with row pivoting; false if singular.
static bool invert(CoMatrix m)
{
    CoMatrix a, out;
    memcpy(a, m, sizeof a);
    set_identity(out);
    for (int k = 0; k < 4; k++) {
        int pivot = k;
        for (int i = k + 1; i < 4; i++)
            if (fabs(a[i][k]) > fabs(a[pivot][k]))
                pivot = i;
        if (!(fabs(a[pivot][k]) > 0))
            return false;
        for (int j = 0; j < 4; j++) {
            double swap = a[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = swap;
            swap = out[k][j];
            out[k][j] = out[pivot][j];
            out[pivot][j] = swap;
        }
        double scale = 1 / a[k][k];
        for (int j = 0; j < 4; j++) {
            a[k][j] *= scale;
            out[k][j] *= scale;
        }
        for (int i = 0; i < 4; i++) {
            double factor = i == k ? 0 : a[i][k];
            for (int j = 0; j < 4; j++) {
                a[i][j] -= factor * a[k][j];
                out[i][j] -= factor * out[k][j];
            }
        }
    }
    memcpy(m, out, sizeof out);
    return true;
}

// "xformOp:rotateXYZ:pivot" is of kind "rotateXYZ".
static bool is_kind(const char *kind, size_t length, const char *wanted)
{
    return strlen(wanted) == length && !memcmp(kind, wanted, length);
}

static bool set_op(CoMatrix m, const char *kind, size_t length, const double *v)
{
    set_identity(m);
    if (is_kind(kind, length, "translate")) {
        memcpy(m[3], v, 3 * sizeof *v);
    } else if (is_kind(kind, length, "scale")) {
        for (int i = 0; i < 3; i++)
            m[i][i] = v[i];
    } else if (is_kind(kind, length, "orient")) {
        set_quaternion(m, v);
    } else if (is_kind(kind, length, "transform")) {
        memcpy(m, v, sizeof(CoMatrix));
    } else if (length == 10 && !memcmp(kind, "translate", 9) && strchr("XYZ", kind[9])) {
        m[3][kind[9] - 'X'] = v[0];
    } else if (length == 6 && !memcmp(kind, "scale", 5) && strchr("XYZ", kind[5])) {
        m[kind[5] - 'X'][kind[5] - 'X'] = v[0];
    } else if (length == 7 && !memcmp(kind, "rotate", 6) && strchr("XYZ", kind[6])) {
        set_rotation(m, kind[6] - 'X', v[0]);
    } else if (length == 9 && !memcmp(kind, "rotate", 6)) {
        static const char *const orders[] = {"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"};
        for (size_t i = 0; i < 6; i++) {
            if (!memcmp(kind + 6, orders[i], 3)) {
                set_euler(m, orders[i], v);
                return true;
            }
        }
        return false;
    } else {
        return false;
    }
    return true;
}

// The matrix of one entry of the order; false if the op does not exist or has no value.
static bool read_op(const CohortPrim *prim, const char *name, double time, CoMatrix m)
{
    bool is_inverse = !strncmp(name, "!invert!", 8);
    const char *attribute = is_inverse ? name + 8 : name;
    if (strncmp(attribute, "xformOp:", 8) != 0)
        return false;
    double v[16] = {0};
    if (!cohort_prim_numbers(prim, attribute, time, v, 16))
        return false;
    const char *kind = attribute + 8;
    if (!set_op(m, kind, strcspn(kind, ":"), v))
        return false;
    return !is_inverse || invert(m);
}

// UsdGeomXformable's derived types have ops; what has no type, or is a Scope, has none whatever it
// authors. Types that are not known here are taken to be a host's own gprims.
static bool is_xformable(const CohortPrim *prim)
{
    const char *type = cohort_prim_type(prim);
    return type[0] && strcmp(type, "Scope") != 0;
}

bool cohort_prim_local_transform(const CohortPrim *prim, double time, double out[4][4],
                                 bool *resets)
{
    bool does_reset = false;
    set_identity(out);
    CohortValue order;
    const char *token = prim->data->stage->composer.names.xformOpOrder;
    bool has_order = is_xformable(prim) &&
                     co_prim_value(prim, token, COHORT_TIME_DEFAULT, &order) &&
                     order.type == COHORT_TYPE_TOKEN;
    const CohortString *names = has_order ? order.data : NULL;
    size_t first = 0, count = has_order ? order.count : 0;
    for (size_t i = 0; i < count; i++) {
        if (strcmp(names[i].text, "!resetXformStack!") != 0)
            continue;
        does_reset = true;
        first = i + 1;
    }
    for (size_t i = first; i < count; i++) {
        CoMatrix op;
        if (read_op(prim, names[i].text, time, op))
            multiply(op, out, out);
    }
    if (resets)
        *resets = does_reset;
    return count > 0;
}
