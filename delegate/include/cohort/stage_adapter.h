// Feeds a render index from a USD stage at a time code: what usdImaging is to Hydra.
//
// Everything authored that is not honored goes into the delegate's report (cohort_delegate_report).
//
// Threads: the host's thread makes all calls.

#ifndef COHORT_STAGE_ADAPTER_H
#define COHORT_STAGE_ADAPTER_H

#include "cohort/delegate.h"
#include "cohort/usda.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct CohortAdapter CohortAdapter;

typedef enum CohortTimeChoice {
    COHORT_TIME_EARLIEST = 0, // the earliest time code, as usdrecord
    COHORT_TIME_AT,           // `time`
    COHORT_TIME_DEFAULTS      // default values only
} CohortTimeChoice;

// Purposes drawn, as bits. 0 = the settings' includedPurposes, else default and render.
typedef enum CohortPurpose {
    COHORT_PURPOSE_DEFAULT = 1 << 0,
    COHORT_PURPOSE_RENDER = 1 << 1,
    COHORT_PURPOSE_PROXY = 1 << 2,
    COHORT_PURPOSE_GUIDE = 1 << 3
} CohortPurpose;

// The light of CohortAdapterOptions.env in the index, and in warnings.
#define COHORT_ENV_PATH "/__cohort/env"

// Zero is the default of every field. Strings are copied.
typedef struct CohortAdapterOptions {
    CohortStageOptions stage;
    CohortTimeChoice time_choice;
    double time;
    const char *camera;          // path, or the name of a camera; NULL: see CohortResolvedSettings
    const char *render_settings; // prim path; NULL: the stage metadata renderSettingsPrimPath
    uint32_t purposes;           // CohortPurpose bits
    uint32_t width, height; // 0 = from the stage; one given: the other from the camera's aspect
    const char *env;        // a dome light: "sky" (built in) or an image file; NULL = none
    bool headlight;         // a distant light along the camera, as usdrecord's camera light
    bool inspect;           // only to learn what is not honored: populate pulls, and makes no scene
} CohortAdapterOptions;

// What to render, from options, render settings and stage, in this order.
typedef struct CohortResolvedSettings {
    const char *camera;     // in the index: option > settings' camera > one named main_cam > the
                            // stage's first > a camera that frames everything
    bool camera_frames;     // the last case
    uint32_t width, height; // pixels; without any: 1280 wide, height from the camera's aperture
    CohortConformPolicy conform;
    double pixel_aspect_ratio;
    bool disable_depth_of_field;
    const char *rendering_color_space; // "" = none authored
    const char *settings_path;         // the RenderSettings prim, "" = none
    const char *product_name;          // of the first RenderProduct, "" = none
    double time;                       // NAN = default values
    double frames_per_second, meters_per_unit;
    uint64_t stage_hash; // stage, time and camera: for saved films
    size_t light_count;  // of the stage; 0 and neither env nor headlight: the image will be black
} CohortResolvedSettings;

// Opens a stage. The delegate must outlive the adapter and have an index. NULL as cohort_stage_open
// fails, or with COHORT_ERROR_ARGUMENT when there is no index. options NULL: all defaults.
CohortAdapter *cohort_adapter_open(CohortDelegate *delegate, const char *path,
                                   const CohortAdapterOptions *options, CohortError *err);

// Removes everything it inserted from the index (effective at the next sync), closes the stage.
void cohort_adapter_destroy(CohortAdapter *adapter);

// Inserts the stage's prims into the index. Syncs the index when the camera has to frame the stage.
// Sets the delegate's cohort:renderingColorSpace when the stage authors one and the setting is
// unset.
bool cohort_adapter_populate(CohortAdapter *adapter, CohortError *err);

// Goes to another time code (NAN = default values) and marks what varies; after populate.
bool cohort_adapter_set_time(CohortAdapter *adapter, double time, CohortError *err);

// Valid after populate; strings live until the next set_time or destroy.
void cohort_adapter_settings(const CohortAdapter *adapter, CohortResolvedSettings *out);

// A pass state without bindings made of the resolved settings.
CohortRenderPassState cohort_adapter_pass_state(const CohortAdapter *adapter);

// Paths of the stage's cameras, as `i` runs from 0; NULL at the end.
const char *cohort_adapter_camera(const CohortAdapter *adapter, size_t i);

// The loader's stage, for queries.
const CohortStage *cohort_adapter_stage(const CohortAdapter *adapter);

// The report, as cohort_delegate_report.
size_t cohort_adapter_report(CohortAdapter *adapter, const CohortReportEntry **out);

#ifdef __cplusplus
}
#endif

#endif
