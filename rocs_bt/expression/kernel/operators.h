/* The operators, in the order of TABLE in ../operators.py: EACH(name, operands, value of A, B and C),
 * GROUP(name, operands, value of a[n] and b[n]), CELLS(name, operands, cells, value of *a and *b at t), RING(name, operands). */
#pragma once

#define OPERATORS(EACH, GROUP, CELLS, RING)                                                                     \
    EACH(NEG, 1, -A)                                                                                            \
    EACH(ADD, 2, A + B)                                                                                         \
    EACH(SUB, 2, A - B)                                                                                         \
    EACH(MUL, 2, A * B)                                                                                         \
    EACH(DIV, 2, B == 0.0 ? NAN : A / B)                                                                        \
    EACH(MIN2, 2, INVALID(A) || INVALID(B) ? NAN : B < A ? B : A)                                               \
    EACH(MAX2, 2, INVALID(A) || INVALID(B) ? NAN : B > A ? B : A)                                               \
    EACH(SELECT, 3, INVALID(C) ? NAN : C == 1.0 ? A : B)                                                        \
    EACH(LT, 2, INVALID(A) || INVALID(B) ? NAN : (double)(A < B))                                               \
    EACH(LE, 2, INVALID(A) || INVALID(B) ? NAN : (double)(A <= B))                                              \
    EACH(EQ, 2, INVALID(A) || INVALID(B) ? NAN : (double)(A == B))                                              \
    EACH(NE, 2, INVALID(A) || INVALID(B) ? NAN : (double)(A != B))                                              \
    EACH(NOT, 1, 1.0 - A)                                                                                       \
    EACH(AND, 2, both(A, B))                                                                                    \
    EACH(OR, 2, either(A, B))                                                                                   \
    EACH(GAP, 3, INVALID(A) || INVALID(B) ? NAN : A == B ? 0.0 : (B - A) / C)                                   \
    EACH(WORST, 2, worst(A, B))                                                                                 \
    EACH(BEST, 2, best(A, B))                                                                                   \
    GROUP(WORST_OF, 1, folded(worst, a, n))                                                                     \
    GROUP(BEST_OF, 1, folded(best, a, n))                                                                       \
    RING(DELAY, 1)                                                                                              \
    RING(LOWEST, 1)                                                                                             \
    RING(SINCE_MARGIN, 2)                                                                                       \
    GROUP(MIN, 1, least(a, n))                                                                                  \
    GROUP(MAX, 1, greatest(a, n))                                                                               \
    GROUP(SUM, 1, total(a, n))                                                                                  \
    GROUP(ANY, 1, folded(either, a, n))                                                                         \
    GROUP(ALL, 1, folded(both, a, n))                                                                           \
    GROUP(COUNT, 1, count(a, n))                                                                                \
    EACH(ABS, 1, fabs(A))                                                                                       \
    EACH(CLIP, 3, INVALID(A) || INVALID(B) || INVALID(C) ? NAN : C < (B > A ? B : A) ? C : B > A ? B : A)       \
    EACH(HYPOT, 2, INVALID(A) || INVALID(B) ? NAN : hypot(A, B))                                                \
    EACH(SIGN, 1, INVALID(A) ? NAN : (double)((A > 0.0) - (A < 0.0)))                                           \
    EACH(SIDE, 1, INVALID(A) ? NAN : A >= 0.0 ? 1.0 : -1.0)                                                     \
    EACH(SQRT, 1, A >= 0.0 ? sqrt(A) : NAN)                                                                     \
    EACH(WRAP_ANGLE, 1, wrapped(A))                                                                             \
    GROUP(MIN_VALID, 2, min_valid(a, n, *b))                                                                    \
    GROUP(ARGMIN, 1, argmin(a, n))                                                                              \
    GROUP(DOT, 2, dot(a, b, n))                                                                                 \
    EACH(ATAN2, 2, atan2(A, B))                                                                                 \
    CELLS(HELD, 1, 2, held(cell, *a, t, *c))                                                                    \
    CELLS(SINCE, 2, 2, since(cell, *a, *b, t, *c))                                                              \
    CELLS(TIME_SINCE, 1, 1, ago(cell, *a, t))                                                                   \
    RING(RATE, 1)

#define NAME(OP, ...) OP,
enum { LOAD, OPERATORS(NAME, NAME, NAME, NAME) OPS,
       AND_LT = OPS, AND_LE /* a and b < c: two fused instructions, see placing.h */ };

#define TEXT(OP, ...) " " #OP
static const char OPERATIONS[] = "LOAD" OPERATORS(TEXT, TEXT, TEXT, TEXT);

enum { ONE_BY_ONE, REDUCE, REMEMBER, RINGED }; /* elementwise; reduction of n values; temporal with a fixed number of cells; temporal with a ring */

#define KIND_EACH(OP, OPERANDS, VALUE) {ONE_BY_ONE, OPERANDS, 0},
#define KIND_GROUP(OP, OPERANDS, VALUE) {REDUCE, OPERANDS, 0},
#define KIND_CELLS(OP, OPERANDS, CELLS, VALUE) {REMEMBER, OPERANDS, CELLS},
#define KIND_RING(OP, OPERANDS) {RINGED, OPERANDS, 0},
static const struct { uint8_t kind, operands, cells; } KINDS[OPS] = {
    {ONE_BY_ONE, 0, 0}, OPERATORS(KIND_EACH, KIND_GROUP, KIND_CELLS, KIND_RING)};
