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

/* known_at(ground, frame, points, since, found): found (...) is filled for points (..., 2). */
static PyObject *known_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer map, points, found;
    Frame at;
    (void)module;
    if (wrong_count(count, 5)) return NULL;
    const double since = number(args[3]);
    if ((since == -1.0 && PyErr_Occurred()) || framed(args, &at, &map, 0) < 0) return NULL;
    int failed = opened(args[2], &points, 0, 2, 0) < 0;
    if (!failed && (failed = PyObject_GetBuffer(args[4], &found, PyBUF_WRITABLE | PyBUF_C_CONTIGUOUS) < 0)) PyBuffer_Release(&points);
    if (!failed) {
        const int depth = points.ndim - 1;
        Py_ssize_t index[DEEPEST] = {0}, here = 0, many = 1;
        for (int d = 0; d < depth; d++) many *= points.shape[d];
        failed = found.itemsize != 1 || found.len != many;
        if (failed) PyErr_Format(PyExc_ValueError, "there are %zd points, found room for %zd", many, found.len);
        for (Py_ssize_t i = 0; i < many && !failed; i++) {
            const Py_ssize_t place = square(&at, AT(points, here), AT(points, here + points.strides[depth]));
            ((char *)found.buf)[i] = place >= 0 && ((const double *)map.buf)[place] >= since;
            step_on(&points, depth, index, &here);
        }
        PyBuffer_Release(&found);
        PyBuffer_Release(&points);
    }
    PyBuffer_Release(&map);
    return failed ? NULL : Py_NewRef(Py_None);
}

#endif
