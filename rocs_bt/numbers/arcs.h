/* Poses that move on arcs (geometry.py, control/ways.py), and how long is a way between two points. */
#ifndef ROCS_NUMBERS_ARCS_H
#define ROCS_NUMBERS_ARCS_H
#include <float.h>
#include <math.h>
#include "arguments.h"

static const double PI = 3.14159265358979323846;

static double wrapped(double angle) {
    const double within = remainder(angle, 2.0 * PI);
    return within == -PI ? PI : within;
}

/* wrap_angle(angle): in (-pi, pi]. */
static PyObject *wrap_angle(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    (void)module;
    if (wrong_count(count, 1)) return NULL;
    const double angle = number(args[0]);
    if (angle == -1.0 && PyErr_Occurred()) return NULL;
    if (isinf(angle)) {
        PyErr_SetString(PyExc_ValueError, "math domain error");
        return NULL;
    }
    return PyFloat_FromDouble(wrapped(angle));
}

/* The lesser of two numbers, NaN if either is: as numpy's minimum. */
static double lesser(double a, double b) { return a < b || a != a ? a : b; }

/* sin(a) / a and (1 - cos(a)) / a, whose limits at zero are 1 and 0. */
static void chords(double angle, double *along, double *across) {
    *along = 1.0;
    *across = 0.0;
    if (fabs(angle) > 1e-9) {
        *along = sin(angle) / angle;
        *across = (1.0 - cos(angle)) / angle;
    }
}

static PyObject *pair(double x, double y) {
    PyObject *first = PyFloat_FromDouble(x), *second = PyFloat_FromDouble(y), *both = NULL;
    if (first != NULL && second != NULL) both = PyTuple_Pack(2, first, second);
    Py_XDECREF(first);
    Py_XDECREF(second);
    return both;
}

/* Where a constant twist leads in some whiles: the positions alone, or the poses. */
static PyObject *arc_of(PyObject *const *args, Py_ssize_t count, int poses) {
    double pose[3], twist[3];
    if (wrong_count(count, 3) || numbers(args[0], pose, 3) < 0 || numbers(args[1], twist, 3) < 0) return NULL;
    PyObject *whiles = PySequence_Tuple(args[2]);
    if (whiles == NULL) return NULL;
    const Py_ssize_t many = PyTuple_Size(whiles);
    const double c = cos(pose[2]), s = sin(pose[2]);
    PyObject *found = PyList_New(many);
    for (Py_ssize_t i = 0; i < many && found != NULL; i++) {
        const double duration = number(PyTuple_GetItem(whiles, i)), angle = twist[1] * duration;
        double along, across;
        chords(angle, &along, &across);
        const double ahead = twist[0] * duration, aside = twist[2] * duration;
        const double dx = along * ahead - across * aside, dy = across * ahead + along * aside;
        const double x = pose[0] + c * dx - s * dy, y = pose[1] + s * dx + c * dy;
        PyObject *place = NULL;
        if (!(duration == -1.0 && PyErr_Occurred())) place = poses ? Py_BuildValue("ddd", x, y, wrapped(pose[2] + angle)) : pair(x, y);
        if (place == NULL || PyList_SetItem(found, i, place) < 0) Py_CLEAR(found);
    }
    Py_DECREF(whiles);
    return found;
}

static PyObject *arc_positions(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    (void)module;
    return arc_of(args, count, 0);
}

static PyObject *arc_poses(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    (void)module;
    return arc_of(args, count, 1);
}

/* About as far: exact enough to tell two lengths apart that differ by more than a billionth, and by what underflows. */
static double roughly(double x, double y) { return sqrt(x * x + y * y); }

/* Whether one length is surely less than another, of which at least one was found roughly. */
static int surely_less(double one, double other) { return one < other * (1.0 - 1e-9) - 1e-100; }

/* math.hypot, as Python rounds it; negative with an error set where it cannot be. */
static double hypotenuse(PyObject *function, double x, double y) {
    double result = -1.0;
    PyObject *both = pair(x, y), *found = both == NULL ? NULL : PyObject_Call(function, both, NULL);
    if (found != NULL) result = PyFloat_AsDouble(found);
    Py_XDECREF(both);
    Py_XDECREF(found);
    return result;
}

/* along_at(motions, durations, found): motions are p of x, y, yaw, forward, turn, left; the others (p, k) and (p, k, 3). */
static PyObject *along_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer durations, found;
    (void)module;
    if (wrong_count(count, 3) || opened(args[1], &durations, 2, 0, PyBUF_C_CONTIGUOUS) < 0) return NULL;
    int failed = opened(args[2], &found, 3, 3, PyBUF_WRITABLE | PyBUF_C_CONTIGUOUS) < 0;
    if (!failed) {
        const Py_ssize_t many = durations.shape[0], moments = durations.shape[1];
        const double *duration = durations.buf;
        double *out = found.buf, m[6];
        if ((failed = found.shape[0] != many || found.shape[1] != moments || PySequence_Size(args[0]) != many))
            PyErr_SetString(PyExc_ValueError, "there must be as many durations, and as much room, as motions");
        for (Py_ssize_t i = 0; i < many && !failed; i++) {
            PyObject *motion = PySequence_GetItem(args[0], i);
            failed = motion == NULL || numbers(motion, m, 6) < 0;
            Py_XDECREF(motion);
            for (Py_ssize_t k = 0; k < moments && !failed; k++, out += 3, duration++) {
                const double half = 0.5 * m[4] * *duration, middle = m[2] + half;
                double angle = PI * (half / PI);
                if (angle == 0.0) angle = DBL_EPSILON;
                const double chord = *duration * (sin(angle) / angle), c = chord * cos(middle), s = chord * sin(middle);
                out[0] = m[0] + m[3] * c - m[5] * s;
                out[1] = m[1] + m[3] * s + m[5] * c;
                out[2] = middle + half;
            }
        }
        PyBuffer_Release(&found);
    }
    PyBuffer_Release(&durations);
    return failed ? NULL : Py_NewRef(Py_None);
}

#endif
