// All settings: names, types, ranges, defaults.

#include "index/settings.h"

#define FALSE_VALUE \
    { \
        .type = COHORT_SETTING_BOOL, .string = "" \
    }
#define TRUE_VALUE \
    { \
        .type = COHORT_SETTING_BOOL, .boolean = true, .string = "" \
    }
#define INT_VALUE(v) \
    { \
        .type = COHORT_SETTING_INT, .integer = (v), .string = "" \
    }
#define DOUBLE_VALUE(v) \
    { \
        .type = COHORT_SETTING_DOUBLE, .number = (v), .string = "" \
    }
#define STRING_VALUE(v) \
    { \
        .type = COHORT_SETTING_STRING, .string = (v) \
    }

#define SWITCH(key, alias, fallback, image, text) \
    { \
        key, alias, COHORT_SETTING_BOOL, fallback, 0.0, 1.0, NULL, text, image \
    }
#define INT(key, alias, fallback, least, most, image, text) \
    { \
        key, alias, COHORT_SETTING_INT, INT_VALUE(fallback), least, most, NULL, text, image \
    }
#define DOUBLE(key, alias, fallback, least, most, image, text) \
    { \
        key, alias, COHORT_SETTING_DOUBLE, DOUBLE_VALUE(fallback), least, most, NULL, text, image \
    }
#define STRING(key, fallback, choices, image, text) \
    { \
        key, NULL, COHORT_SETTING_STRING, STRING_VALUE(fallback), 0.0, 0.0, choices, text, image \
    }

static const CohortSettingDescriptor table[CO_SETTING_COUNT] = {
    [CO_SETTING_SPP] = INT("cohort:spp", "convergedSamplesPerPixel", 64, 1, 2147483648.0, true,
                           "Samples per pixel."),
    [CO_SETTING_MAX_DEPTH] = INT("cohort:maxDepth", NULL, 6, 1, 1023, true,
                                 "Path length in segments; the camera's is 1."),
    [CO_SETTING_FIRST_HIT_SAMPLES] = INT("cohort:firstHitSamples", NULL, 1, 1, 255, true,
                                         "Reflection rays at the first vertex."),
    [CO_SETTING_LIGHT_SAMPLES] =
        INT("cohort:lightSamples", NULL, 1, 1, 255, true, "Light samples at the first vertex."),
    [CO_SETTING_NO_LIGHT_SAMPLES_AFTER_SPLIT] =
        SWITCH("cohort:noLightSamplesAfterSplit", NULL, FALSE_VALUE, true,
               "No light samples after the first vertex, as in the paper."),
    [CO_SETTING_FILTER] = STRING("cohort:filter", "blackman-harris", "blackman-harris|box|gaussian",
                                 true, "Pixel filter."),
    [CO_SETTING_HIDE_LIGHTS] = SWITCH("cohort:hideLights", NULL, FALSE_VALUE, true,
                                      "Lights are not seen by the camera's own rays."),
    [CO_SETTING_SEED] =
        INT("cohort:seed", NULL, 0, 0, 4294967295.0, true, "Changes all random numbers."),
    [CO_SETTING_NOISE] = DOUBLE("cohort:noise", NULL, 0.0, 0.0, 1.0, true,
                                "Stop when the mean relative error is below this; 0 = off."),
    [CO_SETTING_TEXTURE_LEVEL0] = SWITCH("cohort:textureLevel0", NULL, FALSE_VALUE, true,
                                         "Look textures up at full resolution, for references."),
    [CO_SETTING_COMPLEXITY] =
        INT("cohort:complexity", NULL, 2, 0, 8, true,
            "Subdivision level; low, medium, high and veryhigh of usdrecord are 0 to 3."),
    [CO_SETTING_EDGE_LENGTH] = DOUBLE(
        "cohort:edgeLength", NULL, 0.0, 0.0, 1e6, true,
        "Pixels that edges of subdivided meshes are at most; 0 = cohort:complexity decides."),
    [CO_SETTING_RENDERING_COLOR_SPACE] =
        STRING("cohort:renderingColorSpace", "", NULL, true,
               "Space of all light transport; empty = the config's scene_linear, else Rec.709."),
    [CO_SETTING_OCIO_CONFIG] =
        STRING("cohort:ocioConfig", "", NULL, true, "OpenColorIO config; empty = $OCIO."),
    [CO_SETTING_PTEX_REDUCTIONS_AUTHORED] =
        SWITCH("cohort:ptexReductionsAuthored", NULL, FALSE_VALUE, true,
               "Take the reductions stored in Ptex files instead of rebuilding them."),
    [CO_SETTING_TIME_LIMIT] = DOUBLE("cohort:timeLimit", NULL, 0.0, 0.0, 1e9, false,
                                     "Seconds after which no further round starts; 0 = off."),
    [CO_SETTING_BATCH] =
        INT("cohort:batch", NULL, 0, 0, 67108864.0, false, "Rays per bin; 0 = 4194304."),
    [CO_SETTING_MEMORY] =
        INT("cohort:memory", NULL, 0, 0, 9.2e18, false, "Memory limit in bytes; 0 = none."),
    [CO_SETTING_TEXTURE_MEMORY] = INT("cohort:textureMemory", NULL, 0, 0, 9.2e18, false,
                                      "Bytes of decoded texels that may stay; 0 = 1 GiB."),
    [CO_SETTING_THREADS] =
        INT("cohort:threads", "threadLimit", 0, 0, 4096, false, "Threads; 0 = all."),
    [CO_SETTING_SORT] = STRING("cohort:sort", "auto", "auto|none|rays|hits|both", false,
                               "What is sorted; never changes a pixel."),
    [CO_SETTING_SORTER] =
        STRING("cohort:sorter", "fast", "fast|exact", false, "How rays are sorted."),
    [CO_SETTING_ISA] = STRING("cohort:isa", "", "|scalar|sse42|avx2|avx512", false,
                              "Instruction set of the kernels; empty = the best there is."),
    [CO_SETTING_SCRATCH_FOLDER] = STRING("cohort:scratchFolder", "", NULL, false,
                                         "Where ray bins live; empty = $TMPDIR or /tmp."),
    [CO_SETTING_CONVERTED_FOLDER] =
        STRING("cohort:convertedFolder", "", NULL, false,
               "Where converted textures are kept; empty = the user's cache."),
    [CO_SETTING_ENABLE_SHADOWS] = SWITCH("enableShadows", NULL, TRUE_VALUE, true,
                                         "Off: no surface keeps the light of a lamp from another."),
    [CO_SETTING_ENABLE_SCENE_MATERIALS] =
        SWITCH("enableSceneMaterials", NULL, TRUE_VALUE, true,
               "Off: every mesh is Lambertian with its displayColor."),
    [CO_SETTING_ENABLE_SCENE_LIGHTS] =
        SWITCH("enableSceneLights", NULL, TRUE_VALUE, true, "Off: no light contributes."),
    [CO_SETTING_DOME_LIGHT_CAMERA_VISIBILITY] =
        SWITCH("domeLightCameraVisibility", NULL, TRUE_VALUE, true,
               "Off: the camera does not see dome lights; cohort:hideLights hides all."),
    [CO_SETTING_CONVERGED_VARIANCE] =
        DOUBLE("convergedVariance", NULL, 0.0, 0.0, 1.0, true,
               "Stop when the mean relative variance is below this; cohort:noise wins."),
    [CO_SETTING_ENABLE_INTERACTIVE] = SWITCH("enableInteractive", NULL, TRUE_VALUE, false,
                                             "A hint of the host; rounds are always progressive."),
};

size_t cohort_setting_descriptors(const CohortSettingDescriptor **out)
{
    *out = table;
    return CO_SETTING_COUNT;
}
