/* Paths and timetables (control/path.py, grid.py, profile.py, reference.py). */
#ifndef ROCS_NUMBERS_PATHS_H
#define ROCS_NUMBERS_PATHS_H
#include <math.h>
#include "arcs.h"

/* within(values, limit): whether all of an array (...) are numbers, and no farther from zero than a limit. */
static PyObject *within(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer values;
    (void)module;
    if (wrong_count(count, 2)) return NULL;
    const double limit = number(args[1]);
    if ((limit == -1.0 && PyErr_Occurred()) || opened(args[0], &values, 0, 0, 0) < 0) return NULL;
    Py_ssize_t index[DEEPEST] = {0}, here = 0, many = values.len / values.itemsize;
    int all = 1;
    for (; many > 0 && all; many--) {
        all = fabs(AT(values, here)) <= limit;
        step_on(&values, values.ndim, index, &here);
    }
    PyBuffer_Release(&values);
    return PyBool_FromLong(all);
}

/* rows_at(rows, slopes, steps, found): rows and slopes are (n, c), steps (k,) and found (k, c). */
static PyObject *rows_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[4];
    (void)module;
    if (wrong_count(count, 4) || opened_all(args, in, 4, (const int[]){2, 2, 1, 2}, (const Py_ssize_t[]){0, 0, 0, 0}, 3) < 0) return NULL;
    const Py_ssize_t rows = in[0].shape[0], width = in[0].shape[1], many = in[2].shape[0];
    if (rows < 1 || in[1].shape[0] != rows || in[1].shape[1] != width || in[3].shape[0] != many || in[3].shape[1] != width)
        return closed_all(in, 4, "rows, slopes and room must fit each other");
    const double *row = in[0].buf, *slope = in[1].buf, *step = in[2].buf;
    double *found = in[3].buf;
    for (Py_ssize_t i = 0; i < many; i++) {
        double at = step[i] > 0.0 ? step[i] : 0.0;
        if (at > (double)(rows - 1)) at = (double)(rows - 1);
        if (step[i] != step[i]) return closed_all(in, 4, "a place is no number");
        const Py_ssize_t cell = (Py_ssize_t)at;
        const double part = at - (double)cell;
        for (Py_ssize_t c = 0; c < width; c++) *found++ = row[cell * width + c] + part * slope[cell * width + c];
    }
    return closed_all(in, 4, NULL);
}

/* The place of a number among ascending ones: before those that equal it, or after. */
static Py_ssize_t place(const double *numbers_, Py_ssize_t many, double number_, int after) {
    Py_ssize_t low = 0, high = many;
    while (low < high) {
        const Py_ssize_t middle = low + (high - low) / 2;
        if (numbers_[middle] < number_ || (after && numbers_[middle] == number_)) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* Between ascending numbers linear, held beyond: as numpy's interp, to the bit. */
static double between(const double *xs, const double *ys, Py_ssize_t many, double x) {
    const Py_ssize_t cell = place(xs, many, x, 1) - 1;
    if (x != x) return x;
    if (cell < 0) return ys[0];
    if (cell >= many - 1 || xs[cell] == x) return ys[cell];
    const double slope = (ys[cell + 1] - ys[cell]) / (xs[cell + 1] - xs[cell]);
    return slope * (x - xs[cell]) + ys[cell];
}

/* stations_at((stations, squared, passed), (s, speed, limit, acceleration), times, found): three times (n,), twice (k,). */
static PyObject *stations_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[5];
    double begin[4];
    (void)module;
    if (wrong_count(count, 4) || numbers(args[1], begin, 4) < 0) return NULL;
    if (!PyTuple_Check(args[0]) || PyTuple_Size(args[0]) != 3) {
        PyErr_SetString(PyExc_TypeError, "a profile is a tuple of three arrays");
        return NULL;
    }
    PyObject *const arrays[] = {PyTuple_GetItem(args[0], 0), PyTuple_GetItem(args[0], 1), PyTuple_GetItem(args[0], 2), args[2], args[3]};
    if (opened_all(arrays, in, 5, (const int[]){1, 1, 1, 1, 1}, (const Py_ssize_t[]){0, 0, 0, 0, 0}, 4) < 0) return NULL;
    const Py_ssize_t rows = in[0].shape[0], many = in[3].shape[0];
    if (rows < 1 || in[1].shape[0] != rows || in[2].shape[0] != rows || in[4].shape[0] != many)
        return closed_all(in, 5, "the arrays of a profile, and times and room, must fit each other");
    const double *stations = in[0].buf, *squared = in[1].buf, *passed = in[2].buf, *times = in[3].buf;
    const double speed = begin[1], limit = begin[2], acceleration = begin[3];
    double *found = in[4].buf, start = begin[0], since = 0.0;
    Py_ssize_t first = 0;
    for (; speed < limit && first < many; first++) { /* as long as it may gain speed */
        const double gained = speed + acceleration * times[first], free = begin[0] + 0.5 * (speed + gained) * times[first];
        if (gained > sqrt(between(stations, squared, rows, free))) break;
        found[first] = start = free;
        since = times[first];
    }
    const double begun = between(stations, passed, rows, start) - since;
    for (; first < many; first++) found[first] = between(passed, stations, rows, begun + times[first]);
    return closed_all(in, 5, NULL);
}

/* path_stages(rows, (turn, speed, acceleration), times, stages): (k, 5), (k,) and (k, 6). */
static PyObject *path_stages(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[3];
    double given[3];
    (void)module;
    if (wrong_count(count, 4) || numbers(args[1], given, 3) < 0) return NULL;
    PyObject *const arrays[] = {args[0], args[2], args[3]};
    if (opened_all(arrays, in, 3, (const int[]){2, 1, 2}, (const Py_ssize_t[]){5, 0, 6}, 2) < 0) return NULL;
    const Py_ssize_t many = in[1].shape[0];
    if (in[0].shape[0] != many || in[2].shape[0] != many) return closed_all(in, 3, "rows, times and stages must fit each other");
    const double *row = in[0].buf, *times = in[1].buf;
    double *stage = in[2].buf;
    for (Py_ssize_t i = 0; i < many; i++, row += 5, stage += 6) {
        const double speed = lesser(sqrt(row[4]), given[1] + given[2] * times[i]);
        stage[0] = row[0];
        stage[1] = row[1];
        stage[2] = row[2] + given[0];
        stage[3] = speed;
        stage[4] = 0.0;
        stage[5] = speed * row[3];
    }
    return closed_all(in, 3, NULL);
}

/* timed_stages(times, since, begin, velocity, at, stages): (m,), (m + 1,), twice (m + 1, 3), (k,) and (k, 6). */
static PyObject *timed_stages(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[6];
    (void)module;
    if (wrong_count(count, 6) || opened_all(args, in, 6, (const int[]){1, 1, 2, 2, 1, 2}, (const Py_ssize_t[]){0, 0, 3, 3, 0, 6}, 5) < 0) return NULL;
    const Py_ssize_t rows = in[0].shape[0] + 1, many = in[4].shape[0];
    if (in[1].shape[0] != rows || in[2].shape[0] != rows || in[3].shape[0] != rows || in[5].shape[0] != many)
        return closed_all(in, 6, "times, rows and stages must fit each other");
    const double *times = in[0].buf, *since = in[1].buf, *begin = in[2].buf, *velocity = in[3].buf, *at = in[4].buf;
    double *stage = in[5].buf;
    for (Py_ssize_t i = 0; i < many; i++, stage += 6) {
        if (at[i] != at[i]) return closed_all(in, 6, "a time is no number");
        const Py_ssize_t row = place(times, rows - 1, at[i], 1);
        const double passed = at[i] - since[row];
        for (int c = 0; c < 3; c++) stage[c] = velocity[3 * row + c] * passed + begin[3 * row + c];
        const double *v = velocity + 3 * place(times, rows - 1, at[i], 0), c = cos(stage[2]), s = sin(stage[2]);
        stage[3] = c * v[0] + s * v[1];
        stage[4] = c * v[1] - s * v[0];
        stage[5] = v[2];
    }
    return closed_all(in, 6, NULL);
}

/* timed_lines(times, poses, since, begin, velocity): whether the poses (m, 3) and times (m,) are finite, and these
 * ascend; then the lines between them are found. A yaw that jumps by half a turn or more is none of theirs: None. */
static PyObject *timed_lines(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[5];
    (void)module;
    if (wrong_count(count, 5)) return NULL;
    PyObject *const arrays[] = {args[2], args[3], args[4], args[0], args[1]};
    const int dimensions[] = {1, 2, 2, 1, 2};
    const Py_ssize_t lasts[] = {0, 3, 3, 0, 3};
    int open_ones = 0;
    for (; open_ones < 5; open_ones++)
        if (opened(arrays[open_ones], &in[open_ones], dimensions[open_ones], lasts[open_ones], PyBUF_C_CONTIGUOUS | (open_ones < 3 ? PyBUF_WRITABLE : 0)) < 0) break;
    if (open_ones < 5) {
        while (open_ones > 0) PyBuffer_Release(&in[--open_ones]);
        return NULL;
    }
    const Py_ssize_t many = in[3].shape[0];
    if (many < 1 || in[4].shape[0] != many || in[0].shape[0] != many + 1 || in[1].shape[0] != many + 1 || in[2].shape[0] != many + 1)
        return closed_all(in, 5, "times, poses and lines must fit each other");
    double *since = in[0].buf, *begin = in[1].buf, *velocity = in[2].buf;
    const double *times = in[3].buf, *pose = in[4].buf;
    int fit = isfinite(times[0]) && isfinite(times[many - 1]), jumps = 0;
    for (Py_ssize_t i = 0; i < many && fit; i++, pose += 3) {
        const Py_ssize_t row = 3 * (i + 1);
        const double step = i > 0 ? times[i] - times[i - 1] : 1.0;
        fit = step > 0.0 && isfinite(pose[0]) && isfinite(pose[1]) && isfinite(pose[2]);
        since[i + 1] = times[i];
        for (int c = 0; c < 3; c++) {
            begin[row + c] = pose[c];
            velocity[row + c] = 0.0;
            if (i > 0) velocity[row - 3 + c] = (pose[c] - pose[c - 3]) / step;
        }
        jumps |= i > 0 && fabs(pose[2] - pose[-1]) >= PI;
    }
    since[0] = since[1];
    for (int c = 0; c < 3; c++) begin[c] = begin[3 + c], velocity[c] = 0.0;
    PyObject *done = closed_all(in, 5, NULL);
    if (jumps && fit) return done;
    Py_DECREF(done);
    return PyBool_FromLong(fit);
}

/* nearest(xs, ys, x, y, low, high): the first of the nearest points from low up to high, and the square of how far. */
static PyObject *nearest(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[2];
    (void)module;
    if (wrong_count(count, 6)) return NULL;
    const double x = number(args[2]), y = number(args[3]);
    const Py_ssize_t low = PyLong_AsSsize_t(args[4]), high = PyLong_AsSsize_t(args[5]);
    if (PyErr_Occurred() || opened_all(args, in, 2, (const int[]){1, 1}, (const Py_ssize_t[]){0, 0}, -1) < 0) return NULL;
    if (!(0 <= low && low <= high && high < in[0].shape[0] && high < in[1].shape[0]))
        return closed_all(in, 2, "there are not so many points");
    const double *xs = in[0].buf, *ys = in[1].buf;
    Py_ssize_t best = low;
    double least = (xs[low] - x) * (xs[low] - x) + (ys[low] - y) * (ys[low] - y);
    for (Py_ssize_t i = low + 1; i <= high; i++) {
        const double dx = xs[i] - x, dy = ys[i] - y, squared = dx * dx + dy * dy;
        if (squared < least) least = squared, best = i;
    }
    Py_DECREF(closed_all(in, 2, NULL));
    return Py_BuildValue("nd", best, least);
}

#endif
