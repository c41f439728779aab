"""A rule of which the checker says that it never acts is never the one that acts, whatever signals are invalid."""

import math
import random
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from rocs_bt.base.signal import Signal
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.expression import Environment
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.reactive import choose_backend, load_rules
from rocs_bt.reactive.analysis import analyse_rules
from rocs_bt.reactive.rule_table import lower_rules

ENVIRONMENT = Environment.packed(
    [
        Signal("front", 2, (LENGTH,), bounds=(0.0, 2.0)),
        Signal("rear", 2, (LENGTH,), bounds=(0.0, math.inf)),
        Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.0)),
    ]
)
VALUES = [[0.0, 0.2, 0.3, 0.4, 1.0, 2.0, math.nan]] * 2 + [[0.0, 0.2, 0.4, math.inf, math.nan]] * 2
VALUES += [[-1.0, 0.0, 0.2, 1.0, math.nan]]


class Halt(AtomicAction):
    """Does nothing."""

    def act(self, body):
        return Progress.SUCCEEDED


class Guards:
    """Random guards that cover each other often."""

    def __init__(self, draw):
        self.draw = draw

    def atom(self):
        metres = self.draw.choice(["0.2 m", "0.3 m", "0.5 m"])
        return self.draw.choice(
            [
                f"min(front) < {metres}",
                f"min(front, rear) < {metres}",
                f"front[0] < {metres}",
                f"any(front < {metres})",
                f"all(rear < {metres})",
                f"front[0] / speed < {metres} / 0.5 m/s",
                f"min_valid(front, 1) < {metres}",
                f"rear[0] - rear[1] < {metres}",
                f"(front[0] if speed > 0 m/s else rear[0]) < {metres}",
                f"0.1 m < front[1] < {metres}",
                f"count(rear < {metres}) > 0",
                f"once(front[0] < {metres}, 0.1 s)",
                "speed > 0 m/s",
                "speed >= 0.1 m/s",
            ]
        )

    def guard(self):
        a, b = self.atom(), self.atom()
        return self.draw.choice([a, a, a, f"({a}) and ({b})", f"({a}) or ({b})", f"not ({a})"])


def rules_of(seed):
    draw = random.Random(seed)
    guards, lines = Guards(draw), ['format = "reflex/1"']
    shared = guards.guard()
    for k in range(3):
        when = draw.choice([shared, f"({shared}) or ({guards.atom()})", f"({shared}) and ({guards.atom()})"])
        until = draw.choice(["", "", f"until = '{guards.guard()}'", f"until = 'not ({shared})'"])
        policy = draw.choice(["'clear'", "'clear'", "'trip'", "'hold'\nmax_hold = '0.1 s'"])
        hold = draw.choice(["0 s", "0 s", "0.1 s"])
        lines += [f"[rule.R{k}]", f"when = '{when}'", until, f"priority = {k + 1}", f"for = '{hold}'"]
        lines += [f"on_invalid = {policy}", f"trigger = '{draw.choice(['edge', 'level'])}'", "action.name = 'Halt'"]
    table = read_toml(Path("random.toml"), "\n".join(lines))
    return load_rules(table, ENVIRONMENT, {"Halt": Halt}).rules, "\n".join(lines)


def claims(rules):
    faults = analyse_rules(rules, ENVIRONMENT, {})
    return {m[1] for f in faults if (m := re.match(r"(\w+) never acts", f.message))}


def rows(draw, count):
    """Snapshots, of which each differs from the last one in few values."""
    row = np.array([draw.choice(values) for values in VALUES])
    for _ in range(count):
        for i in draw.sample(range(len(row)), draw.choice([1, 1, 2, 5])):
            row[i] = draw.choice(VALUES[i])
        yield row.copy()


def hold_claims(seed, counts, steps):
    rules, text = rules_of(seed)
    dead = claims(rules)
    counts["sets"] += 1
    counts["claims"] += len(dead)
    if not dead:
        return
    machine = choose_backend().machine(lower_rules(rules))
    for k, row in enumerate(rows(random.Random(seed), steps)):
        winner = machine.step(row, 0.05 * k)
        name = "" if winner < 0 else rules[winner].name.rpartition("/")[2]
        assert name not in dead, f"{seed}: {name} acts with {row}\n{text}"


def test_a_rule_that_never_acts_never_does():
    counts = Counter()
    for seed in range(60):
        hold_claims(seed, counts, 150)
    assert counts["claims"] > 8, counts


@pytest.mark.soak
def test_a_rule_that_never_acts_never_does_for_long():
    counts = Counter()
    for seed in range(1000, 9000):
        hold_claims(seed, counts, 400)
    assert counts["claims"] > 800, counts


LOW = "[rule.Low]\nwhen = 'min(front) < 0.3 m'\npriority = 1\non_invalid = '{low}'\naction.name = 'Halt'\n"
HIGH = "[rule.High]\nwhen = 'min({high}) < 0.3 m'\npriority = 2\non_invalid = '{policy}'\naction.name = 'Halt'\n"


@pytest.mark.parametrize(
    ("low", "high", "policy", "dead"),
    [
        ("clear", "front, rear", "clear", False),  # rear is invalid
        ("clear", "front, rear", "trip", True),
        ("clear", "front", "clear", True),
        ("trip", "front", "clear", False),
        ("trip", "front", "trip", True),
        ("trip", "front, rear", "trip", True),
    ],
)
def test_a_fallback_for_invalid_signals_is_not_dead(low, high, policy, dead):
    text = 'format = "reflex/1"\n' + LOW.format(low=low) + HIGH.format(high=high, policy=policy)
    rules = load_rules(read_toml(Path("fallback.toml"), text), ENVIRONMENT, {"Halt": Halt}).rules
    assert claims(rules) == ({"Low"} if dead else set())
