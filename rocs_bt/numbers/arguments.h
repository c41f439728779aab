/* What functions are given: numbers, and arrays through the buffer protocol, held to their sizes. */
#ifndef ROCS_NUMBERS_ARGUMENTS_H
#define ROCS_NUMBERS_ARGUMENTS_H
#include <Python.h>

enum { DEEPEST = 8, MOST = 64, NESTED = 100 }; /* dimensions of an array; detours, and others, of a string */

typedef struct {
    PyObject *hypot;
} State;

/* A number of a sequence's, or of an argument; -1.0 with an error set where it is none. */
static double number(PyObject *value) { return PyFloat_AsDouble(value); }

static int numbers(PyObject *sequence, double *out, Py_ssize_t count) {
    PyObject *fast = PySequence_Tuple(sequence);
    if (fast == NULL) return -1;
    int failed = PyTuple_Size(fast) != count;
    if (failed) PyErr_Format(PyExc_ValueError, "it takes %zd numbers, found %zd", count, PyTuple_Size(fast));
    for (Py_ssize_t i = 0; i < count && !failed; i++) {
        out[i] = number(PyTuple_GetItem(fast, i));
        failed = out[i] == -1.0 && PyErr_Occurred() != NULL;
    }
    Py_DECREF(fast);
    return failed ? -1 : 0;
}

static int wrong_count(Py_ssize_t count, Py_ssize_t wanted) {
    if (count == wanted) return 0;
    PyErr_Format(PyExc_TypeError, "it takes %zd arguments, found %zd", wanted, count);
    return 1;
}

/* Open an array of float64 with so many dimensions (0 for any), the last of which holds so many numbers (0 for any). */
static int opened(PyObject *array, Py_buffer *view, int dimensions, Py_ssize_t last, int flags) {
    if (PyObject_GetBuffer(array, view, PyBUF_FORMAT | PyBUF_STRIDES | flags) < 0) return -1;
    const int fits = dimensions == 0 ? view->ndim >= 1 && view->ndim <= DEEPEST : view->ndim == dimensions;
    if (view->format != NULL && view->format[0] == 'd' && view->format[1] == 0 && fits &&
        (last == 0 || view->shape[view->ndim - 1] == last))
        return 0;
    PyErr_Format(PyExc_ValueError, "it takes float64 with %d dimensions, found '%s' with %d", dimensions,
                 view->format ? view->format : "?", view->ndim);
    PyBuffer_Release(view);
    return -1;
}

#define AT(view, offset) (*(const double *)((const char *)(view).buf + (offset)))

/* On to the next element of an array's first dimensions, the last of them first. */
static void step_on(const Py_buffer *view, int dimensions, Py_ssize_t *index, Py_ssize_t *here) {
    for (int d = dimensions - 1; d >= 0; d--) {
        *here += view->strides[d];
        if (++index[d] < view->shape[d]) break;
        *here -= index[d] * view->strides[d];
        index[d] = 0;
    }
}

/* Open arrays of float64, all of so many dimensions as told, from a writable one on writable (-1 for none); -1 where one
 * does not fit, and then none is open. */
static int opened_all(PyObject *const *arrays, Py_buffer *views, int count, const int dimensions[], const Py_ssize_t lasts[], int writable) {
    for (int i = 0; i < count; i++) {
        const int flags = PyBUF_C_CONTIGUOUS | (writable >= 0 && i >= writable ? PyBUF_WRITABLE : 0);
        if (opened(arrays[i], &views[i], dimensions[i], lasts[i], flags) == 0) continue;
        while (i > 0) PyBuffer_Release(&views[--i]);
        return -1;
    }
    return 0;
}

static PyObject *closed_all(Py_buffer *views, int count, const char *wrong) {
    while (count > 0) PyBuffer_Release(&views[--count]);
    if (wrong == NULL) return Py_NewRef(Py_None);
    PyErr_SetString(PyExc_ValueError, wrong);
    return NULL;
}

#endif
