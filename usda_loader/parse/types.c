#include "parse/types.h"

#include <string.h>

#define S(T) \
    { \
        T, CO_SCALAR_NONE, 0, 0, false \
    }

static const CoTypeInfo infos[COHORT_TYPE_COUNT] = {
    [COHORT_TYPE_NONE] = {"", CO_SCALAR_NONE, 0, 0, false},
    [COHORT_TYPE_BLOCK] = {"None", CO_SCALAR_NONE, 0, 0, false},
    [COHORT_TYPE_BOOL] = {"bool", CO_SCALAR_BOOL, 0, 0, false},
    [COHORT_TYPE_UCHAR] = {"uchar", CO_SCALAR_UCHAR, 0, 0, false},
    [COHORT_TYPE_INT] = {"int", CO_SCALAR_INT, 0, 0, false},
    [COHORT_TYPE_UINT] = {"uint", CO_SCALAR_UINT, 0, 0, false},
    [COHORT_TYPE_INT64] = {"int64", CO_SCALAR_INT64, 0, 0, false},
    [COHORT_TYPE_UINT64] = {"uint64", CO_SCALAR_UINT64, 0, 0, false},
    [COHORT_TYPE_HALF] = {"half", CO_SCALAR_HALF, 0, 0, false},
    [COHORT_TYPE_FLOAT] = {"float", CO_SCALAR_FLOAT, 0, 0, false},
    [COHORT_TYPE_DOUBLE] = {"double", CO_SCALAR_DOUBLE, 0, 0, false},
    [COHORT_TYPE_TIMECODE] = {"timecode", CO_SCALAR_DOUBLE, 0, 0, false},
    [COHORT_TYPE_DURATION] = {"duration", CO_SCALAR_DOUBLE, 0, 0, false},
    [COHORT_TYPE_STRING] = {"string", CO_SCALAR_STRING, 0, 0, false},
    [COHORT_TYPE_TOKEN] = {"token", CO_SCALAR_TOKEN, 0, 0, false},
    [COHORT_TYPE_ASSET] = {"asset", CO_SCALAR_ASSET, 0, 0, false},
    [COHORT_TYPE_PATH_EXPRESSION] = {"pathExpression", CO_SCALAR_PATH_EXPRESSION, 0, 0, false},
    [COHORT_TYPE_INT2] = {"int2", CO_SCALAR_INT, 0, 2, false},
    [COHORT_TYPE_INT3] = {"int3", CO_SCALAR_INT, 0, 3, false},
    [COHORT_TYPE_INT4] = {"int4", CO_SCALAR_INT, 0, 4, false},
    [COHORT_TYPE_HALF2] = {"half2", CO_SCALAR_HALF, 0, 2, false},
    [COHORT_TYPE_HALF3] = {"half3", CO_SCALAR_HALF, 0, 3, false},
    [COHORT_TYPE_HALF4] = {"half4", CO_SCALAR_HALF, 0, 4, false},
    [COHORT_TYPE_FLOAT2] = {"float2", CO_SCALAR_FLOAT, 0, 2, false},
    [COHORT_TYPE_FLOAT3] = {"float3", CO_SCALAR_FLOAT, 0, 3, false},
    [COHORT_TYPE_FLOAT4] = {"float4", CO_SCALAR_FLOAT, 0, 4, false},
    [COHORT_TYPE_DOUBLE2] = {"double2", CO_SCALAR_DOUBLE, 0, 2, false},
    [COHORT_TYPE_DOUBLE3] = {"double3", CO_SCALAR_DOUBLE, 0, 3, false},
    [COHORT_TYPE_DOUBLE4] = {"double4", CO_SCALAR_DOUBLE, 0, 4, false},
    [COHORT_TYPE_QUATH] = {"quath", CO_SCALAR_HALF, 0, 4, true},
    [COHORT_TYPE_QUATF] = {"quatf", CO_SCALAR_FLOAT, 0, 4, true},
    [COHORT_TYPE_QUATD] = {"quatd", CO_SCALAR_DOUBLE, 0, 4, true},
    [COHORT_TYPE_MATRIX2D] = {"matrix2d", CO_SCALAR_DOUBLE, 2, 2, false},
    [COHORT_TYPE_MATRIX3D] = {"matrix3d", CO_SCALAR_DOUBLE, 3, 3, false},
    [COHORT_TYPE_MATRIX4D] = {"matrix4d", CO_SCALAR_DOUBLE, 4, 4, false},
    [COHORT_TYPE_POINT3H] = {"point3h", CO_SCALAR_HALF, 0, 3, false},
    [COHORT_TYPE_POINT3F] = {"point3f", CO_SCALAR_FLOAT, 0, 3, false},
    [COHORT_TYPE_POINT3D] = {"point3d", CO_SCALAR_DOUBLE, 0, 3, false},
    [COHORT_TYPE_NORMAL3H] = {"normal3h", CO_SCALAR_HALF, 0, 3, false},
    [COHORT_TYPE_NORMAL3F] = {"normal3f", CO_SCALAR_FLOAT, 0, 3, false},
    [COHORT_TYPE_NORMAL3D] = {"normal3d", CO_SCALAR_DOUBLE, 0, 3, false},
    [COHORT_TYPE_VECTOR3H] = {"vector3h", CO_SCALAR_HALF, 0, 3, false},
    [COHORT_TYPE_VECTOR3F] = {"vector3f", CO_SCALAR_FLOAT, 0, 3, false},
    [COHORT_TYPE_VECTOR3D] = {"vector3d", CO_SCALAR_DOUBLE, 0, 3, false},
    [COHORT_TYPE_COLOR3H] = {"color3h", CO_SCALAR_HALF, 0, 3, false},
    [COHORT_TYPE_COLOR3F] = {"color3f", CO_SCALAR_FLOAT, 0, 3, false},
    [COHORT_TYPE_COLOR3D] = {"color3d", CO_SCALAR_DOUBLE, 0, 3, false},
    [COHORT_TYPE_COLOR4H] = {"color4h", CO_SCALAR_HALF, 0, 4, false},
    [COHORT_TYPE_COLOR4F] = {"color4f", CO_SCALAR_FLOAT, 0, 4, false},
    [COHORT_TYPE_COLOR4D] = {"color4d", CO_SCALAR_DOUBLE, 0, 4, false},
    [COHORT_TYPE_FRAME4D] = {"frame4d", CO_SCALAR_DOUBLE, 4, 4, false},
    [COHORT_TYPE_TEXCOORD2H] = {"texCoord2h", CO_SCALAR_HALF, 0, 2, false},
    [COHORT_TYPE_TEXCOORD2F] = {"texCoord2f", CO_SCALAR_FLOAT, 0, 2, false},
    [COHORT_TYPE_TEXCOORD2D] = {"texCoord2d", CO_SCALAR_DOUBLE, 0, 2, false},
    [COHORT_TYPE_TEXCOORD3H] = {"texCoord3h", CO_SCALAR_HALF, 0, 3, false},
    [COHORT_TYPE_TEXCOORD3F] = {"texCoord3f", CO_SCALAR_FLOAT, 0, 3, false},
    [COHORT_TYPE_TEXCOORD3D] = {"texCoord3d", CO_SCALAR_DOUBLE, 0, 3, false},
    [COHORT_TYPE_OPAQUE] = {"opaque", CO_SCALAR_NONE, 0, 0, false},
    [COHORT_TYPE_GROUP] = {"group", CO_SCALAR_NONE, 0, 0, false},
    [COHORT_TYPE_DICTIONARY] = S("dictionary"),
    [COHORT_TYPE_TIME_SAMPLES] = S("timeSamples"),
    [COHORT_TYPE_TOKEN_LIST_OP] = S("token list"),
    [COHORT_TYPE_STRING_LIST_OP] = S("string list"),
    [COHORT_TYPE_PATH_LIST_OP] = S("path list"),
    [COHORT_TYPE_INT_LIST_OP] = S("int list"),
    [COHORT_TYPE_UINT_LIST_OP] = S("uint list"),
    [COHORT_TYPE_INT64_LIST_OP] = S("int64 list"),
    [COHORT_TYPE_UINT64_LIST_OP] = S("uint64 list"),
    [COHORT_TYPE_REFERENCE_LIST_OP] = S("reference list"),
    [COHORT_TYPE_PAYLOAD_LIST_OP] = S("payload list"),
    [COHORT_TYPE_VARIANT_SELECTION] = S("variant selection"),
    [COHORT_TYPE_SUBLAYERS] = S("sublayers"),
    [COHORT_TYPE_RELOCATES] = S("relocates"),
    [COHORT_TYPE_SPLINE] = S("spline"),
    [COHORT_TYPE_ARRAY_EDIT] = S("array edit"),
    [COHORT_TYPE_ANIMATION_BLOCK] = S("AnimationBlock"),
};

// Spellings of older files that mean a current type.
static const struct {
    const char *name;
    CohortType type;
} aliases[] = {
    {"Vec2i", COHORT_TYPE_INT2},        {"Vec2h", COHORT_TYPE_HALF2},
    {"Vec2f", COHORT_TYPE_FLOAT2},      {"Vec2d", COHORT_TYPE_DOUBLE2},
    {"Vec3i", COHORT_TYPE_INT3},        {"Vec3h", COHORT_TYPE_HALF3},
    {"Vec3f", COHORT_TYPE_FLOAT3},      {"Vec3d", COHORT_TYPE_DOUBLE3},
    {"Vec4i", COHORT_TYPE_INT4},        {"Vec4h", COHORT_TYPE_HALF4},
    {"Vec4f", COHORT_TYPE_FLOAT4},      {"Vec4d", COHORT_TYPE_DOUBLE4},
    {"Quath", COHORT_TYPE_QUATH},       {"Quatf", COHORT_TYPE_QUATF},
    {"Quatd", COHORT_TYPE_QUATD},       {"Matrix2d", COHORT_TYPE_MATRIX2D},
    {"Matrix3d", COHORT_TYPE_MATRIX3D}, {"Matrix4d", COHORT_TYPE_MATRIX4D},
    {"Point", COHORT_TYPE_POINT3D},     {"PointFloat", COHORT_TYPE_POINT3F},
    {"Normal", COHORT_TYPE_NORMAL3D},   {"NormalFloat", COHORT_TYPE_NORMAL3F},
    {"Vector", COHORT_TYPE_VECTOR3D},   {"VectorFloat", COHORT_TYPE_VECTOR3F},
    {"Color", COHORT_TYPE_COLOR3D},     {"ColorFloat", COHORT_TYPE_COLOR3F},
    {"Frame", COHORT_TYPE_FRAME4D},     {"Transform", COHORT_TYPE_MATRIX4D},
    {"PointIndex", COHORT_TYPE_INT},    {"EdgeIndex", COHORT_TYPE_INT},
    {"FaceIndex", COHORT_TYPE_INT},
};

const CoTypeInfo *co_type_info(CohortType type)
{
    return &infos[type < COHORT_TYPE_COUNT ? type : COHORT_TYPE_NONE];
}

size_t co_scalar_size(CoScalar scalar)
{
    static const uint8_t sizes[] = {
        [CO_SCALAR_NONE] = 0,
        [CO_SCALAR_BOOL] = 1,
        [CO_SCALAR_UCHAR] = 1,
        [CO_SCALAR_INT] = 4,
        [CO_SCALAR_UINT] = 4,
        [CO_SCALAR_INT64] = 8,
        [CO_SCALAR_UINT64] = 8,
        [CO_SCALAR_HALF] = 2,
        [CO_SCALAR_FLOAT] = 4,
        [CO_SCALAR_DOUBLE] = 8,
        [CO_SCALAR_STRING] = sizeof(CohortString),
        [CO_SCALAR_TOKEN] = sizeof(CohortString),
        [CO_SCALAR_ASSET] = sizeof(CohortString),
        [CO_SCALAR_PATH_EXPRESSION] = sizeof(CohortString),
    };
    return sizes[scalar];
}

size_t co_type_size(CohortType type)
{
    const CoTypeInfo *info = co_type_info(type);
    return co_scalar_size(info->scalar) * co_type_width(info);
}

const char *co_type_name(CohortType type)
{
    return co_type_info(type)->name;
}

static bool equals(const char *name, const char *text, size_t length)
{
    return length && name[0] == text[0] && strncmp(name, text, length) == 0 && name[length] == '\0';
}

bool co_type_from_name(const char *name, size_t length, CohortType *out, bool *is_array)
{
    bool array = length > 2 && name[length - 2] == '[' && name[length - 1] == ']';
    if (array)
        length -= 2;
    CohortType found = COHORT_TYPE_NONE;
    for (CohortType type = COHORT_TYPE_BOOL; type <= COHORT_TYPE_DURATION && !found; type++)
        if ((type <= COHORT_TYPE_GROUP || type == COHORT_TYPE_DURATION) &&
            equals(infos[type].name, name, length))
            found = type;
    for (size_t i = 0; i < sizeof aliases / sizeof *aliases && !found; i++)
        if (equals(aliases[i].name, name, length))
            found = aliases[i].type;
    if (!found || (array && infos[found].scalar == CO_SCALAR_NONE))
        return false;
    *out = found;
    *is_array = array;
    return true;
}
