// The cache of the unsorted mode: what was asked for last stays, within a limit.

#include "texture_support.h"

#include "base/memory.h"
#include "texture/block_cache.h"

enum {
    SIDE = 4, // quads a side, each a block of 16 x 16 bytes
    LOG2 = 4
};

typedef struct Fixture {
    CoTextureFile file;
    CoReader reader;
    CoBlockCount count;
    CoBlockCache cache;
} Fixture;

static void open_grid(Fixture *f, size_t limit)
{
    CohortError err = {0};
    *f = (Fixture){.count = {.batch = 1}, .cache = {.limit = limit}};
    write_grid(in_folder("grid.ptx"), SIDE, LOG2, CO_PTEX_U8, 1);
    f->file.ptex = co_ptex_open(in_folder("grid.ptx"), &err);
    assert_non_null(f->file.ptex);
    f->reader.decoder.count = &f->count;
}

static void close_grid(Fixture *f)
{
    co_block_cache_clear(&f->cache);
    assert_int_equal(f->cache.bytes + f->cache.count, 0);
    co_reader_clear(&f->reader);
    co_ptex_close(f->file.ptex);
    assert_int_equal(co_memory_live(CO_MEMORY_TEXTURE), 0);
}

// Of a face, halved so often in u.
static const unsigned char *get(Fixture *f, uint32_t face, uint8_t steps)
{
    bool is_damaged = true;
    const CoRequest request = {
        .block = f->file.ptex->ranks[face], .ulog2 = LOG2, .vlog2 = LOG2, .steps = steps};
    const void *texels = co_block_cache_get(&f->cache, &f->reader, &f->file, &request, &is_damaged);
    assert_false(is_damaged);
    return texels;
}

static void what_is_there_is_not_read_again(void **state)
{
    (void)state;
    Fixture f;
    open_grid(&f, 1 << 20);
    for (int round = 0; round < 3; round++)
        for (uint32_t face = 0; face < SIDE * SIDE; face++) {
            const unsigned char *texels = get(&f, face, 0);
            assert_non_null(texels);
            for (uint32_t i = 0; i < 1 << 2 * LOG2; i++)
                assert_int_equal(texels[i], (uint8_t)(random_at(face, i) * 255.0f));
        }
    assert_int_equal(f.count.read, SIDE * SIDE);
    assert_int_equal(f.cache.count, SIDE * SIDE);
    close_grid(&f);
}

// A halved block is another one, with the means of its pairs.
static void resolutions_are_kept_apart(void **state)
{
    (void)state;
    Fixture f;
    open_grid(&f, 1 << 20);
    const unsigned char *whole = get(&f, 5, 0), *half = get(&f, 5, 1);
    assert_ptr_not_equal(whole, half);
    for (int i = 0; i < 1 << (2 * LOG2 - 1); i++)
        assert_int_equal(half[i], (whole[2 * i] + whole[2 * i + 1]) >> 1);
    assert_ptr_equal(get(&f, 5, 0), whole);
    close_grid(&f);
}

static void the_longest_unused_makes_room(void **state)
{
    (void)state;
    Fixture f;
    open_grid(&f, 1 << 20);
    get(&f, 0, 0);
    f.cache.limit = 3 * f.cache.bytes; // three blocks
    get(&f, 1, 0);
    get(&f, 2, 0);
    get(&f, 0, 0); // so that 1 is the oldest
    get(&f, 3, 0);
    assert_int_equal(f.cache.count, 3);
    assert_true(f.cache.bytes <= f.cache.limit);
    assert_int_equal(f.count.read, 4);
    get(&f, 0, 0);
    get(&f, 2, 0);
    assert_int_equal(f.count.read, 4);
    get(&f, 1, 0);
    assert_int_equal(f.count.read, 5);
    close_grid(&f);
}

// Without a limit set, one block at a time.
static void a_cache_of_nothing_still_answers(void **state)
{
    (void)state;
    Fixture f;
    open_grid(&f, 0);
    for (uint32_t face = 0; face < 4; face++)
        assert_non_null(get(&f, face, 0));
    assert_int_equal(f.cache.count, 1);
    close_grid(&f);
}

static void no_memory_is_no_damage(void **state)
{
    (void)state;
    Fixture f;
    open_grid(&f, 1 << 20);
    co_memory_fail_after(1);
    assert_null(get(&f, 0, 0));
    co_memory_fail_after(2);
    assert_null(get(&f, 0, 0));
    co_memory_fail_after(0);
    assert_non_null(get(&f, 0, 0));
    close_grid(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_there_is_not_read_again),
        cmocka_unit_test(resolutions_are_kept_apart),
        cmocka_unit_test(the_longest_unused_makes_room),
        cmocka_unit_test(a_cache_of_nothing_still_answers),
        cmocka_unit_test(no_memory_is_no_damage),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
