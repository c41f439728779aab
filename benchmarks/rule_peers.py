"""Baselines of the rules benchmark: the same guards hand-written in Python and C, and in other engines.

Rule k is `speed > 0.1 and min(range[a:a + 8]) < threshold` over 64 ranges. The baselines have no hysteresis, timers,
cooldown or NaN handling. Each evaluator is a function of (snapshot, time) that returns the guards that hold, or their
number. Engines without `min` get a chain of eight `or`; CLIPS, which matches facts, gets precomputed minima, in its
favour.
"""

from __future__ import annotations

import importlib.util
import random
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.machinery import ExtensionFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

RANGES, WIDTH, SPEED = 64, 8, 64  # number of ranges, ranges per rule, column of the speed
MINIMA = SPEED + 1  # first column of the precomputed minima
ROOT = Path(__file__).resolve().parents[1]
Floats = np.ndarray
Evaluator = Callable[[Floats, float], Any]


@dataclass(frozen=True)
class Guard:
    """`speed > 0.1 and min(range[first:first + 8]) < threshold`."""

    first: int
    threshold: float


def guards(count: int) -> list[Guard]:
    """Guards from a fixed seed."""
    draw = random.Random(count)
    return [Guard(draw.randrange(RANGES - WIDTH + 1), round(0.3 + 0.4 * k / count, 6)) for k in range(count)]


def trace(rows: int) -> Floats:
    """Snapshots of a robot that drives among obstacles, (rows, 64 + 1 + 57): ranges [m], speed [m/s], minima [m]."""
    noise = np.random.default_rng(1)
    wander = 2.0 + np.cumsum(noise.normal(0.0, 0.05, (rows, RANGES)), axis=0)
    x = np.empty((rows, MINIMA + RANGES - WIDTH + 1))
    x[:, :RANGES] = np.abs(wander) + 0.2
    x[:, SPEED] = 0.4 + 0.05 * noise.normal(size=rows)
    x[:, MINIMA:] = np.lib.stride_tricks.sliding_window_view(x[:, :RANGES], WIDTH, axis=1).min(axis=2)
    return x


def python_by_hand(wanted: list[Guard]) -> Evaluator:
    """Hand-written Python."""
    lines = [f"        speed > 0.1 and min(v[{g.first}:{g.first + WIDTH}]) < {g.threshold}," for g in wanted]
    source = ["def step(x, t):", "    v = x.tolist()", f"    speed = v[{SPEED}]", "    return [", *lines, "    ]"]
    names: dict[str, Any] = {}
    exec("\n".join(source), names)
    step: Evaluator = names["step"]
    return step


def c_by_hand(wanted: list[Guard]) -> Evaluator:
    """Hand-written C in an extension module, which stores the guards that hold and returns their number.

    Raises:
        ImportError: There is no C compiler.
    """
    tests = [
        f"    count += fired[{k}] = speed > 0.1 && least(v + {g.first}) < {g.threshold};" for k, g in enumerate(wanted)
    ]
    source = _C.replace("@RULES@", str(len(wanted))).replace("@TESTS@", "\n".join(tests))
    hook = _load("hatch_build", ROOT / "hatch_build.py")
    folder = Path(tempfile.mkdtemp())
    (folder / "hand.c").write_text(source)
    if reason := hook.compile_kernel(folder / "hand.c", folder / "hand.so"):
        raise ImportError(reason)
    spec = importlib.util.spec_from_file_location(
        "hand", folder / "hand.so", loader=ExtensionFileLoader("hand", str(folder / "hand.so"))
    )
    step: Evaluator = _module(spec).step
    return step


def evalidate(wanted: list[Guard]) -> Evaluator:
    """One compiled expression per rule, evaluated as its manual advises for speed."""
    from evalidate import Expr

    codes, names = [Expr(_chain(g)).code for g in wanted], _names()

    def step(x: Floats, t: float) -> list[bool]:
        values = dict(zip(names, x.tolist(), strict=False))
        return [eval(code, {}, values) for code in codes]

    return step


def rule_engine(wanted: list[Guard]) -> Evaluator:
    """One rule object per rule."""
    from rule_engine import Rule

    rules, names = [Rule(_chain(g)) for g in wanted], _names()

    def step(x: Floats, t: float) -> list[bool]:
        values = dict(zip(names, x.tolist(), strict=False))
        return [rule.matches(values) for rule in rules]

    return step


def clips(wanted: list[Guard]) -> Evaluator:
    """CLIPS: one fact per snapshot: retract, assert, run."""
    import clips as engine

    environment = engine.Environment()
    used = sorted({g.first for g in wanted})
    environment.build(f"(deftemplate snap (slot speed) {' '.join(f'(slot m{a})' for a in used)})")
    for k, g in enumerate(wanted):
        environment.build(f"(defrule r{k} (snap (speed ?s&:(> ?s 0.1)) (m{g.first} ?m&:(< ?m {g.threshold}))) =>)")
    template, fact = environment.find_template("snap"), None

    def step(x: Floats, t: float) -> int:
        nonlocal fact
        if fact is not None:
            fact.retract()
        v = x.tolist()
        fact = template.assert_fact(speed=v[SPEED], **{f"m{a}": v[MINIMA + a] for a in used})
        return environment.run()

    return step


PEERS: dict[str, Callable[[list[Guard]], Evaluator]] = {
    "evalidate": evalidate,
    "CLIPS": clips,
    "rule-engine": rule_engine,
}


def holding(answer: list[bool] | int) -> int:
    """Number of guards that hold, from an evaluator's answer."""
    return answer if isinstance(answer, int) else sum(answer)


def _chain(g: Guard) -> str:
    tests = " or ".join(f"r{i} < {g.threshold}" for i in range(g.first, g.first + WIDTH))
    return f"speed > 0.1 and ({tests})"


def _names() -> list[str]:
    return [*(f"r{i}" for i in range(RANGES)), "speed"]


def _load(name: str, path: Path) -> ModuleType:
    return _module(importlib.util.spec_from_file_location(name, path))


def _module(spec: Any) -> ModuleType:
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def rule_file(wanted: Iterable[Guard]) -> str:
    """The guards as a rule file with all features: hysteresis, hold, cooldown, policy, priority."""
    rules = [
        f"""
[rule.R{k}]
when = "speed > 0.1 m/s and min(range[{g.first}:{g.first + WIDTH}]) < {g.threshold} m"
until = "min(range[{g.first}:{g.first + WIDTH}]) > {g.threshold + 0.1:.6f} m"
for = "0.1 s"
cooldown = "0.5 s"
trigger = "{("edge", "level")[k % 2]}"
priority = {k}
on_invalid = "{("clear", "trip", "hold")[k % 3]}"
{'max_hold = "1 s"' if k % 3 == 2 else ""}
[rule.R{k}.action]
name = "Stop"
"""
        for k, g in enumerate(wanted)
    ]
    return 'format = "reflex/1"\n' + "".join(rules)


_C = """
#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>

unsigned char fired[@RULES@]; /* visible to others, so that the compiler must write it */

static double least(const double *v) {
    double m = v[0];
    for (int i = 1; i < 8; i++) m = v[i] < m ? v[i] : m;
    return m;
}

static long holding(const double *v) {
    const double speed = v[64];
    long count = 0;
@TESTS@
    return count;
}

static PyObject *step(PyObject *self, PyObject *const *args, Py_ssize_t count) {
    Py_buffer x;
    if (count != 2 || PyObject_GetBuffer(args[0], &x, PyBUF_C_CONTIGUOUS) < 0) return NULL;
    const long found = holding(x.buf);
    PyBuffer_Release(&x);
    return PyLong_FromLong(found);
}

static PyMethodDef methods[] = {{"step", (PyCFunction)(void (*)(void))step, METH_FASTCALL, ""}, {0}};
static PyModuleDef module = {PyModuleDef_HEAD_INIT, "hand", "", 0, methods};
PyMODINIT_FUNC PyInit_hand(void) { return PyModuleDef_Init(&module); }
"""
