/* Creates a table from the caller's arrays. */
#pragma once

#include "placing.h"

/* Opens a buffer with `dimensions` and a number type: 'd' float64, 'i' int32, 'q' int64, 'B' uint8, '?' bool. */
static int buffer(PyObject *object, Py_buffer *view, const char *name, char kind, int dimensions, int flags) {
    if (PyObject_GetBuffer(object, view, flags | PyBUF_FORMAT) < 0) return -1;
    const char *format = view->format == NULL ? "B" : view->format;
    const char given = format[0] != '\0' && strchr("@=<", format[0]) != NULL ? format[1] : format[0];
    const Py_ssize_t size = view->itemsize;
    int right = given == kind;
    if (kind == 'i') right = strchr("il", given) != NULL && size == 4;
    if (kind == 'q') right = strchr("lq", given) != NULL && size == 8;
    if (given != '\0' && right && view->ndim == dimensions) return 0;
    PyErr_Format(PyExc_ValueError, "%s: numbers of kind '%s' in %d dimensions were given; '%c' in %d are needed", name,
                 format, view->ndim, kind, dimensions);
    PyBuffer_Release(view);
    return -1;
}

enum { CODE, REGISTERS, KEEP, INITIAL, WHEN, UNTIL, MARGINS, HOLDS, COOLDOWN, MAX_HOLD, LEVEL, ON_INVALID, PRIORITY, INPUTS };
static const char *const NAMES[INPUTS] = {"code", "registers", "keep", "initial", "when", "until", "margins",
                                          "hold", "cooldown", "max_hold", "level", "on_invalid", "priority"};
static const char INPUT_KINDS[INPUTS + 1] = "ididiiidddBBq";

typedef struct {
    int64_t priority;
    int32_t rule;
} Ranked;

static int by_priority(const void *one, const void *other) {
    const Ranked *a = one, *b = other;
    if (a->priority != b->priority) return a->priority > b->priority ? -1 : 1;
    return a->rule < b->rule ? -1 : 1;
}

static int table_rules(Table *table, const Py_buffer *in) {
    const size_t n = (size_t)table->rules;
    const int32_t *when = in[WHEN].buf, *until = in[UNTIL].buf, *margins = in[MARGINS].buf;
    Ranked *ranked = malloc((n + 1) * sizeof(Ranked));
    table->rule = calloc(n + 1, sizeof(Rule));
    table->guard = malloc((n + 1) * sizeof(int32_t));
    table->by_rank = malloc((n + 1) * sizeof(int32_t));
    if (!ranked || !table->rule || !table->guard || !table->by_rank) {
        free(ranked);
        PyErr_NoMemory();
        return -1;
    }
    for (size_t i = 0; i < n; i++) {
        const int32_t margin = table->margins ? margins[i] : 0;
        if (when[i] < 0 || when[i] >= table->registers || until[i] < -1 || until[i] >= table->registers || margin < 0 ||
            margin > table->registers || (table->margins && margin == table->registers)) {
            free(ranked);
            PyErr_Format(PyExc_ValueError, "rule %zu: its guard, release and margin are registers %d, %d, %d of %zd", i,
                         (int)when[i], (int)until[i], (int)margin, table->registers);
            return -1;
        }
        table->rule[i] = (Rule){((const double *)in[HOLDS].buf)[i], ((const double *)in[COOLDOWN].buf)[i],
                                ((const double *)in[MAX_HOLD].buf)[i], when[i], until[i], margin, 0, {0, 0, 0, 0},
                                ((const uint8_t *)in[LEVEL].buf)[i], ((const uint8_t *)in[ON_INVALID].buf)[i]};
        table->guard[i] = when[i];
        ranked[i] = (Ranked){((const int64_t *)in[PRIORITY].buf)[i], (int32_t)i};
    }
    qsort(ranked, n, sizeof(Ranked), by_priority);
    for (size_t i = 0; i < n; i++) {
        table->by_rank[i] = ranked[i].rule;
        table->rule[ranked[i].rule].rank = (int32_t)i;
    }
    free(ranked);
    return 0;
}

static int table_sizes(Table *table, const Py_buffer *in) {
    if (in[CODE].shape[1] != 8 || in[CODE].shape[0] > INT32_MAX || in[REGISTERS].shape[0] > INT32_MAX) {
        PyErr_Format(PyExc_ValueError, "code has the shape (%zd, %zd), not (n, 8)", in[CODE].shape[0], in[CODE].shape[1]);
        return -1;
    }
    table->registers = in[REGISTERS].shape[0];
    table->kept = in[KEEP].shape[0];
    table->rules = in[WHEN].shape[0];
    table->margins = in[MARGINS].shape[0];
    table->width = in[INITIAL].shape[0];
    table->cells = table->width - 1 - COLUMNS * table->rules - table->margins;
    for (int i = UNTIL; i < INPUTS; i++)
        if (in[i].shape[0] != table->rules && !(i == MARGINS && table->margins == 0)) {
            PyErr_Format(PyExc_ValueError, "%s has %zd values for %zd rules", NAMES[i], in[i].shape[0], table->rules);
            return -1;
        }
    if (table->cells >= 0 && table->cells <= INT32_MAX && table->rules <= INT32_MAX / 8) return 0;
    PyErr_Format(PyExc_ValueError, "initial has %zd values, too few or too many for %zd rules", table->width, table->rules);
    return -1;
}

static int table_fill(Table *table, const Py_buffer *in) {
    if (table_sizes(table, in) < 0) return -1;
    table->first = malloc((size_t)(table->registers + 1) * sizeof(double));
    table->initial = malloc((size_t)table->width * sizeof(double));
    table->keep = malloc((size_t)(table->kept + 1) * sizeof(int32_t));
    if (!table->first || !table->initial || !table->keep) {
        PyErr_NoMemory();
        return -1;
    }
    memcpy(table->first, in[REGISTERS].buf, (size_t)table->registers * sizeof(double));
    for (Py_ssize_t i = 0; i < table->kept; i++) {
        table->keep[i] = ((const int32_t *)in[KEEP].buf)[i];
        if (table->keep[i] >= 0 && table->keep[i] < table->registers) continue;
        PyErr_Format(PyExc_ValueError, "register %d is to be kept, and there are %zd", (int)table->keep[i], table->registers);
        return -1;
    }
    memcpy(table->initial, in[INITIAL].buf, (size_t)table->width * sizeof(double));
    return table_rules(table, in) < 0 ? -1 : table_code(table, &in[CODE]);
}
