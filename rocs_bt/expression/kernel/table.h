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

#include "operators.h"

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
    Py_ssize_t instructions, runs, registers, rules, cells, margins, width, kept;
    Py_ssize_t needed; /* minimum length of a snapshot */
    Instruction *code;
    Run *run;
    int32_t *keep;   /* registers that can be read after a step: never fused or deferred */
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
