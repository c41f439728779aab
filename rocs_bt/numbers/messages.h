/* Messages of a recording (record/container.py). */
#ifndef ROCS_NUMBERS_MESSAGES_H
#define ROCS_NUMBERS_MESSAGES_H
#include <string.h>
#include "arguments.h"

enum { MESSAGE = 5, HEAD = 31 }; /* a message's opcode, and what stands before its data */

/* A number as so many bytes, the least first. */
static unsigned char *put(unsigned char *out, unsigned long long value, int bytes) {
    for (int i = 0; i < bytes; i++, value >>= 8) *out++ = (unsigned char)value;
    return out;
}

/* Note in the index when a message is, and where it stands. */
static int indexed(PyObject *index, PyObject *message, Py_ssize_t where) {
    PyObject *entries = PyObject_GetItem(index, PyTuple_GetItem(message, 0)), *place_ = PyLong_FromSsize_t(where);
    const int failed = entries == NULL || place_ == NULL || PyList_Append(entries, PyTuple_GetItem(message, 2)) < 0 ||
                       PyList_Append(entries, place_) < 0;
    Py_XDECREF(entries);
    Py_XDECREF(place_);
    return failed ? -1 : 0;
}

/* One message: channel, sequence, time, data; NULL where it is none. */
static unsigned char *chunked_one(PyObject *message, unsigned char *out) {
    const unsigned long channel = PyLong_AsUnsignedLong(PyTuple_GetItem(message, 0)), sequence = PyLong_AsUnsignedLong(PyTuple_GetItem(message, 1));
    const unsigned long long time = PyLong_AsUnsignedLongLong(PyTuple_GetItem(message, 2));
    PyObject *data = PyTuple_GetItem(message, 3);
    const Py_ssize_t size = PyBytes_Size(data);
    if (PyErr_Occurred()) return NULL;
    if (channel > 0xFFFFUL || sequence > 0xFFFFFFFFUL) {
        PyErr_SetString(PyExc_OverflowError, "a channel has two bytes, a sequence four");
        return NULL;
    }
    out = put(out, MESSAGE, 1);
    out = put(out, (unsigned long long)size + HEAD - 9, 8);
    out = put(put(out, channel, 2), sequence, 4);
    out = put(put(out, time, 8), time, 8);
    memcpy(out, PyBytes_AsString(data), (size_t)size);
    return out + size;
}

/* All of chunked but for its arguments; the messages are the caller's for so long. */
static PyObject *chunked_all(PyObject *messages, Py_ssize_t begin, PyObject *index) {
    const Py_ssize_t many = PyTuple_Size(messages);
    Py_ssize_t size = 0;
    for (Py_ssize_t i = 0; i < many; i++) {
        PyObject *message = PyTuple_GetItem(messages, i);
        const int fits = PyTuple_CheckExact(message) && PyTuple_Size(message) == 4 && PyBytes_Check(PyTuple_GetItem(message, 3));
        if (!fits) {
            PyErr_SetString(PyExc_TypeError, "a message is a tuple of channel, sequence, time and bytes");
            return NULL;
        }
        size += HEAD + PyBytes_Size(PyTuple_GetItem(message, 3));
    }
    PyObject *found = PyBytes_FromStringAndSize(NULL, size);
    if (found == NULL) return NULL;
    unsigned char *const start = (unsigned char *)PyBytes_AsString(found), *out = start;
    for (Py_ssize_t i = 0; i < many; i++) {
        PyObject *message = PyTuple_GetItem(messages, i);
        const Py_ssize_t where = begin + (out - start);
        if ((out = chunked_one(message, out)) == NULL || indexed(index, message, where) < 0) {
            Py_DECREF(found);
            return NULL;
        }
    }
    return found;
}

/* chunked(messages, begin, index): messages are a list of tuples, the index a mapping of channels to lists. */
static PyObject *chunked(PyObject *module, PyObject *const *args, Py_ssize_t count) {
    (void)module;
    if (wrong_count(count, 3)) return NULL;
    const Py_ssize_t begin = PyLong_AsSsize_t(args[1]);
    if (!PyErr_Occurred() && !PyList_Check(args[0])) PyErr_SetString(PyExc_TypeError, "the messages must be a list");
    PyObject *messages = PyErr_Occurred() ? NULL : PySequence_Tuple(args[0]);
    if (messages == NULL) return NULL;
    PyObject *found = chunked_all(messages, begin, args[2]);
    Py_DECREF(messages);
    return found;
}

#endif
