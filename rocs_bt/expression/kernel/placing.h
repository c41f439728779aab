/* Checks, fuses and sorts the instructions of a table. */
#pragma once

#include "table.h"

typedef struct {
    Instruction code;
    int32_t depth, place, rule; /* rule: the only rule whose release needs it; else STEP or FUSED */
} Placed;

enum { STEP = -1, FUSED = -2 }; /* Placed.rule: runs at every step; fused with another instruction */

static int by_depth_and_kind(const void *one, const void *other) {
    const Placed *a = one, *b = other;
    if (a->depth != b->depth) return a->depth < b->depth ? -1 : 1;
    if (a->code.op != b->code.op) return a->code.op < b->code.op ? -1 : 1;
    if ((a->code.n == 1) != (b->code.n == 1)) return a->code.n == 1 ? -1 : 1;
    return a->place < b->place ? -1 : 1;
}

typedef struct { /* data of each register, while instructions are checked */
    int32_t *depth;
    uint8_t *used;  /* READ: by one instruction; AGAIN: by another one or a rule; WRITTEN; RELEASES: releases one rule */
} Registers;

enum { READ = 1, WRITTEN = 2, RELEASES = 4, AGAIN = 8 };

static int wrong(Py_ssize_t place, const char *what, long long found, long long limit) {
    PyErr_Format(PyExc_ValueError, "instruction %zd: %s %lld, and there are %lld", place, what, found, limit);
    return -1;
}

/* Marks registers [a, a + n) as read by an instruction; returns the minimum depth of the instruction, or -1. */
static int32_t reads(const Table *table, Registers *registers, Py_ssize_t place, int32_t a, int64_t n) {
    int32_t depth = 0;
    if (a < 0 || a + n > table->registers) return wrong(place, "it reads register", a < 0 ? a : a + n - 1, table->registers);
    for (int64_t i = a; i < a + n; i++) {
        registers->used[i] |= registers->used[i] & READ ? AGAIN : READ;
        if (registers->depth[i] >= depth) depth = registers->depth[i] + 1;
    }
    return depth;
}

static int writes(const Table *table, Registers *registers, Py_ssize_t place, int32_t dst, int64_t n, int32_t depth) {
    if (dst < 0 || dst + n > table->registers)
        return wrong(place, "it writes register", dst < 0 ? dst : dst + n - 1, table->registers);
    for (int64_t i = dst; i < dst + n; i++) {
        if (registers->used[i]) {
            PyErr_Format(PyExc_ValueError, "instruction %zd: it writes register %lld, which was written or read before",
                         place, (long long)i);
            return -1;
        }
        registers->used[i] = WRITTEN;
        registers->depth[i] = depth;
    }
    return 0;
}

/* Checks the memory of a temporal instruction. */
static int remembers(const Table *table, Registers *registers, Py_ssize_t place, Instruction *k) {
    int64_t cells = KINDS[k->op].cells;
    if (k->n != 1) return wrong(place, "its length is", k->n, 1);
    if (reads(table, registers, place, k->c, 4) < 0) return -1;
    if (KINDS[k->op].kind == RINGED) {
        const double capacity = table->first[k->c + 3];
        if (!(capacity >= 1.0 && capacity <= (double)table->cells)) return wrong(place, "its ring is too long for cells", k->cell, table->cells);
        k->capacity = (int32_t)capacity;
        cells = 2 + 2 * (int64_t)k->capacity;
    }
    if (k->cell < 0 || k->cell + cells > table->cells) return wrong(place, "it needs cell", k->cell + cells - 1, table->cells);
    return 0;
}

static int place_one(Table *table, Registers *registers, Py_ssize_t place, const int32_t *row, Placed *placed) {
    Instruction *k = &placed->code;
    *k = (Instruction){row[1], row[2], row[3], row[4], row[5], row[7], 0, (uint8_t)row[0], (uint8_t)(row[6] & 7)};
    if (row[0] < 0 || row[0] >= OPS) return wrong(place, "its operation is", row[0], OPS);
    if (k->n < 1) return wrong(place, "its length is", k->n, table->registers);
    const int kind = KINDS[k->op].kind, operands = KINDS[k->op].operands;
    const int32_t from[3] = {k->a, k->b, k->c};
    int32_t depth = 0;
    for (int i = 0; i < operands; i++) {
        int wide = kind == ONE_BY_ONE ? k->wide >> i & 1 : kind == REDUCE && (i == 0 || k->op == DOT);
        int32_t least_depth = reads(table, registers, place, from[i], wide ? k->n : 1);
        if (least_depth < 0) return -1;
        if (least_depth > depth) depth = least_depth;
    }
    if (k->op == LOAD) {
        if (k->a < 0) return wrong(place, "it loads signal", k->a, 0);
        if ((int64_t)k->a + k->n > table->needed) table->needed = (Py_ssize_t)k->a + k->n;
        k->b = k->c = 0;
    } else {
        if (operands < 2) k->b = k->a; /* unused operands must be valid, too */
        if (operands < 3 && kind < REMEMBER) k->c = k->a;
        if (operands < 3 && kind == ONE_BY_ONE) k->wide &= (uint8_t)((1 << operands) - 1);
    }
    if (kind >= REMEMBER && remembers(table, registers, place, k) < 0) return -1;
    placed->depth = depth;
    placed->place = (int32_t)place;
    placed->rule = STEP;
    return writes(table, registers, place, k->dst, kind == ONE_BY_ONE ? k->n : 1, depth);
}

/* Finds comparisons that only the release of one rule needs, and sorts them behind all others. */
static void defer(const Table *table, Registers *registers, Placed *placed, Py_ssize_t n) {
    uint8_t *const used = registers->used;
    for (Py_ssize_t i = 0; i < table->kept; i++) used[table->keep[i]] |= READ | AGAIN;
    for (Py_ssize_t i = 0; i < table->rules; i++) {
        const Rule *rule = table->rule + i;
        used[rule->when] |= READ | AGAIN;
        if (table->margins > 0) used[rule->margin] |= READ | AGAIN;
        if (rule->until >= 0) used[rule->until] |= AGAIN | (used[rule->until] & RELEASES ? READ : RELEASES);
    }
    for (Py_ssize_t i = 0; i < n; i++) {
        const Instruction *k = &placed[i].code;
        const int32_t size = KINDS[k->op].kind == ONE_BY_ONE ? k->n : 1;
        if (k->op >= LT && k->op <= NE && size == 1) registers->depth[k->dst] = (int32_t)i;
        else
            for (int32_t j = 0; j < size; j++) used[k->dst + j] |= READ | AGAIN;
    }
    for (Py_ssize_t i = 0; i < table->rules; i++) {
        const int32_t until = table->rule[i].until;
        if (until < 0 || used[until] != (WRITTEN | RELEASES | AGAIN)) continue;
        Placed *found = placed + registers->depth[until];
        found->depth = INT32_MAX;
        found->rule = (int32_t)i;
    }
}

/* Fuses a comparison with the only AND that needs it. */
static void fuse(const Registers *registers, Placed *placed, Py_ssize_t n) {
    for (Py_ssize_t i = 0; i < n; i++) {
        Instruction *k = &placed[i].code;
        if (k->op != AND || k->n != 1) continue;
        const int last = registers->used[k->b] == (WRITTEN | READ);
        const int32_t compared = last ? k->b : k->a, other = last ? k->a : k->b;
        if (registers->used[compared] != (WRITTEN | READ)) continue;
        Placed *from = placed + registers->depth[compared];
        if (from->code.op != LT && from->code.op != LE) continue;
        k->op = from->code.op == LT ? AND_LT : AND_LE;
        k->a = other;
        k->b = from->code.a;
        k->c = from->code.b;
        from->rule = FUSED;
        from->depth = INT32_MAX;
    }
}

/* Checks and sorts the instructions. */
static int table_code(Table *table, const Py_buffer *code) {
    const Py_ssize_t n = code->shape[0];
    Registers registers = {calloc((size_t)table->registers + 1, sizeof(int32_t)), calloc((size_t)table->registers + 1, 1)};
    Placed *placed = malloc((size_t)(n + 1) * sizeof(Placed));
    int done = -1;
    table->code = malloc((size_t)(n + 1) * sizeof(Instruction));
    table->run = malloc((size_t)(n + 1) * sizeof(Run));
    if (!registers.depth || !registers.used || !placed || !table->code || !table->run) {
        PyErr_NoMemory();
        goto end;
    }
    for (Py_ssize_t i = 0; i < n; i++)
        if (place_one(table, &registers, i, (const int32_t *)code->buf + 8 * i, placed + i) < 0) goto end;
    defer(table, &registers, placed, n);
    fuse(&registers, placed, n);
    qsort(placed, (size_t)n, sizeof(Placed), by_depth_and_kind);
    for (Py_ssize_t i = 0; i < n; i++) {
        if (placed[i].rule == FUSED) continue;
        table->code[i] = placed[i].code;
        const int single = placed[i].code.n == 1;
        if (placed[i].rule >= 0) {
            table->rule[placed[i].rule].release = (Run){placed[i].code.op, single, i, i + 1};
            continue;
        }
        const Run *last = i == 0 ? NULL : &table->run[table->runs - 1];
        if (!last || placed[i].depth != placed[i - 1].depth || placed[i].code.op != last->op || single != last->single)
            table->run[table->runs++] = (Run){placed[i].code.op, single, i, i};
        table->run[table->runs - 1].stop = i + 1;
    }
    table->instructions = n;
    done = 0;
end:
    free(registers.depth);
    free(registers.used);
    free(placed);
    return done;
}
