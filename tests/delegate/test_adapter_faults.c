// Stages that meet a lack of memory: what is done is done whole, what is not is made good
// (adapter.c, walk.c, network.c, records.c, primvars.c, pull_mesh.c, pull_instancer.c, values.c).

#include "base/hash.h"
#include "stage/stage_data.h"
#include "stage_adapter/adapter.h"
#include "stage_fixture.h"
#include "support/faults.h"

#include <stdio.h>
#include <string.h>

// ---- What a host sees --------------------------------------------------------------------------

static uint64_t hash_text(const char *text, uint64_t seed)
{
    return co_hash_bytes(text, strlen(text), seed);
}

static uint64_t hash_material(uint32_t id)
{
    if (id == COHORT_INVALID_ID)
        return 0;
    const CohortMaterialDesc *m = &fake.materials[id];
    uint64_t hash = co_hash_combine(m->diffuse_color.kind, m->lookup_count);
    for (size_t i = 0; i < m->lookup_count; i++)
        hash = hash_text(fake.texture_paths[fake.lookups[id][i].texture], hash);
    return co_hash_bytes(m->roughness.value, sizeof m->roughness.value, hash);
}

// All that is placed in an object, whatever numbers things have got.
static uint64_t hash_object(const FakeObject *object)
{
    uint64_t hash = co_hash_combine(object->is_mesh, object->instance_count);
    if (object->is_mesh) {
        hash = hash_text(object->path, hash);
        hash = co_hash_combine(hash, object->point_count);
        hash = co_hash_combine(hash, object->primvar_count);
        hash = co_hash_combine(hash, object->subset_faces);
        hash = co_hash_combine(hash, hash_material(object->material));
        hash = co_hash_bytes(object->first_color, sizeof object->first_color, hash);
        return co_hash_bytes(object->first_point, sizeof object->first_point, hash);
    }
    for (size_t i = 0; i < object->instance_count; i++) {
        const CohortInstanceDesc *d = &object->instances[i];
        hash = co_hash_bytes(d->transform, sizeof d->transform, hash);
        hash = co_hash_bytes(object->colors[i], sizeof object->colors[i], hash);
        hash = co_hash_combine(hash, d->hidden);
        hash = co_hash_combine(hash, hash_object(&fake.objects[d->object]));
    }
    return hash;
}

static uint64_t hash_scene(void)
{
    uint64_t lights = 0;
    for (uint32_t i = 0; i < fake.light_count; i++)
        lights += !fake.lights[i].hidden;
    return co_hash_combine(lights, hash_object(&fake.objects[0]));
}

typedef struct Report {
    uint64_t lines[64];
    size_t count;
} Report;

static void read_report(Report *out)
{
    const CohortReportEntry *entries;
    out->count = cohort_delegate_report(stage.delegate, &entries);
    assert_true(out->count <= sizeof out->lines / sizeof *out->lines);
    for (size_t i = 0; i < out->count; i++)
        out->lines[i] =
            hash_text(entries[i].prim_path,
                      hash_text(entries[i].name, hash_text(entries[i].action, entries[i].count)));
}

// ---- A stage with some of everything -----------------------------------------------------------

static const char beginning[] =
    "class Xform 'P' { float[] primvars:own = [1]; def Mesh 'A' { $triangle } def SphereLight 'SL' "
    "{} }"
    "def Xform 'I' (instanceable = true; inherits = </P>) { $at(1,2,3)"
    "  color3f[] primvars:displayColor = [(1,0,0)] }"
    "def SphereLight 'L' {} def CylinderLight 'CL' {} def Points 'Dots' {}"
    "def Camera 'C1' {} def Camera 'C2' {} def Camera 'C3' {} def Camera 'C4' {}"
    "def Material 'M' { token outputs:surface.connect = </M/S.outputs:surface>;"
    "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface';"
    "    color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>;"
    "    float inputs:roughness = 0.25; color3f inputs:emissiveColor.connect = </M/R.outputs:r>;"
    "    token outputs:surface }"
    "  def Shader 'T' { uniform token info:id = 'UsdUVTexture'; asset inputs:file = @a.png@;"
    "    token inputs:wrapS = 'odd'; float3 outputs:rgb }"
    "  def Shader 'R' { uniform token info:id = 'UsdPrimvarReader_float3';"
    "    string inputs:varname = 'glow'; float3 outputs:r } }"
    "def Mesh 'B' { $triangle rel material:binding = </M>;"
    "  color3d[] primvars:displayColor = [(0,0.5,1)]; vector3f[] velocities = [(1,1,1)];"
    "  def GeomSubset 'G' { int[] indices = [0]; uniform token familyName = 'materialBind';"
    "    rel material:binding = </Nowhere> } }"
    "def PointInstancer 'PI' { rel prototypes = [</PI/T>, </PI/None>]; int[] protoIndices = [0, 0];"
    "  point3f[] positions = [(0,0,0), (4,5,6)]; def Mesh 'T' { $triangle } ";

// Lists so long that each takes memory of its own: points as doubles, and who is invisible.
static const char *make_body(void)
{
    enum {
        POINTS = 3000,
        IDS = 9000
    };
    static char body[128 * 1024];
    size_t used = (size_t)snprintf(body, sizeof body, "%sint64[] invisibleIds = [1", beginning);
    for (int i = 0; i < IDS; i++)
        used += (size_t)snprintf(body + used, sizeof body - used, ",%d", 5 + i % 5);
    used += (size_t)snprintf(body + used, sizeof body - used,
                             "] } def Mesh 'D' { int[] faceVertexCounts = [3];"
                             "int[] faceVertexIndices = [0,1,2]; point3d[] points = [(7,8,9)");
    for (int i = 0; i < 2 * POINTS; i++)
        used += (size_t)snprintf(body + used, sizeof body - used, ",(%d,1,0)", i % 10);
    used += (size_t)snprintf(body + used, sizeof body - used, "] }");
    assert_true(used < sizeof body);
    return body;
}

enum {
    MOST = 1 << 16 // bytes that what an adapter keeps for itself never comes to here
};

static uint64_t whole_scene;
static Report whole_report;

// The report says what it should, each as often, and nothing else.
static void check_report(void)
{
    Report report;
    read_report(&report);
    assert_int_equal(report.count, whole_report.count);
    assert_memory_equal(report.lines, whole_report.lines, report.count * sizeof *report.lines);
}

// An adapter of the stage that has been written, on a delegate of its own.
static void open_again(void)
{
    fake_reset();
    stage.delegate = cohort_delegate_create(NULL);
    stage.index = cohort_render_index_create(stage.delegate, NULL);
    stage.adapter = cohort_adapter_open(stage.delegate, stage.path, NULL, NULL);
    assert_non_null(stage.adapter);
}

static void close_again(void)
{
    cohort_adapter_destroy(stage.adapter);
    cohort_delegate_destroy(stage.delegate);
    stage.adapter = NULL;
    stage.delegate = NULL;
}

// What has been populated in part is of no use; the delegate stays.
static void populate_anew(void)
{
    cohort_adapter_destroy(stage.adapter);
    stage.adapter = cohort_adapter_open(stage.delegate, stage.path, NULL, NULL);
    assert_true(cohort_adapter_populate(stage.adapter, NULL));
}

static void open_whole(void)
{
    open_stage(make_body());
    whole_scene = hash_scene();
    read_report(&whole_report);
    assert_int_equal(fake_mesh("/D")->point_count, 6001);
    assert_true(is_reported("/B", "primvars:glow"));
    assert_true(is_reported("/Dots", "Points"));
    close_again();
}

static void sync_stage(void)
{
    CohortError err = {0};
    if (!cohort_render_index_sync(stage.index, &err))
        fail_msg("%s", err.message);
    assert_int_equal(hash_scene(), whole_scene);
}

// ---- Tests -------------------------------------------------------------------------------------

// What was left undone is done when there is memory, and then all is as it should be.
static void make_good(bool is_populated)
{
    if (!is_populated)
        populate_anew();
    sync_stage();
    check_report();
    close_again();
}

// Refuses each allocation of populating, or of the first sync. Returns how many there are.
static uint64_t check_faults(bool is_sync)
{
    open_whole();
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        open_again();
        CohortError err = {0};
        if (is_sync)
            assert_true(cohort_adapter_populate(stage.adapter, NULL));
        test_faults_begin(&faults);
        bool ok = is_sync ? cohort_render_index_sync(stage.index, &err)
                          : cohort_adapter_populate(stage.adapter, &err);
        test_faults_end(&faults, ok, &err);
        make_good(ok || is_sync);
    }
    return faults.count;
}

static void test_populate(void **state)
{
    (void)state;
    assert_true(check_faults(false) > 50);
}

static void test_sync(void **state)
{
    (void)state;
    assert_true(check_faults(true) > 20);
}

typedef CoArena *ArenaFn(void);

static CoArena *adapter_arena(void)
{
    return &stage.adapter->arena;
}

static CoArena *answers_arena(void)
{
    return &((CohortStage *)(uintptr_t)cohort_adapter_stage(stage.adapter))->answers_arena;
}

// Populates and syncs, or syncs alone, with ever more room in an arena, until it is enough.
// failures[0] counts those of populating, failures[1] those of syncs.
static void check_room(ArenaFn *arena_of, bool is_sync, size_t step, size_t failures[2])
{
    open_whole();
    size_t room = 0;
    failures[0] = failures[1] = 0;
    for (bool is_done = false; !is_done && room < MOST; room += step) {
        open_again();
        bool is_populated = is_sync && cohort_adapter_populate(stage.adapter, NULL);
        CoArena *arena = arena_of();
        test_arena_leave(arena, room);
        CohortError err = {0};
        is_populated = is_populated || cohort_adapter_populate(stage.adapter, &err);
        is_done = is_populated && cohort_render_index_sync(stage.index, &err);
        assert_int_equal(err.code, is_done ? COHORT_OK : COHORT_ERROR_OUT_OF_MEMORY);
        arena->limit = 0;
        failures[is_populated] += !is_done;
        make_good(is_populated);
    }
    assert_true(room < MOST);
}

// Whatever does not fit into the memory that the adapter has taken already.
static void test_the_last_bytes(void **state)
{
    (void)state;
    size_t failures[2];
    check_room(adapter_arena, false, 16, failures);
    assert_true(failures[0] > 5);
}

static void test_the_last_bytes_of_a_sync(void **state)
{
    (void)state;
    size_t failures[2];
    check_room(adapter_arena, true, 16, failures);
    assert_true(failures[1] > 1);
}

// The same of what the stage takes to answer.
static void test_stages_that_run_short(void **state)
{
    (void)state;
    size_t failures[2];
    check_room(answers_arena, false, 112, failures);
    assert_true(failures[0] > 1 && failures[1] > 1);
}

static uint64_t hash_frame(void)
{
    CohortResolvedSettings settings;
    cohort_adapter_settings(stage.adapter, &settings);
    return co_hash_combine(hash_scene(), settings.width ^ (uint64_t)settings.height << 32);
}

// A time that was refused can be set.
static void test_set_time(void **state)
{
    (void)state;
    open_stage("def Xform 'Parent' {"
               "  color3f[] primvars:displayColor.timeSamples = { 1: [(1,0,0)], 2: [(0,1,0)] };"
               "  def Mesh 'M' { $triangle } }"
               "def Mesh 'S' { $triangle"
               "  def GeomSubset 'G' { int[] indices.timeSamples = { 1: [], 2: [0] };"
               "    uniform token elementType = 'face';"
               "    uniform token familyName = 'materialBind' } }"
               "def Camera 'C' { float horizontalAperture.timeSamples = { 1: 10, 3: 20 };"
               "  float verticalAperture = 10 }");
    assert_true(cohort_adapter_set_time(stage.adapter, 2.0, NULL));
    assert_true(cohort_render_index_sync(stage.index, NULL));
    uint64_t there = hash_frame();
    close_again();
    size_t room = 0, failures = 0;
    for (bool is_done = false; !is_done && room < MOST; room += 4) {
        open_again();
        assert_true(cohort_adapter_populate(stage.adapter, NULL));
        assert_true(cohort_render_index_sync(stage.index, NULL));
        assert_true(hash_frame() != there);
        CoArena *arena = answers_arena();
        test_arena_leave(arena, room);
        CohortError err = {0};
        is_done = cohort_adapter_set_time(stage.adapter, 2.0, &err);
        assert_int_equal(err.code, is_done ? COHORT_OK : COHORT_ERROR_OUT_OF_MEMORY);
        arena->limit = 0;
        failures += !is_done;
        assert_true(is_done || cohort_adapter_set_time(stage.adapter, 2.0, NULL));
        assert_true(cohort_render_index_sync(stage.index, NULL));
        assert_int_equal(hash_frame(), there);
        close_again();
    }
    assert_true(failures > 1 && room < MOST);
}

// Options are copied: each text takes memory of its own.
static void test_open(void **state)
{
    (void)state;
    static char camera[70000], settings[70000], env[70000];
    memset(camera, 'c', sizeof camera - 1);
    memset(settings, 's', sizeof settings - 1);
    memset(env, 'e', sizeof env - 1);
    const CohortAdapterOptions options = {
        .camera = camera, .render_settings = settings, .env = env};
    open_stage("def 'R' (references = @nowhere.usda@) {} def Mesh 'M' { $triangle }");
    read_report(&whole_report);
    close_again();
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        fake_reset();
        stage.delegate = cohort_delegate_create(NULL);
        stage.index = cohort_render_index_create(stage.delegate, NULL);
        CohortError err = {0};
        test_faults_begin(&faults);
        stage.adapter = cohort_adapter_open(stage.delegate, stage.path, &options, &err);
        test_faults_end(&faults, stage.adapter != NULL, &err);
        if (stage.adapter)
            check_report();
        close_again();
    }
    assert_true(faults.count > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_populate, close_stage),
        cmocka_unit_test_teardown(test_sync, close_stage),
        cmocka_unit_test_teardown(test_the_last_bytes, close_stage),
        cmocka_unit_test_teardown(test_the_last_bytes_of_a_sync, close_stage),
        cmocka_unit_test_teardown(test_stages_that_run_short, close_stage),
        cmocka_unit_test_teardown(test_set_time, close_stage),
        cmocka_unit_test_teardown(test_open, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
