// Coding of many rays at once (kernels/code.c): the same records from every instruction set.
// Decoding is in test_ray_batch.

#include "ray_code_support.h"

static void kernels_have_names(void **state)
{
    (void)state;
    static const char *const isas[] = {"scalar", "sse42", "avx2", "avx512"};
    const CoRayKernels *best = co_ray_kernels("scalar");
    assert_non_null(best);
    for (int k = 0; k < 4; k++)
        best = co_ray_kernels(isas[k]) ? co_ray_kernels(isas[k]) : best;
    assert_ptr_equal(co_ray_kernels(NULL), best);
    assert_null(co_ray_kernels("avx1024"));
    assert_ptr_equal(co_ray_kernels(""), best);
}

// A ray with anything in any field: what a path makes, and what none should.
static CoRay any_ray(uint64_t *random)
{
    const float odd[] = {0.0f,   -0.0f,  -1.0f, NAN,   INFINITY, -INFINITY,
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

// Sixteen at a time or alone, with every instruction set: the same records, kept and overflown
// ones.
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
                                (CoRayKey){round, i, 7}, words[i], &overflow)
                    << i;
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
        cmocka_unit_test(kernels_have_names),
        cmocka_unit_test(queues_of_any_length_and_kernel_give_the_same_records),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
