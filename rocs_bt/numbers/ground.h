/* Squares of ground (monitor/free_ground.py). */
#ifndef ROCS_NUMBERS_GROUND_H
#define ROCS_NUMBERS_GROUND_H
#include <math.h>
#include "arguments.h"

/* The square of FreeGround that a point of a frame is in, counted row by row; -1 beyond the map. */
typedef struct {
    double x, y, c, s;
    Py_ssize_t size;
} Frame;

static Py_ssize_t square(const Frame *at, double x, double y) {
    const double ix = floor(at->x + at->c * x - at->s * y), iy = floor(at->y + at->s * x + at->c * y);
    if (!(ix >= 0.0 && iy >= 0.0 && ix < (double)at->size && iy < (double)at->size)) return -1;
    return (Py_ssize_t)ix * at->size + (Py_ssize_t)iy;
}

static int framed(PyObject *const *args, Frame *at, Py_buffer *map, int flags) {
    double given[4];
    if (numbers(args[1], given, 4) < 0 || opened(args[0], map, 2, 0, flags | PyBUF_C_CONTIGUOUS) < 0) return -1;
    *at = (Frame){given[0], given[1], given[2], given[3], map->shape[0]};
    if (map->shape[1] == at->size) return 0;
    PyErr_SetString(PyExc_ValueError, "the map must be a square");
    PyBuffer_Release(map);
    return -1;
}

/* mark_at(ground, frame, points, t): points are (k, 2). */
static PyObject *mark_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer map, points;
    Frame at;
    (void)module;
    if (wrong_count(count, 4)) return NULL;
    const double t = number(args[3]);
    if ((t == -1.0 && PyErr_Occurred()) || framed(args, &at, &map, PyBUF_WRITABLE) < 0) return NULL;
    const int failed = opened(args[2], &points, 2, 2, 0);
    if (!failed) {
        for (Py_ssize_t i = 0; i < points.shape[0]; i++) {
            const Py_ssize_t here = i * points.strides[0];
            const Py_ssize_t found = square(&at, AT(points, here), AT(points, here + points.strides[1]));
            if (found >= 0) ((double *)map.buf)[found] = t;
        }
        PyBuffer_Release(&points);
    }
    PyBuffer_Release(&map);
    return failed ? NULL : Py_NewRef(Py_None);
}

/* Whether all points (m, 2) of a stride are in squares of no earlier a time. */
static int known(const Py_buffer *map, const Frame *at, const Py_buffer *ways, Py_ssize_t here, double since) {
    for (Py_ssize_t i = 0; i < ways->shape[2]; i++, here += ways->strides[2]) {
        const Py_ssize_t place = square(at, AT(*ways, here), AT(*ways, here + ways->strides[3]));
        if (place < 0 || !(((const double *)map->buf)[place] >= since)) return 0;
    }
    return 1;
}

/* strides_at(ground, frame, ways, since): of ways (n, k, m, 2) how many strides are known to be free. */
static PyObject *strides_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer map, ways;
    Frame at;
    PyObject *found = NULL;
    (void)module;
    if (wrong_count(count, 4)) return NULL;
    const double since = number(args[3]);
    if ((since == -1.0 && PyErr_Occurred()) || framed(args, &at, &map, 0) < 0) return NULL;
    if (opened(args[2], &ways, 4, 2, 0) == 0) {
        found = PyList_New(ways.shape[0]);
        for (Py_ssize_t i = 0; i < ways.shape[0] && found != NULL; i++) {
            Py_ssize_t free = 0, here = i * ways.strides[0];
            for (; free < ways.shape[1] && known(&map, &at, &ways, here, since); free++) here += ways.strides[1];
            PyObject *strides = PyLong_FromSsize_t(free);
            if (strides == NULL || PyList_SetItem(found, i, strides) < 0) Py_CLEAR(found);
        }
        PyBuffer_Release(&ways);
    }
    PyBuffer_Release(&map);
    return found;
}

#endif
