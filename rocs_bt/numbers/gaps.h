/* Gaps between hulls and what is near (geometry.py, monitor/gaps.py, actions/give_way.py). */
#ifndef ROCS_NUMBERS_GAPS_H
#define ROCS_NUMBERS_GAPS_H
#include <math.h>
#include <stdlib.h>
#include "arcs.h"

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

/* bent_at(pose, runs, bends, ways): ways (3, n, k) are filled for runs (n, k) on bends (n, 1). */
static PyObject *bent_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[2], ways;
    double at[3];
    (void)module;
    if (wrong_count(count, 4) || numbers(args[0], at, 3) < 0) return NULL;
    PyObject *const arrays[] = {args[1], args[2]};
    if (opened_all(arrays, in, 2, (const int[]){2, 2}, (const Py_ssize_t[]){0, 1}, -1) < 0) return NULL;
    const Py_ssize_t many = in[0].shape[0], moments = in[0].shape[1];
    if (opened(args[3], &ways, 3, moments, PyBUF_WRITABLE) < 0) {
        Py_DECREF(closed_all(in, 2, NULL));
        return NULL;
    }
    const int fits = ways.shape[0] == 3 && ways.shape[1] == many && in[1].shape[0] == many;
    const double *run = in[0].buf, *bend = in[1].buf;
    double last = 0.0, there[3] = {at[0], at[1], at[2]};
    for (Py_ssize_t i = 0; fits && i < many; i++) {
        for (Py_ssize_t k = 0; k < moments; k++, run++) {
            if (k == 0 || *run != last) { /* it stands as soon as it has come as far as it may */
                const double turned = bend[i] * *run, half = 0.5 * turned, middle = at[2] + half;
                double angle = PI * (half / PI);
                if (angle == 0.0) angle = DBL_EPSILON;
                const double chord = *run * (sin(angle) / angle);
                there[0] = at[0] + chord * cos(middle);
                there[1] = at[1] + chord * sin(middle);
                there[2] = at[2] + turned;
                last = *run;
            }
            for (int d = 0; d < 3; d++)
                *(double *)((char *)ways.buf + d * ways.strides[0] + i * ways.strides[1] + k * ways.strides[2]) = there[d];
        }
    }
    PyBuffer_Release(&ways);
    return closed_all(in, 2, fits ? NULL : "there must be a bend for each way, and room for all");
}

/* How far one has gone [m] at a time [s], at a speed [m/s] from which one brakes [m/s2] to stand at a reach [m]. */
static double braked(double speed, double reach, double t, double braking) {
    const double most = sqrt(2.0 * braking * reach), fast = speed < most ? speed : most;
    double cruised = (reach - fast * fast / (2.0 * braking)) / (fast < 1e-9 ? 1e-9 : fast);
    if (cruised < 0.0) cruised = 0.0;
    double slowed = t - cruised < 0.0 ? 0.0 : t - cruised;
    if (fast / braking < slowed) slowed = fast / braking;
    return fast * (t < cruised ? t : cruised) + (fast - 0.5 * braking * slowed) * slowed;
}

/* turned_at(pose, (headings, errors, reach), (speed, rate, lag, braking), times, ways): thrice (m,), (k,), (3, m, k). */
static PyObject *turned_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[4], ways;
    double at[3], turning[4];
    (void)module;
    if (wrong_count(count, 5) || numbers(args[0], at, 3) < 0 || numbers(args[2], turning, 4) < 0) return NULL;
    if (!PyTuple_Check(args[1]) || PyTuple_Size(args[1]) != 3) {
        PyErr_SetString(PyExc_TypeError, "what is ahead is a tuple of three arrays");
        return NULL;
    }
    PyObject *const arrays[] = {PyTuple_GetItem(args[1], 0), PyTuple_GetItem(args[1], 1), PyTuple_GetItem(args[1], 2), args[3]};
    if (opened_all(arrays, in, 4, (const int[]){1, 1, 1, 1}, (const Py_ssize_t[]){0, 0, 0, 0}, -1) < 0) return NULL;
    const Py_ssize_t many = in[0].shape[0], moments = in[3].shape[0];
    if (opened(args[4], &ways, 3, moments, PyBUF_WRITABLE) < 0) {
        Py_DECREF(closed_all(in, 4, NULL));
        return NULL;
    }
    const int fits = ways.shape[0] == 3 && ways.shape[1] == many && in[1].shape[0] == many && in[2].shape[0] == many;
    const double *heading = in[0].buf, *error = in[1].buf, *reach = in[2].buf, *times = in[3].buf;
    for (Py_ssize_t i = 0; fits && i < many; i++) {
        const double turn = fabs(error[i]) / turning[1], took = turn + (turning[2] < turn ? turning[2] : turn), c = cos(heading[i]), s = sin(heading[i]);
        for (Py_ssize_t k = 0; k < moments; k++) {
            const double since = times[k] - took, share = times[k] / (took < 1e-6 ? 1e-6 : took);
            const double run = braked(turning[0], reach[i], since < 0.0 ? 0.0 : since, turning[3]);
            const double there[3] = {at[0] + run * c, at[1] + run * s, at[2] + error[i] * (1.0 < share ? 1.0 : share)};
            for (int d = 0; d < 3; d++)
                *(double *)((char *)ways.buf + d * ways.strides[0] + i * ways.strides[1] + k * ways.strides[2]) = there[d];
        }
    }
    PyBuffer_Release(&ways);
    return closed_all(in, 4, fits ? NULL : "there must be an error, a reach and a way for each heading");
}

/* Where a way is at a moment, of ways (3, n, k) or of one way (k, 3); and how a hull is turned there. */
typedef struct {
    const Py_buffer *ways;
    Py_ssize_t value, way, moment; /* strides */
    double half[2], yaw, c, s;
} Hull;

/* Between the hull on a way at a moment and the middle of another. */
static double apart(Hull *hull, Py_ssize_t i, Py_ssize_t k, const Py_buffer *other) {
    const Py_ssize_t here = i * hull->way + k * hull->moment, there = k * other->strides[0];
    const double yaw = AT(*hull->ways, here + 2 * hull->value);
    if (yaw != hull->yaw) { /* many ways go straight on */
        hull->yaw = yaw;
        hull->c = cos(yaw);
        hull->s = sin(yaw);
    }
    const double dx = AT(*other, there) - AT(*hull->ways, here), dy = AT(*other, there + other->strides[1]) - AT(*hull->ways, here + hull->value);
    const double ahead = fabs(hull->c * dx + hull->s * dy) - hull->half[0], aside = fabs(hull->c * dy - hull->s * dx) - hull->half[1];
    return hypot(ahead < 0.0 ? 0.0 : ahead, aside < 0.0 ? 0.0 : aside);
}

/* least_apart(way, other, half): both are (k, 3). */
static PyObject *least_apart(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer way, other;
    Hull hull = {.c = 1.0};
    (void)module;
    if (wrong_count(count, 3) || numbers(args[2], hull.half, 2) < 0 || opened(args[0], &way, 2, 3, 0) < 0) return NULL;
    double least = HUGE_VAL;
    int failed = opened(args[1], &other, 2, 3, 0) < 0;
    if (!failed) {
        failed = way.shape[0] < 1 || other.shape[0] != way.shape[0];
        if (failed) PyErr_SetString(PyExc_ValueError, "both ways must have as many moments, at least one");
        hull.ways = &way, hull.value = way.strides[1], hull.moment = way.strides[0];
        for (Py_ssize_t k = 0; !failed && k < way.shape[0]; k++) least = lesser(apart(&hull, 0, k, &other), least);
        PyBuffer_Release(&other);
    }
    PyBuffer_Release(&way);
    return failed ? NULL : PyFloat_FromDouble(least);
}

/* The sum of numbers in the order in which numpy adds them up. */
static double sum(const double *a, Py_ssize_t many) {
    if (many > 128) {
        const Py_ssize_t half = many / 2 - many / 2 % 8;
        return sum(a, half) + sum(a + half, many - half);
    }
    Py_ssize_t i = 0;
    double total = 0.0, r[8];
    if (many >= 8) {
        for (; i < 8; i++) r[i] = a[i];
        for (; i < many - many % 8; i += 8)
            for (int j = 0; j < 8; j++) r[j] += a[i + j];
        total = ((r[0] + r[1]) + (r[2] + r[3])) + ((r[4] + r[5]) + (r[6] + r[7]));
    }
    for (; i < many; i++) total += a[i];
    return total;
}

/* What it costs to come nearer to another than one should; whether standing does. */
static int crowded(Hull *hull, const Py_buffer *other, const double limits[5], Py_ssize_t soon, double *costs, double *short_) {
    const Py_ssize_t many = hull->ways->shape[1];
    int standing = 0;
    for (Py_ssize_t i = 0; i < many; i++) {
        double most = 0.0;
        for (Py_ssize_t k = 0; k < soon; k++) {
            short_[k] = limits[2] - apart(hull, i, k, other);
            if (short_[k] < 0.0) short_[k] = 0.0;
            if (short_[k] > most) most = short_[k];
        }
        costs[i] += limits[3] * (sum(short_, soon) / (double)soon + most);
        standing |= i == 0 && most > 0.0;
    }
    return standing;
}

/* What it costs to be too far from the leader, or too near; how near each way comes to it where standing keeps more. */
static void led(const Hull *hull, const Py_buffer *leader, const double limits[5], Py_ssize_t soon, double *costs, double *nearest_, double *far, double *near, double *stands) {
    const Py_ssize_t many = hull->ways->shape[1], moments = hull->ways->shape[2];
    for (Py_ssize_t i = 0; i < many; i++) {
        nearest_[i] = HUGE_VAL;
        for (Py_ssize_t k = 0; k < moments; k++) {
            const Py_ssize_t here = i * hull->way + k * hull->moment, there = k * leader->strides[0];
            const double away = hypot(AT(*hull->ways, here) - AT(*leader, there), AT(*hull->ways, here + hull->value) - AT(*leader, there + leader->strides[1]));
            const double beyond = away - limits[0] < 0.0 ? 0.0 : away - limits[0];
            far[k] = beyond * beyond;
            near[k] = limits[1] - away < 0.0 ? 0.0 : limits[1] - away;
            if (i == 0) stands[k] = k > 0 ? lesser(away, stands[k - 1]) : away;
            if (away < stands[k] - limits[4]) nearest_[i] = lesser(away, nearest_[i]);
        }
        costs[i] = sum(far, soon) / (double)soon;
        costs[i] += limits[3] * (sum(near, moments) / (double)moments);
    }
}

/* All of costs_at but for its arguments; -1 where another does not fit. */
static int costs_in(Hull *hull, const Py_buffer *leader, PyObject *others, const double limits[5], Py_ssize_t soon, double *costs) {
    const Py_ssize_t many = hull->ways->shape[1], moments = hull->ways->shape[2];
    double *nearest_ = malloc(sizeof(double) * (size_t)(many + 3 * moments)), limit = limits[0];
    if (nearest_ == NULL) {
        PyErr_NoMemory();
        return -1;
    }
    double *const far = nearest_ + many;
    led(hull, leader, limits, soon, costs, nearest_, far, far + moments, far + 2 * moments);
    int failed = 0;
    for (Py_ssize_t n = 0; n < PyTuple_Size(others) && !failed; n++) {
        Py_buffer other;
        failed = opened(PyTuple_GetItem(others, n), &other, 2, 3, 0) < 0;
        if (failed) break;
        failed = other.shape[0] != soon;
        if (failed) PyErr_SetString(PyExc_ValueError, "the others must have as many moments as count for them");
        else if (crowded(hull, &other, limits, soon, costs, far)) limit = limits[1];
        PyBuffer_Release(&other);
    }
    for (Py_ssize_t i = 0; i < many; i++)
        if (nearest_[i] < limit) costs[i] = HUGE_VAL;
    free(nearest_);
    return failed ? -1 : 0;
}

/* costs_at(ways, leader, others, half, limits, soon, costs): (3, n, k), (k, 3), a sequence of (soon, 3), and (n,). */
static PyObject *costs_at(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    Py_buffer in[2], leader;
    Hull hull = {.ways = &in[0], .c = 1.0};
    double limits[5];
    (void)module;
    if (wrong_count(count, 7) || numbers(args[3], hull.half, 2) < 0 || numbers(args[4], limits, 5) < 0) return NULL;
    const Py_ssize_t soon = PyLong_AsSsize_t(args[5]);
    PyObject *const arrays[] = {args[0], args[6]};
    if (PyErr_Occurred() || opened_all(arrays, in, 2, (const int[]){3, 1}, (const Py_ssize_t[]){0, 0}, 1) < 0) return NULL;
    if (opened(args[1], &leader, 2, 3, 0) < 0) {
        Py_DECREF(closed_all(in, 2, NULL));
        return NULL;
    }
    const Py_ssize_t many = in[0].shape[1], moments = in[0].shape[2];
    const int whole = in[0].shape[0] == 3 && many > 0 && in[1].shape[0] == many;
    const int fits = whole && leader.shape[0] == moments && 0 < soon && soon <= moments;
    PyObject *others = fits ? PySequence_Tuple(args[2]) : NULL;
    hull.value = in[0].strides[0], hull.way = in[0].strides[1], hull.moment = in[0].strides[2];
    const int failed = others == NULL || costs_in(&hull, &leader, others, limits, soon, in[1].buf) < 0;
    Py_XDECREF(others);
    PyBuffer_Release(&leader);
    if (fits && failed) {
        PyBuffer_Release(&in[0]);
        PyBuffer_Release(&in[1]);
        return NULL;
    }
    return closed_all(in, 2, fits ? NULL : "there must be a cost for each way, and a place of the leader for each moment");
}

#endif
