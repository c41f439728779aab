/* Signals and readings (knowledge/signals.py, event.py, record/codec.py, drivers/mujoco/sensors.py). */
#ifndef ROCS_NUMBERS_SIGNALS_H
#define ROCS_NUMBERS_SIGNALS_H
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "arguments.h"

/* Whether numbers keep their bounds: of each run of them (low, high, from, to) the least and the greatest count, as
 * Python's min and max find them. A NaN hides behind what comes before it. */
static int bounded(const double *values, Py_ssize_t many, const Py_buffer *bounds) {
    const double *run = bounds->buf;
    for (Py_ssize_t i = 0; i < bounds->shape[0]; i++, run += 4) {
        const Py_ssize_t first = (Py_ssize_t)run[2], last = (Py_ssize_t)run[3];
        if (!(0 <= first && first < last && last <= many)) return 0;
        double least = values[first], most = least;
        for (Py_ssize_t k = first + 1; k < last; k++) {
            if (values[k] < least) least = values[k];
            if (values[k] > most) most = values[k];
        }
        if (!(run[0] <= least && most <= run[1])) return 0;
    }
    return 1;
}

/* The numbers of lists of these sizes one after the other; 0 where they are others, or no numbers. */
static int flattened(PyObject *lists, PyObject *sizes, double *out, Py_ssize_t room) {
    const Py_ssize_t many = PyTuple_Size(lists);
    if (many != PyTuple_Size(sizes)) return 0;
    for (Py_ssize_t i = 0; i < many; i++) {
        PyObject *list = PyTuple_GetItem(lists, i);
        const Py_ssize_t size = PyLong_AsSsize_t(PyTuple_GetItem(sizes, i));
        if (!PyList_CheckExact(list) || PyList_Size(list) != size || size > room) return 0;
        room -= size;
        for (Py_ssize_t k = 0; k < size; k++, out++) {
            *out = PyFloat_AsDouble(PyList_GetItem(list, k));
            if (*out == -1.0 && PyErr_Occurred()) return 0;
        }
    }
    return room == 0;
}

/* fill(target, expires, until, values, sizes, bounds): what was filled in, or None where that needs a closer look. */
static PyObject *fill(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer target, expires, bounds;
    PyObject *found = NULL;
    (void)module;
    if (wrong_count(count, 6)) return NULL;
    const double until = number(args[2]);
    if ((until == -1.0 && PyErr_Occurred()) || opened(args[0], &target, 1, 0, PyBUF_WRITABLE | PyBUF_C_CONTIGUOUS) < 0) return NULL;
    const Py_ssize_t room = target.shape[0];
    double *values = malloc(sizeof(double) * (size_t)(room + 1));
    PyObject *lists = values == NULL ? PyErr_NoMemory() : PySequence_Tuple(args[3]);
    int opened_ones = lists != NULL && opened(args[1], &expires, 1, room, PyBUF_WRITABLE | PyBUF_C_CONTIGUOUS) == 0;
    if (opened_ones && opened(args[5], &bounds, 2, 4, PyBUF_C_CONTIGUOUS) == 0) opened_ones = 2;
    if (opened_ones == 2 && !PyTuple_Check(args[4])) {
        PyErr_SetString(PyExc_TypeError, "the sizes must be a tuple");
    } else if (opened_ones == 2 && flattened(lists, args[4], values, room) && bounded(values, room, &bounds)) {
        memcpy(target.buf, values, sizeof(double) * (size_t)room);
        for (Py_ssize_t i = 0; i < room; i++) ((double *)expires.buf)[i] = until;
        found = PyBytes_FromStringAndSize((const char *)values, (Py_ssize_t)sizeof(double) * room);
    } else if (opened_ones == 2) {
        int doubtful = PyErr_Occurred() == NULL;
        PyObject *const wrong[] = {PyExc_TypeError, PyExc_ValueError, PyExc_OverflowError};
        for (int i = 0; i < 3 && !doubtful; i++) doubtful = PyErr_ExceptionMatches(wrong[i]);
        if (doubtful) { /* whoever looks closer tells what is wrong */
            PyErr_Clear();
            found = Py_NewRef(Py_None);
        }
    }
    if (opened_ones == 2) PyBuffer_Release(&bounds);
    if (opened_ones) PyBuffer_Release(&expires);
    Py_XDECREF(lists);
    free(values);
    PyBuffer_Release(&target);
    return found;
}

/* pack(values): as bytes. */
static PyObject *pack(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    (void)module;
    if (wrong_count(count, 1)) return NULL;
    PyObject *values = PySequence_Tuple(args[0]);
    if (values == NULL) return NULL;
    const Py_ssize_t many = PyTuple_Size(values);
    PyObject *packed = PyBytes_FromStringAndSize(NULL, (Py_ssize_t)sizeof(double) * many);
    for (Py_ssize_t i = 0; i < many && packed != NULL; i++) {
        const double value = number(PyTuple_GetItem(values, i));
        if (value == -1.0 && PyErr_Occurred()) Py_CLEAR(packed);
        else memcpy(PyBytes_AsString(packed) + sizeof(double) * (size_t)i, &value, sizeof value);
    }
    Py_DECREF(values);
    return packed;
}

/* Whether no NaN and no infinity is in a value; not for what only a closer look can tell either. */
static int all_finite(PyObject *value, int depth) {
    if (PyFloat_CheckExact(value)) return isfinite(PyFloat_AsDouble(value));
    if (value == Py_None || PyUnicode_CheckExact(value) || PyBytes_CheckExact(value) || PyLong_CheckExact(value) || PyBool_Check(value)) return 1;
    if (depth == 0) return 0;
    if (PyList_CheckExact(value)) {
        for (Py_ssize_t i = 0; i < PyList_Size(value); i++)
            if (!all_finite(PyList_GetItem(value, i), depth - 1)) return 0;
        return 1;
    }
    if (PyTuple_CheckExact(value)) {
        for (Py_ssize_t i = 0; i < PyTuple_Size(value); i++)
            if (!all_finite(PyTuple_GetItem(value, i), depth - 1)) return 0;
        return 1;
    }
    if (PyDict_CheckExact(value)) {
        PyObject *key, *inner;
        Py_ssize_t at = 0;
        while (PyDict_Next(value, &at, &key, &inner))
            if (!all_finite(inner, depth - 1)) return 0;
        return 1;
    }
    return 0;
}

static PyObject *finite_all(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    (void)module;
    return wrong_count(count, 1) ? NULL : PyBool_FromLong(all_finite(args[0], NESTED));
}

/* valid(values, expires, t, out): a copy, NaN where it has expired. */
static PyObject *valid(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[3];
    (void)module;
    if (wrong_count(count, 4)) return NULL;
    PyObject *const arrays[] = {args[0], args[1], args[3]};
    const double t = number(args[2]);
    if ((t == -1.0 && PyErr_Occurred()) || opened_all(arrays, in, 3, (const int[]){1, 1, 1}, (const Py_ssize_t[]){0, 0, 0}, 2) < 0) return NULL;
    const Py_ssize_t many = in[0].shape[0];
    if (in[1].shape[0] != many || in[2].shape[0] != many) return closed_all(in, 3, "the arrays must be of one size");
    const double *value = in[0].buf, *until = in[1].buf;
    for (Py_ssize_t i = 0; i < many; i++) ((double *)in[2].buf)[i] = until[i] < t ? Py_NAN : value[i];
    return closed_all(in, 3, NULL);
}

/* least_echoes(rays, each): the least of each so many rays, infinity for those that are negative. */
static PyObject *least_echoes(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer rays;
    (void)module;
    if (wrong_count(count, 2)) return NULL;
    const Py_ssize_t each = PyLong_AsSsize_t(args[1]);
    if (PyErr_Occurred() || opened(args[0], &rays, 1, 0, PyBUF_C_CONTIGUOUS) < 0) return NULL;
    const Py_ssize_t many = each > 0 ? rays.shape[0] / each : 0;
    PyObject *found = NULL;
    if (each <= 0 || many * each != rays.shape[0]) PyErr_SetString(PyExc_ValueError, "the rays do not part evenly");
    else found = PyList_New(many);
    const double *ray = rays.buf;
    for (Py_ssize_t i = 0; i < many && found != NULL; i++) {
        double least = HUGE_VAL;
        for (Py_ssize_t k = 0; k < each; k++, ray++)
            if ((*ray >= 0.0 && *ray < least) || *ray != *ray) least = *ray;
        PyObject *value = PyFloat_FromDouble(least);
        if (value == NULL || PyList_SetItem(found, i, value) < 0) Py_CLEAR(found);
    }
    PyBuffer_Release(&rays);
    return found;
}

#endif
