/* Gaps between hulls and what is near (geometry.py, monitor/gaps.py, actions/give_way.py). */
#ifndef ROCS_NUMBERS_GAPS_H
#define ROCS_NUMBERS_GAPS_H
#include "arcs.h"

/* The lesser of two numbers, NaN if either is: as numpy's minimum. */
static double lesser(double a, double b) { return a < b || a != a ? a : b; }

/* Between a hull, a rectangle about a pose, and a circle at a point; negative: it is over the hull's edge. */
static int gap(PyObject *hypot, PyObject *pose, PyObject *point, const double half[2], double radius, double *found) {
    double here[3], there[2];
    if (numbers(pose, here, 3) < 0 || numbers(point, there, 2) < 0) return -1;
    const double c = cos(here[2]), s = sin(here[2]), dx = there[0] - here[0], dy = there[1] - here[1];
    const double ahead = fabs(c * dx + s * dy) - half[0], aside = fabs(c * dy - s * dx) - half[1];
    double away = aside > ahead ? aside : ahead; /* as Python's max: the first stands, NaN too */
    if (0.0 > away) away = 0.0;
    if (ahead > 0.0 && aside > 0.0 && (away = hypotenuse(hypot, ahead, aside)) < 0.0) return -1;
    *found = away - radius;
    return 0;
}

static PyObject *hull_gaps(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    double half[2];
    if (wrong_count(count, 4) || numbers(args[2], half, 2) < 0) return NULL;
    const double radius = number(args[3]);
    if (radius == -1.0 && PyErr_Occurred()) return NULL;
    PyObject *way = PySequence_Tuple(args[0]), *places = way == NULL ? NULL : PySequence_Tuple(args[1]), *found = NULL;
    if (places != NULL && PyTuple_Size(way) != PyTuple_Size(places))
        PyErr_SetString(PyExc_ValueError, "there must be as many places as poses");
    else if (places != NULL)
        found = PyList_New(PyTuple_Size(way));
    for (Py_ssize_t i = 0; found != NULL && i < PyTuple_Size(way); i++) {
        double apart = 0.0;
        PyObject *value = NULL;
        if (gap(((State *)PyModule_GetState(module))->hypot, PyTuple_GetItem(way, i), PyTuple_GetItem(places, i), half, radius, &apart) == 0)
            value = PyFloat_FromDouble(apart);
        if (value == NULL || PyList_SetItem(found, i, value) < 0) Py_CLEAR(found);
    }
    Py_XDECREF(way);
    Py_XDECREF(places);
    return found;
}

/* least_gaps(points, bearings, half, sectors): the least gap [m] on the left, on the right, and behind over its sector's
 * weight, between a hull and points (k, 2) of its frame; sectors (n, 2) are how far off the axis each ends, and its weight. */
static PyObject *least_gaps(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[3];
    double half[2], left = HUGE_VAL, right = HUGE_VAL, rear = HUGE_VAL;
    (void)module;
    if (wrong_count(count, 4) || numbers(args[2], half, 2) < 0) return NULL;
    PyObject *const arrays[] = {args[0], args[1], args[3]};
    if (opened_all(arrays, in, 3, (const int[]){2, 1, 2}, (const Py_ssize_t[]){2, 0, 2}, -1) < 0) return NULL;
    const Py_ssize_t many = in[0].shape[0], sectors = in[2].shape[0];
    if (in[1].shape[0] != many || sectors < 1) return closed_all(in, 3, "there must be a bearing for each point, and a sector");
    const double *point = in[0].buf, *bearing = in[1].buf, *sector = in[2].buf;
    for (Py_ssize_t i = 0; i < many; i++, point += 2) {
        const double ahead = fabs(point[0]) - half[0], aside = fabs(point[1]) - half[1], off = fabs(bearing[i]);
        const double gap_ = hypot(ahead < 0.0 ? 0.0 : ahead, aside < 0.0 ? 0.0 : aside), behind = PI - off;
        if (off <= 0.5 * PI && bearing[i] >= 0.0) left = lesser(gap_, left);
        if (off <= 0.5 * PI && !(bearing[i] >= 0.0)) right = lesser(gap_, right);
        if (!(behind <= sector[2 * (sectors - 1)])) continue;
        Py_ssize_t in_sector = 0;
        while (sector[2 * in_sector] < behind) in_sector++;
        rear = lesser(gap_ / sector[2 * in_sector + 1], rear);
    }
    Py_DECREF(closed_all(in, 3, NULL));
    return Py_BuildValue("ddd", left, right, rear);
}

/* nearest_moment(way, other): how near two ways (k, 3) come, each moment with its own. */
static PyObject *nearest_moment(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer way, other;
    (void)module;
    if (wrong_count(count, 2) || opened(args[0], &way, 2, 3, 0) < 0) return NULL;
    if (opened(args[1], &other, 2, 3, 0) < 0) {
        PyBuffer_Release(&way);
        return NULL;
    }
    double least = HUGE_VAL;
    const Py_ssize_t many = way.shape[0];
    const int fits = many > 0 && other.shape[0] == many;
    for (Py_ssize_t i = 0; i < many && fits; i++) {
        const Py_ssize_t a = i * way.strides[0], b = i * other.strides[0];
        const double away = hypot(AT(way, a) - AT(other, b), AT(way, a + way.strides[1]) - AT(other, b + other.strides[1]));
        least = lesser(away, least);
    }
    PyBuffer_Release(&other);
    PyBuffer_Release(&way);
    if (fits) return PyFloat_FromDouble(least);
    PyErr_SetString(PyExc_ValueError, "both ways must have as many moments, at least one");
    return NULL;
}

#endif
