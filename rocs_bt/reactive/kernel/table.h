/* Data structures of a table. */
#pragma once

#include <Python.h>
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0
#error "doubles are computed with more digits here: results would differ from Python's"
#endif

#define INVALID(v) ((v) != (v))
#define PI 3.141592653589793
#define TWO_PI 6.283185307179586
#define TOLERANCE 1e-9 /* [s], as in program.py */

enum { LOAD, NEG, ABS, SIGN, SIDE, SQRT, WRAP, ADD, SUB, MUL, DIV, HYPOT, ATAN2, MIN2, MAX2, CLIP, SELECT, LT, LE, EQ, NE,
       NOT, AND, OR, MIN, MAX, ARGMIN, SUM, ANY, ALL, COUNT, MIN_VALID, DOT, HELD, SINCE, AGO, RATE, DELAY, GAP, WORST,
       BEST, WORST_OF, BEST_OF, LOWEST, SINCE_MARGIN, OPS,
       AND_LT = OPS, AND_LE /* a and b < c: two fused instructions, see placing.h */ };

enum { EACH, REDUCE, REMEMBER, RING }; /* elementwise; reduction of n values; temporal with a fixed number of cells; temporal with a ring */

static const struct { uint8_t kind, operands, cells; } KINDS[OPS] = {
    [LOAD] = {EACH, 0, 0}, [NEG] = {EACH, 1, 0}, [ABS] = {EACH, 1, 0}, [SIGN] = {EACH, 1, 0}, [SIDE] = {EACH, 1, 0},
    [SQRT] = {EACH, 1, 0}, [WRAP] = {EACH, 1, 0}, [ADD] = {EACH, 2, 0}, [SUB] = {EACH, 2, 0}, [MUL] = {EACH, 2, 0},
    [DIV] = {EACH, 2, 0}, [HYPOT] = {EACH, 2, 0}, [ATAN2] = {EACH, 2, 0}, [MIN2] = {EACH, 2, 0}, [MAX2] = {EACH, 2, 0},
    [CLIP] = {EACH, 3, 0}, [SELECT] = {EACH, 3, 0}, [LT] = {EACH, 2, 0}, [LE] = {EACH, 2, 0}, [EQ] = {EACH, 2, 0},
    [NE] = {EACH, 2, 0}, [NOT] = {EACH, 1, 0}, [AND] = {EACH, 2, 0}, [OR] = {EACH, 2, 0}, [GAP] = {EACH, 3, 0},
    [WORST] = {EACH, 2, 0}, [BEST] = {EACH, 2, 0}, [MIN] = {REDUCE, 1, 0}, [MAX] = {REDUCE, 1, 0},
    [ARGMIN] = {REDUCE, 1, 0}, [SUM] = {REDUCE, 1, 0}, [ANY] = {REDUCE, 1, 0}, [ALL] = {REDUCE, 1, 0},
    [COUNT] = {REDUCE, 1, 0}, [MIN_VALID] = {REDUCE, 2, 0}, [DOT] = {REDUCE, 2, 0}, [WORST_OF] = {REDUCE, 1, 0},
    [BEST_OF] = {REDUCE, 1, 0}, [HELD] = {REMEMBER, 1, 2}, [SINCE] = {REMEMBER, 2, 2}, [AGO] = {REMEMBER, 1, 1},
    [RATE] = {RING, 1, 0}, [DELAY] = {RING, 1, 0}, [LOWEST] = {RING, 1, 0}, [SINCE_MARGIN] = {RING, 2, 0},
};

typedef struct {
    int32_t n, dst, a, b, c, cell, capacity; /* capacity: maximum number of pairs in the ring */
    uint8_t op, wide;
} Instruction;

typedef struct {
    int32_t op, single;     /* single: all of n = 1 */
    Py_ssize_t start, stop; /* range of the sorted instructions */
} Run;

typedef struct {
    double hold, cooldown, max_hold;
    int32_t when, until, margin, rank; /* rank: order by priority, 0 first */
    Run release;                       /* instructions that only its release needs: run while it is latched; may be empty */
    uint8_t level, on_invalid;
} Rule;

enum { CLEAR, TRIP, HOLD };                                 /* Rule.on_invalid */
enum { LATCHED, RISEN, READY, UNKNOWN, ENABLED, BLIND, COLUMNS }; /* columns of a state, one value per rule */

typedef struct {
    PyObject_HEAD
    Py_ssize_t instructions, runs, registers, rules, cells, margins, width;
    Py_ssize_t needed; /* minimum length of a snapshot */
    Instruction *code;
    Run *run;
    double *first;   /* initial registers */
    double *initial; /* initial state */
    Rule *rule;
    int32_t *guard;   /* register of each rule's guard: the only cost of an inactive rule */
    int32_t *by_rank;
} Table;

typedef struct { /* working memory of a step, in addition to the state */
    double *r;
    uint8_t *flags; /* per rule: 0 if inactive (a false guard changes nothing); AWAKE; AWAKE | ON if latched */
} Work;

enum { AWAKE = 1, ON = 2 };
