// The film as a file: a header, then the words in chunks that are compressed and hashed one by one.
#include "film/film_state.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <errno.h>
#include <fcntl.h>
#include <libdeflate.h>
#include <string.h>
#include <unistd.h>

#define MAGIC 0x314d4c4946484f43u // "COHFILM1", little-endian
#define CHUNK_WORDS ((size_t)1 << 17)
#define CHUNK_BYTES (CHUNK_WORDS * sizeof(uint64_t))
#define WAVE 8 // chunks in memory at once
#define LEVEL 1

typedef struct Header {
    uint64_t magic, key;
    uint32_t width, height, aovs;
    int32_t unit_exponent;
    uint64_t samples, words;
    uint64_t hash; // of all before
} Header;

_Static_assert(sizeof(Header) == 56, "no padding in the file");

typedef struct ChunkHeader {
    uint64_t bytes; // compressed
    uint64_t hash;  // of the words, seeded with the header's hash and the chunk's number
} ChunkHeader;

typedef struct Chunk {
    ChunkHeader header;
    uint64_t *words;
    size_t word_count, number;
    bool is_good;
} Chunk;

typedef struct Wave {
    Chunk chunks[WAVE];
    unsigned char *packed; // WAVE slots of slot_bytes
    size_t slot_bytes;
    uint64_t seed;
} Wave;

static Header header_of(const CoFilm *film, uint64_t key)
{
    Header h = {MAGIC,         key,         film->width,
                film->height,  film->aovs,  film->unit_exponent,
                film->samples, film->words, 0};
    h.hash = co_hash_bytes(&h, offsetof(Header, hash), 0);
    return h;
}

static bool wave_init(Wave *wave, uint64_t seed, CohortError *err)
{
    memset(wave, 0, sizeof *wave);
    wave->seed = seed;
    wave->slot_bytes = libdeflate_deflate_compress_bound(NULL, CHUNK_BYTES);
    wave->packed = co_alloc(CO_MEMORY_FILM, WAVE * wave->slot_bytes);
    CO_CHECK_MEMORY(wave->packed, err);
    return true;
}

static void wave_clear(Wave *wave)
{
    co_free(CO_MEMORY_FILM, wave->packed, WAVE * wave->slot_bytes);
}

// Assigns the chunks from number `first` on; returns how many.
static size_t wave_assign(Wave *wave, uint64_t *words, size_t word_count, size_t first)
{
    size_t n = 0;
    for (size_t at = first * CHUNK_WORDS; n < WAVE && at < word_count; at += CHUNK_WORDS, n++) {
        size_t left = word_count - at;
        wave->chunks[n] = (Chunk){.words = words + at,
                                  .word_count = left < CHUNK_WORDS ? left : CHUNK_WORDS,
                                  .number = first + n};
    }
    return n;
}

static uint64_t chunk_hash(const Wave *wave, const Chunk *chunk)
{
    return co_hash_bytes(chunk->words, chunk->word_count * sizeof(uint64_t),
                         co_hash_combine(wave->seed, chunk->number));
}

// --- save ---------------------------------------------------------------------------------------

static void pack_chunks(void *context, size_t begin, size_t end, uint32_t worker)
{
    Wave *wave = context;
    (void)worker;
    struct libdeflate_compressor *compressor = libdeflate_alloc_compressor(LEVEL);
    for (size_t i = begin; i < end; i++) {
        Chunk *chunk = &wave->chunks[i];
        chunk->header.hash = chunk_hash(wave, chunk);
        chunk->header.bytes =
            compressor
                ? libdeflate_deflate_compress(compressor, chunk->words,
                                              chunk->word_count * sizeof(uint64_t),
                                              wave->packed + i * wave->slot_bytes, wave->slot_bytes)
                : 0;
        chunk->is_good = chunk->header.bytes > 0;
    }
    if (compressor)
        libdeflate_free_compressor(compressor);
}

static bool write_all(FILE *file, const void *data, size_t size, CohortError *err)
{
    CO_CHECK(fwrite(data, 1, size, file) == size, err, COHORT_ERROR_FILE_WRITE,
             "cannot write the film: %s", strerror(errno));
    return true;
}

static bool write_film(const CoFilm *film, uint64_t key, FILE *file, CohortError *err)
{
    Header header = header_of(film, key);
    Wave wave;
    if (!write_all(file, &header, sizeof header, err) || !wave_init(&wave, header.hash, err))
        return false;
    bool is_good = true;
    size_t n;
    for (size_t first = 0; is_good; first += n) {
        n = wave_assign(&wave, film->shown, film->words, first);
        if (n == 0)
            break;
        co_parallel_for(n, 1, pack_chunks, &wave);
        for (size_t i = 0; is_good && i < n; i++) {
            const Chunk *chunk = &wave.chunks[i];
            is_good = chunk->is_good ||
                      CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory saving the film");
            is_good = is_good && write_all(file, &chunk->header, sizeof chunk->header, err) &&
                      write_all(file, wave.packed + i * wave.slot_bytes, chunk->header.bytes, err);
        }
    }
    wave_clear(&wave);
    return is_good;
}

// The rename itself must survive a power cut, so the folder is synced too, where it can be opened.
static void sync_folder_of(const char *path)
{
    char folder[4096];
    size_t length = strlen(path);
    while (length > 0 && path[length - 1] != '/')
        length--;
    if (length >= sizeof folder)
        return;
    memcpy(folder, path, length);
    folder[length] = 0;
    int fd = open(length ? folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
}

bool co_film_save(const CoFilm *film, const char *path, uint64_t key, CohortError *err)
{
    char temporary[4096];
    int length = snprintf(temporary, sizeof temporary, "%s.%ld.tmp", path, (long)getpid());
    CO_CHECK(length > 0 && (size_t)length < sizeof temporary, err, COHORT_ERROR_ARGUMENT,
             "the path of the film file is too long");
    int fd = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    FILE *file = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (!file) {
        CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot create %s: %s", temporary, strerror(errno));
        co_error_place(err, path, 0, 0, NULL);
        if (fd >= 0)
            close(fd);
        return false;
    }
    bool is_good = write_film(film, key, file, err);
    if (is_good && (fflush(file) || fsync(fd)))
        is_good =
            CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot write the film: %s", strerror(errno));
    if (fclose(file) && is_good)
        is_good = CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot close the film file: %s",
                          strerror(errno));
    if (is_good && rename(temporary, path))
        is_good =
            CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot replace %s: %s", path, strerror(errno));
    if (is_good)
        sync_folder_of(path);
    else
        unlink(temporary);
    if (!is_good)
        co_error_place(err, path, 0, 0, NULL);
    return is_good;
}

// --- load ---------------------------------------------------------------------------------------

static void unpack_chunks(void *context, size_t begin, size_t end, uint32_t worker)
{
    Wave *wave = context;
    (void)worker;
    struct libdeflate_decompressor *decompressor = libdeflate_alloc_decompressor();
    for (size_t i = begin; decompressor && i < end; i++) {
        Chunk *chunk = &wave->chunks[i];
        enum libdeflate_result result = libdeflate_deflate_decompress(
            decompressor, wave->packed + i * wave->slot_bytes, chunk->header.bytes, chunk->words,
            chunk->word_count * sizeof(uint64_t), NULL);
        chunk->is_good =
            result == LIBDEFLATE_SUCCESS && chunk->header.hash == chunk_hash(wave, chunk);
    }
    if (decompressor)
        libdeflate_free_decompressor(decompressor);
}

static bool read_all(FILE *file, void *data, size_t size, CohortError *err)
{
    CO_CHECK(fread(data, 1, size, file) == size, err, COHORT_ERROR_FILE_READ, "%s",
             ferror(file) ? "the film file cannot be read" : "the film file is truncated");
    return true;
}

static bool read_words(FILE *file, uint64_t *words, size_t word_count, Wave *wave, CohortError *err)
{
    size_t n;
    for (size_t first = 0;; first += n) {
        n = wave_assign(wave, words, word_count, first);
        if (n == 0)
            break;
        for (size_t i = 0; i < n; i++) {
            ChunkHeader *header = &wave->chunks[i].header;
            if (!read_all(file, header, sizeof *header, err))
                return false;
            CO_CHECK(header->bytes <= wave->slot_bytes, err, COHORT_ERROR_FILE_READ,
                     "the film file is damaged");
            if (!read_all(file, wave->packed + i * wave->slot_bytes, header->bytes, err))
                return false;
        }
        co_parallel_for(n, 1, unpack_chunks, wave);
        for (size_t i = 0; i < n; i++)
            CO_CHECK(wave->chunks[i].is_good, err, COHORT_ERROR_FILE_READ,
                     "the film file is damaged");
    }
    CO_CHECK(fgetc(file) == EOF, err, COHORT_ERROR_FILE_READ,
             "the film file is damaged: bytes after its end");
    return true;
}

// Size, AOVs and unit are looked at before the key, so that the message is the most telling one.
static bool check_header(const CoFilm *film, const Header *h, uint64_t key, CohortError *err)
{
    CO_CHECK(h->magic == MAGIC, err, COHORT_ERROR_FILE_READ,
             "this is no film file of this version of Cohort");
    CO_CHECK(h->hash == co_hash_bytes(h, offsetof(Header, hash), 0), err, COHORT_ERROR_FILE_READ,
             "the header of the film file is damaged");
    CO_CHECK(h->width == film->width && h->height == film->height, err, COHORT_ERROR_ARGUMENT,
             "the saved film has %u x %u pixels, this render %u x %u", h->width, h->height,
             film->width, film->height);
    CO_CHECK(h->aovs == film->aovs, err, COHORT_ERROR_ARGUMENT,
             "the saved film has other AOVs than this render");
    CO_CHECK(h->unit_exponent == film->unit_exponent, err, COHORT_ERROR_ARGUMENT,
             "the saved film is in units of 2^%d, this render in 2^%d: the lights differ",
             h->unit_exponent, film->unit_exponent);
    CO_CHECK(h->key == key, err, COHORT_ERROR_ARGUMENT,
             "the saved film belongs to another stage, seed or image settings");
    CO_CHECK(h->words == film->words && h->samples <= (uint64_t)1 << 31, err,
             COHORT_ERROR_FILE_READ, "the header of the film file is damaged");
    return true;
}

static bool read_film(CoFilm *film, FILE *file, uint64_t key, CohortError *err)
{
    Header header;
    CO_CHECK(fread(&header, 1, sizeof header, file) == sizeof header, err, COHORT_ERROR_FILE_READ,
             "this is no film file of this version of Cohort, or it is truncated");
    if (!check_header(film, &header, key, err))
        return false;
    Wave wave;
    if (!wave_init(&wave, header.hash, err))
        return false;
    size_t bytes = film->words * sizeof *film->shown;
    uint64_t *words = co_alloc(CO_MEMORY_FILM, bytes);
    bool is_good = words || CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    is_good = is_good && read_words(file, words, film->words, &wave, err);
    wave_clear(&wave);
    if (!is_good) {
        co_free(CO_MEMORY_FILM, words, bytes);
        return false;
    }
    co_free(CO_MEMORY_FILM, film->shown, bytes);
    film->shown = words;
    film->samples = header.samples;
    co_film_revert(film);
    return true;
}

bool co_film_load(CoFilm *film, const char *path, uint64_t key, CohortError *err)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        CO_FAIL(err, errno == ENOENT ? COHORT_ERROR_FILE_NOT_FOUND : COHORT_ERROR_FILE_READ,
                "cannot open %s: %s", path, strerror(errno));
        co_error_place(err, path, 0, 0, NULL);
        return false;
    }
    bool is_good = read_film(film, file, key, err);
    fclose(file);
    if (!is_good)
        co_error_place(err, path, 0, 0, NULL);
    return is_good;
}
