// A whole layer as text. Fields and specs come in the order in which they were said, so that
// writing what was written gives the same bytes.

#include "base/error.h"
#include "parse/writer.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const CoValue *value_of(const CoSpec *spec, const char *name)
{
    for (size_t i = 0; i < spec->field_count; i++)
        if (strcmp(spec->fields[i].name, name) == 0)
            return &spec->fields[i].value;
    return NULL;
}

// " (...)" with the metadata, if there is any; `lead` stands before the bracket.
static void write_block(CoWriter *w, const CoSpec *spec, const char *lead)
{
    bool any = false;
    for (size_t i = 0; i < spec->field_count; i++) {
        if (!co_is_metadata(&spec->fields[i]))
            continue;
        if (!any) {
            co_write_text(w, lead);
            co_write_text(w, "(\n");
            w->depth++;
        }
        any = true;
        co_write_metadata(w, &spec->fields[i]);
    }
    if (!any)
        return;
    w->depth--;
    co_write_indent(w);
    putc(')', w->file);
}

static void write_order(CoWriter *w, const CoSpec *spec, const char *field, const char *word)
{
    const CoValue *order = value_of(spec, field);
    if (!order)
        return;
    co_write_indent(w);
    fprintf(w->file, "reorder %s = ", word);
    co_write_value(w, order);
    putc('\n', w->file);
}

// ---- Properties --------------------------------------------------------------------------------

// What stands before the name in every statement of a property.
static void write_head(CoWriter *w, const CoSpec *property)
{
    bool is_attribute = property->kind == CO_SPEC_ATTRIBUTE;
    co_write_text(w, property->is_custom ? "custom " : "");
    if (property->is_uniform == is_attribute)
        co_write_text(w, is_attribute ? "uniform " : "varying ");
    co_write_text(w, is_attribute ? property->type_name : "rel");
    putc(' ', w->file);
    co_write_text(w, property->name);
}

// "[op ]head name[.suffix] = [<...>]" for every list of paths but, if asked, the explicit one.
static void write_path_lists(CoWriter *w, const CoSpec *spec, const CoValue *value,
                             const char *suffix, bool skip_explicit)
{
    const CoListOp *op = value->data;
    CoListOpKind kind = CO_LIST_EXPLICIT;
    if (op->is_explicit && skip_explicit)
        return;
    for (bool more = co_list_op_next(op, &kind, true); more;
         more = co_list_op_next(op, &kind, false)) {
        co_write_indent(w);
        co_write_text(w, co_list_word(kind));
        write_head(w, spec);
        fprintf(w->file, "%s = ", suffix);
        co_write_items(w, value->type, op->list[kind].items, op->list[kind].count);
        putc('\n', w->file);
    }
}

static void write_suffixed(CoWriter *w, const CoSpec *attribute, const char *field)
{
    const CoValue *value = value_of(attribute, field);
    if (!value)
        return;
    co_write_indent(w);
    write_head(w, attribute);
    fprintf(w->file, ".%s = ", field);
    co_write_value(w, value);
    putc('\n', w->file);
}

// The reference lets a later "rel" of the same name add its targets to an attribute.
static void write_stray_targets(CoWriter *w, const CoSpec *attribute, const CoValue *targets)
{
    CoSpec relationship = *attribute;
    relationship.kind = CO_SPEC_RELATIONSHIP;
    relationship.is_custom = false;
    relationship.is_uniform = true;
    const CoListOp *op = targets->data;
    if (op->is_explicit) {
        co_write_indent(w);
        write_head(w, &relationship);
        co_write_text(w, " = ");
        co_write_items(w, targets->type, op->list[0].items, op->list[0].count);
        putc('\n', w->file);
    }
    write_path_lists(w, &relationship, targets, "", true);
}

static void write_attribute(CoWriter *w, const CoSpec *attribute)
{
    const CoValue *targets = value_of(attribute, "targetPaths");
    const CoValue *value = value_of(attribute, "default");
    const CoValue *connections = value_of(attribute, "connectionPaths");
    co_write_indent(w);
    write_head(w, attribute);
    if (value) {
        co_write_text(w, " = ");
        co_write_value(w, value);
    }
    write_block(w, attribute, " ");
    putc('\n', w->file);
    write_suffixed(w, attribute, "timeSamples");
    write_suffixed(w, attribute, "spline");
    if (connections)
        write_path_lists(w, attribute, connections, ".connect", false);
    if (targets)
        write_stray_targets(w, attribute, targets);
}

static void write_relationship(CoWriter *w, const CoSpec *relationship)
{
    const CoValue *targets = value_of(relationship, "targetPaths");
    const CoValue *value = value_of(relationship, "default");
    const CoListOp *op = targets ? targets->data : NULL;
    co_write_indent(w);
    write_head(w, relationship);
    if (op && op->is_explicit) {
        co_write_text(w, " = ");
        co_write_items(w, targets->type, op->list[0].items, op->list[0].count);
    }
    write_block(w, relationship, " ");
    putc('\n', w->file);
    if (targets)
        write_path_lists(w, relationship, targets, "", true);
    if (value) {
        const CohortString *path = value->data;
        co_write_indent(w);
        write_head(w, relationship);
        fprintf(w->file, ".default = <%s>\n", path->text);
    }
}

// ---- Prims -------------------------------------------------------------------------------------

static void write_contents(CoWriter *w, const CoSpec *spec);

static void write_variant_set(CoWriter *w, const CoSpec *set)
{
    co_write_indent(w);
    co_write_text(w, "variantSet ");
    co_write_string(w, set->name, strlen(set->name));
    co_write_text(w, " = {");
    w->depth++;
    const CoContents *in = co_spec_contents(set);
    for (size_t i = 0; i < in->child_count; i++) {
        const CoSpec *variant = in->children[i];
        putc('\n', w->file);
        co_write_indent(w);
        co_write_string(w, variant->name, strlen(variant->name));
        write_block(w, variant, " ");
        co_write_text(w, " {\n");
        write_contents(w, variant);
        co_write_indent(w);
        co_write_text(w, "}");
    }
    w->depth--;
    if (in->child_count) {
        putc('\n', w->file);
        co_write_indent(w);
    }
    co_write_text(w, "}\n");
}

static void write_prim(CoWriter *w, const CoSpec *prim)
{
    static const char *const words[] = {"def ", "over ", "class "};
    co_write_indent(w);
    co_write_text(w, words[prim->specifier]);
    if (prim->type_name[0]) {
        co_write_text(w, prim->type_name);
        putc(' ', w->file);
    }
    co_write_string(w, prim->name, strlen(prim->name));
    write_block(w, prim, " ");
    putc('\n', w->file);
    co_write_indent(w);
    co_write_text(w, "{\n");
    write_contents(w, prim);
    co_write_indent(w);
    co_write_text(w, "}\n");
}

static void write_contents(CoWriter *w, const CoSpec *spec)
{
    w->depth++;
    write_order(w, spec, "primOrder", "nameChildren");
    write_order(w, spec, "propertyOrder", "properties");
    const CoContents *in = co_spec_contents(spec);
    for (size_t i = 0; i < in->property_count; i++) {
        const CoSpec *property = in->properties[i];
        if (property->kind == CO_SPEC_ATTRIBUTE)
            write_attribute(w, property);
        else
            write_relationship(w, property);
    }
    for (size_t i = 0; i < in->child_count; i++) {
        if (i || in->property_count)
            putc('\n', w->file);
        write_prim(w, in->children[i]);
    }
    for (size_t i = 0; i < in->variant_set_count; i++)
        write_variant_set(w, in->variant_sets[i]);
    w->depth--;
}

void co_write_layer(const CoLayer *layer, FILE *file)
{
    CoWriter writer = {.file = file}, *w = &writer;
    const CoSpec *root = layer->root;
    co_write_text(w, "#usda 1.0\n");
    write_block(w, root, "");
    co_write_text(w, "\n");
    write_order(w, root, "primOrder", "rootPrims");
    const CoContents *in = co_spec_contents(root);
    for (size_t i = 0; i < in->child_count; i++) {
        if (i)
            putc('\n', w->file);
        write_prim(w, in->children[i]);
    }
}

static bool fail(const char *path, int cause, CohortError *err)
{
    CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot write %s: %s", path ? path : "standard output",
            cause ? strerror(cause) : "the disk is full or the stream was closed");
    co_error_place(err, path, 0, 0, NULL);
    return false;
}

// A file is written beside its place and moved there when it is whole, so that nobody ever sees
// half of it, and an old one survives a full disk.
static FILE *open_beside(const char *path, char *beside, size_t size)
{
    int length = snprintf(beside, size, "%s.%ld.tmp", path, (long)getpid());
    if (length < 0 || (size_t)length >= size) {
        errno = ENAMETOOLONG;
        return NULL;
    }
    int fd = open(beside, O_WRONLY | O_CREAT | O_EXCL, 0666);
    FILE *file = fd < 0 ? NULL : fdopen(fd, "wb");
    if (fd >= 0 && !file) {
        close(fd);
        unlink(beside);
    }
    return file;
}

// Devices and pipes are written to as they are.
static bool is_replaceable(const char *path)
{
    struct stat st;
    return stat(path, &st) != 0 || S_ISREG(st.st_mode);
}

bool co_layer_write(const CoLayer *layer, const char *path, CohortError *err)
{
    char beside[4096];
    bool replaces = path && is_replaceable(path);
    FILE *file = !path      ? stdout
                 : replaces ? open_beside(path, beside, sizeof beside)
                            : fopen(path, "wb");
    if (!file)
        return fail(path, errno, err);
    co_write_layer(layer, file);
    bool good = fflush(file) == 0 && !ferror(file);
    int cause = good ? 0 : errno;
    if (path && fclose(file) != 0 && good) {
        cause = errno;
        good = false;
    }
    if (good && replaces && rename(beside, path) != 0) {
        cause = errno;
        good = false;
    }
    if (replaces && !good)
        unlink(beside);
    return good || fail(path, cause, err);
}

bool cohort_layer_cat(const char *in, const char *out, const CohortStageOptions *options,
                      CohortError *err)
{
    CO_CHECK(in, err, COHORT_ERROR_ARGUMENT, "no layer to read was named");
    CoLayer *layer = co_layer_open(in, options, options ? options->report : NULL,
                                   options ? options->cookie : NULL, err);
    if (!layer)
        return false;
    bool good = co_layer_write(layer, out, err);
    co_layer_destroy(layer);
    return good;
}
