/* Temporal operations, on cells and rings of a state. */
#pragma once

#include "values.h"

static double held(double *cell, double a, double t, double window) {
    if (a == 0.0) {
        cell[0] = cell[1] = INFINITY;
        return 0.0;
    }
    if (cell[0] == INFINITY) cell[0] = t;
    if (INVALID(a)) cell[1] = INFINITY;
    else if (cell[1] == INFINITY) cell[1] = t;
    if (!(t - cell[0] >= window)) return 0.0;
    return t - cell[1] >= window ? 1.0 : NAN;
}

static double since(double *cell, double a, double b, double t, double window) {
    double sure = cell[0] == INFINITY ? t : cell[0], perhaps = cell[1] == INFINITY ? t : cell[1];
    if (b == 1.0) {
        sure = perhaps = INFINITY;
    } else {
        if (a != 1.0) sure = -INFINITY;
        if (INVALID(b)) perhaps = INFINITY;
        else if (a == 0.0) perhaps = -INFINITY;
    }
    cell[0] = sure;
    cell[1] = perhaps;
    if (t - sure < window) return 1.0;
    return t - perhaps < window ? NAN : 0.0;
}

static double ago(double *cell, double a, double t) {
    if (INVALID(a)) return NAN;
    if (a == 1.0) cell[0] = t;
    return t - cell[0];
}

typedef struct {
    double *pairs;
    int head, count, capacity;
} Ring;

static double *pair(const Ring *ring, int i) { return ring->pairs + 2 * ((ring->head + i) % ring->capacity); }

/* Opens the ring at a cell and drops the pairs that have left the window. */
static Ring opened(double *cell, int capacity, double t, double window) {
    Ring ring = {cell + 2, 0, 0, capacity};
    if (cell[0] >= 0.0 && cell[0] < capacity) ring.head = (int)cell[0];
    if (cell[1] >= 0.0 && cell[1] <= capacity) ring.count = (int)cell[1];
    while (ring.count >= 2 && t - pair(&ring, 1)[0] >= window) {
        ring.head = (ring.head + 1) % capacity;
        ring.count--;
    }
    return ring;
}

static double former(double old, double new) {
    (void)new;
    return old;
}

static void pushed(Ring *ring, double *cell, double t, double value, double grain, double (*join)(double, double)) {
    double *newest = pair(ring, ring->count + ring->capacity - 1);
    if (ring->count > 0 && t - newest[0] < grain) {
        newest[1] = join(newest[1], value);
    } else {
        newest = pair(ring, ring->count);
        newest[0] = t;
        newest[1] = value;
        if (ring->count < ring->capacity) ring->count++; /* false only for an invalid state */
    }
    cell[0] = ring->head;
    cell[1] = ring->count;
}

/* RATE, DELAY, LOWEST and SINCE_MARGIN; k contains window, grain, before. */
static double remembered(int op, double *cell, int capacity, double a, double b, double t, const double *k) {
    Ring ring = opened(cell, capacity, t, k[0]);
    double m;
    if (op == SINCE_MARGIN) {
        for (int i = 0; i < ring.count; i++) pair(&ring, i)[1] = worst(pair(&ring, i)[1], a);
        pushed(&ring, cell, t, b, k[1], best);
        m = -INFINITY;
        for (int i = 0; i < ring.count; i++) m = best(m, pair(&ring, i)[1]);
        return m;
    }
    pushed(&ring, cell, t, a, k[1], op == LOWEST ? worst : former);
    const double *oldest = pair(&ring, 0);
    int covered = t - oldest[0] >= k[0];
    if (op == DELAY) return covered ? oldest[1] : NAN;
    if (op == RATE) return covered ? (a - oldest[1]) / (t - oldest[0]) : NAN;
    m = covered ? oldest[1] : worst(k[2], oldest[1]);
    for (int i = 1; i < ring.count; i++) m = worst(m, pair(&ring, i)[1]);
    return m;
}
