// Boxes and nodes, kernel by kernel: whatever a ray enters by exact arithmetic, every kernel says
// so, alone and together; what lies in a node never starts before it; no bit of the canonical
// interval depends on the kernel.

#include "kernel_calls.h"

#include "accel_scene.h"
#include "simd/isa.h"

#include <float.h>

enum {
    TRIALS = 15000
};

// Coordinates beyond have differences that overflow.
#define MOST 1.5e38f

static KernelCalls *const calls[CO_ISA_COUNT] = {
    kernel_calls_scalar,
#ifdef __x86_64__
    kernel_calls_sse42,
    kernel_calls_avx2,
    kernel_calls_avx512,
#endif
};

static bool chance(Random *random, uint32_t one_in)
{
    return random_bits(random) % one_in == 0;
}

// Any finite float, each exponent as likely as any other.
static float any_float(Random *random)
{
    union {
        uint32_t u;
        float f;
    } bits;
    do
        bits.u = random_bits(random);
    while (!isfinite(bits.f));
    return bits.f;
}

static float odd_float(Random *random)
{
    const float odd[] = {0.0f,   -0.0f,  1e-45f, -1e-45f, FLT_MIN, -FLT_MIN, 1e-30f,  1e30f,
                         -1e30f, 1e-18f, 1e18f,  MOST,    1.0f,    -MOST,    -1e-40f, 0.5f};
    float x = chance(random, 2) ? odd[random_bits(random) % 16] : any_float(random);
    return fmaxf(-MOST, fminf(x, MOST));
}

// A trial keeps to one size and place, so that rays meet boxes.
typedef struct Theme {
    float size, offset[3];
    bool is_lattice, is_odd; // coordinates in eighths; any floats at all
    bool is_plain;           // neither odd nor small nor large nor far
} Theme;

static Theme make_theme(Random *random)
{
    const float sizes[] = {1.0f, 1e-6f, 1e7f, 1e-37f, 1e-42f, 1e30f, 3e37f, 1e-30f};
    Theme theme = {.size = chance(random, 2) ? 1.0f : sizes[random_bits(random) % 8],
                   .is_lattice = chance(random, 3),
                   .is_odd = chance(random, 6)};
    float far = chance(random, 3) ? ldexpf(theme.size, (int)(random_bits(random) % 24)) : 0.0f;
    for (int k = 0; k < 3; k++)
        theme.offset[k] = isfinite(4.0f * far) ? random_float(random, -far, far) : 0.0f;
    theme.is_plain = theme.size == 1.0f && far == 0.0f && !theme.is_odd && !theme.is_lattice;
    return theme;
}

static float make_coordinate(Random *random, const Theme *theme, int k)
{
    if (theme->is_odd && chance(random, 2))
        return odd_float(random);
    float x = theme->is_lattice ? (float)(random_bits(random) % 17) / 8.0f - 1.0f
                                : random_float(random, -1.0f, 1.0f);
    return x * theme->size + theme->offset[k];
}

static void make_box(Random *random, const Theme *theme, CoBox *box)
{
    for (int k = 0; k < 3; k++) {
        float a = make_coordinate(random, theme, k), b = make_coordinate(random, theme, k);
        if (chance(random, 5)) // without thickness
            b = a;
        box->lo[k] = fminf(a, b);
        box->hi[k] = fmaxf(a, b);
    }
}

// Brings the largest component into [1, 2), as the kernels do before anything else.
static bool scale_direction(float dir[3])
{
    float largest = fmaxf(fabsf(dir[0]), fmaxf(fabsf(dir[1]), fabsf(dir[2])));
    if (!(largest >= FLT_MIN && largest <= FLT_MAX))
        return false;
    for (int k = 0; k < 3; k++)
        dir[k] = ldexpf(dir[k], -ilogbf(largest));
    return true;
}

// Often from a plane of a box or along one, mostly towards a point in or on a box.
static void make_ray(Random *random, const Theme *theme, const CoBox *boxes, uint32_t count,
                     KernelRay *ray)
{
    do {
        const CoBox *target = &boxes[random_bits(random) % count];
        const CoBox *start = &boxes[random_bits(random) % count];
        for (int k = 0; k < 3; k++) {
            float w =
                chance(random, 2) ? random_float(random, 0.0f, 1.0f) : (float)chance(random, 2);
            float at = target->lo[k] * (1.0f - w) + target->hi[k] * w;
            float from = chance(random, 3) ? start->lo[k] : make_coordinate(random, theme, k);
            ray->org[k] = chance(random, 6) ? at : from;
            ray->dir[k] = at - ray->org[k];
            if (chance(random, 6))
                ray->dir[k] = chance(random, 3) ? odd_float(random) : copysignf(0.0f, ray->dir[k]);
        }
    } while (!scale_direction(ray->dir));
    ray->from = chance(random, 4) ? make_coordinate(random, theme, 0) : 0.0f;
    ray->to = INFINITY;
    if (chance(random, 3)) // up to a plane
        ray->to = fabsf(boxes[0].hi[0] - ray->org[0]);
}

// Where the ray is in the box, in double; false when it is not.
static bool exact_interval(const KernelRay *ray, const CoBox *box, double *from, double *to)
{
    *from = (double)ray->from;
    *to = (double)ray->to;
    for (int k = 0; k < 3; k++) {
        double lo = (double)box->lo[k] - (double)ray->org[k], d = (double)ray->dir[k];
        double hi = (double)box->hi[k] - (double)ray->org[k];
        if (d == 0.0) {
            if (lo > 0.0 || hi < 0.0)
                return false;
            continue;
        }
        *from = fmax(*from, d < 0.0 ? hi / d : lo / d);
        *to = fmin(*to, d < 0.0 ? lo / d : hi / d);
    }
    return *from <= *to;
}

static bool check_node(const KernelNode *node, uint32_t i, double from)
{
    // Not a number: taken as a reason to look.
    return (node->bits >> i & 1u) && !((double)node->entry[i] > from);
}

typedef struct Tally {
    size_t entered, missed, huge;
    size_t easy, loose; // missed in plain trials; of those looked at all the same
} Tally;

static void check_answer(const KernelRay *ray, const CoBox *boxes, uint32_t count, const char *isa,
                         const KernelAnswer *answer, bool is_plain, Tally *tally)
{
    assert_true(answer->is_fit);
    tally->huge += answer->is_huge;
    // Where there is nothing, nothing is entered.
    assert_int_equal(answer->alone.bits >> count, 0);
    assert_int_equal(answer->together.bits >> count, 0);
    assert_int_equal(answer->beam.bits >> count, 0);
    for (uint32_t i = 0; i < count; i++) {
        double from, to;
        bool is_in = exact_interval(ray, &boxes[i], &from, &to);
        tally->entered += is_in;
        tally->missed += !is_in;
        tally->easy += is_plain && !is_in;
        tally->loose += is_plain && !is_in && (answer->alone.bits >> i & 1u);
        bool is_good = !is_in || (check_node(&answer->alone, i, from) &&
                                  (answer->is_huge || check_node(&answer->together, i, from)));
        is_good &= !is_in || check_node(&answer->interval, i, from);
        is_good &= !is_in || (double)answer->exit[i] >= to;
        if (answer->interval.bits >> i & 1u) {
            double canonical = (double)answer->interval.entry[i];
            is_good &= check_node(&answer->alone, i, canonical);
            is_good &= answer->is_huge ||
                       (check_node(&answer->together, i, canonical) && (answer->again >> i & 1u) &&
                        check_node(&answer->beam, i, canonical));
        }
        if (!is_good)
            print_error(
                "%s: org %a %a %a dir %a %a %a from %a to %a, box %a %a %a to %a %a %a: "
                "exactly %a, canonically %a, alone %d %a, together %d %a, beam %d %a, again %d\n",
                isa, (double)ray->org[0], (double)ray->org[1], (double)ray->org[2],
                (double)ray->dir[0], (double)ray->dir[1], (double)ray->dir[2], (double)ray->from,
                (double)ray->to, (double)boxes[i].lo[0], (double)boxes[i].lo[1],
                (double)boxes[i].lo[2], (double)boxes[i].hi[0], (double)boxes[i].hi[1],
                (double)boxes[i].hi[2], from, (double)answer->interval.entry[i],
                (int)(answer->alone.bits >> i & 1u), (double)answer->alone.entry[i],
                (int)(answer->together.bits >> i & 1u), (double)answer->together.entry[i],
                (int)(answer->beam.bits >> i & 1u), (double)answer->beam.entry[i],
                (int)(answer->again >> i & 1u));
        assert_true(is_good);
    }
}

static void compare_answers(const KernelAnswer *want, const KernelAnswer *got, uint32_t count)
{
    assert_int_equal(want->is_fit, got->is_fit);
    assert_int_equal(want->is_huge, got->is_huge);
    assert_int_equal(want->interval.bits, got->interval.bits);
    assert_memory_equal(want->interval.entry, got->interval.entry, count * sizeof(float));
    assert_memory_equal(want->exit, got->exit, count * sizeof(float));
}

static void nodes_hold_what_rays_enter(void **state)
{
    (void)state;
    Tally tally = {0};
    for (uint64_t trial = 0; trial < TRIALS; trial++) {
        Random random = {trial << 20};
        Theme theme = make_theme(&random);
        uint32_t count = 1 + random_bits(&random) % CO_NODE_WIDTH;
        uint32_t ray_count = 1 + random_bits(&random) % KERNEL_CALL_RAYS;
        float relative = chance(&random, 3) ? 0x1p-18f : 0.0f;
        CoBox boxes[CO_NODE_WIDTH];
        KernelRay rays[KERNEL_CALL_RAYS];
        KernelAnswer want[KERNEL_CALL_RAYS], got[KERNEL_CALL_RAYS];
        for (uint32_t i = 0; i < count; i++)
            make_box(&random, &theme, &boxes[i]);
        for (uint32_t i = 0; i < ray_count; i++)
            make_ray(&random, &theme, boxes, count, &rays[i]);
        for (int isa = 0; isa < CO_ISA_COUNT; isa++) {
            if (!calls[isa] || !(co_isa_flags() >> isa & 1u))
                continue;
            calls[isa](boxes, count, relative, rays, ray_count, got);
            if (isa == 0)
                memcpy(want, got, sizeof want);
            for (uint32_t i = 0; i < ray_count; i++) {
                check_answer(&rays[i], boxes, count, co_isa_name((CoIsa)isa), &got[i],
                             theme.is_plain, &tally);
                compare_answers(&want[i], &got[i], count);
            }
        }
    }
    print_message("%zu entered, %zu missed; plainly missed %zu, of those looked at %zu; huge %zu\n",
                  tally.entered, tally.missed, tally.easy, tally.loose, tally.huge);
    assert_true(tally.entered > 100000 && tally.missed > 100000 && tally.huge > 1000);
    assert_true(tally.easy > 10000 && tally.loose < tally.easy / 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(nodes_hold_what_rays_enter)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
