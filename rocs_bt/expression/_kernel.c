/* Table machine: runs a Program (program.py), alone or of a RuleTable (../reactive/rule_table.py); these modules define
 * every instruction and every step. Built by hatch_build.py; kernel.py is its only caller.
 *
 * A Table is checked once, when it is created: every register, cell and column that it names exists, and every register
 * is written at most once and before it is read. States are not trusted either: ring positions in a state are limited to
 * the ring's capacity at every use. So no input can cause a read or write beyond an array.
 *
 * Because a register is written once, instructions can be reordered as long as operands come first. They are sorted by
 * depth and kind, so that, for example, all comparisons of one depth run in one tight loop instead of a switch for each.
 * A comparison that only a release (`until`) needs runs only while its rule is latched; one that only an AND needs is
 * fused with it.
 *
 * Only the limited API of CPython 3.11 is used: one binary works with that version and all later ones.
 *
 * The implementation is in kernel/; this file is the Python binding.
 */
#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include "kernel/making.h"
#include "kernel/rule_step.h"

static void release_type(PyObject *self) {
    PyTypeObject *type = Py_TYPE(self);
    ((freefunc)PyType_GetSlot(type, Py_tp_free))(self);
    Py_DECREF(type);
}

static PyObject *table_new(PyTypeObject *type, PyObject *args, PyObject *kwargs) {
    PyObject *given[INPUTS];
    Py_buffer in[INPUTS];
    int opened_ones = 0, failed = 1;
    (void)kwargs;
    if (!PyArg_ParseTuple(args, "OOOOOOOOOOOOO:Table", &given[0], &given[1], &given[2], &given[3], &given[4], &given[5],
                          &given[6], &given[7], &given[8], &given[9], &given[10], &given[11], &given[12]))
        return NULL;
    Table *table = (Table *)PyType_GenericAlloc(type, 0);
    if (table == NULL) return NULL;
    for (; opened_ones < INPUTS; opened_ones++)
        if (buffer(given[opened_ones], &in[opened_ones], NAMES[opened_ones], INPUT_KINDS[opened_ones],
                   opened_ones == CODE ? 2 : 1, PyBUF_C_CONTIGUOUS) < 0)
            break;
    if (opened_ones == INPUTS) failed = table_fill(table, in) < 0;
    while (opened_ones > 0) PyBuffer_Release(&in[--opened_ones]);
    if (failed) Py_CLEAR(table);
    return (PyObject *)table;
}

static void table_dealloc(PyObject *self) {
    Table *table = (Table *)self;
    free(table->code);
    free(table->run);
    free(table->first);
    free(table->initial);
    free(table->keep);
    free(table->rule);
    free(table->guard);
    free(table->by_rank);
    release_type(self);
}

enum { X, T, VALUES, WINNER, MASK, MARGIN, PARTS };

static void advance(const Table *table, Work *work, const Py_buffer *in) {
    const Py_ssize_t n = in[X].shape[0], size = in[X].shape[1], lanes = in[VALUES].shape[0];
    double *values = in[VALUES].buf;
    uint8_t *mask = in[MASK].buf;
    double *margin = in[MARGIN].buf;
    for (Py_ssize_t i = 0; i < n; i++) {
        double *const state = values + (lanes == 1 ? 0 : i * table->width);
        if (i == 0 || lanes > 1) rouse(table, state + 1 + table->cells, work->flags);
        ((int32_t *)in[WINNER].buf)[i] = step(table, work, state, (const char *)in[X].buf + i * size * (Py_ssize_t)sizeof(double),
                                              sizeof(double), ((const double *)in[T].buf)[i]);
        for (Py_ssize_t k = 0; k < table->rules; k++) mask[k] = work->flags[k] >> 1;
        memcpy(margin, state + table->width - table->margins, (size_t)table->margins * sizeof(double));
        mask += table->rules;
        margin += table->margins;
    }
}

static int batch_fits(const Table *table, const Py_buffer *in) {
    const Py_ssize_t n = in[X].shape[0], lanes = in[VALUES].shape[0];
    if (in[X].shape[1] >= table->needed && in[T].shape[0] == n && (lanes == 1 || lanes == n) &&
        in[VALUES].shape[1] == table->width && in[WINNER].shape[0] == n && in[MASK].shape[0] == n &&
        in[MASK].shape[1] == table->rules && in[MARGIN].shape[0] == n && in[MARGIN].shape[1] == table->margins)
        return 1;
    PyErr_Format(PyExc_ValueError,
                 "%zd snapshots of %zd signals, %zd times and %zd states of %zd values were given; a snapshot needs %zd "
                 "signals and a time, and a state %zd values, one state for all snapshots or one for each",
                 n, in[X].shape[1], in[T].shape[0], lanes, in[VALUES].shape[1], table->needed, table->width);
    return 0;
}

static PyObject *table_batch(PyObject *self, PyObject *const *args, Py_ssize_t count_of_args) {
    static const char *const names[PARTS] = {"x", "t", "values", "winner", "mask", "margin"};
    Table *table = (Table *)self;
    Py_buffer in[PARTS];
    Work work = {NULL, NULL};
    int opened_ones = 0, done = 0;
    if (count_of_args != PARTS) {
        PyErr_Format(PyExc_TypeError, "batch takes x, t, values, winner, mask, margin; %zd were given", count_of_args);
        return NULL;
    }
    for (; opened_ones < PARTS; opened_ones++)
        if (buffer(args[opened_ones], &in[opened_ones], names[opened_ones], "dddi?d"[opened_ones],
                   opened_ones == T || opened_ones == WINNER ? 1 : 2,
                   PyBUF_C_CONTIGUOUS | (opened_ones >= VALUES ? PyBUF_WRITABLE : 0)) < 0)
            break;
    if (opened_ones == PARTS && batch_fits(table, in)) {
        if (work_make(&work, table) < 0) {
            PyErr_NoMemory();
        } else {
            Py_BEGIN_ALLOW_THREADS
            advance(table, &work, in);
            Py_END_ALLOW_THREADS
            done = 1;
        }
        work_free(&work);
    }
    while (opened_ones > 0) PyBuffer_Release(&in[--opened_ones]);
    if (!done) return NULL;
    Py_RETURN_NONE;
}

typedef struct {
    PyObject_HEAD
    Table *table;
    Py_buffer values; /* the state: the caller's array */
    Py_buffer x;      /* buffer of the last snapshot, kept open: the next snapshot is usually the same array */
    PyObject *seen;   /* object that owns buffer x; NULL if none, or if the buffer belongs to another object */
    Work work;
} Machine;

static PyObject *table_machine(PyObject *self, PyObject *values) {
    Table *table = (Table *)self;
    PyTypeObject **type = PyType_GetModuleState(Py_TYPE(self));
    Machine *machine = type == NULL ? NULL : (Machine *)PyType_GenericAlloc(*type, 0);
    if (machine == NULL) return NULL;
    if (buffer(values, &machine->values, "values", 'd', 1, PyBUF_C_CONTIGUOUS | PyBUF_WRITABLE) < 0) {
        machine->values.obj = NULL;
    } else if (machine->values.shape[0] != table->width) {
        PyErr_Format(PyExc_ValueError, "a state of %zd values was given; one of %zd is needed", machine->values.shape[0],
                     table->width);
    } else if (work_make(&machine->work, table) < 0) {
        PyErr_NoMemory();
    } else {
        Py_INCREF(self);
        machine->table = table;
        rouse(table, (double *)machine->values.buf + 1 + table->cells, machine->work.flags);
        return (PyObject *)machine;
    }
    Py_DECREF(machine);
    return NULL;
}

static void machine_dealloc(PyObject *self) {
    Machine *machine = (Machine *)self;
    if (machine->values.obj != NULL) PyBuffer_Release(&machine->values);
    if (machine->x.obj != NULL) PyBuffer_Release(&machine->x);
    work_free(&machine->work);
    Py_XDECREF((PyObject *)machine->table);
    release_type(self);
}

static int machine_look(Machine *machine, PyObject *x) {
    machine->seen = NULL;
    if (machine->x.obj != NULL) PyBuffer_Release(&machine->x);
    if (buffer(x, &machine->x, "x", 'd', 1, PyBUF_STRIDES) < 0) {
        machine->x.obj = NULL;
        return -1;
    }
    if (machine->x.shape[0] >= machine->table->needed) {
        machine->seen = machine->x.obj == x ? x : NULL;
        return 0;
    }
    PyErr_Format(PyExc_ValueError, "a snapshot of %zd signals was given; the rules read %zd", machine->x.shape[0],
                 machine->table->needed);
    PyBuffer_Release(&machine->x);
    return -1;
}

/* Steps a machine with arguments x and t; -1 if that raises an error. */
static int stepped(Machine *machine, PyObject *const *args, int32_t *winner) {
    const double t = PyFloat_AsDouble(args[1]);
    if (t == -1.0 && PyErr_Occurred()) return -1;
    if (args[0] != machine->seen && machine_look(machine, args[0]) < 0) return -1;
    *winner = step(machine->table, &machine->work, machine->values.buf, machine->x.buf, machine->x.strides[0], t);
    return 0;
}

static PyObject *machine_step(PyObject *self, PyObject *const *args, Py_ssize_t count_of_args) {
    int32_t winner;
    if (count_of_args != 2) {
        PyErr_Format(PyExc_TypeError, "step takes x and t; %zd were given", count_of_args);
        return NULL;
    }
    return stepped((Machine *)self, args, &winner) < 0 ? NULL : PyLong_FromLong(winner);
}

static PyObject *machine_register(PyObject *self, PyObject *index) {
    Machine *machine = (Machine *)self;
    const Py_ssize_t i = PyLong_AsSsize_t(index);
    if (i == -1 && PyErr_Occurred()) return NULL;
    if (i >= 0 && i < machine->table->registers) return PyFloat_FromDouble(machine->work.r[i]);
    PyErr_Format(PyExc_IndexError, "there is no register %zd; there are %zd", i, machine->table->registers);
    return NULL;
}

/* Both in one call, so that no other thread can step in between. */
static PyObject *machine_value(PyObject *self, PyObject *const *args, Py_ssize_t count_of_args) {
    int32_t winner;
    if (count_of_args != 3) {
        PyErr_Format(PyExc_TypeError, "value takes x, t and index; %zd were given", count_of_args);
        return NULL;
    }
    return stepped((Machine *)self, args, &winner) < 0 ? NULL : machine_register(self, args[2]);
}

static PyObject *machine_wake(PyObject *self, PyObject *nothing) {
    Machine *machine = (Machine *)self;
    (void)nothing;
    rouse(machine->table, (double *)machine->values.buf + 1 + machine->table->cells, machine->work.flags);
    Py_RETURN_NONE;
}

static PyMethodDef TABLE_METHODS[] = {
    {"batch", (PyCFunction)(void (*)(void))table_batch, METH_FASTCALL, "batch(x, t, values, winner, mask, margin)"},
    {"machine", table_machine, METH_O, "machine(values): one robot's rules, live, on an array for their state"},
    {NULL, NULL, 0, NULL}};
static PyType_Slot TABLE_SLOTS[] = {
    {Py_tp_new, table_new}, {Py_tp_dealloc, table_dealloc}, {Py_tp_methods, TABLE_METHODS}, {0, NULL}};
static PyType_Spec TABLE = {"rocs_bt.expression._kernel.Table", sizeof(Table), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE, TABLE_SLOTS};

static PyMethodDef MACHINE_METHODS[] = {
    {"step", (PyCFunction)(void (*)(void))machine_step, METH_FASTCALL, "step(x, t): the winner, -1 for none"},
    {"value", (PyCFunction)(void (*)(void))machine_value, METH_FASTCALL, "value(x, t, index): a register after a step"},
    {"wake", machine_wake, METH_NOARGS, "look at a state that was changed from outside"},
    {"register", machine_register, METH_O, "register(index): its value after the last step"},
    {NULL, NULL, 0, NULL}};
static PyType_Slot MACHINE_SLOTS[] = {{Py_tp_dealloc, machine_dealloc}, {Py_tp_methods, MACHINE_METHODS}, {0, NULL}};
static PyType_Spec MACHINE = {"rocs_bt.expression._kernel.Machine", sizeof(Machine), 0,
                              Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE | Py_TPFLAGS_DISALLOW_INSTANTIATION, MACHINE_SLOTS};

static int module_exec(PyObject *module) {
    PyObject **machine = PyModule_GetState(module);
    PyObject *table = PyType_FromModuleAndSpec(module, &TABLE, NULL);
    if (table == NULL) return -1;
    int added = PyModule_AddObjectRef(module, "Table", table);
    Py_DECREF(table);
    *machine = PyType_FromModuleAndSpec(module, &MACHINE, NULL);
    if (added < 0 || *machine == NULL) return -1;
    return PyModule_AddStringConstant(module, "OPERATIONS", OPERATIONS) < 0 ? -1 : PyModule_AddObjectRef(module, "Machine", *machine);
}

static void module_free(void *module) {
    PyObject **machine = PyModule_GetState(module);
    if (machine != NULL) Py_CLEAR(*machine);
}

static PyModuleDef_Slot MODULE_SLOTS[] = {{Py_mod_exec, module_exec}, {0, NULL}};
static PyModuleDef MODULE = {PyModuleDef_HEAD_INIT, "_kernel", "Runs tables of rules.", sizeof(PyObject *), NULL,
                             MODULE_SLOTS, NULL, NULL, module_free};

PyMODINIT_FUNC PyInit__kernel(void) { return PyModuleDef_Init(&MODULE); }
