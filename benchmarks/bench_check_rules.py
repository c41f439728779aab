"""Static checks of a large rule file: 1000 rules over 64 ranges, in CPU seconds.

Half of the rules are subsumed by others, so that there are many proofs and findings. The time includes the
confirmation of each example by the interpreter.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from row import Row, size

from rocs_bt.actions import ACTIONS
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.expression import Environment, compile_expression
from rocs_bt.reactive import Argument, Rule
from rocs_bt.reactive.analysis import analyse_rules

ENVIRONMENT = Environment.packed(
    [Signal("range", 64, (LENGTH,), bounds=(0.02, 30.0)), Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.5))]
)
BUDGET = 6.0  # [s] for 1000 rules
FEW, MANY = size((100, 1000), (5, 10))


def rule(k: int, priority: int) -> Rule:
    """The k-th rule: eight neighbouring ranges and a threshold; every second rule has hysteresis."""
    beams, near = f"range[{k * 7 % 56}:{k * 7 % 56 + 8}]", 0.30 + k % 37 * 0.01
    when = f"speed > 0.1 m/s and min({beams}) < {near:.2f} m"
    until = f"min({beams}) > {near + 0.1:.2f} m" if k % 2 else None
    return Rule(
        name=f"bench/R{k}",
        when=compile_expression(when, ENVIRONMENT),
        until=None if until is None else compile_expression(until, ENVIRONMENT),
        priority=priority,
        action="Stop",
        cooldown=0.5 if k % 3 == 0 else 0.0,
        level=bool(k % 5),
        arguments={"below": Argument(0.1 + k)},
    )


PRIORITIES: dict[str, Callable[[int], int]] = {
    "distinct priorities": lambda k: k,
    "equal priorities": lambda k: 5,
    "random priorities": lambda k: k * 7919 % 1000,
}


def run() -> Iterator[Row]:
    """The rows of this benchmark."""
    for words, priority in PRIORITIES.items():
        seconds = {}
        for count in (FEW, MANY):
            rules = [rule(k, priority(k)) for k in range(count)]
            start = time.process_time()
            findings = len(analyse_rules(rules, ENVIRONMENT, ACTIONS))
            seconds[count] = time.process_time() - start
        name, took = f"check {MANY} rules, {words}, {findings} findings", seconds[MANY]
        ratio = took / seconds[FEW]
        yield Row(name, took, "s", f"{FEW} rules", ratio, f"<= {BUDGET:g} s", took <= BUDGET)
