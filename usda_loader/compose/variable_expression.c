// Variable expressions: `"${NAME}/rest"` between backquotes, in asset paths and variant selections.
//
// Read are strings in either kind of quotes with ${NAME} in them, a bare ${NAME}, and the functions
// if, and, or, not, eq, neq, lt, leq, gt, geq, contains, at, len, defined over strings, integers,
// booleans and lists of one of these. Anything else is refused by name.

#include "compose/composer.h"
#include "compose/fields.h"
#include "lex/scan.h"

#include <stdlib.h>
#include <string.h>

typedef enum CoTermKind {
    CO_TERM_NONE = 0,
    CO_TERM_STRING,
    CO_TERM_INT,
    CO_TERM_BOOL,
    CO_TERM_LIST
} CoTermKind;

typedef struct CoTerm {
    CoTermKind kind;
    const char *text;
    int64_t number;             // also for booleans
    const struct CoTerm *items; // of a list: `count` of one kind, none of them a list
    size_t count;
} CoTerm;

#define MAX_ARGUMENTS 16
#define MAX_NESTING 32

typedef struct CoExpression {
    CoComposer *c;
    const CoVariables *variables;
    const char *at, *end;
    const char *why; // NULL while all is well
    int nesting;
} CoExpression;

static CoTerm fail(CoExpression *x, const char *why)
{
    if (!x->why)
        x->why = why;
    return (CoTerm){0};
}

static void skip_space(CoExpression *x)
{
    while (x->at < x->end && (*x->at == ' ' || *x->at == '\t'))
        x->at++;
}

static bool take(CoExpression *x, char ch)
{
    skip_space(x);
    if (x->at >= x->end || *x->at != ch)
        return false;
    x->at++;
    return true;
}

static bool is_word(char ch)
{
    return (ch >= 'a' && ch <= 'z') || (ch >= 'A' && ch <= 'Z') || (ch >= '0' && ch <= '9') ||
           ch == '_';
}

static CoTerm parse_term(CoExpression *x);

static CoTerm evaluate_nested(CoExpression *x, const char *text)
{
    if (x->nesting >= MAX_NESTING)
        return fail(x, "variables refer to each other without end");
    CoExpression inner = {x->c, x->variables, text, text + strlen(text), NULL, x->nesting + 1};
    CoTerm term = parse_term(&inner);
    skip_space(&inner);
    if (!inner.why && inner.at != inner.end)
        inner.why = "text after the end of an expression";
    return inner.why ? fail(x, inner.why) : term;
}

static const CoValue *find_variable(const CoExpression *x, const char *name, size_t length)
{
    for (size_t i = 0; x->variables && i < x->variables->count; i++) {
        const char *other = x->variables->items[i].name;
        if (strlen(other) == length && !memcmp(other, name, length))
            return x->variables->items[i].value;
    }
    return NULL;
}

static CoTerm array_term(CoExpression *x, const CoValue *value)
{
    CoTerm *items = co_composer_array(x->c, value->count, sizeof *items);
    for (size_t i = 0; i < value->count; i++) {
        if (value->type == COHORT_TYPE_STRING)
            items[i] = (CoTerm){.kind = CO_TERM_STRING,
                                .text = ((const CohortString *)value->data)[i].text};
        else if (value->type == COHORT_TYPE_BOOL)
            items[i] = (CoTerm){.kind = CO_TERM_BOOL, .number = ((const uint8_t *)value->data)[i]};
        else if (value->type == COHORT_TYPE_INT)
            items[i] = (CoTerm){.kind = CO_TERM_INT, .number = ((const int32_t *)value->data)[i]};
        else if (value->type == COHORT_TYPE_INT64)
            items[i] = (CoTerm){.kind = CO_TERM_INT, .number = ((const int64_t *)value->data)[i]};
        else
            return fail(x, "a variable holds other than strings, integers or booleans");
    }
    return (CoTerm){.kind = CO_TERM_LIST, .items = items, .count = value->count};
}

static CoTerm value_term(CoExpression *x, const CoValue *value)
{
    if (value->is_array)
        return array_term(x, value);
    const CohortString *text = co_value_text(value);
    double number;
    if (text) {
        size_t n = text->length;
        if (n < 2 || text->text[0] != '`' || text->text[n - 1] != '`')
            return (CoTerm){.kind = CO_TERM_STRING, .text = text->text};
        char *inner = co_arena_string(&x->c->arena, text->text + 1, n - 2);
        co_composer_need(x->c, inner);
        return evaluate_nested(x, inner);
    }
    if (value->type == COHORT_TYPE_BLOCK)
        return (CoTerm){0};
    if (!co_value_double(value, &number))
        return fail(x, "a variable is neither string, integer nor boolean");
    return (CoTerm){.kind = value->type == COHORT_TYPE_BOOL ? CO_TERM_BOOL : CO_TERM_INT,
                    .number = (int64_t)number};
}

// After "${". Within a string an unknown variable stays as it is written.
static CoTerm parse_variable(CoExpression *x, bool *is_known)
{
    const char *start = x->at;
    while (x->at < x->end && is_word(*x->at))
        x->at++;
    size_t length = (size_t)(x->at - start);
    if (!length || x->at >= x->end || *x->at != '}')
        return fail(x, "a variable's name must stand in ${...}");
    x->at++;
    const CoValue *value = find_variable(x, start, length);
    *is_known = value != NULL;
    return value ? value_term(x, value) : (CoTerm){0};
}

typedef struct CoText {
    char *bytes;
    size_t count, capacity;
} CoText;

static void put(CoExpression *x, CoText *text, const char *bytes, size_t count)
{
    if (text->count + count + 1 > text->capacity) {
        size_t capacity = 2 * (text->count + count + 1);
        char *grown = co_composer_alloc(x->c, capacity);
        if (text->count)
            memcpy(grown, text->bytes, text->count);
        text->bytes = grown;
        text->capacity = capacity;
    }
    if (count)
        memcpy(text->bytes + text->count, bytes, count);
    text->count += count;
    text->bytes[text->count] = 0;
}

static CoTerm parse_string(CoExpression *x, char quote)
{
    CoText text = {0};
    put(x, &text, "", 0);
    while (x->at < x->end && *x->at != quote) {
        if (*x->at == '\\' && x->at + 1 < x->end) {
            put(x, &text, x->at + 1, 1);
            x->at += 2;
        } else if (*x->at == '$' && x->at + 1 < x->end && x->at[1] == '{') {
            const char *start = x->at;
            x->at += 2;
            bool is_known = false;
            CoTerm term = parse_variable(x, &is_known);
            if (x->why)
                return term;
            if (!is_known)
                put(x, &text, start, (size_t)(x->at - start));
            if (term.kind != CO_TERM_STRING && term.kind != CO_TERM_NONE)
                return fail(x, "a variable within a string must be a string");
            if (term.text)
                put(x, &text, term.text, strlen(term.text));
        } else {
            put(x, &text, x->at++, 1);
        }
    }
    if (x->at >= x->end)
        return fail(x, "a string has no end");
    x->at++;
    return (CoTerm){.kind = CO_TERM_STRING, .text = text.bytes};
}

static CoTerm truth(bool is_true)
{
    return (CoTerm){.kind = CO_TERM_BOOL, .number = is_true};
}

static bool is_call(const char *name, size_t length, const char *wanted)
{
    return strlen(wanted) == length && !memcmp(name, wanted, length);
}

static CoTerm compare(CoExpression *x, const char *name, size_t length, const CoTerm *a)
{
    if (a[0].kind != a[1].kind)
        return fail(x, "two values of different types are compared");
    if (a[0].kind == CO_TERM_LIST)
        return fail(x, "lists are compared");
    int order = a[0].kind == CO_TERM_STRING
                    ? strcmp(a[0].text, a[1].text)
                    : (a[0].number > a[1].number) - (a[0].number < a[1].number);
    if (is_call(name, length, "eq"))
        return truth(order == 0);
    if (is_call(name, length, "neq"))
        return truth(order != 0);
    if (is_call(name, length, "lt"))
        return truth(order < 0);
    if (is_call(name, length, "leq"))
        return truth(order <= 0);
    if (is_call(name, length, "gt"))
        return truth(order > 0);
    return truth(order >= 0);
}

static size_t series_length(const CoTerm *series)
{
    return series->kind == CO_TERM_LIST ? series->count : strlen(series->text);
}

static CoTerm contains(CoExpression *x, const CoTerm *series, const CoTerm *wanted)
{
    if (series->kind == CO_TERM_STRING)
        return wanted->kind == CO_TERM_STRING ? truth(strstr(series->text, wanted->text) != NULL)
                                              : fail(x, "contains() looks for a string");
    bool found = false;
    for (size_t i = 0; i < series->count && !found; i++) {
        const CoTerm *item = &series->items[i];
        if (item->kind != wanted->kind)
            return fail(x, "contains() looks for what its list does not hold");
        found = item->kind == CO_TERM_STRING ? !strcmp(item->text, wanted->text)
                                             : item->number == wanted->number;
    }
    return truth(found);
}

// Indices below zero count from the end.
static CoTerm element(CoExpression *x, const CoTerm *series, const CoTerm *index)
{
    int64_t length = (int64_t)series_length(series), i = index->number;
    if (index->kind != CO_TERM_INT)
        return fail(x, "the index of at() is no integer");
    if (i < -length || i >= length)
        return fail(x, "the index of at() is out of range");
    size_t at = (size_t)(i < 0 ? i + length : i);
    if (series->kind == CO_TERM_LIST)
        return series->items[at];
    char *text = co_arena_string(&x->c->arena, series->text + at, 1);
    co_composer_need(x->c, text);
    return (CoTerm){.kind = CO_TERM_STRING, .text = text};
}

static CoTerm call(CoExpression *x, const char *name, size_t length, const CoTerm *a, size_t count)
{
    if (is_call(name, length, "if") && (count == 2 || count == 3)) {
        if (a[0].kind != CO_TERM_BOOL)
            return fail(x, "the condition of if() is no boolean");
        if (count == 3 && a[1].kind != a[2].kind && a[1].kind && a[2].kind)
            return fail(x, "the values of if() are of different types");
        return a[0].number ? a[1] : count == 3 ? a[2] : (CoTerm){0};
    }
    if ((is_call(name, length, "and") || is_call(name, length, "or")) && count >= 2) {
        bool all = true, any = false;
        for (size_t i = 0; i < count; i++) {
            if (a[i].kind != CO_TERM_BOOL)
                return fail(x, "and() and or() take booleans");
            all = all && a[i].number;
            any = any || a[i].number;
        }
        return truth(is_call(name, length, "and") ? all : any);
    }
    if (is_call(name, length, "not") && count == 1)
        return a[0].kind == CO_TERM_BOOL ? truth(!a[0].number) : fail(x, "not() takes a boolean");
    bool is_series = count && (a[0].kind == CO_TERM_STRING || a[0].kind == CO_TERM_LIST);
    if (is_call(name, length, "len") && count == 1 && is_series)
        return (CoTerm){.kind = CO_TERM_INT, .number = (int64_t)series_length(a)};
    if (is_call(name, length, "contains") && count == 2 && is_series)
        return contains(x, &a[0], &a[1]);
    if (is_call(name, length, "at") && count == 2 && is_series)
        return element(x, &a[0], &a[1]);
    static const char *const comparisons[] = {"eq", "neq", "lt", "leq", "gt", "geq"};
    for (size_t i = 0; i < 6 && count == 2; i++)
        if (is_call(name, length, comparisons[i]))
            return compare(x, name, length, a);
    return fail(x, "a function or its arguments are not known");
}

// After "[": the items of a list, separated by commas.
static CoTerm parse_list(CoExpression *x)
{
    CoTerm *items = NULL;
    size_t count = 0, capacity = 0;
    while (!take(x, ']')) {
        if (count && !take(x, ','))
            return fail(x, "a list has no end");
        if (count == capacity) {
            CoTerm *grown = co_composer_array(x->c, 2 * capacity + 4, sizeof *grown);
            if (count)
                memcpy(grown, items, count * sizeof *grown);
            items = grown;
            capacity = 2 * capacity + 4;
        }
        items[count] = parse_term(x);
        if (x->why)
            return (CoTerm){0};
        if (items[count].kind == CO_TERM_NONE || items[count].kind == CO_TERM_LIST ||
            items[count].kind != items[0].kind)
            return fail(x, "a list holds other than strings, integers or booleans of one kind");
        count++;
    }
    return (CoTerm){.kind = CO_TERM_LIST, .items = items, .count = count};
}

static CoTerm parse_call(CoExpression *x, const char *name, size_t length)
{
    CoTerm arguments[MAX_ARGUMENTS];
    size_t count = 0;
    bool asks_defined = is_call(name, length, "defined"), all_defined = true;
    while (!x->why && !take(x, ')')) {
        if (count && !take(x, ','))
            return fail(x, "arguments must be separated by commas");
        if (count == MAX_ARGUMENTS)
            return fail(x, "a function has too many arguments");
        arguments[count++] = parse_term(x);
        if (asks_defined && arguments[count - 1].kind == CO_TERM_STRING)
            all_defined &= find_variable(x, arguments[count - 1].text,
                                         strlen(arguments[count - 1].text)) != NULL;
    }
    if (x->why)
        return (CoTerm){0};
    return asks_defined ? truth(all_defined && count) : call(x, name, length, arguments, count);
}

static CoTerm parse_term(CoExpression *x)
{
    if (++x->nesting > MAX_NESTING)
        return fail(x, "it is nested too deeply");
    CoTerm term = {0};
    skip_space(x);
    if (x->at >= x->end) {
        term = fail(x, "an expression is empty");
    } else if (*x->at == '"' || *x->at == '\'') {
        char quote = *x->at++;
        term = parse_string(x, quote);
    } else if (*x->at == '$' && x->at + 1 < x->end && x->at[1] == '{') {
        x->at += 2;
        bool is_known;
        term = parse_variable(x, &is_known);
        if (!x->why && !is_known)
            term = fail(x, "it names a variable that has no value");
    } else if (take(x, '[')) {
        term = parse_list(x);
    } else {
        const char *start = x->at;
        if (*x->at == '-')
            x->at++;
        while (x->at < x->end && is_word(*x->at))
            x->at++;
        size_t length = (size_t)(x->at - start);
        if (is_call(start, length, "True") || is_call(start, length, "true"))
            term = truth(true);
        else if (is_call(start, length, "False") || is_call(start, length, "false"))
            term = truth(false);
        else if (is_call(start, length, "None") || is_call(start, length, "none"))
            term = (CoTerm){0};
        else if (length && (*start == '-' || (*start >= '0' && *start <= '9')))
            term = (CoTerm){.kind = CO_TERM_INT, .number = strtoll(start, NULL, 10)};
        else if (length && take(x, '('))
            term = parse_call(x, start, length);
        else
            term = fail(x, "it is no expression");
    }
    x->nesting--;
    return term;
}

// Results become asset paths and names, which hold neither control characters nor bad UTF-8.
static bool is_clean(const char *text)
{
    const char *end = text + strlen(text);
    while (text < end) {
        uint32_t code = 0;
        size_t step = co_utf8_decode(text, end, &code);
        if (!step || code < 0x20 || (code >= 0x7f && code < 0xa0))
            return false;
        text += step;
    }
    return true;
}

const char *co_expression_evaluate(CoComposer *c, const CoVariables *variables, const char *text,
                                   const char **why)
{
    size_t length = strlen(text);
    if (length < 2 || text[0] != '`' || text[length - 1] != '`')
        return text;
    CoExpression x = {c, variables, text + 1, text + length - 1, NULL, 0};
    CoTerm term = parse_term(&x);
    skip_space(&x);
    if (!x.why && x.at != x.end)
        x.why = "text after the end of an expression";
    if (!x.why && term.kind != CO_TERM_STRING && term.kind != CO_TERM_NONE)
        x.why = "the expression is no string";
    if (!x.why && term.text && !is_clean(term.text))
        x.why = "it yields a control character or bad UTF-8";
    *why = x.why;
    return x.why ? NULL : term.text ? term.text : "";
}
