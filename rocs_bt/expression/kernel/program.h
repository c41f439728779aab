/* Runs the sorted instructions. */
#pragma once

#include "memory.h"

#define FOR_ALL for (const Instruction *k = table->code + run->start, *stop = table->code + run->stop; k < stop; k++)

#define RUN_EACH(OP, OPERANDS, VALUE)                                                  \
    case OP:                                                                           \
        if (run->single) FOR_ALL {                                                     \
            const double A = r[k->a], B = r[k->b], C = r[k->c];                        \
            (void)B, (void)C;                                                          \
            r[k->dst] = (VALUE);                                                       \
        } else FOR_ALL                                                                 \
            for (int i = 0; i < k->n; i++) {                                           \
                const double A = r[k->a + (k->wide & 1 ? i : 0)],                      \
                             B = r[k->b + (k->wide & 2 ? i : 0)],                      \
                             C = r[k->c + (k->wide & 4 ? i : 0)];                      \
                (void)B, (void)C;                                                      \
                r[k->dst + i] = (VALUE);                                               \
            }                                                                          \
        break;

#define RUN_GROUP(OP, OPERANDS, VALUE)                                          \
    case OP:                                                                    \
        FOR_ALL {                                                               \
            const double *a = r + k->a, *b = r + k->b, *c = r + k->c;           \
            double *const cell = cells + k->cell;                               \
            const int n = k->n;                                                 \
            (void)b, (void)c, (void)cell, (void)n;                              \
            r[k->dst] = (VALUE);                                                \
        }                                                                       \
        break;

#define RUN_CELLS(OP, OPERANDS, CELLS, VALUE) RUN_GROUP(OP, OPERANDS, VALUE)
#define RUN_RING(OP, OPERANDS) /* see default */

static void load(const Table *table, const Run *run, double *r, const char *x, Py_ssize_t stride) {
    FOR_ALL {
        const char *from = x + k->a * stride;
        if (stride == sizeof(double)) memcpy(r + k->dst, from, (size_t)k->n * sizeof(double));
        else
            for (int i = 0; i < k->n; i++) memcpy(r + k->dst + i, from + i * stride, sizeof(double));
    }
}

static void execute(const Table *table, const Run *run, double *r, double *cells, const char *x, Py_ssize_t stride, double t) {
    switch (run->op) {
    case LOAD: load(table, run, r, x, stride); break;
    OPERATORS(RUN_EACH, RUN_GROUP, RUN_CELLS, RUN_RING)
    RUN_EACH(AND_LT, 3, both(A, INVALID(B) || INVALID(C) ? NAN : (double)(B < C)))
    RUN_EACH(AND_LE, 3, both(A, INVALID(B) || INVALID(C) ? NAN : (double)(B <= C)))
    default:
        FOR_ALL r[k->dst] = remembered(k->op, cells + k->cell, k->capacity, r[k->a], r[k->b], t, r + k->c);
    }
}
