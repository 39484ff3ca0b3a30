// The walk over a stage: every prim that can be drawn, lit or looked through becomes a record.

#include "stage_adapter/walk.h"

#include "base/error.h"
#include "base/stop.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_NESTED_PROTOTYPES = 512, // as prims of a layer: the walk is recursive
    KEY_SIZE = 4096
};

static bool walk_prim(CoWalk *walk, CoPlace place, uint32_t purpose);

// ---- What a prim is ----------------------------------------------------------------------------

static bool is_one_of(const char *type, const char *const *types)
{
    for (; *types; types++)
        if (strcmp(type, *types) == 0)
            return true;
    return false;
}

static bool is_unsupported_light(const char *type)
{
    static const char *const types[] = {
        "CylinderLight",     "PortalLight", "GeometryLight", "PluginLight", "LightFilter",
        "PluginLightFilter", NULL};
    return is_one_of(type, types);
}

static bool is_unsupported_shape(const char *type)
{
    static const char *const types[] = {
        "BasisCurves", "HermiteCurves", "NurbsCurves",   "NurbsPatch", "Points",
        "TetMesh",     "Volume",        "ParticleField", "PointCloud", NULL};
    return is_one_of(type, types);
}

// Prims that hold no geometry below.
static bool is_closed(const char *type)
{
    static const char *const types[] = {"Material",   "Shader",         "NodeGraph",
                                        "GeomSubset", "RenderSettings", "RenderProduct",
                                        "RenderVar",  "RenderPass",     NULL};
    return is_one_of(type, types);
}

bool co_is_point_instancer(const CohortPrim *prim)
{
    return strcmp(cohort_prim_type(prim), "PointInstancer") == 0;
}

static uint32_t purpose_of(const CohortAdapter *adapter, const CohortPrim *prim, uint32_t inherited)
{
    if (!co_is_imageable(prim))
        return inherited;
    const char *authored = cohort_prim_token(prim, "purpose", adapter->time, "");
    if (strcmp(authored, "default") == 0)
        return COHORT_PURPOSE_DEFAULT;
    if (strcmp(authored, "render") == 0)
        return COHORT_PURPOSE_RENDER;
    if (strcmp(authored, "proxy") == 0)
        return COHORT_PURPOSE_PROXY;
    if (strcmp(authored, "guide") == 0)
        return COHORT_PURPOSE_GUIDE;
    return authored[0] ? 0 : inherited; // a purpose that USD does not know is never included
}

bool co_is_never_visible(const CohortAdapter *adapter, const CohortPrim *prim)
{
    const double *times;
    return co_is_imageable(prim) &&
           strcmp(cohort_prim_token(prim, "visibility", adapter->time, "inherited"), "invisible") ==
               0 &&
           cohort_prim_time_samples(prim, "visibility", &times) == 0;
}

// What a prim authors that its type does not have.
static void report_untyped(const CohortAdapter *adapter, const CohortPrim *prim)
{
    static const char *const names[] = {"xformOpOrder", "visibility", "purpose"};
    size_t count = co_is_imageable(prim) ? 1 : 3;
    if (count == 1 && strcmp(cohort_prim_type(prim), "Scope") != 0)
        return;
    for (size_t i = 0; i < count; i++)
        if (cohort_prim_has_attribute(prim, names[i]))
            co_adapter_report(adapter, prim, names[i], "",
                              count == 1 ? "a Scope has none: ignored"
                                         : "a prim without a type has none: ignored");
}

// Prims of other types that are made lights by an API schema.
static void report_light_api(const CohortAdapter *adapter, const CohortPrim *prim)
{
    static const char *const names[] = {"MeshLightAPI", "VolumeLightAPI", "LightAPI"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (cohort_prim_has_api(prim, names[i])) {
            co_adapter_report(adapter, prim, names[i], "", "gives no light");
            return;
        }
}

// ---- Meshes ------------------------------------------------------------------------------------

// Bindings of the purpose preview are for viewports: one that stands alone looks forgotten.
static void report_preview_binding(const CohortAdapter *adapter, CoPlace place)
{
    static const char name[] = "material:binding:preview";
    const CohortPrim *mesh = place.prim;
    const char *const *targets;
    do {
        if (cohort_prim_targets(place.prim, name, &targets) == 0)
            continue;
        co_adapter_report(adapter, mesh, name, targets[0],
                          "full and all-purpose bindings alone count: displayColor");
        return;
    } while (co_place_up(adapter, &place));
}

static bool add_mesh(CoWalk *walk, CoPlace place)
{
    CohortAdapter *a = walk->adapter;
    CoRecord record = {.kind = CO_RECORD_MESH,
                       .path = cohort_prim_path(place.prim),
                       .prim = place.prim,
                       .prototype = place.prototype};
    const char *bound = co_binding_resolve(a, place);
    record.material = co_record_material(a, place, bound, walk->err);
    if (!bound)
        report_preview_binding(a, place);
    // Subsets name materials of their own, which must be in the index before the mesh is pulled.
    size_t children = cohort_prim_child_count(place.prim);
    for (size_t i = 0; i < children; i++) {
        CoPlace child = {cohort_prim_child(place.prim, i), place.prototype};
        if (strcmp(cohort_prim_type(child.prim), "GeomSubset") == 0)
            co_record_material(a, child, co_binding_resolve(a, child), walk->err);
    }
    if (cohort_prim_has_api(place.prim, "SkelBindingAPI"))
        co_adapter_report(a, place.prim, "SkelBindingAPI", "", "drawn without skinning");
    return co_record_add(a, &record, COHORT_PRIM_MESH, walk->err) != NULL;
}

// ---- Prototypes --------------------------------------------------------------------------------

uint32_t co_walk_add_prototype(CoWalk *walk, const CoPrototype *prototype, const char *key)
{
    CohortAdapter *a = walk->adapter;
    uint32_t number = (uint32_t)a->prototype_count;
    bool ok = co_grow(CO_MEMORY_DELEGATE, (void **)&a->prototypes, a->prototype_count,
                      &a->prototype_capacity, sizeof *a->prototypes) &&
              (!key || co_string_map_set(&a->prototype_keys, key, number));
    if (!ok) {
        CO_FAIL(walk->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        return COHORT_INVALID_ID;
    }
    a->prototypes[a->prototype_count] = *prototype;
    a->prototype_count++;
    return number;
}

// Whether a prototype's root is to be walked where the walk is: not within itself. What an
// instancer places may be a native instance, and the first of its kind: its root then stands for
// two prototypes, one in the other.
static bool may_enter(CoWalk *walk, CoPlace place, const CohortPrim *root, bool is_native)
{
    const char *why = NULL;
    if (walk->open && walk->open->depth == MAX_NESTED_PROTOTYPES)
        why = "prototypes nested too deep: not drawn";
    for (const CoOpen *open = walk->open; open && !why; open = open->outer)
        if (open->root == root && open->is_native == is_native)
            why = "a prototype within itself: not drawn";
    if (why)
        co_adapter_report(walk->adapter, place.prim, "instancing", cohort_prim_path(root), why);
    return !why;
}

// Walks what stands in a new prototype.
static bool walk_prototype(CoWalk *walk, uint32_t number, uint32_t purpose)
{
    const CoPrototype prototype = walk->adapter->prototypes[number];
    const CoOpen *outer = walk->open;
    const CoOpen open = {outer, prototype.root, outer ? outer->depth + 1 : 1, prototype.is_native};
    bool ok = true;
    walk->open = &open;
    if (!prototype.is_native)
        ok = walk_prim(walk, (CoPlace){prototype.root, number}, purpose);
    size_t children = prototype.is_native ? cohort_prim_child_count(prototype.root) : 0;
    for (size_t i = 0; i < children && ok; i++)
        ok = walk_prim(walk, (CoPlace){cohort_prim_child(prototype.root, i), number}, purpose);
    walk->open = outer;
    return ok;
}

// Prims above a place, itself included, that may hand constant primvars down.
static size_t primvar_key(const CohortAdapter *adapter, CoPlace place, char *out, size_t size)
{
    size_t used = 0;
    do {
        size_t count = cohort_prim_property_count(place.prim);
        for (size_t i = 0; i < count && used < size; i++) {
            const char *name = cohort_prim_property_name(place.prim, i);
            // displayColor travels with the placement instead.
            if (co_starts_with(name, "primvars:") && strcmp(name, "primvars:displayColor") != 0) {
                int n = snprintf(out + used, size - used, "|%p", (const void *)place.prim);
                used += n > 0 ? (size_t)n : 0;
                break;
            }
        }
    } while (co_place_up(adapter, &place));
    return used;
}

// By what entries of native instances are told apart.
static const char *native_key(CoWalk *walk, CoPlace place, const CohortPrim *root, uint32_t purpose)
{
    CohortAdapter *a = walk->adapter;
    char binding[KEY_SIZE], primvars[KEY_SIZE], key[2 * KEY_SIZE + 64];
    primvars[0] = '\0';
    const char *shared = "";
    if (!co_binding_key(a, place, binding, sizeof binding) ||
        primvar_key(a, place, primvars, sizeof primvars) >= sizeof primvars)
        shared = cohort_prim_path(place.prim); // too much to compare: shared with nothing
    snprintf(key, sizeof key, "n%p|%u|%s|%s|%.2000s", (const void *)root, (unsigned)purpose,
             binding, primvars, shared);
    return co_arena_string(&a->arena, key, strlen(key));
}

// The entry of what a native instance shows, made and walked when it is new.
static uint32_t native_prototype(CoWalk *walk, CoPlace place, uint32_t purpose)
{
    CohortAdapter *a = walk->adapter;
    const CohortPrim *root = cohort_prim_prototype(place.prim);
    const char *key = native_key(walk, place, root, purpose);
    if (!key) {
        CO_FAIL(walk->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        return COHORT_INVALID_ID;
    }
    uint32_t number = co_string_map_find(&a->prototype_keys, key);
    if (number != COHORT_INVALID_ID)
        return number;
    CoPrototype prototype = {
        .is_native = true, .root = root, .anchor = place.prim, .outer = place.prototype};
    number = co_walk_add_prototype(walk, &prototype, key);
    bool ok = number != COHORT_INVALID_ID && walk_prototype(walk, number, purpose);
    return ok ? number : COHORT_INVALID_ID;
}

// The record that places all native instances of one prototype or of the world.
static bool ensure_instances_record(CoWalk *walk, uint32_t within)
{
    CohortAdapter *a = walk->adapter;
    char path[64];
    if (within == CO_WORLD)
        snprintf(path, sizeof path, "/__cohort/instances");
    else
        snprintf(path, sizeof path, "/__cohort/instances/%u", (unsigned)within);
    if (co_record_find(a, path))
        return true;
    const char *copy = co_arena_string(&a->arena, path, strlen(path));
    CO_CHECK_MEMORY(copy, walk->err);
    CoRecord record = {.kind = CO_RECORD_NATIVE_INSTANCES, .path = copy, .prototype = within};
    return co_record_add(a, &record, COHORT_PRIM_INSTANCER, walk->err) != NULL;
}

static bool add_native_instance(CoWalk *walk, CoPlace place, uint32_t purpose)
{
    CohortAdapter *a = walk->adapter;
    if (!may_enter(walk, place, cohort_prim_prototype(place.prim), true))
        return true;
    CoPlacement placement = {.prim = place.prim, .within = place.prototype};
    placement.prototype = native_prototype(walk, place, purpose);
    if (placement.prototype == COHORT_INVALID_ID)
        return false;
    CO_CHECK(co_grow(CO_MEMORY_DELEGATE, (void **)&a->placements, a->placement_count,
                     &a->placement_capacity, sizeof *a->placements),
             walk->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    a->placements[a->placement_count++] = placement;
    if (place.prototype == CO_WORLD && co_walk_has_lights(a, place.prim) &&
        !co_walk_lights(walk, place))
        return false;
    return ensure_instances_record(walk, place.prototype);
}

// The innermost prototype around a place that a target stands in too: what it inherits is found
// there.
static uint32_t home_of(const CohortAdapter *a, const CohortPrim *target, uint32_t around)
{
    for (; around != CO_WORLD; around = a->prototypes[around].outer)
        for (const CohortPrim *up = target; up; up = cohort_prim_parent(up))
            if (up == a->prototypes[around].root)
                return around;
    return CO_WORLD;
}

static uint32_t point_prototype(CoWalk *walk, CoPlace place, const char *path, uint32_t purpose)
{
    CohortAdapter *a = walk->adapter;
    const CohortPrim *target = cohort_stage_prim(a->stage, path);
    if (!target) {
        co_adapter_report(a, place.prim, "prototypes", path,
                          "no such prim: its instances are left out");
        return COHORT_INVALID_ID;
    }
    if (!cohort_prim_is_active(target) || !may_enter(walk, place, target, false))
        return COHORT_INVALID_ID;
    char key[96];
    CoPrototype prototype = {.root = target, .outer = home_of(a, target, place.prototype)};
    snprintf(key, sizeof key, "p%p|%u|%u", (const void *)target, (unsigned)purpose,
             (unsigned)prototype.outer);
    uint32_t number = co_string_map_find(&a->prototype_keys, key);
    if (number != COHORT_INVALID_ID)
        return number;
    number = co_walk_add_prototype(walk, &prototype, key);
    co_walk_report_lights(a, target);
    bool ok = number != COHORT_INVALID_ID && walk_prototype(walk, number, purpose);
    return ok ? number : COHORT_INVALID_ID;
}

static bool add_point_instancer(CoWalk *walk, CoPlace place, uint32_t purpose)
{
    CohortAdapter *a = walk->adapter;
    const char *const *targets;
    size_t count = cohort_prim_targets(place.prim, "prototypes", &targets);
    CoRecord record = {.kind = CO_RECORD_POINT_INSTANCER,
                       .path = cohort_prim_path(place.prim),
                       .prim = place.prim,
                       .prototype = place.prototype,
                       .placed = co_arena_array(&a->arena, count, sizeof(uint32_t)),
                       .placed_count = count};
    CO_CHECK_MEMORY(record.placed, walk->err);
    for (size_t i = 0; i < count; i++) {
        record.placed[i] = point_prototype(walk, place, targets[i], purpose);
        if (walk->err->code != COHORT_OK)
            return false;
    }
    return co_record_add(a, &record, COHORT_PRIM_INSTANCER, walk->err) != NULL;
}

// ---- Cameras ------------------------------------------------------------------------------------

static bool add_camera(CoWalk *walk, CoPlace place)
{
    CohortAdapter *a = walk->adapter;
    if (place.prototype != CO_WORLD)
        return true;
    CoRecord record = {.kind = CO_RECORD_CAMERA,
                       .path = cohort_prim_path(place.prim),
                       .prim = place.prim,
                       .prototype = CO_WORLD};
    CO_CHECK(co_grow(CO_MEMORY_DELEGATE, (void **)&a->cameras, a->camera_count, &a->camera_capacity,
                     sizeof *a->cameras),
             walk->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    a->cameras[a->camera_count++] = record.path;
    return co_record_add(a, &record, COHORT_PRIM_CAMERA, walk->err) != NULL;
}

// ---- The walk ----------------------------------------------------------------------------------

static bool walk_children(CoWalk *walk, CoPlace place, uint32_t purpose)
{
    size_t children = cohort_prim_child_count(place.prim);
    for (size_t i = 0; i < children; i++)
        if (!walk_prim(walk, (CoPlace){cohort_prim_child(place.prim, i), place.prototype}, purpose))
            return false;
    return true;
}

static bool walk_prim(CoWalk *walk, CoPlace place, uint32_t purpose)
{
    CohortAdapter *a = walk->adapter;
    const char *type = cohort_prim_type(place.prim);
    CO_CHECK_STOP(a->options.stage.stop, walk->err);
    if (is_closed(type))
        return true;
    if (strcmp(type, "Camera") == 0 && !add_camera(walk, place))
        return false;
    if (co_is_never_visible(a, place.prim))
        return true;
    report_untyped(a, place.prim);
    purpose = purpose_of(a, place.prim, purpose);
    bool is_drawn = (purpose & a->purposes) != 0;
    if (co_is_point_instancer(place.prim))
        return !is_drawn || add_point_instancer(walk, place, purpose);
    // Lights of native prototypes are found by walk_lights; a PointInstancer's are reported.
    if (co_is_light_type(type) && place.prototype == CO_WORLD && !co_walk_add_light(walk, place))
        return false;
    if (is_drawn && (strcmp(type, "Mesh") == 0 || co_is_implicit_type(type)) &&
        !add_mesh(walk, place))
        return false;
    if (is_unsupported_light(type))
        co_adapter_report(a, place.prim, type, "", "not supported: left out");
    else if (!co_is_light_type(type))
        report_light_api(a, place.prim);
    if (is_drawn && is_unsupported_shape(type))
        co_adapter_report(a, place.prim, type, "", "not supported: not drawn");
    if (cohort_prim_is_instance(place.prim) && cohort_prim_prototype(place.prim))
        return add_native_instance(walk, place, purpose);
    return walk_children(walk, place, purpose);
}

static int compare_placements(const void *a, const void *b)
{
    const CoPlacement *x = a, *y = b;
    if (x->within != y->within)
        return x->within < y->within ? -1 : 1;
    return strcmp(cohort_prim_path(x->prim), cohort_prim_path(y->prim));
}

bool co_walk_stage(CohortAdapter *adapter, CohortError *err)
{
    CohortError own = {0};
    CoWalk walk = {.adapter = adapter, .err = &own};
    CoPlace root = {cohort_stage_root(adapter->stage), CO_WORLD};
    bool ok = walk_children(&walk, root, COHORT_PURPOSE_DEFAULT) && own.code == COHORT_OK;
    if (adapter->placement_count > 1)
        qsort(adapter->placements, adapter->placement_count, sizeof *adapter->placements,
              compare_placements);
    if (!ok && err && err->code == COHORT_OK)
        *err = own;
    return ok;
}
