/* Things that move and are seen (control/motion_filter.py). */
#ifndef ROCS_NUMBERS_TRACKS_H
#define ROCS_NUMBERS_TRACKS_H
#include <math.h>
#include <string.h>
#include "arcs.h"

/* Python's x ** 2 is the library's pow, whose last digit is not always that of x * x; compilers would fold it. */
static double squared(double x) {
    static const volatile double two = 2.0;
    return pow(x, two);
}

/* sin(w dt) / w and (1 - cos(w dt)) / w, and their derivatives by w; the limits where w vanishes. */
static void turned(double w, double dt, double found[4]) {
    const double angle = w * dt;
    if (fabs(angle) < 1e-4) {
        found[0] = dt;
        found[1] = 0.5 * angle * dt;
        found[2] = -angle * dt * dt / 3.0;
        found[3] = 0.5 * dt * dt;
        return;
    }
    const double c = cos(angle), s = sin(angle);
    found[0] = s / w;
    found[1] = (1.0 - c) / w;
    found[2] = (angle * c - s) / squared(w);
    found[3] = (angle * s - 1.0 + c) / squared(w);
}

/* turn_on(state, dt, kept, moved, slope): (5,), (5,) and (5, 5). */
static PyObject *turn_on(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[3];
    double t[4];
    (void)module;
    if (wrong_count(count, 5)) return NULL;
    const double dt = number(args[1]), kept = number(args[2]);
    PyObject *const arrays[] = {args[0], args[3], args[4]};
    if (PyErr_Occurred() || opened_all(arrays, in, 3, (const int[]){1, 1, 2}, (const Py_ssize_t[]){5, 5, 5}, 1) < 0) return NULL;
    if (in[2].shape[0] != 5) return closed_all(in, 3, "a slope has five rows");
    const double *state = in[0].buf, vx = state[2], vy = state[3], w = state[4], c = cos(w * dt), s = sin(w * dt);
    turned(w, dt, t);
    const double moved[] = {state[0] + t[0] * vx - t[1] * vy, state[1] + t[1] * vx + t[0] * vy, c * vx - s * vy, s * vx + c * vy, kept * w};
    const double slope[] = {
        1.0, 0.0, t[0], -t[1], t[2] * vx - t[3] * vy,
        0.0, 1.0, t[1], t[0], t[3] * vx + t[2] * vy,
        0.0, 0.0, c, -s, -dt * (s * vx + c * vy),
        0.0, 0.0, s, c, dt * (c * vx - s * vy),
        0.0, 0.0, 0.0, 0.0, kept,
    };
    memcpy(in[1].buf, moved, sizeof moved);
    memcpy(in[2].buf, slope, sizeof slope);
    return closed_all(in, 3, NULL);
}

/* sight(state, observer, distance, bearing, slope, error): (5,), (2, 5) and (2,); whether there is a direction. */
static PyObject *sight(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[3];
    double here[3];
    if (wrong_count(count, 6) || numbers(args[1], here, 3) < 0) return NULL;
    const double distance = number(args[2]), bearing = number(args[3]);
    PyObject *const arrays[] = {args[0], args[4], args[5]};
    if (PyErr_Occurred() || opened_all(arrays, in, 3, (const int[]){1, 2, 1}, (const Py_ssize_t[]){5, 5, 2}, 1) < 0) return NULL;
    if (in[1].shape[0] != 2) return closed_all(in, 3, "a slope has two rows");
    const double *state = in[0].buf, dx = state[0] - here[0], dy = state[1] - here[1];
    const double expected = hypotenuse(((State *)PyModule_GetState(module))->hypot, dx, dy);
    if (!(expected < 1e-6)) {
        const double slope[] = {dx / expected, dy / expected, 0.0, 0.0, 0.0, -dy / squared(expected), dx / squared(expected), 0.0, 0.0, 0.0};
        memcpy(in[1].buf, slope, sizeof slope);
        ((double *)in[2].buf)[0] = distance - expected;
        ((double *)in[2].buf)[1] = wrapped(bearing - wrapped(atan2(dy, dx) - here[2]));
    }
    Py_DECREF(closed_all(in, 3, NULL));
    return expected < 0.0 ? NULL : PyBool_FromLong(!(expected < 1e-6));
}

/* inverse(matrix, found): of (2, 2). */
static PyObject *inverse(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[2];
    (void)module;
    if (wrong_count(count, 2) || opened_all(args, in, 2, (const int[]){2, 2}, (const Py_ssize_t[]){2, 2}, 1) < 0) return NULL;
    if (in[0].shape[0] != 2 || in[1].shape[0] != 2) return closed_all(in, 2, "a matrix has two rows");
    const double *m = in[0].buf, scale = 1.0 / (m[0] * m[3] - m[1] * m[2]);
    const double found[] = {scale * m[3], -scale * m[1], -scale * m[2], scale * m[0]};
    memcpy(in[1].buf, found, sizeof found);
    return closed_all(in, 2, NULL);
}

#endif
