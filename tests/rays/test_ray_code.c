// The ray record: direction error, fixed points of quantizing, every field, what cannot be traced.
// COHORT_TEST_FULL in the environment runs the statistics at full length.

#include "ray_code_support.h"

// Angle between two directions, in double, from the cross product.
static double angle(CoVec3 a, CoVec3 b)
{
    double ax = (double)a.x, ay = (double)a.y, az = (double)a.z;
    double bx = (double)b.x, by = (double)b.y, bz = (double)b.z;
    double cx = ay * bz - az * by, cy = az * bx - ax * bz, cz = ax * by - ay * bx;
    return atan2(sqrt(cx * cx + cy * cy + cz * cz), ax * bx + ay * by + az * bz);
}

static void check_direction(CoVec3 d)
{
    CoRay ray = simple_ray(), out;
    uint32_t words[CO_RAY_WORDS_MAX];
    ray.dir = d;
    assert_int_equal(encode(&ray, words), 1);
    co_ray_decode(words, 0, &out);
    assert_true(angle(d, out.dir) <= 1.1e-7);
    double n = sqrt((double)out.dir.x * (double)out.dir.x + (double)out.dir.y * (double)out.dir.y +
                    (double)out.dir.z * (double)out.dir.z);
    assert_true(fabs(n - 1.0) <= 1.1e-7);
    const CoVec3 stored = ray.dir = out.dir; // and stays what it is
    assert_int_equal(encode(&ray, words), 1);
    co_ray_decode(words, 0, &out);
    assert_memory_equal(&out.dir, &stored, sizeof stored);
    // A snapped direction is as close, and what its code stores is the same three floats.
    ray.dir = co_ray_snap_direction(d, ray.code);
    assert_true(angle(d, ray.dir) <= 1.1e-7);
    assert_int_equal(encode(&ray, words), 1);
    co_ray_decode(words, 0, &out);
    assert_memory_equal(&out.dir, &ray.dir, sizeof out.dir);
    assert_memory_equal(out.code, ray.code, sizeof out.code);
}

static void snapping_nothing_leaves_the_ray_invalid(void **state)
{
    (void)state;
    const CoVec3 bad[] = {{0, 0, 0}, {NAN, 0, 1}, {INFINITY, 0, 0}};
    for (size_t i = 0; i < 3; i++) {
        CoRay ray = simple_ray(), out;
        uint32_t words[CO_RAY_WORDS_MAX];
        co_ray_snap_direction(bad[i], ray.code);
        assert_int_equal(ray.code[0] | ray.code[1], 0);
        ray.dir = bad[i];
        assert_int_equal(encode(&ray, words), 1);
        co_ray_decode(words, 0, &out);
        assert_true(isnan(out.org.x));
    }
}

static void directions_are_close_and_quantizing_is_a_projection(void **state)
{
    (void)state;
    uint64_t random = 1;
    for (size_t i = samples(1000000); i-- > 0;)
        check_direction(random_direction(&random));
}

static void axes_borders_and_folds_are_exact_or_close(void **state)
{
    (void)state;
    const float values[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e-7f, -1e-7f, 1e-30f, -1e-30f, 0.5f, -0.5f};
    for (size_t i = 0; i < 10; i++)
        for (size_t j = 0; j < 10; j++)
            for (size_t k = 0; k < 10; k++) {
                CoVec3 d = co_normalize(co_vec3(values[i], values[j], values[k]));
                if (co_max3(co_mul(d, d)) > 0.0f)
                    check_direction(d);
            }
    for (uint32_t axis = 0; axis < 6; axis++) {
        float s = axis % 2 ? -1.0f : 1.0f;
        CoVec3 d = co_vec3(axis / 2 == 0 ? s : 0, axis / 2 == 1 ? s : 0, axis / 2 == 2 ? s : 0);
        uint32_t words[2];
        CoVec3 q = co_ray_snap_direction(d, words);
        assert_memory_equal(&q, &d, sizeof d);
        CoOct code;
        assert_true(co_oct_nearest(d, CO_DIRECTION_MAX, &code));
        assert_int_equal(co_ray_bin(code), axis);
    }
}

static void normals_and_pdfs_are_projected(void **state)
{
    (void)state;
    uint64_t random = 2;
    double worst = 0;
    for (size_t i = 0; i < 100000; i++) {
        uint32_t code = 0, same = 0;
        CoVec3 n = random_direction(&random), q = co_ray_snap_normal(n, &code);
        CoVec3 again = co_ray_snap_normal(q, &same);
        assert_true(code != 0 && same != 0);
        assert_memory_equal(&q, &again, sizeof q);
        worst = fmax(worst, angle(n, q));
        float pdf = (float)exp2(62.0 * uniform(&random) - 30.0);
        float r = co_ray_quantize_pdf(pdf);
        assert_true(fabsf(r - pdf) <= pdf * 0.00049f);
        assert_true(co_ray_quantize_pdf(r) == r);
    }
    assert_true(worst < 0.0168);
    assert_true(co_ray_quantize_pdf(0.0f) == 0.0f);
    assert_true(isinf(co_ray_quantize_pdf(INFINITY)));
    assert_true(co_ray_quantize_pdf(1e-38f) > 0.0f);
    assert_true(isfinite(co_ray_quantize_pdf(3e38f)));
    assert_true(co_ray_quantize_pdf(-1.0f) == 0.0f && co_ray_quantize_pdf(NAN) == 0.0f);
}

static void every_field_survives(void **state)
{
    (void)state;
    uint64_t random = 3;
    for (uint32_t i = 0; i < 50000; i++) {
        CoRay ray = {.org = random_direction(&random), .dir = random_direction(&random)};
        CoRay out;
        uint32_t words[CO_RAY_WORDS_MAX + 1], overflow = 0, options = i % 4;
        memset(words, 0xa5, sizeof words);
        ray.dir = co_ray_snap_direction(ray.dir, ray.code);
        ray.weight = co_vec3(1.0f, 0.5f, 0.25f);
        ray.kind = i % 3;
        ray.depth = 1 + i % 1023;
        ray.path = (uint32_t)co_hash64(i);
        ray.branch = i % 256;
        ray.flags = i % 128;
        ray.width = exp2f((float)(i % 250) / 4.0f - 39.0f);
        ray.spread = i % 5 ? exp2f(-(float)(i % 100) / 4.0f) : 0.0f;
        if (options & CO_RAY_OPTION_TNEAR)
            ray.tnear = (float)uniform(&random);
        if (options & CO_RAY_OPTION_EXTRA)
            ray.extra = i;
        if (ray.kind == CO_RAY_LIGHT) {
            ray.emitter = (uint32_t)random & 0xffffffu;
        } else {
            ray.pdf = co_ray_quantize_pdf((float)uniform(&random));
            ray.normal = co_ray_snap_normal(random_direction(&random), &ray.normal_code);
            ray.normal_code = i % 2 ? ray.normal_code : 0; // which need not be given
        }
        CoRayKey key = {i, 0, 0};
        assert_int_equal(encode_with(co_ray_kernels(NULL), &ray, options, key, words, &overflow),
                         1);
        assert_int_equal(words[co_ray_words(options)], 0xa5a5a5a5u);
        co_ray_decode(words, options, &out);
        assert_true(fabsf(out.width / ray.width - 1.0f) < 1e-5f);
        assert_true(fabsf(out.spread - ray.spread) <= ray.spread * 1e-5f);
        out.width = ray.width;
        out.spread = ray.spread;
        if (!ray.normal_code)
            out.normal_code = 0; // decoding finds one
        assert_memory_equal(&out, &ray, sizeof out);
    }
}

static void widths_are_rounded_to_the_nearest_quarter_octave(void **state)
{
    (void)state;
    CoRay ray = simple_ray(), out;
    uint32_t words[CO_RAY_WORDS_MAX];
    for (float width = 1e-11f; width < 1e6f; width *= 1.003f) {
        ray.width = width;
        encode(&ray, words);
        co_ray_decode(words, 0, &out);
        assert_true(fabs(log2((double)(out.width / width))) < 0.1251);
    }
    const float inputs[] = {0.0f, -1.0f, NAN, 1e-38f, INFINITY};
    for (size_t i = 0; i < 5; i++) {
        ray.width = inputs[i];
        encode(&ray, words);
        co_ray_decode(words, 0, &out);
        assert_true(i < 3 ? out.width == 0.0f : out.width > 0.0f && isfinite(out.width));
    }
}

static void rays_that_cannot_be_traced_are_marked(void **state)
{
    (void)state;
    CoRay bad[8], out;
    for (int i = 0; i < 8; i++)
        bad[i] = simple_ray();
    bad[0].dir = co_vec3(0, 0, 0);
    bad[1].dir.y = NAN;
    bad[2].dir.x = INFINITY;
    bad[3].org.z = NAN;
    bad[4].org.x = -INFINITY;
    bad[5].weight.x = NAN;
    bad[6].weight.y = -1.0f;
    bad[7].weight.z = 1e30f;
    for (int i = 0; i < 8; i++) {
        uint32_t words[CO_RAY_WORDS_MAX];
        assert_int_equal(encode(&bad[i], words), 1);
        co_ray_decode(words, 0, &out);
        assert_true(isnan(out.org.x) && isnan(out.org.y) && isnan(out.org.z));
        assert_true(co_is_finite3(out.dir) && co_is_finite3(out.weight));
    }
    bad[7].kind = CO_RAY_LIGHT; // has the exponent bits for that
    uint32_t words[CO_RAY_WORDS_MAX];
    encode(&bad[7], words);
    co_ray_decode(words, 0, &out);
    assert_true(fabsf(out.weight.z / 1e30f - 1.0f) < 0.004f);
    CoRay black = simple_ray();
    black.weight = co_vec3(0, 0, 0);
    assert_int_equal(encode(&black, words), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_are_close_and_quantizing_is_a_projection),
        cmocka_unit_test(snapping_nothing_leaves_the_ray_invalid),
        cmocka_unit_test(axes_borders_and_folds_are_exact_or_close),
        cmocka_unit_test(normals_and_pdfs_are_projected),
        cmocka_unit_test(every_field_survives),
        cmocka_unit_test(widths_are_rounded_to_the_nearest_quarter_octave),
        cmocka_unit_test(rays_that_cannot_be_traced_are_marked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
