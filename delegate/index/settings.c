#include "index/settings.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const CohortSettingDescriptor *descriptor(CoSetting setting)
{
    const CohortSettingDescriptor *table;
    cohort_setting_descriptors(&table);
    return &table[setting];
}

static bool copy_string(const char *text, const char **out, CohortError *err)
{
    size_t size = strlen(text) + 1;
    char *copy = co_alloc(CO_MEMORY_DELEGATE, size);
    CO_CHECK_MEMORY(copy, err);
    memcpy(copy, text, size);
    *out = copy;
    return true;
}

static void free_string(const char *text)
{
    if (text)
        co_free(CO_MEMORY_DELEGATE, (void *)(uintptr_t)text, strlen(text) + 1);
}

bool co_settings_init(CoSettings *settings, CohortError *err)
{
    memset(settings, 0, sizeof *settings);
    for (CoSetting i = 0; i < CO_SETTING_COUNT; i++) {
        settings->values[i] = descriptor(i)->fallback;
        settings->values[i].string = NULL;
    }
    for (CoSetting i = 0; i < CO_SETTING_COUNT; i++)
        if (!copy_string(descriptor(i)->fallback.string, &settings->values[i].string, err)) {
            co_settings_clear(settings);
            return false;
        }
    return true;
}

void co_settings_clear(CoSettings *settings)
{
    for (CoSetting i = 0; i < CO_SETTING_COUNT; i++)
        free_string(settings->values[i].string);
    memset(settings, 0, sizeof *settings);
}

CoSetting co_setting_find(const char *key)
{
    const CohortSettingDescriptor *table;
    size_t count = cohort_setting_descriptors(&table);
    for (size_t i = 0; key && i < count; i++)
        if (strcmp(table[i].key, key) == 0 || (table[i].alias && strcmp(table[i].alias, key) == 0))
            return (CoSetting)i;
    return CO_SETTING_COUNT;
}

// Whether `text` is one of "a|b|c".
static bool is_choice(const char *choices, const char *text)
{
    size_t length = strlen(text);
    const char *at = choices;
    for (;;) {
        const char *end = strchr(at, '|');
        size_t n = end ? (size_t)(end - at) : strlen(at);
        if (n == length && memcmp(at, text, n) == 0)
            return true;
        if (!end)
            return false;
        at = end + 1;
    }
}

// The number that a value holds, whatever its numeric type.
static double number_of(const CohortSettingValue *value)
{
    if (value->type == COHORT_SETTING_BOOL)
        return value->boolean ? 1.0 : 0.0;
    return value->type == COHORT_SETTING_INT ? (double)value->integer : value->number;
}

// Converts `value` to the setting's type where nothing is lost, and checks its range.
static bool convert(const CohortSettingDescriptor *d, const CohortSettingValue *value,
                    CohortSettingValue *out, CohortError *err)
{
    *out = d->fallback;
    if (d->type == COHORT_SETTING_STRING) {
        CO_CHECK(value->type == COHORT_SETTING_STRING && value->string, err, COHORT_ERROR_ARGUMENT,
                 "setting %s takes a text", d->key);
        CO_CHECK(!d->choices || is_choice(d->choices, value->string), err, COHORT_ERROR_ARGUMENT,
                 "setting %s is one of %s, not \"%.60s\"", d->key, d->choices, value->string);
        out->string = value->string;
        return true;
    }
    CO_CHECK(value->type != COHORT_SETTING_STRING, err, COHORT_ERROR_ARGUMENT,
             "setting %s takes a number or switch, not a text", d->key);
    double number = number_of(value);
    CO_CHECK(number >= d->least && number <= d->most, err, COHORT_ERROR_ARGUMENT,
             "setting %s is from %g to %g, not %g", d->key, d->least, d->most, number);
    CO_CHECK(d->type == COHORT_SETTING_DOUBLE || number == floor(number), err,
             COHORT_ERROR_ARGUMENT, "setting %s takes a whole number, not %g", d->key, number);
    if (d->type == COHORT_SETTING_BOOL)
        out->boolean = number != 0.0;
    else if (d->type == COHORT_SETTING_DOUBLE)
        out->number = number;
    else
        out->integer = value->type == COHORT_SETTING_INT ? value->integer : (int64_t)number;
    return true;
}

bool co_settings_set(CoSettings *settings, CoSetting setting, const CohortSettingValue *value,
                     bool *changed, CohortError *err)
{
    const CohortSettingDescriptor *d = descriptor(setting);
    CohortSettingValue *old = &settings->values[setting];
    CohortSettingValue converted;
    if (!convert(d, value, &converted, err))
        return false;
    *changed = converted.boolean != old->boolean || converted.integer != old->integer ||
               converted.number != old->number || strcmp(converted.string, old->string) != 0;
    if (!*changed)
        return true;
    if (!copy_string(converted.string, &converted.string, err))
        return false;
    free_string(old->string);
    *old = converted;
    settings->version++;
    if (d->affects_image)
        settings->image_version++;
    return true;
}

static const char *string_or_null(const CoSettings *settings, CoSetting setting)
{
    const char *text = settings->values[setting].string;
    return text[0] ? text : NULL;
}

// Position of the setting's value in its choices, which are in the order of the renderer's enum.
static int choice_of(const CoSettings *settings, CoSetting setting)
{
    const char *text = settings->values[setting].string;
    int position = 0;
    const char *at = descriptor(setting)->choices;
    for (const char *next; (next = strchr(at, '|')) != NULL; at = next + 1, position++)
        if ((size_t)(next - at) == strlen(text) && memcmp(at, text, strlen(text)) == 0)
            return position;
    return position;
}

void co_settings_render(const CoSettings *settings, CohortRenderSettings *out)
{
    const CohortSettingValue *v = settings->values;
    double variance = v[CO_SETTING_CONVERGED_VARIANCE].number;
    double noise = v[CO_SETTING_NOISE].number;
    *out = (CohortRenderSettings){
        .spp = (uint32_t)v[CO_SETTING_SPP].integer,
        .max_depth = (uint32_t)v[CO_SETTING_MAX_DEPTH].integer,
        .first_hit_samples = (uint32_t)v[CO_SETTING_FIRST_HIT_SAMPLES].integer,
        .light_samples = (uint32_t)v[CO_SETTING_LIGHT_SAMPLES].integer,
        .no_light_samples_after_split = v[CO_SETTING_NO_LIGHT_SAMPLES_AFTER_SPLIT].boolean,
        .filter = (CohortFilter)choice_of(settings, CO_SETTING_FILTER),
        .hide_lights = v[CO_SETTING_HIDE_LIGHTS].boolean,
        .hide_domes = !v[CO_SETTING_DOME_LIGHT_CAMERA_VISIBILITY].boolean,
        .seed = (uint32_t)v[CO_SETTING_SEED].integer,
        .noise = noise > 0.0 ? noise : sqrt(variance),
        .texture_level0 = v[CO_SETTING_TEXTURE_LEVEL0].boolean,
        .time_limit_seconds = v[CO_SETTING_TIME_LIMIT].number,
        .batch = (uint32_t)v[CO_SETTING_BATCH].integer,
        .memory = (uint64_t)v[CO_SETTING_MEMORY].integer,
        .threads = (uint32_t)v[CO_SETTING_THREADS].integer,
        .sort = (CohortSort)choice_of(settings, CO_SETTING_SORT),
        .sorter = (CohortSorter)choice_of(settings, CO_SETTING_SORTER),
        .isa = string_or_null(settings, CO_SETTING_ISA),
        .scratch_folder = string_or_null(settings, CO_SETTING_SCRATCH_FOLDER),
    };
}

void co_settings_scene(const CoSettings *settings, CohortSceneOptions *out)
{
    *out = (CohortSceneOptions){
        .rendering_color_space = string_or_null(settings, CO_SETTING_RENDERING_COLOR_SPACE),
        .ocio_config = string_or_null(settings, CO_SETTING_OCIO_CONFIG),
        .converted_folder = string_or_null(settings, CO_SETTING_CONVERTED_FOLDER),
        .ptex_reductions_authored = settings->values[CO_SETTING_PTEX_REDUCTIONS_AUTHORED].boolean,
        .texture_memory = (uint64_t)settings->values[CO_SETTING_TEXTURE_MEMORY].integer,
    };
}

static bool is_when_to_stop(CoSetting setting)
{
    return setting == CO_SETTING_SPP || setting == CO_SETTING_NOISE ||
           setting == CO_SETTING_CONVERGED_VARIANCE || setting == CO_SETTING_TIME_LIMIT;
}

uint64_t co_settings_film_hash(const CoSettings *settings)
{
    uint64_t hash = 1;
    for (CoSetting i = 0; i < CO_SETTING_COUNT; i++) {
        const CohortSettingValue *v = &settings->values[i];
        if (!descriptor(i)->affects_image || is_when_to_stop(i))
            continue;
        const char *text = v->string;
        if (i == CO_SETTING_OCIO_CONFIG && !text[0] && getenv("OCIO"))
            text = getenv("OCIO"); // as the renderer chooses
        hash = co_hash_combine(hash, v->boolean);
        hash = co_hash_combine(hash, (uint64_t)v->integer);
        hash = co_hash_bytes(&v->number, sizeof v->number, hash);
        hash = co_hash_combine(co_hash_bytes(text, strlen(text), hash), strlen(text));
    }
    return hash;
}
