// The values of the settings table (cohort_setting_descriptors) in one delegate.

#ifndef CO_DELEGATE_SETTINGS_H
#define CO_DELEGATE_SETTINGS_H

#include "cohort/delegate.h"

// In the order of the table.
typedef enum CoSetting {
    CO_SETTING_SPP = 0,
    CO_SETTING_MAX_DEPTH,
    CO_SETTING_FIRST_HIT_SAMPLES,
    CO_SETTING_LIGHT_SAMPLES,
    CO_SETTING_NO_LIGHT_SAMPLES_AFTER_SPLIT,
    CO_SETTING_FILTER,
    CO_SETTING_HIDE_LIGHTS,
    CO_SETTING_SEED,
    CO_SETTING_NOISE,
    CO_SETTING_TEXTURE_LEVEL0,
    CO_SETTING_COMPLEXITY,
    CO_SETTING_EDGE_LENGTH,
    CO_SETTING_RENDERING_COLOR_SPACE,
    CO_SETTING_OCIO_CONFIG,
    CO_SETTING_PTEX_REDUCTIONS_AUTHORED,
    CO_SETTING_TIME_LIMIT,
    CO_SETTING_BATCH,
    CO_SETTING_MEMORY,
    CO_SETTING_TEXTURE_MEMORY,
    CO_SETTING_THREADS,
    CO_SETTING_SORT,
    CO_SETTING_SORTER,
    CO_SETTING_ISA,
    CO_SETTING_SCRATCH_FOLDER,
    CO_SETTING_CONVERTED_FOLDER,
    CO_SETTING_ENABLE_SHADOWS,
    CO_SETTING_ENABLE_SCENE_MATERIALS,
    CO_SETTING_ENABLE_SCENE_LIGHTS,
    CO_SETTING_DOME_LIGHT_CAMERA_VISIBILITY,
    CO_SETTING_CONVERGED_VARIANCE,
    CO_SETTING_ENABLE_INTERACTIVE,
    CO_SETTING_COUNT
} CoSetting;

typedef struct CoSettings {
    CohortSettingValue values[CO_SETTING_COUNT]; // strings are owned
    uint64_t version;                            // of all values
    uint64_t image_version;                      // of those that affect the image
} CoSettings;

bool co_settings_init(CoSettings *settings, CohortError *err);
void co_settings_clear(CoSettings *settings);

// The setting of a key or alias, CO_SETTING_COUNT when there is none.
CoSetting co_setting_find(const char *key);

// Sets a value after checks; *changed tells whether it differs from the old one.
bool co_settings_set(CoSettings *settings, CoSetting setting, const CohortSettingValue *value,
                     bool *changed, CohortError *err);

// A hash of what a film must share to be gone on from: all that affects the image except when to
// stop. An OpenColorIO config counts by its name.
uint64_t co_settings_film_hash(const CoSettings *settings);

// What the values mean to the renderer.
void co_settings_render(const CoSettings *settings, CohortRenderSettings *out);
void co_settings_scene(const CoSettings *settings, CohortSceneOptions *out);

#endif
