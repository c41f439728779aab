/* Work on a few numbers: what compiled.py gives in place of a function of the same name in Python.
 *
 * Each does what that function does with finite numbers, to the bit, in the same order of operations; hatch_build.py compiles without
 * anything that would change a result. Where Python has math.hypot, whose rounding is Python's own, it is called.
 * Arrays come through the buffer protocol and are held to their sizes. Only the limited API of CPython 3.11 is used.
 *
 * What it is made of stands in numbers/; this file shows it to Python.
 */
#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include "numbers/arcs.h"
#include "numbers/gaps.h"
#include "numbers/ground.h"
#include "numbers/messages.h"
#include "numbers/paths.h"
#include "numbers/signals.h"
#include "numbers/strings.h"
#include "numbers/tracks.h"

#define METHOD(name, text) {#name, (PyCFunction)(void (*)(void))name, METH_FASTCALL, text}
static PyMethodDef METHODS[] = {
    METHOD(arc_poses, "arc_poses(pose, twist, durations): geometry.arc_poses"),
    METHOD(arc_positions, "arc_positions(pose, twist, durations): geometry.arc_positions"),
    METHOD(hull_gaps, "hull_gaps(way, places, half, radius): geometry.hull_gaps"),
    METHOD(strides_at, "strides_at(ground, frame, ways, since): monitor.free_ground.strides_at"),
    METHOD(mark_at, "mark_at(ground, frame, points, t): monitor.free_ground.mark_at"),
    METHOD(wrap_angle, "wrap_angle(angle): geometry.wrap_angle"),
    METHOD(finite_all, "finite_all(values): record.codec.finite_all"),
    METHOD(chunked, "chunked(messages, begin, index): record.container.chunked"),
    METHOD(pack, "pack(values): event.pack"),
    METHOD(valid, "valid(values, expires, t, out): knowledge.signals.valid"),
    METHOD(least_echoes, "least_echoes(rays, each): drivers.mujoco.sensors.least_echoes"),
    METHOD(least_gaps, "least_gaps(points, bearings, half, sectors): monitor.gaps.least_gaps"),
    METHOD(nearest_moment, "nearest_moment(way, other): actions.give_way.nearest_moment"),
    METHOD(bent_at, "bent_at(pose, runs, bends, ways): actions.give_way.bent_at"),
    METHOD(turned_at, "turned_at(pose, ahead, turning, times, ways): actions.give_way.turned_at"),
    METHOD(least_apart, "least_apart(way, other, half): actions.give_way.least_apart"),
    METHOD(costs_at, "costs_at(ways, leader, others, half, limits, soon, costs): actions.give_way.costs_at"),
    METHOD(fill, "fill(target, expires, until, values, sizes, bounds): knowledge.signals.fill"),
    METHOD(along_at, "along_at(motions, durations, found): control.ways.along_at"),
    METHOD(nearest, "nearest(xs, ys, x, y, low, high): control.path.nearest"),
    METHOD(within, "within(values, limit): control.follower.within"),
    METHOD(rows_at, "rows_at(rows, slopes, steps, found): control.grid.rows_at"),
    METHOD(stations_at, "stations_at(profile, begin, times, found): control.profile.stations_at"),
    METHOD(path_stages, "path_stages(rows, given, times, stages): control.reference.path_stages"),
    METHOD(timed_lines, "timed_lines(times, poses, since, begin, velocity): control.reference.timed_lines"),
    METHOD(timed_stages, "timed_stages(times, since, begin, velocity, at, stages): control.reference.timed_stages"),
    METHOD(turn_on, "turn_on(state, dt, kept, moved, slope): control.motion_filter.turn_on"),
    METHOD(sight, "sight(state, observer, distance, bearing, slope, error): control.motion_filter.sight"),
    METHOD(inverse, "inverse(matrix, found): control.motion_filter.inverse"),
    METHOD(pull, "pull(way, pose, leader, others, detours, limits): actions.give_way.pull"),
    {NULL, NULL, 0, NULL}};

static int module_exec(PyObject *module) {
    PyObject *math = PyImport_ImportModule("math");
    if (math == NULL) return -1;
    State *state = PyModule_GetState(module);
    state->hypot = PyObject_GetAttrString(math, "hypot");
    Py_DECREF(math);
    return state->hypot == NULL ? -1 : 0;
}

static int module_traverse(PyObject *module, visitproc visit, void *arg) {
    State *state = PyModule_GetState(module);
    if (state != NULL) Py_VISIT(state->hypot);
    return 0;
}

static void module_free(void *module) {
    State *state = PyModule_GetState(module);
    if (state != NULL) Py_CLEAR(state->hypot);
}

static PyModuleDef_Slot SLOTS[] = {{Py_mod_exec, module_exec}, {0, NULL}};
static PyModuleDef MODULE = {PyModuleDef_HEAD_INIT, "_numbers", "Work on a few numbers.", sizeof(State),
                             METHODS, SLOTS, module_traverse, NULL, module_free};

PyMODINIT_FUNC PyInit__numbers(void) { return PyModuleDef_Init(&MODULE); }
