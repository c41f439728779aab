/* A string that pulls a robot (actions/give_way.py). */
#ifndef ROCS_NUMBERS_STRINGS_H
#define ROCS_NUMBERS_STRINGS_H
#include "arcs.h"

typedef struct {
    PyObject *hypot;
    double length, stride, keep_off, look;
    const double *detours;
    Py_ssize_t many;
    const Py_buffer *others;
    Py_ssize_t crowd;
} String;

/* Whether a step comes not too near to anybody at a moment, or at least no nearer; -1 for an error. */
static int clear(const String *string, Py_ssize_t moment, double x, double y, double to_x, double to_y) {
    for (Py_ssize_t i = 0; i < string->crowd; i++) {
        const Py_buffer *other = &string->others[i];
        const Py_ssize_t here = moment * other->strides[0];
        const double at_x = AT(*other, here), at_y = AT(*other, here + other->strides[1]);
        if (surely_less(string->keep_off, roughly(to_x - at_x, to_y - at_y))) continue;
        const double apart = hypotenuse(string->hypot, to_x - at_x, to_y - at_y);
        if (apart < 0.0) return -1;
        if (apart >= string->keep_off) continue;
        const double before = hypotenuse(string->hypot, x - at_x, y - at_y);
        if (before < 0.0) return -1;
        if (!(apart >= before)) return 0;
    }
    return 1;
}

/* Where the string takes the robot in the next step: at is x, y and yaw. */
static int follow(const String *string, const Py_buffer *leader, Py_ssize_t moment, double at[3]) {
    const Py_ssize_t here = moment * leader->strides[0];
    const double dx = AT(*leader, here) - at[0], dy = AT(*leader, here + leader->strides[1]) - at[1];
    const double rough = roughly(dx, dy);
    double step = string->stride;
    if (surely_less(rough, string->length)) return 0;
    if (!surely_less(string->length + string->stride, rough)) { /* else it is a whole stride */
        const double away = hypotenuse(string->hypot, dx, dy);
        if (away < 0.0) return -1;
        if (!(away > string->length)) return 0;
        if (!(string->stride < away - string->length)) step = away - string->length;
    }
    const double heading = atan2(dy, dx);
    for (Py_ssize_t i = 0; i < string->many; i++) {
        const double angle = heading + string->detours[i], c = cos(angle), s = sin(angle);
        const int free_way =
            clear(string, moment, at[0], at[1], at[0] + string->look * c, at[1] + string->look * s);
        if (free_way < 0) return -1;
        if (free_way) {
            at[0] += step * c;
            at[1] += step * s;
            at[2] = angle;
            break;
        }
    }
    return 0;
}

/* pull(way, pose, leader, others, detours, (length, stride, keep_off, look)): fills the way (k, 3). */
static PyObject *pull(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer way, leader, *others;
    double at[3], limits[4], detours[MOST];
    if (wrong_count(count, 6) || numbers(args[1], at, 3) < 0 || numbers(args[5], limits, 4) < 0) return NULL;
    const Py_ssize_t many = PySequence_Size(args[4]), crowd = PySequence_Size(args[3]);
    if (many < 0 || crowd < 0) return NULL;
    if (many > MOST) return PyErr_Format(PyExc_ValueError, "it takes at most %d detours", MOST);
    if (numbers(args[4], detours, many) < 0 || opened(args[0], &way, 2, 3, PyBUF_WRITABLE | PyBUF_C_CONTIGUOUS) < 0) return NULL;
    if ((others = PyMem_Calloc((size_t)crowd + 1, sizeof *others)) == NULL) {
        PyBuffer_Release(&way);
        return PyErr_NoMemory();
    }
    int failed = opened(args[2], &leader, 2, 3, 0) < 0;
    const int led = !failed;
    Py_ssize_t open_ones = 0;
    for (; open_ones < crowd && !failed; open_ones++) {
        PyObject *other = PySequence_GetItem(args[3], open_ones);
        failed = other == NULL || opened(other, &others[open_ones], 2, 3, 0) < 0;
        Py_XDECREF(other);
        if (failed) break;
        if (others[open_ones].shape[0] < way.shape[0]) failed = 1, PyErr_SetString(PyExc_ValueError, "another's way is shorter");
    }
    if (!failed && leader.shape[0] < way.shape[0]) failed = 1, PyErr_SetString(PyExc_ValueError, "the leader's way is shorter");
    const String string = {((State *)PyModule_GetState(module))->hypot, limits[0], limits[1], limits[2], limits[3], detours, many, others, crowd};
    for (Py_ssize_t moment = 0; moment < way.shape[0] && !failed; moment++) {
        failed = moment > 0 && follow(&string, &leader, moment, at) < 0;
        for (int i = 0; i < 3; i++) ((double *)way.buf)[3 * moment + i] = at[i];
    }
    while (open_ones > 0) PyBuffer_Release(&others[--open_ones]);
    PyMem_Free(others);
    if (led) PyBuffer_Release(&leader);
    PyBuffer_Release(&way);
    return failed ? NULL : Py_NewRef(Py_None);
}

#endif
