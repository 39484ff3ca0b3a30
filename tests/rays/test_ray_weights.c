// Weights in the ray record (kernels/code.c): right in the mean at any size and through many
// vertices, and not changed twice. COHORT_TEST_FULL in the environment runs these at full length.

#include "ray_code_support.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_are_right_in_the_mean),
        cmocka_unit_test(light_weights_keep_their_precision_at_any_size),
        cmocka_unit_test(the_extreme_floats_are_light_weights),
        cmocka_unit_test(weights_are_right_in_the_mean_through_64_vertices),
        cmocka_unit_test(mantissas_never_round_to_512),
        cmocka_unit_test(representable_weights_stay_as_they_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
