// The delegate: its life, and its settings by key.

#include "base/error.h"
#include "index/index.h"
#include "pass/render_buffer.h"
#include "pass/render_pass.h"
#include "pass/render_thread.h"

#include <string.h>

CohortDelegate *cohort_delegate_create(CohortError *err)
{
    CohortDelegate *delegate = co_alloc_zero(CO_MEMORY_DELEGATE, sizeof *delegate);
    CO_CHECK_NULL(delegate, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    delegate->thread = co_render_thread_create(err);
    if (!delegate->thread || !co_settings_init(&delegate->settings, err)) {
        cohort_delegate_destroy(delegate);
        return NULL;
    }
    return delegate;
}

void cohort_delegate_destroy(CohortDelegate *delegate)
{
    if (!delegate)
        return;
    co_render_thread_destroy(delegate->thread);
    delegate->thread = NULL;
    while (delegate->passes)
        cohort_render_pass_destroy(delegate->passes);
    while (delegate->buffers)
        cohort_render_buffer_destroy(delegate->buffers);
    co_index_destroy(delegate->index);
    co_report_clear(&delegate->report);
    co_settings_clear(&delegate->settings);
    co_free(CO_MEMORY_DELEGATE, delegate, sizeof *delegate);
}

// ---- Settings ----------------------------------------------------------------------------------

bool cohort_delegate_set(CohortDelegate *delegate, const char *key, const CohortSettingValue *value,
                         CohortError *err)
{
    CoSetting setting = co_setting_find(key);
    CO_CHECK(setting != CO_SETTING_COUNT, err, COHORT_ERROR_ARGUMENT,
             "there is no setting named \"%.100s\"", key ? key : "");
    bool changed = false;
    if (!co_settings_set(&delegate->settings, setting, value, &changed, err))
        return false;
    if (changed)
        co_index_setting_changed(delegate->index, setting);
    return true;
}

bool cohort_delegate_set_bool(CohortDelegate *delegate, const char *key, bool value,
                              CohortError *err)
{
    CohortSettingValue v = {.type = COHORT_SETTING_BOOL, .boolean = value};
    return cohort_delegate_set(delegate, key, &v, err);
}

bool cohort_delegate_set_int(CohortDelegate *delegate, const char *key, int64_t value,
                             CohortError *err)
{
    CohortSettingValue v = {.type = COHORT_SETTING_INT, .integer = value};
    return cohort_delegate_set(delegate, key, &v, err);
}

bool cohort_delegate_set_double(CohortDelegate *delegate, const char *key, double value,
                                CohortError *err)
{
    CohortSettingValue v = {.type = COHORT_SETTING_DOUBLE, .number = value};
    return cohort_delegate_set(delegate, key, &v, err);
}

bool cohort_delegate_set_string(CohortDelegate *delegate, const char *key, const char *value,
                                CohortError *err)
{
    CohortSettingValue v = {.type = COHORT_SETTING_STRING, .string = value};
    return cohort_delegate_set(delegate, key, &v, err);
}

bool cohort_delegate_get(const CohortDelegate *delegate, const char *key, CohortSettingValue *out)
{
    CoSetting setting = co_setting_find(key);
    if (setting == CO_SETTING_COUNT)
        return false;
    *out = delegate->settings.values[setting];
    return true;
}

uint64_t cohort_delegate_settings_version(const CohortDelegate *delegate)
{
    return delegate->settings.version;
}

void cohort_delegate_render_settings(const CohortDelegate *delegate, CohortRenderSettings *out)
{
    co_settings_render(&delegate->settings, out);
}

// ---- Report ------------------------------------------------------------------------------------

size_t cohort_delegate_report(CohortDelegate *delegate, const CohortReportEntry **out)
{
    return co_report_entries(&delegate->report, out);
}

bool cohort_delegate_report_add(CohortDelegate *delegate, CohortSeverity severity,
                                const char *prim_path, const char *name, const char *value,
                                const char *action)
{
    CohortReportEntry entry = {.severity = severity,
                               .prim_path = prim_path,
                               .name = name,
                               .value = value,
                               .action = action};
    return co_report_add(&delegate->report, &entry);
}

void co_delegate_note(CohortDelegate *delegate, CohortSeverity severity, const char *prim_path,
                      const char *name, const char *value, const char *action)
{
    if (!cohort_delegate_report_add(delegate, severity, prim_path, name, value, action))
        delegate->has_lost = true;
}

bool co_delegate_has_lost(CohortDelegate *delegate)
{
    bool has_lost = delegate->has_lost;
    delegate->has_lost = false;
    return has_lost;
}

void cohort_delegate_report_clear(CohortDelegate *delegate)
{
    co_report_clear(&delegate->report);
}
