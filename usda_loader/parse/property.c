// Attributes and relationships.

#include "parse/parser.h"

#include <string.h>

typedef struct Declaration {
    const char *at;
    const char *type; // token, "" for a relationship
    bool is_relationship, is_custom, is_uniform;
    const char *name;
} Declaration;

// Whether rel, custom rel, varying rel or custom varying rel stands here.
static bool scan_relationship(CoScan *scan, Declaration *out)
{
    CoScan ahead = *scan;
    out->is_uniform = true;
    out->is_custom = co_scan_word(&ahead, "custom");
    if (out->is_custom && !co_scan_gap(&ahead))
        return false;
    if (co_scan_word(&ahead, "varying")) {
        out->is_uniform = false;
        if (!co_scan_gap(&ahead))
            return false;
    }
    if (!co_scan_word(&ahead, "rel"))
        return false;
    scan->at = ahead.at;
    out->is_relationship = true;
    return true;
}

// ["custom"] ["uniform" | "config"] type ["[]"]
static bool parse_attribute_type(CoParser *p, Declaration *out, bool *found)
{
    const char *from = p->scan.at;
    out->is_custom = co_scan_word(&p->scan, "custom");
    if (out->is_custom && !co_scan_gap(&p->scan))
        return co_parse_expected(p, "a blank");
    out->is_uniform = co_scan_word(&p->scan, "uniform") || co_scan_word(&p->scan, "config");
    if (out->is_uniform && !co_scan_gap(&p->scan))
        return co_parse_expected(p, "a blank");
    CoSlice name;
    *found = co_scan_type_name(&p->scan, &name);
    if (!*found) {
        if (p->scan.at > from)
            return co_parse_expected(p, "the type of an attribute");
        return true;
    }
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    if (!co_scan_char(&ahead, '[')) {
        out->type = co_parse_token(p, name.begin, name.length);
        return out->type != NULL;
    }
    p->scan.at = ahead.at;
    co_scan_inline(&p->scan);
    if (!co_parse_char(p, ']') || !co_parse_scratch(p, name.length + 2))
        return false;
    memcpy(p->scratch, name.begin, name.length);
    memcpy(p->scratch + name.length, "[]", 2);
    out->type = co_parse_token(p, (const char *)p->scratch, name.length + 2);
    return out->type != NULL;
}

static bool parse_declaration(CoParser *p, Declaration *out, bool *found)
{
    *out = (Declaration){.at = p->scan.at};
    *found = true;
    if (!scan_relationship(&p->scan, out)) {
        if (!parse_attribute_type(p, out, found) || !*found)
            return !*found && !p->stopped;
    }
    if (!co_scan_gap(&p->scan))
        return co_parse_expected(p, "a blank and the name of a property");
    CoSlice name;
    if (!co_scan_namespaced(&p->scan, &name))
        return co_parse_expected(p, "the name of a property");
    out->name = co_parse_token(p, name.begin, name.length);
    return out->name != NULL;
}

static bool same_type(const char *a, const char *b)
{
    CohortType x, y;
    bool x_array, y_array;
    return a == b ||
           (co_type_from_name(a, strlen(a), &x, &x_array) &&
            co_type_from_name(b, strlen(b), &y, &y_array) && x == y && x_array == y_array);
}

// The property declared, new or as it stands already.
static CoSpec *declare(CoParser *p, CoSpec *prim, const Declaration *what)
{
    CoSpecKind kind = what->is_relationship ? CO_SPEC_RELATIONSHIP : CO_SPEC_ATTRIBUTE;
    CoSpec *spec = co_parse_property_named(prim, what->name);
    if (!spec) {
        spec = co_parse_spec(p, prim, kind, what->name, what->at);
        if (!spec)
            return NULL;
        spec->is_uniform = what->is_uniform;
        if (!what->is_relationship)
            spec->type_name = what->type;
    }
    // The last word on a relationship counts. An attribute may be spoken of as one later: it stays
    // what it is but takes its flag.
    if (what->is_relationship) {
        spec->is_uniform = what->is_uniform;
        spec->is_custom |= what->is_custom;
        return spec;
    }
    if (spec->kind != kind ||
        (kind == CO_SPEC_ATTRIBUTE && !same_type(spec->type_name, what->type))) {
        co_parse_fail(p, what->at, "'%s' was a %s on line %u and cannot become a %s", what->name,
                      spec->kind == CO_SPEC_RELATIONSHIP ? "relationship" : spec->type_name,
                      spec->line, what->is_relationship ? "relationship" : what->type);
        return NULL;
    }
    if (spec->is_uniform != what->is_uniform) {
        co_parse_fail(p, what->at, "'%s' was %s on line %u and cannot become %s", what->name,
                      spec->is_uniform ? "uniform" : "varying", spec->line,
                      what->is_uniform ? "uniform" : "varying");
        return NULL;
    }
    spec->is_custom |= what->is_custom;
    return spec;
}

// ---- Values ------------------------------------------------------------------------------------

bool co_parse_typed(CoParser *p, const CoSpec *attribute, CoValue *out)
{
    CohortType type;
    bool is_array;
    if (co_scan_word(&p->scan, "None")) {
        *out = (CoValue){.type = COHORT_TYPE_BLOCK};
        return true;
    }
    bool known = co_parse_type(p, attribute->type_name, &type, &is_array);
    // A path stands for itself whatever the type.
    if (!known || co_scan_peek(&p->scan) == '<')
        return co_parse_opaque(p, out);
    return co_parse_value(p, type, is_array, out);
}

static bool parse_default(CoParser *p, CoSpec *attribute)
{
    const char *at = p->scan.at;
    CoValue parsed;
    co_parse_line(p, at);
    if (!co_parse_assignment(p))
        return false;
    if (co_scan_word(&p->scan, "AnimationBlock"))
        parsed = (CoValue){.type = COHORT_TYPE_ANIMATION_BLOCK};
    else if (!co_parse_typed(p, attribute, &parsed))
        return false;
    CoValue *value = co_parse_field(p, attribute, "default", at);
    if (value)
        *value = parsed;
    return value != NULL;
}

static bool parse_spline(CoParser *p, CoSpec *attribute)
{
    const char *at = p->scan.at;
    CohortType type = COHORT_TYPE_NONE;
    bool is_array = false;
    CoSpline *spline = co_parse_alloc(p, 1, sizeof *spline);
    co_type_from_name(attribute->type_name, strlen(attribute->type_name), &type, &is_array);
    if (is_array || !(type == COHORT_TYPE_DOUBLE || type == COHORT_TYPE_FLOAT ||
                      type == COHORT_TYPE_HALF || type == COHORT_TYPE_TIMECODE))
        return co_parse_fail(p, at, "an attribute of type %s cannot have a spline",
                             attribute->type_name);
    if (!spline || !co_parse_assignment(p) || !co_parse_spline(p, spline))
        return false;
    CoValue *value = co_parse_field(p, attribute, "spline", at);
    if (value)
        *value = (CoValue){.type = COHORT_TYPE_SPLINE, .count = 1, .data = spline};
    return value != NULL;
}

// ---- Properties --------------------------------------------------------------------------------

static bool scan_dot(CoParser *p)
{
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    if (!co_scan_char(&ahead, '.'))
        return false;
    co_scan_inline(&ahead);
    p->scan.at = ahead.at;
    return true;
}

static bool parse_trailing_metadata(CoParser *p, CoSpec *property)
{
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    if (co_scan_peek(&ahead) != '(')
        return true;
    p->scan.at = ahead.at;
    return co_parse_metadata(p, property);
}

static bool assignment_follows(const CoParser *p)
{
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    return co_scan_peek(&ahead) == '=';
}

static bool parse_attribute(CoParser *p, CoSpec *attribute)
{
    if (scan_dot(p)) {
        if (co_scan_word(&p->scan, "timeSamples"))
            return co_parse_samples(p, attribute);
        if (co_scan_word(&p->scan, "connect"))
            return co_parse_path_list(p, attribute, "connectionPaths", CO_LIST_EXPLICIT);
        if (co_scan_word(&p->scan, "spline"))
            return parse_spline(p, attribute);
        return co_parse_expected(p, "timeSamples, connect or spline");
    }
    if (assignment_follows(p) && !parse_default(p, attribute))
        return false;
    return parse_trailing_metadata(p, attribute);
}

// The default of a relationship is a path, kept as text.
static bool parse_relationship_default(CoParser *p, CoSpec *relationship)
{
    const char *at = p->scan.at, *path;
    CoPathInfo info;
    if (!co_scan_word(&p->scan, "default"))
        return co_parse_expected(p, "default");
    CohortString *text = co_parse_alloc(p, 1, sizeof *text);
    if (!text || !co_parse_assignment(p) || !co_parse_path(p, &path, &info))
        return false;
    CoValue *value = co_parse_field(p, relationship, "default", at);
    *text = (CohortString){path, strlen(path)};
    if (value)
        *value = (CoValue){.type = COHORT_TYPE_STRING, .count = 1, .data = text};
    return value != NULL;
}

// rel name[<path>]: what once was the spec of a target says nothing any more.
static bool scan_target(CoScan *scan)
{
    CoScan ahead = *scan;
    CoSlice path;
    CoPathInfo info;
    size_t bad;
    co_scan_inline(&ahead);
    if (!co_scan_char(&ahead, '['))
        return false;
    co_scan_inline(&ahead);
    if (co_scan_path(&ahead, &path) != CO_SCAN_OK || !co_path_check(path, &info, &bad))
        return false;
    co_scan_inline(&ahead);
    if (!co_scan_char(&ahead, ']'))
        return false;
    scan->at = ahead.at;
    return true;
}

static bool parse_relationship(CoParser *p, CoSpec *relationship)
{
    if (scan_dot(p))
        return parse_relationship_default(p, relationship);
    if (scan_target(&p->scan))
        return true;
    if (assignment_follows(p) &&
        !co_parse_path_list(p, relationship, "targetPaths", CO_LIST_EXPLICIT))
        return false;
    return parse_trailing_metadata(p, relationship);
}

bool co_parse_property(CoParser *p, CoSpec *prim, bool *found)
{
    CoListOpKind kind = CO_LIST_EXPLICIT;
    bool is_edit = co_scan_list_kind(&p->scan, &kind);
    Declaration what;
    if (!parse_declaration(p, &what, found))
        return false;
    if (!*found)
        return !is_edit || co_parse_expected(p, "a relationship or an attribute's connections");
    CoSpec *property = declare(p, prim, &what);
    if (!property)
        return false;
    if (!is_edit)
        return what.is_relationship ? parse_relationship(p, property)
                                    : parse_attribute(p, property);
    if (what.is_relationship)
        return !assignment_follows(p) || co_parse_path_list(p, property, "targetPaths", kind);
    if (!scan_dot(p) || !co_scan_word(&p->scan, "connect"))
        return co_parse_expected(p, "'.connect'");
    return co_parse_path_list(p, property, "connectionPaths", kind);
}
