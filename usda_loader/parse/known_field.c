// The metadata that is known, and where it may stand: what the reference has registered.

#include "parse/parser.h"

enum {
    LAYER = 1 << CO_SPEC_LAYER,
    PRIM = 1 << CO_SPEC_PRIM | 1 << CO_SPEC_VARIANT,
    ATTRIBUTE = 1 << CO_SPEC_ATTRIBUTE,
    RELATION = 1 << CO_SPEC_RELATIONSHIP,
    PROPERTY = ATTRIBUTE | RELATION,
    OBJECT = PRIM | PROPERTY,
    ANY = LAYER | OBJECT
};

// One value of a known type each.
static const CoKnownField known_fields[] = {
    {"active", COHORT_TYPE_BOOL, false, PRIM},
    {"allowedTokens", COHORT_TYPE_TOKEN, true, ATTRIBUTE},
    {"apiSchemas", COHORT_TYPE_TOKEN_LIST_OP, false, PRIM},
    {"arraySizeConstraint", COHORT_TYPE_INT64, false, ATTRIBUTE},
    {"assetInfo", COHORT_TYPE_DICTIONARY, false, OBJECT},
    {"bindMaterialAs", COHORT_TYPE_TOKEN, false, RELATION},
    {"clipSets", COHORT_TYPE_STRING_LIST_OP, false, PRIM},
    {"clips", COHORT_TYPE_DICTIONARY, false, PRIM},
    {"colorConfiguration", COHORT_TYPE_ASSET, false, LAYER},
    {"colorManagementSystem", COHORT_TYPE_TOKEN, false, LAYER},
    {"colorSpace", COHORT_TYPE_TOKEN, false, ATTRIBUTE},
    {"connectability", COHORT_TYPE_TOKEN, false, ATTRIBUTE},
    {"constraintTargetIdentifier", COHORT_TYPE_TOKEN, false, ATTRIBUTE},
    {"customData", COHORT_TYPE_DICTIONARY, false, OBJECT},
    {"customLayerData", COHORT_TYPE_DICTIONARY, false, LAYER},
    {"defaultPrim", COHORT_TYPE_TOKEN, false, LAYER},
    {"displayGroup", COHORT_TYPE_STRING, false, PROPERTY},
    {"displayGroupOrder", COHORT_TYPE_STRING, true, PRIM},
    {"displayName", COHORT_TYPE_STRING, false, OBJECT},
    {"documentation", COHORT_TYPE_STRING, false, ANY},
    {"elementSize", COHORT_TYPE_INT, false, ATTRIBUTE},
    {"endFrame", COHORT_TYPE_DOUBLE, false, LAYER},
    {"endTimeCode", COHORT_TYPE_DOUBLE, false, LAYER},
    {"expressionVariables", COHORT_TYPE_DICTIONARY, false, LAYER},
    {"fallbackPrimTypes", COHORT_TYPE_DICTIONARY, false, LAYER},
    {"framePrecision", COHORT_TYPE_INT, false, LAYER},
    {"framesPerSecond", COHORT_TYPE_DOUBLE, false, LAYER},
    {"hasOwnedSubLayers", COHORT_TYPE_BOOL, false, LAYER},
    {"hidden", COHORT_TYPE_BOOL, false, OBJECT},
    {"inactiveIds", COHORT_TYPE_INT64_LIST_OP, false, PRIM},
    {"instanceable", COHORT_TYPE_BOOL, false, PRIM},
    {"interpolation", COHORT_TYPE_TOKEN, false, ATTRIBUTE},
    {"kilogramsPerUnit", COHORT_TYPE_DOUBLE, false, LAYER},
    {"limits", COHORT_TYPE_DICTIONARY, false, ATTRIBUTE},
    {"metersPerUnit", COHORT_TYPE_DOUBLE, false, LAYER},
    {"noLoadHint", COHORT_TYPE_BOOL, false, RELATION},
    {"outputName", COHORT_TYPE_TOKEN, false, RELATION},
    {"owner", COHORT_TYPE_STRING, false, LAYER},
    {"payloadAssetDependencies", COHORT_TYPE_ASSET, true, PRIM},
    {"prefix", COHORT_TYPE_STRING, false, OBJECT},
    {"renderSettingsPrimPath", COHORT_TYPE_STRING, false, LAYER},
    {"renderType", COHORT_TYPE_TOKEN, false, PROPERTY},
    {"sdrMetadata", COHORT_TYPE_DICTIONARY, false, PRIM | ATTRIBUTE},
    {"sessionOwner", COHORT_TYPE_STRING, false, LAYER},
    {"startFrame", COHORT_TYPE_DOUBLE, false, LAYER},
    {"startTimeCode", COHORT_TYPE_DOUBLE, false, LAYER},
    {"suffix", COHORT_TYPE_STRING, false, OBJECT},
    {"symmetricPeer", COHORT_TYPE_STRING, false, OBJECT},
    {"symmetryArguments", COHORT_TYPE_DICTIONARY, false, OBJECT},
    {"timeCodesPerSecond", COHORT_TYPE_DOUBLE, false, LAYER},
    {"typeName", COHORT_TYPE_TOKEN, false, 1 << CO_SPEC_VARIANT},
    {"uiHints", COHORT_TYPE_DICTIONARY, false, OBJECT},
    {"unauthoredValuesIndex", COHORT_TYPE_INT, false, ATTRIBUTE},
    {"upAxis", COHORT_TYPE_TOKEN, false, LAYER},
    {"weight", COHORT_TYPE_FLOAT, false, ATTRIBUTE},
};

// Fields that are no metadata: they have syntax of their own.
static const struct {
    const char *name;
    unsigned where;
} structural_fields[] = {
    {"comment", ANY},
    {"connectionChildren", ATTRIBUTE},
    {"connectionPaths", ATTRIBUTE},
    {"inheritPaths", PRIM},
    {"layerRelocates", LAYER},
    {"primChildren", LAYER | PRIM},
    {"primOrder", LAYER | PRIM},
    {"propertyOrder", PRIM},
    {"specifier", PRIM},
    {"subLayerOffsets", LAYER},
    {"targetChildren", RELATION},
    {"targetPaths", RELATION},
    {"typeName", ATTRIBUTE},
    {"variability", PROPERTY},
    {"variantSelection", PRIM},
    {"variantSetChildren", PRIM},
    {"variantSetNames", PRIM},
};

const CoKnownField *co_known_field(CoSlice name, CoSpecKind kind)
{
    for (size_t i = 0; i < sizeof known_fields / sizeof *known_fields; i++)
        if (co_slice_is(name, known_fields[i].name))
            return known_fields[i].where >> kind & 1 ? &known_fields[i] : NULL;
    return NULL;
}

const char *co_structural_field(CoSlice name, CoSpecKind kind)
{
    for (size_t i = 0; i < sizeof structural_fields / sizeof *structural_fields; i++)
        if (co_slice_is(name, structural_fields[i].name))
            return structural_fields[i].where >> kind & 1 ? structural_fields[i].name : NULL;
    return NULL;
}
