"""The compiled kernel: its batches, threads and refusals. test_backends compares what it computes with numpy."""

import dataclasses
import random
import sys
import threading

import numpy as np
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.expression import compile_expression, kernel_missing
from rocs_bt.expression.operators import CODES, INSTRUCTIONS
from rocs_bt.reactive import Rule, choose_backend, lower_rules
from rocs_bt.reactive.kernel_backend import KernelBackend, compiled

from .. import needs
from .random_rules import same

WILD = [np.nan, np.inf, -np.inf, 0.0, -1.0, 1e9, -1e9, 3.5, 1e300]
NUMBERS = [-(2**31), -1000, -2, -1, 0, 1, 2, 3, 5, 8, 40, 1000, 2**30, 2**31 - 1]


@pytest.fixture
def kernel():
    return KernelBackend()


class TestChoice:
    def test_auto_is_the_kernel_where_it_is(self):
        assert choose_backend().name == ("numpy" if kernel_missing() else "kernel")
        assert choose_backend("numpy").name == "numpy"

    def test_it_is_not_missed_where_it_is_not(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "rocs_bt.expression._kernel", None)
        monkeypatch.delattr("rocs_bt.expression._kernel", raising=False)
        kernel_missing.cache_clear()
        try:
            assert choose_backend().name == "numpy"
            with pytest.raises(InputError, match="choose 'numpy'"):
                choose_backend("kernel")
        finally:
            kernel_missing.cache_clear()

    def test_other_names_are_refused_with_those_that_exist(self):
        with pytest.raises(InputError, match="kernel"):
            choose_backend("fortran")


@needs.kernel
def test_it_knows_every_operation():
    """And numbers them as the table of Python does."""
    from rocs_bt.expression import _kernel

    assert _kernel.OPERATIONS.lower().split() == [row.name for row in INSTRUCTIONS]


@needs.kernel
class TestBatches:
    def test_none_and_strided_arrays_are_taken(self, kernel, random_rules):
        table = random_rules.random_case(5).table
        width, size = table.width, random_rules.SIZE
        assert kernel.batch_time(table, np.empty((0, size)), np.empty(0), table.start()).mask.shape == (
            0,
            len(table.names),
        )
        wide = np.full((4, 2 * width), np.nan)
        wide[:, ::2] = table.start(4)
        x = np.asfortranarray(np.ones((4, size)))
        steps = kernel.batch_lanes(table, x, 1.0, wide[:, ::2])
        states = table.start(4)
        assert same(steps.winner, kernel.batch_lanes(table, np.ones((4, size)), 1.0, states).winner)
        assert same(wide[:, ::2], states)
        machine = kernel.machine(table)
        assert machine.step(np.ones(2 * size)[::2], 1.0) == steps.winner[0]
        assert same(machine.values(), states[0])

    def test_other_threads_go_on_meanwhile(self, kernel, random_rules):
        """A thread that counts between naps cannot while this one holds the GIL, which nobody is made to give away."""
        table = random_rules.random_case(11, rules=8).table
        x, t = np.ones((200_000, random_rules.SIZE)), np.arange(200_000) * 0.05
        counted, stop = [0], threading.Event()

        def count():
            while not stop.wait(0.0005):
                counted[0] += 1

        interval = sys.getswitchinterval()
        sys.setswitchinterval(1e3)
        thread = threading.Thread(target=count)
        try:
            thread.start()
            before = counted[0]
            kernel.batch_time(table, x, t, table.start())
            after = counted[0]
        finally:
            stop.set()
            sys.setswitchinterval(interval)
            thread.join()
        assert after > before


@needs.kernel
class TestWrongInput:
    def test_a_broken_table_is_refused_or_harmless(self, random_rules):
        """A crash of the interpreter is what would fail here."""
        draw, refused = random.Random(1), 0
        for seed in range(400):
            case = random_rules.random_case(seed % 60, steps=3)
            values = np.array([draw.choice([*WILD, 1.0]) for _ in range(case.table.width)])
            try:
                machine = compiled(_broken(draw, case.table)).machine(values)
                for x, t in case.rows:
                    machine.step(x, t)
            except ValueError:
                refused += 1
        assert 200 < refused < 400

    def test_what_a_temporal_operation_needs_must_exist(self, random_rules):
        """Reading a little too far seldom crashes, so it is the refusal that is looked at."""
        guard = compile_expression("held(goal < 1 m, 0.1 s)", random_rules.ENVIRONMENT)
        table = lower_rules([Rule("r/R", guard, 1, "Stop")])
        row = [op == CODES["held"] for op in table.program.code[:, 0]].index(True)
        for column, last, words in ((5, table.program.registers.size - 3, "reads register"), (7, 1, "needs cell")):
            code = table.program.code.copy()
            code[row, column] = last
            with pytest.raises(ValueError, match=words):
                compiled(dataclasses.replace(table, program=dataclasses.replace(table.program, code=code)))

    def test_a_broken_state_is_harmless(self, kernel, random_rules):
        draw = random.Random(2)
        for seed in range(200):
            case = random_rules.random_case(seed)
            machine = kernel.machine(case.table)
            machine.restore(np.array([draw.choice(WILD) for _ in range(case.table.width)]))
            for x, t in case.rows:
                assert -1 <= machine.step(x, t) < len(case.table.names)

    def test_what_does_not_fit_is_refused(self, kernel, random_rules):
        table = random_rules.random_case(5, rules=3).table
        x = np.ones(random_rules.SIZE)
        machine = kernel.machine(table)
        machine.step(x, 0.0)
        with pytest.raises(ValueError, match="signals"):
            machine.step(x[:1], 0.0)
        with pytest.raises(ValueError, match="kind"):
            machine.step(x.astype(np.float32), 0.0)
        with pytest.raises(TypeError):
            machine.step("front", 0.0)
        with pytest.raises(TypeError):
            machine.step(x, "now")
        with pytest.raises(IndexError):
            machine.register(10**6)
        with pytest.raises(ValueError, match="state"):
            kernel.batch_lanes(table, np.ones((3, x.size)), 0.0, table.start(2))
        with pytest.raises(ValueError, match="times"):
            kernel.batch_time(table, np.ones((3, x.size)), np.zeros(2), table.start())

    def test_a_snapshot_may_change_its_array(self, kernel, random_rules):
        """The kernel keeps the last one open; another one must not be taken for it."""
        case = random_rules.random_case(12, steps=40)
        one, other, buffer = kernel.machine(case.table), kernel.machine(case.table), np.empty(random_rules.SIZE)
        for k, (x, t) in enumerate(case.rows):
            buffer[:] = x
            assert one.step(buffer if k % 3 else x.copy(), t) == other.step(list_view(x), t)
        assert same(one.values(), other.values())


def list_view(x):
    return memoryview(bytearray(x.tobytes())).cast("d")


def _broken(draw, table):
    """A table in which one number, or the length of one array, is another."""
    program = table.program
    what = draw.choice(
        ["code", "code", "code", "code", "when", "until", "margins", "registers", "initial", "hold", "level"]
    )
    if what == "code":
        code = program.code.copy()
        code[draw.randrange(len(code)), draw.randrange(8)] = draw.choice([*NUMBERS, draw.randrange(60)])
        return dataclasses.replace(table, program=dataclasses.replace(program, code=code))
    if what == "registers":
        registers = program.registers.copy()
        registers[draw.randrange(len(registers))] = draw.choice(WILD)
        registers = registers[: draw.choice([len(registers), 0, len(registers) // 2])]
        return dataclasses.replace(table, program=dataclasses.replace(program, registers=registers))
    array = getattr(table, what).copy()
    if what in ("when", "until", "margins") and draw.random() < 0.7:
        array[draw.randrange(len(array))] = draw.choice(NUMBERS)
    else:
        array = array[: draw.choice([0, len(array) - 1])]
    return dataclasses.replace(table, **{what: array})
