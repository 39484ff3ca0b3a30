// The ray record: direction error, fixed points of quantizing, unbiased weights, every field.
// COHORT_TEST_FULL in the environment runs the statistics at full length.

#include "base/hash.h"
#include "rays/ray_kernels.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static size_t samples(size_t fast)
{
    return getenv("COHORT_TEST_FULL") ? 10000000 : fast;
}

static double uniform(uint64_t *state)
{
    *state = co_hash64(*state);
    return (double)(*state >> 11) * 0x1p-53;
}

static CoVec3 random_direction(uint64_t *state)
{
    for (;;) {
        double x = 2 * uniform(state) - 1, y = 2 * uniform(state) - 1, z = 2 * uniform(state) - 1;
        double n = x * x + y * y + z * z;
        if (n > 1e-3 && n <= 1.0) {
            double inv = 1.0 / sqrt(n);
            return co_vec3((float)(x * inv), (float)(y * inv), (float)(z * inv));
        }
    }
}

static CoRay simple_ray(void)
{
    CoRay ray = {.org = {1, 2, 3}, .dir = {0, 0, 1}, .weight = {1, 1, 1}, .depth = 1};
    return ray;
}

// One ray by itself. The number of records it gets: 1, or 0 when its weight was rounded to nothing.
static uint32_t encode_with(const CoRayKernels *kernels, const CoRay *ray, uint32_t options,
                            CoRayKey key, uint32_t *words, uint32_t *overflow)
{
    static CoRayQueue queue;
    CoRayEncoded encoded;
    queue.count = 0;
    assert_false(co_ray_queue_add(&queue, ray, key));
    kernels->encode(&queue, options, &encoded);
    if (encoded.is_kept)
        memcpy(words, encoded.words[0], co_ray_words(options) * sizeof *words);
    *overflow += encoded.has_overflown;
    return encoded.is_kept;
}

static uint32_t encode(const CoRay *ray, uint32_t *words)
{
    uint32_t overflow = 0;
    return encode_with(co_ray_kernels(NULL), ray, 0, (CoRayKey){1, 2, 3}, words, &overflow);
}

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
    CoVec3 q = co_ray_quantize_direction(d);
    assert_memory_equal(&q, &out.dir, sizeof q);
    CoVec3 again = co_ray_quantize_direction(q);
    assert_memory_equal(&again, &q, sizeof q);
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
        CoVec3 q = co_ray_quantize_direction(d);
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
        CoVec3 n = random_direction(&random), q = co_ray_quantize_normal(n);
        CoVec3 again = co_ray_quantize_normal(q);
        uint32_t code = 0;
        CoVec3 snapped = co_ray_snap_normal(n, &code);
        assert_memory_equal(&snapped, &q, sizeof q);
        assert_true(code != 0);
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

typedef struct Mean {
    double sum[3], sum2[3];
    size_t count;
} Mean;

// Adds w relative to `truth`; a lost ray is a zero.
static void mean_add(Mean *mean, CoVec3 w, const double *truth)
{
    const double got[3] = {(double)w.x, (double)w.y, (double)w.z};
    for (int c = 0; c < 3; c++) {
        double deviation = got[c] / truth[c] - 1.0;
        mean->sum[c] += deviation;
        mean->sum2[c] += deviation * deviation;
    }
    mean->count++;
}

static void mean_check(const Mean *mean)
{
    double n = (double)mean->count;
    for (int c = 0; c < 3; c++) {
        double standard_error = sqrt(mean->sum2[c]) / n;
        assert_true(fabs(mean->sum[c] / n) <= 4.0 * standard_error + 1e-15);
    }
}

static CoVec3 transport(const CoRay *ray, CoRayKey key, uint32_t *overflow)
{
    uint32_t words[CO_RAY_WORDS_MAX];
    CoRay out = {.kind = 0};
    if (encode_with(co_ray_kernels(NULL), ray, 0, key, words, overflow))
        co_ray_decode(words, 0, &out);
    return out.weight;
}

static void weights_are_right_in_the_mean(void **state)
{
    (void)state;
    for (int power = -9; power <= 9; power++)
        for (uint32_t kind = CO_RAY_BSDF; kind <= CO_RAY_LIGHT; kind++) {
            double m = pow(10.0, power);
            CoRay ray = simple_ray();
            ray.kind = kind;
            ray.weight = co_vec3((float)(1.37 * m), (float)(0.71 * m), (float)(0.02 * m));
            double truth[3] = {(double)ray.weight.x, (double)ray.weight.y, (double)ray.weight.z};
            Mean mean = {.count = 0};
            uint32_t overflow = 0, expected = 0;
            for (uint32_t i = (uint32_t)samples(100000); i-- > 0;) {
                mean_add(&mean, transport(&ray, (CoRayKey){i % 1000, i / 1000, 7}, &overflow),
                         truth);
                expected += power >= 5;
            }
            mean_check(&mean);
            assert_int_equal(overflow, expected);
        }
}

// What a light ray of weight (1.37, 0.71, 0.02) * scale becomes, over many paths: the mean, every
// single one to within a step of the mantissa, and none lost.
static void check_light_weight(double scale)
{
    const double steps = 1.0 / 256.0; // of the largest channel, at most
    CoRay ray = simple_ray();
    ray.kind = CO_RAY_LIGHT;
    ray.weight = co_vec3((float)(1.37 * scale), (float)(0.71 * scale), (float)(0.02 * scale));
    double truth[3] = {(double)ray.weight.x, (double)ray.weight.y, (double)ray.weight.z};
    Mean mean = {.count = 0};
    uint32_t overflow = 0;
    for (uint32_t i = (uint32_t)samples(10000); i-- > 0;) {
        CoVec3 w = transport(&ray, (CoRayKey){i % 1000, i / 1000, 7}, &overflow);
        mean_add(&mean, w, truth);
        assert_true(fabs((double)w.x - truth[0]) <= truth[0] * steps);
        assert_true(fabs((double)w.y - truth[1]) <= truth[0] * steps);
        assert_true(fabs((double)w.z - truth[2]) <= truth[0] * steps);
        CoRay again = ray;
        again.weight = w;
        w = transport(&again, (CoRayKey){i, 1, 0}, &overflow);
        assert_memory_equal(&w, &again.weight, sizeof w);
    }
    mean_check(&mean);
    assert_true(scale > 1e4 ? overflow > 0 : overflow == 0);
}

static void light_weights_keep_their_precision_at_any_size(void **state)
{
    (void)state;
    for (int power = -35; power <= 35; power++)
        check_light_weight(pow(10.0, power));
}

static void the_extreme_floats_are_light_weights(void **state)
{
    (void)state;
    const float exact[] = {0x1p-149f, 0x1.fep-141f, 0x1p-126f, 1.0f, 0x1.fep127f};
    uint32_t overflow = 0;
    for (size_t i = 0; i < 5; i++) {
        CoRay ray = simple_ray();
        ray.kind = CO_RAY_LIGHT;
        ray.weight = co_vec3(exact[i], 0.0f, exact[i]);
        CoVec3 w = transport(&ray, (CoRayKey){7, 8, 9}, &overflow);
        assert_memory_equal(&w, &ray.weight, sizeof w);
    }
}

static void weights_are_right_in_the_mean_through_64_vertices(void **state)
{
    (void)state;
    Mean mean = {.count = 0};
    const CoVec3 albedo = {0.93f, 0.86f, 0.88f};
    double truth[3] = {1, 1, 1};
    for (int i = 0; i < 64; i++) {
        truth[0] *= (double)albedo.x;
        truth[1] *= (double)albedo.y;
        truth[2] *= (double)albedo.z;
    }
    uint32_t overflow = 0;
    for (uint32_t path = (uint32_t)samples(200000) / 10; path-- > 0;) {
        CoRay ray = simple_ray();
        ray.kind = CO_RAY_BSDF;
        for (ray.depth = 1; ray.depth <= 64; ray.depth++) {
            ray.weight = co_mul(ray.weight, albedo);
            ray.weight = transport(&ray, (CoRayKey){path, 0, 0}, &overflow);
        }
        mean_add(&mean, ray.weight, truth);
    }
    mean_check(&mean);
}

static void mantissas_never_round_to_512(void **state)
{
    (void)state;
    uint32_t overflow = 0;
    for (uint32_t i = 0; i < 200000; i++) {
        CoRay ray = simple_ray();
        float top = 511.0f + (float)(i % 1001) * 0.001f; // 511 to 512, in units of the last place
        ray.weight = co_vec3(top / 1024.0f, 0.0f, top / 512.0f);
        CoVec3 w = transport(&ray, (CoRayKey){i, 0, 0}, &overflow);
        assert_true(w.x >= 0.496f && w.x <= 0.5f);
        assert_true(w.y == 0.0f);
        assert_true(w.z >= 0.996f && w.z <= 1.0f);
    }
    assert_int_equal(overflow, 0);
}

static void representable_weights_stay_as_they_are(void **state)
{
    (void)state;
    uint32_t overflow = 0;
    uint64_t random = 5;
    for (uint32_t i = 0; i < 100000; i++) {
        CoRay ray = simple_ray();
        ray.weight = co_vec3((float)uniform(&random), (float)uniform(&random), 1e-6f);
        ray.weight = transport(&ray, (CoRayKey){i, 0, 0}, &overflow);
        CoVec3 again = transport(&ray, (CoRayKey){i, 1, 0}, &overflow);
        assert_memory_equal(&again, &ray.weight, sizeof again);
    }
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
            ray.normal = i % 2 ? co_ray_quantize_normal(random_direction(&random))
                               : co_ray_snap_normal(random_direction(&random), &ray.normal_code);
        }
        CoRayKey key = {i, 0, 0};
        assert_int_equal(
            encode_with(co_ray_kernels(NULL), &ray, options, key, words, &overflow), 1);
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

// A ray with anything in any field: what a path makes, and what none should.
static CoRay any_ray(uint64_t *random)
{
    const float odd[] = {0.0f, -0.0f,    -1.0f, NAN,   INFINITY, -INFINITY,
                         1e-45f, 1e-38f, 3e38f, 65408, 65536,    2.8e14f};
    CoRay ray = {.dir = random_direction(random), .org = random_direction(random)};
    float *floats[] = {&ray.org.x,    &ray.org.y, &ray.dir.x, &ray.dir.z,  &ray.weight.x,
                       &ray.weight.y, &ray.pdf,   &ray.width, &ray.spread, &ray.tnear};
    float scale = (float)exp2(100.0 * uniform(random) - 60.0);
    ray.weight = co_vec3(scale, scale * (float)uniform(random), scale * (float)uniform(random));
    ray.pdf = (float)exp2(80.0 * uniform(random) - 40.0);
    ray.width = (float)exp2(80.0 * uniform(random) - 50.0);
    ray.spread = (float)uniform(random);
    ray.normal = random_direction(random);
    ray.kind = (uint32_t)(3.0 * uniform(random));
    ray.depth = (uint32_t)(2000.0 * uniform(random));
    ray.path = (uint32_t)(*random >> 32);
    ray.branch = (uint32_t)(300.0 * uniform(random));
    ray.emitter = ray.kind == CO_RAY_LIGHT ? (uint32_t)*random : 0;
    ray.flags = (uint32_t)(*random >> 8) & 255u;
    ray.extra = (uint32_t)*random;
    if (uniform(random) < 0.3)
        *floats[(size_t)(10.0 * uniform(random))] = odd[(size_t)(12.0 * uniform(random))];
    if (uniform(random) < 0.5)
        ray.dir = co_ray_snap_direction(ray.dir, ray.code);
    return ray;
}

// Sixteen at a time or alone, with every instruction set: the same records, kept and overflown ones.
static void queues_of_any_length_and_kernel_give_the_same_records(void **state)
{
    (void)state;
    static const char *const isas[] = {"scalar", "sse42", "avx2", "avx512"};
    uint64_t random = 11;
    static CoRayQueue queue;
    for (uint32_t round = 0; round < 20000; round++) {
        uint32_t options = round % 4, count = 1 + round / 4 % CO_RAY_QUEUE_RAYS;
        CoRay rays[CO_RAY_QUEUE_RAYS];
        uint32_t words[CO_RAY_QUEUE_RAYS][CO_RAY_WORDS_MAX], kept = 0, overflown = 0;
        for (uint32_t i = 0; i < count; i++) {
            uint32_t overflow = 0;
            rays[i] = any_ray(&random);
            kept |= encode_with(co_ray_kernels("scalar"), &rays[i], options,
                                (CoRayKey){round, i, 7}, words[i], &overflow) << i;
            overflown |= overflow << i;
        }
        for (int k = 0; k < 4; k++) {
            const CoRayKernels *kernels = co_ray_kernels(isas[k]);
            if (!kernels)
                continue;
            CoRayEncoded encoded;
            queue.count = 0;
            for (uint32_t i = 0; i < count; i++) {
                bool is_full = co_ray_queue_add(&queue, &rays[i], (CoRayKey){round, i, 7});
                assert_int_equal(is_full, i + 1 == CO_RAY_QUEUE_RAYS);
            }
            kernels->encode(&queue, options, &encoded);
            assert_int_equal(encoded.is_kept, kept);
            assert_int_equal(encoded.has_overflown, overflown);
            for (uint32_t i = 0; i < count; i++)
                if (kept >> i & 1)
                    assert_memory_equal(encoded.words[i], words[i],
                                        co_ray_words(options) * sizeof(uint32_t));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(queues_of_any_length_and_kernel_give_the_same_records),
        cmocka_unit_test(directions_are_close_and_quantizing_is_a_projection),
        cmocka_unit_test(snapping_nothing_leaves_the_ray_invalid),
        cmocka_unit_test(axes_borders_and_folds_are_exact_or_close),
        cmocka_unit_test(normals_and_pdfs_are_projected),
        cmocka_unit_test(weights_are_right_in_the_mean),
        cmocka_unit_test(light_weights_keep_their_precision_at_any_size),
        cmocka_unit_test(the_extreme_floats_are_light_weights),
        cmocka_unit_test(weights_are_right_in_the_mean_through_64_vertices),
        cmocka_unit_test(mantissas_never_round_to_512),
        cmocka_unit_test(representable_weights_stay_as_they_are),
        cmocka_unit_test(every_field_survives),
        cmocka_unit_test(widths_are_rounded_to_the_nearest_quarter_octave),
        cmocka_unit_test(rays_that_cannot_be_traced_are_marked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
