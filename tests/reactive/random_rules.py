"""Random rule sets on random traces, from a seed: the kernel and numpy do the same with them.

`conftest.py` gives this module as the fixture `random_rules`.
"""

import math
import random
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.units import LENGTH, SPEED, MetresPerSecond
from rocs_bt.expression import Environment
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.reactive import RuleSet, choose_backend, load_rules
from rocs_bt.reactive.rule_table import RuleTable, lower_rules

ENVIRONMENT = Environment.packed(
    [
        Signal("front", 4, (LENGTH,), bounds=(0.0, 5.0)),
        Signal("rear", 4, (LENGTH,)),
        Signal("goal", 1, (LENGTH,)),
        Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.5)),
        Signal("drift", 1, (SPEED,)),
        Signal("n", 2),
    ]
)
SIZE = 13
WINDOWS = ["0.001 s", "0.1 s", "0.25 s", "1 s", "30 s"]


class Move(AtomicAction):
    """Moves."""

    speed: MetresPerSecond = 0.5

    def act(self, body):
        return Progress.SUCCEEDED


@dataclass(frozen=True)
class Case:
    """A rule set, its table, and a trace for it.

    Attributes:
        text: The rule file.
        rules: The loaded rules.
        table: Lowered with margins.
        rows: Snapshots and times [s].
        modes: Which rule is enabled or not before which row: (row, rule, on).
    """

    text: str
    rules: RuleSet
    table: RuleTable
    rows: list[tuple[np.ndarray, float]]
    modes: list[tuple[int, int, bool]]


class Writer:
    """Writes expressions of a depth."""

    def __init__(self, draw: random.Random) -> None:
        self.draw = draw

    def any_of(self, *options):
        return self.draw.choice(options)

    def group(self, depth):
        """Four lengths."""
        if depth <= 0:
            return self.any_of("front", "rear", "rear[0:4]", "[0.5 m, 1 m, 1.5 m, inf m]")
        a, s = self.group(depth - 1), self.length(depth - 2)
        return self.any_of(
            a,
            f"({a} {self.any_of('+', '-')} {s})",
            f"({a} * {self.plain(depth - 2)})",
            f"abs({a})",
            f"(-{a})",
            f"({a} if {self.truth(depth - 2)} else {self.group(depth - 1)})",
            f"clip({a}, {s}, {self.length(depth - 2)})",
            f"({a} + {self.group(depth - 1)})",
            f"({a} / {self.plain(depth - 2)})",
        )

    def length(self, depth):
        if depth <= 0:
            return self.any_of("goal", "front[1]", "0.5 m", "1 m", "0 m", "inf m", "rear[-1]", "-1 m", "1e300 m")
        a, b, g = self.length(depth - 1), self.length(depth - 2), self.group(depth - 1)
        return self.any_of(
            a,
            f"({a} + {b})",
            f"({a} - {b})",
            f"min({g})",
            f"max({g}, {a})",
            f"mean({g})",
            f"sum({g})",
            f"abs({a})",
            f"({a} * {self.plain(depth - 2)})",
            f"({a} / {self.plain(depth - 2)})",
            f"hypot({a}, {b})",
            f"sqrt({a} * {b})",
            f"clip({a}, {b}, 1 m)",
            f"({a} if {self.truth(depth - 1)} else {b})",
            f"(-{a})",
            f"min_valid({g}, {self.any_of(1, 2, 4)})",
            f"dot({g}, [1, -0.5, 0, 2])",
            f"(rate({a}, {self.window()}) * 1 s)",
            f"min({a}, {b}, {g})",
        )

    def plain(self, depth):
        if depth <= 0:
            return self.any_of("n[0]", "n[1]", "0", "2", "-0.5", "inf", "(goal / 1 m)", "(speed / drift)")
        a = self.length(depth - 1)
        return self.any_of(
            f"count({self.tests(depth - 1)})",
            f"argmin({self.group(depth - 1)})",
            f"sign({a})",
            f"side({a})",
            f"({a} / {self.length(depth - 2)})",
            f"(time_since({self.truth(depth - 1)}) / 1 s)",
            f"(atan2({a}, {self.length(depth - 2)}) / 1 rad)",
            f"(wrap_angle({a} * 1 rad / 1 m) / 1 rad)",
            f"(rate(speed, {self.window()}) / 1 m/s2)",
        )

    def tests(self, depth):
        """Four comparisons."""
        g = self.group(depth)
        return self.any_of(
            f"{g} {self.sign()} {self.length(depth - 1)}",
            f"{g} {self.sign()} {self.group(depth - 1)}",
            f"{self.length(depth - 1)} {self.sign()} {g} {self.sign()} {self.length(depth - 1)}",
        )

    def sign(self):
        return self.any_of("<", "<=", ">", ">=", "==", "!=")

    def window(self):
        return self.any_of(*WINDOWS)

    def truth(self, depth):
        if depth <= 0:
            return self.any_of("speed > 0.1 m/s", "goal < 1 m", "True", "drift < speed", "min(front) < 0.5 m", "False")
        a, b = self.truth(depth - 1), self.truth(depth - 2)
        return self.any_of(
            f"({self.length(depth - 1)} {self.sign()} {self.length(depth - 1)})",
            f"({self.length(depth - 1)} {self.sign()} goal {self.sign()} {self.length(depth - 2)})",
            f"({self.plain(depth - 1)} {self.sign()} {self.plain(depth - 2)})",
            f"any({self.tests(depth - 1)})",
            f"all({self.tests(depth - 1)})",
            f"({a} and {b})",
            f"({a} or {b})",
            f"(not {a})",
            f"({a} implies {b})",
            f"({a} if {b} else {self.truth(depth - 1)})",
            f"held({a}, {self.window()})",
            f"once({a}, {self.window()})",
            f"since({a}, {b}, {self.window()})",
            f"({a} and {self.truth(depth - 1)} or {b})",
        )


def _rule(draw, i):
    write, policy = Writer(draw), draw.choice(["trip", "hold", "clear"])

    def time():
        return draw.choice(["0 s", "0.05 s", "0.1 s", "0.3 s"])

    guard = write.truth(draw.choice([0, 1, 2, 2, 3]))
    until = draw.choice(["", "", f"not ({guard})", write.truth(draw.choice([1, 2])), "min(front) > 0.7 m"])
    lines = [f"[rule.R{i}]", f"when = '{guard}'", f"priority = {draw.choice([i, i, 100 + i])}"]
    lines += [f"until = '{until}'"] if until else []
    lines += [f"for = '{time()}'", f"cooldown = '{time()}'", f"trigger = '{draw.choice(['edge', 'level'])}'"]
    lines += [f"on_invalid = '{policy}'", *([f"max_hold = '{time()}'"] if policy == "hold" else [])]
    return "\n".join([*lines, f"[rule.R{i}.action]", "name = 'Move'", ""])


def _row(draw, before):
    """A snapshot: often much like the one before, often hovering about thresholds, at times broken."""
    kind = draw.random()

    def value():
        return draw.choice([0.0, 0.1, 0.3, 0.5, 0.7, 1.0, 2.0, -0.5, draw.uniform(-2, 3)])

    if before is not None and kind < 0.4:
        row = before.copy()
        row[draw.randrange(SIZE)] = value()
    else:
        row = np.array([value() for _ in range(SIZE)])
    if draw.random() < 0.2:
        row[draw.randrange(SIZE)] = draw.choice([math.nan, math.nan, math.inf, -math.inf, -0.0, 1e308, 5e-324])
    if draw.random() < 0.02:
        row[:] = math.nan
    return row


def random_case(seed: int, rules: int | None = None, steps: int | None = None) -> Case:
    """The case of a seed."""
    draw = random.Random(seed)
    count = rules or draw.choice([1, 1, 2, 3, 5, 8])
    while True:
        text = 'format = "reflex/1"\n' + "\n".join(_rule(draw, i) for i in range(count))
        try:
            loaded = load_rules(read_toml(Path("random.toml"), text), ENVIRONMENT, {"Move": Move})
        except InputError as error:
            limits = ("deep", "operations", "characters")
            if not all(any(limit in str(f) for limit in limits) for f in error.faults):
                raise AssertionError(f"{error}\n{text}") from error
            continue
        break
    rows, t, row = [], draw.choice([0.0, 10.0, 1e6]), None
    for _ in range(steps or draw.randint(1, 40)):
        row = _row(draw, row)
        rows.append((row, t))
        t += draw.choice([0.05, 0.05, 0.05, 0.05, 0.02, 0.013, 0.2, 0.0, 1e-4, 1.0, 31.0, draw.uniform(0, 0.3)])
        if draw.random() < 0.02:
            t -= draw.choice([0.3, 1e-9, 100.0])
    modes = [
        (draw.randrange(len(rows)), draw.randrange(count), draw.random() < 0.5) for _ in range(draw.choice([0, 0, 3]))
    ]
    return Case(text, loaded, lower_rules(loaded.rules, margins=True), rows, modes)


def told(machine, case: Case):
    """All that a machine says of a case, row by row, with NaN as None."""
    found = []
    for k, (x, t) in enumerate(case.rows):
        for row, rule, on in case.modes:
            if row == k:
                machine.enable(rule, on)
        winner = machine.step(x, t)
        told = [*machine.blind, *machine.values(), *(machine.register(r) for r in case.table.program.temporal.values())]
        found.append((winner, [bool(on) for on in machine.mask], [None if v != v else float(v).hex() for v in told]))
    return found


def assert_same(case: Case) -> None:
    """That the kernel and numpy do the same with a case, to the bit of every state."""
    expected = told(choose_backend("numpy").machine(case.table), case)
    got = told(choose_backend("kernel").machine(case.table), case)
    for k, (a, b) in enumerate(zip(got, expected, strict=True)):
        assert a == b, f"row {k} at {case.rows[k]}:\nkernel {a}\nnumpy  {b}\n{case.text}"


def same(a, b):
    return np.array_equal(a, b, equal_nan=True)
