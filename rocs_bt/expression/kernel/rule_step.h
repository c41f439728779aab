/* Steps the rules. */
#pragma once

#include "program.h"

/* Sets the flags of all rules from the columns of a state. */
static void rouse(const Table *table, const double *column, uint8_t *flags) {
    const Py_ssize_t n = table->rules;
    const double *latched = column, *risen = column + RISEN * n, *unknown = column + UNKNOWN * n,
                 *blind = column + BLIND * n;
    for (Py_ssize_t i = 0; i < n; i++) {
        int on = latched[i] != 0.0;
        int rests = !on & (risen[i] == INFINITY) & (unknown[i] == INFINITY) & (blind[i] == 0.0);
        flags[i] = (uint8_t)((rests ? 0 : AWAKE) | (on ? ON : 0));
    }
}

static void begin(const Table *table, double *values, uint8_t *flags) {
    double *column = values + 1 + table->cells;
    const size_t before = (size_t)(table->cells + ENABLED * table->rules), all = (size_t)table->width - 1;
    const size_t after = before + (size_t)table->rules;
    memcpy(values + 1, table->initial + 1, before * sizeof(double));
    memcpy(values + 1 + after, table->initial + 1 + after, (all - after) * sizeof(double));
    rouse(table, column, flags);
}

/* Advances one rule; returns its flags. */
static uint8_t live(const Table *table, const Rule *rule, double *column, double *r, double t) {
    const Py_ssize_t n = table->rules;
    double *latched = column + LATCHED * n, *risen = column + RISEN * n, *ready = column + READY * n,
           *unknown = column + UNKNOWN * n, *blind = column + BLIND * n;
    const int on = *latched != 0.0;
    const double guard = r[rule->when];
    if (on && rule->release.stop > 0) execute(table, &rule->release, r, NULL, NULL, 0, t);
    double decided = !on ? guard : rule->until < 0 ? 1.0 - guard : r[rule->until];
    if (column[ENABLED * n] == 0.0) {
        *unknown = *risen = INFINITY;
        *blind = 0.0;
        decided = on; /* released */
    } else {
        *blind = INVALID(guard) || INVALID(decided);
        if (!INVALID(decided)) {
            *unknown = INFINITY;
        } else {
            if (*unknown == INFINITY) *unknown = t;
            if (rule->on_invalid == HOLD && t - *unknown < rule->max_hold) return AWAKE | (on ? ON : 0);
            decided = (rule->on_invalid != CLEAR) != on;
        }
    }
    if (on) {
        if (decided != 0.0) {
            *latched = 0.0;
            if (rule->level) *ready = t + rule->cooldown;
        }
    } else if (decided == 0.0) {
        *risen = INFINITY;
    } else {
        if (*risen == INFINITY) *risen = t;
        if (t - *risen >= rule->hold && t >= *ready - TOLERANCE) {
            *latched = 1.0;
            *risen = INFINITY;
            if (!rule->level) *ready = t + rule->cooldown;
        }
    }
    if (*latched != 0.0) return AWAKE | ON;
    return *risen == INFINITY && *unknown == INFINITY && *blind == 0.0 ? 0 : AWAKE;
}

/* Advances a state by one snapshot; returns the winner. */
static int32_t step(const Table *table, Work *work, double *values, const char *x, Py_ssize_t stride, double t) {
    const Py_ssize_t n = table->rules;
    double *const column = values + 1 + table->cells, *const r = work->r;
    uint8_t *const flags = work->flags;
    int32_t first = INT32_MAX;
    if (t < values[0]) begin(table, values, flags);
    values[0] = t;
    for (const Run *run = table->run; run < table->run + table->runs; run++) execute(table, run, r, values + 1, x, stride, t);
    for (Py_ssize_t i = 0; i < n; i++) {
        if (!flags[i] && r[table->guard[i]] == 0.0) continue;
        flags[i] = live(table, table->rule + i, column + i, r, t);
        if (flags[i] & ON && table->rule[i].rank < first) first = table->rule[i].rank;
    }
    double *const margin = column + COLUMNS * n;
    for (Py_ssize_t i = 0; i < table->margins; i++) margin[i] = r[table->rule[i].margin];
    return first == INT32_MAX ? -1 : table->by_rank[first];
}

static int work_make(Work *work, const Table *table) {
    work->r = malloc((size_t)(table->registers + 1) * sizeof(double));
    work->flags = calloc((size_t)table->rules + 1, 1);
    if (work->r == NULL || work->flags == NULL) return -1;
    memcpy(work->r, table->first, (size_t)table->registers * sizeof(double));
    return 0;
}

static void work_free(Work *work) {
    free(work->r);
    free(work->flags);
}
