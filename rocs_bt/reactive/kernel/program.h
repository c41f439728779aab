/* Runs the sorted instructions. */
#pragma once

#include "memory.h"

#define FOR_ALL for (const Instruction *k = table->code + run->start, *stop = table->code + run->stop; k < stop; k++)

#define ONE_BY_ONE(OP, VALUE)                                                          \
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

#define ALL_OF(OP, VALUE)                                                       \
    case OP:                                                                    \
        FOR_ALL {                                                               \
            const double *a = r + k->a, *b = r + k->b, *c = r + k->c;           \
            double *const cell = cells + k->cell;                               \
            const int n = k->n;                                                 \
            (void)b, (void)c, (void)cell, (void)n;                              \
            r[k->dst] = (VALUE);                                                \
        }                                                                       \
        break;

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
    ONE_BY_ONE(NEG, -A)
    ONE_BY_ONE(ABS, fabs(A))
    ONE_BY_ONE(SIGN, INVALID(A) ? NAN : (double)((A > 0.0) - (A < 0.0)))
    ONE_BY_ONE(SIDE, INVALID(A) ? NAN : A >= 0.0 ? 1.0 : -1.0)
    ONE_BY_ONE(SQRT, A >= 0.0 ? sqrt(A) : NAN)
    ONE_BY_ONE(WRAP, wrapped(A))
    ONE_BY_ONE(ADD, A + B)
    ONE_BY_ONE(SUB, A - B)
    ONE_BY_ONE(MUL, A * B)
    ONE_BY_ONE(DIV, B == 0.0 ? NAN : A / B)
    ONE_BY_ONE(HYPOT, INVALID(A) || INVALID(B) ? NAN : hypot(A, B))
    ONE_BY_ONE(ATAN2, atan2(A, B))
    ONE_BY_ONE(MIN2, INVALID(A) || INVALID(B) ? NAN : B < A ? B : A)
    ONE_BY_ONE(MAX2, INVALID(A) || INVALID(B) ? NAN : B > A ? B : A)
    ONE_BY_ONE(CLIP, INVALID(A) || INVALID(B) || INVALID(C) ? NAN : C < (B > A ? B : A) ? C : B > A ? B : A)
    ONE_BY_ONE(SELECT, INVALID(C) ? NAN : C == 1.0 ? A : B)
    ONE_BY_ONE(LT, INVALID(A) || INVALID(B) ? NAN : (double)(A < B))
    ONE_BY_ONE(LE, INVALID(A) || INVALID(B) ? NAN : (double)(A <= B))
    ONE_BY_ONE(EQ, INVALID(A) || INVALID(B) ? NAN : (double)(A == B))
    ONE_BY_ONE(NE, INVALID(A) || INVALID(B) ? NAN : (double)(A != B))
    ONE_BY_ONE(NOT, 1.0 - A)
    ONE_BY_ONE(AND, both(A, B))
    ONE_BY_ONE(OR, either(A, B))
    ONE_BY_ONE(AND_LT, both(A, INVALID(B) || INVALID(C) ? NAN : (double)(B < C)))
    ONE_BY_ONE(AND_LE, both(A, INVALID(B) || INVALID(C) ? NAN : (double)(B <= C)))
    ONE_BY_ONE(GAP, INVALID(A) || INVALID(B) ? NAN : A == B ? 0.0 : (B - A) / C)
    ONE_BY_ONE(WORST, worst(A, B))
    ONE_BY_ONE(BEST, best(A, B))
    ALL_OF(MIN, least(a, n))
    ALL_OF(MAX, greatest(a, n))
    ALL_OF(ARGMIN, argmin(a, n))
    ALL_OF(SUM, total(a, n))
    ALL_OF(ANY, folded(either, a, n))
    ALL_OF(ALL, folded(both, a, n))
    ALL_OF(COUNT, count(a, n))
    ALL_OF(MIN_VALID, min_valid(a, n, *b))
    ALL_OF(DOT, dot(a, b, n))
    ALL_OF(WORST_OF, folded(worst, a, n))
    ALL_OF(BEST_OF, folded(best, a, n))
    ALL_OF(HELD, held(cell, *a, t, *c))
    ALL_OF(SINCE, since(cell, *a, *b, t, *c))
    ALL_OF(AGO, ago(cell, *a, t))
    default:
        FOR_ALL r[k->dst] = remembered(k->op, cells + k->cell, k->capacity, r[k->a], r[k->b], t, r + k->c);
    }
}
