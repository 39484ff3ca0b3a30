// Image lookups as requests: whose texels, with which weights, at which levels.

#include "base/memory.h"
#include "texture/request.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

// 128 x 128 texels: four tiles, then a tile a level down to 1 x 1.
static CoImageFile image = {.channels = 1, .level_count = 8, .tile_count = 11};

static int set_levels(void **state)
{
    (void)state;
    uint32_t first = 0;
    for (uint32_t i = 0; i < image.level_count; i++) {
        uint32_t side = 128u >> i, tiles = side > CO_IMAGE_TILE ? 2 : 1;
        image.levels[i] = (CoImageLevel){side, side, tiles, tiles, first};
        first += tiles * tiles;
    }
    return 0;
}

typedef struct Asked {
    CoRequestPool pool;
    atomic_size_t budget;
    CoRequestSink sink;
    double weight; // of all requests
} Asked;

static void ask(Asked *asked, CohortWrap wrap, const CoLookup *lookup)
{
    static CoTextureFile file = {.image = &image};
    static CoTexture texture;
    texture = (CoTexture){.kind = CO_TEXTURE_IMAGE, .wrap_s = wrap, .wrap_t = wrap};
    *asked = (Asked){.budget = 1 << 20};
    asked->pool.budget = &asked->budget;
    asked->sink =
        (CoRequestSink){.pool = &asked->pool, .texture = &texture, .file = &file, .ok = true};
    asked->sink.last = &asked->sink.first;
    assert_true(co_image_request(&asked->sink, lookup) == 1.0f);
    for (const CoRequest *r = asked->sink.first; r; r = r->next) {
        double across = 0.0, down = 0.0;
        for (int i = 0; i < r->uw; i++)
            across += (double)r->weights[i];
        for (int i = 0; i < r->vw; i++)
            down += (double)r->weights[r->uw + i];
        asked->weight += across * down;
        assert_true(r->u >= 0 && r->u + r->uw <= CO_IMAGE_TILE);
        assert_true(r->v >= 0 && r->v + r->vw <= CO_IMAGE_TILE && r->block < image.tile_count);
    }
}

static void a_texels_center_is_one_texel(void **state)
{
    (void)state;
    Asked asked;
    ask(&asked, COHORT_WRAP_REPEAT, &(CoLookup){.s = 70.5f / 128, .t = 1 - 3.5f / 128});
    const CoRequest *r = asked.sink.first;
    assert_int_equal(asked.sink.count, 1);
    assert_int_equal(r->block, 1); // the right one of the upper two
    assert_int_equal(r->u, 6);
    assert_int_equal(r->v, 3);
    assert_true(r->uw == 1 && r->vw == 1 && r->weights[0] == 1 && r->weights[1] == 1);
    co_request_pool_clear(&asked.pool);
}

static void at_the_corner_of_four_tiles_each_is_asked(void **state)
{
    (void)state;
    Asked asked;
    ask(&asked, COHORT_WRAP_CLAMP, &(CoLookup){.s = .5f, .t = .5f});
    assert_int_equal(asked.sink.count, 4);
    uint32_t block = 0;
    for (const CoRequest *r = asked.sink.first; r; r = r->next, block++) {
        assert_int_equal(r->block, block);
        assert_int_equal(r->u, block % 2 ? 0 : 63);
        assert_int_equal(r->v, block / 2 ? 0 : 63);
        assert_true(r->weights[0] * r->weights[1] == .25f);
    }
    co_request_pool_clear(&asked.pool);
}

static void wider_footprints_ask_coarser_levels(void **state)
{
    (void)state;
    Asked asked;
    // Three texels: halfway between the levels that halve once and twice.
    ask(&asked, COHORT_WRAP_CLAMP, &(CoLookup){.s = .3f, .t = .3f, .ds0 = 3.0f / 128});
    assert_int_equal(asked.sink.count, 2);
    assert_int_equal(asked.sink.first->block, 4);
    assert_int_equal(asked.sink.first->next->block, 5);
    assert_true(fabs(asked.weight - 1.0) < 1e-6);
    const CoRequest *fine = asked.sink.first;
    assert_true(fabsf(fine->weights[fine->uw] + fine->weights[fine->uw + 1] - .5f) < 1e-6f);
    co_request_pool_clear(&asked.pool);
    // One texel is sharp; anything beyond the image is its mean.
    ask(&asked, COHORT_WRAP_CLAMP, &(CoLookup){.s = .3f, .t = .3f, .dt1 = 1.0f / 128});
    assert_true(asked.sink.first->block < 4);
    co_request_pool_clear(&asked.pool);
    ask(&asked, COHORT_WRAP_REPEAT, &(CoLookup){.s = .3f, .t = .3f, .ds0 = 40, .dt0 = INFINITY});
    assert_int_equal(asked.sink.first->block, 10);
    assert_true(fabs(asked.weight - 1.0) < 1e-6);
    co_request_pool_clear(&asked.pool);
}

static void what_falls_outside_is_missing(void **state)
{
    (void)state;
    static const float places[] = {-7.3f, -.002f, 0, .4f, 1, 1.003f, 2.5f, 1e30f, NAN};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        for (int wrap = COHORT_WRAP_BLACK; wrap <= COHORT_WRAP_MIRROR; wrap++) {
            Asked asked;
            ask(&asked, (CohortWrap)wrap, &(CoLookup){.s = places[i], .t = .25f});
            assert_true(fabs(asked.weight + (double)asked.sink.missing - 1.0) < 1e-6);
            if (wrap != COHORT_WRAP_BLACK)
                assert_true(asked.sink.missing == 0);
            co_request_pool_clear(&asked.pool);
        }
    }
    Asked asked;
    ask(&asked, COHORT_WRAP_BLACK, &(CoLookup){.s = 0, .t = .25f});
    assert_true(asked.sink.missing == .5f);
    co_request_pool_clear(&asked.pool);
    assert_int_equal(co_memory_live(CO_MEMORY_TEXTURE), 0);
}

static void tiles_of_a_set_lie_ten_in_a_row(void **state)
{
    (void)state;
    uint32_t files[CO_UDIM_TILES];
    for (uint32_t i = 0; i < CO_UDIM_TILES; i++)
        files[i] = 1000 + i;
    const CoTexture texture = {.udim = files};
    CoLookup lookup = {.s = 3.25f, .t = 2.5f};
    assert_int_equal(co_image_udim(&texture, &lookup), 1023);
    assert_true(lookup.s == .25f && lookup.t == .5f);
    const float outside[][2] = {{-.1f, 0}, {10, 0}, {0, 10}, {0, -1}, {NAN, 0}, {0, INFINITY}};
    for (int i = 0; i < 6; i++) {
        lookup = (CoLookup){.s = outside[i][0], .t = outside[i][1]};
        assert_int_equal(co_image_udim(&texture, &lookup), COHORT_INVALID_ID);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_texels_center_is_one_texel),
        cmocka_unit_test(at_the_corner_of_four_tiles_each_is_asked),
        cmocka_unit_test(wider_footprints_ask_coarser_levels),
        cmocka_unit_test(what_falls_outside_is_missing),
        cmocka_unit_test(tiles_of_a_set_lie_ten_in_a_row),
    };
    return cmocka_run_group_tests(tests, set_levels, NULL);
}
