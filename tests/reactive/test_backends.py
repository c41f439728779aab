"""The kernel and numpy, two implementations of one table, do the same with random rule sets and traces."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rocs_bt.expression import Expression, compile_expression, parse_requirement
from rocs_bt.reactive import Rule, RuleSet, choose_backend, lower_rules
from rocs_bt.reactive.rule_table import carry

from .. import needs
from .random_rules import same

BACKENDS = ["numpy", pytest.param("kernel", marks=needs.kernel)]


@needs.kernel
@pytest.mark.parametrize("part", range(3))
def test_both_do_the_same(random_rules, part):
    for seed in range(100 * part, 100 * (part + 1)):
        random_rules.assert_same(random_rules.random_case(seed))


@needs.kernel
@pytest.mark.soak
@pytest.mark.parametrize("part", range(20))
def test_both_do_the_same_for_long(random_rules, part):
    for seed in range(1000 + 500 * part, 1500 + 500 * part):
        random_rules.assert_same(random_rules.random_case(seed))


@pytest.mark.parametrize("name", BACKENDS)
def test_a_state_can_be_taken_over(random_rules, name):
    """A machine that goes on from another's state does what the other would have done, to the bit."""
    backend = choose_backend(name)
    for seed in range(60):
        case = random_rules.random_case(seed)
        whole, first = backend.machine(case.table), backend.machine(case.table)
        half = len(case.rows) // 2
        for x, t in case.rows[:half]:
            assert whole.step(x, t) == first.step(x, t)
        second = backend.machine(case.table)
        second.restore(first.values())
        for x, t in case.rows[half:]:
            assert whole.step(x, t) == second.step(x, t)
            assert same(whole.values(), second.values())


@pytest.mark.parametrize("name", BACKENDS)
def test_batches_do_what_steps_do(random_rules, name):
    backend = choose_backend(name)
    for seed in range(40):
        case = random_rules.random_case(seed)
        x, t = np.array([row[0] for row in case.rows]), np.array([row[1] for row in case.rows])
        machine, values = choose_backend("numpy").machine(case.table), case.table.start()
        steps = backend.batch_time(case.table, x, t, values)
        for k, (row, time) in enumerate(case.rows):
            assert steps.winner[k] == machine.step(row, time)
            assert steps.mask[k].tolist() == [bool(on) for on in machine.mask]
            assert same(steps.margin[k], np.array(machine.margins))
        assert same(values, machine.values())
        lanes = case.table.start(len(x))
        for time in (5.0, 5.1):
            before = lanes.copy()
            at_once = backend.batch_lanes(case.table, x, time, lanes)
            for k, row in enumerate(x):
                machine.restore(before[k])
                assert at_once.winner[k] == machine.step(row, time)
                assert same(lanes[k], machine.values())


@needs.kernel
def test_delays_too(random_rules):
    """What requirements about the future become: no rule file can hold a delay."""
    texts = [
        "min(front) < 0.5 m implies within 0.2 s speed < 0.1 m/s",
        "goal < 1 m and within 1 s (goal > 1 m or within 0.25 s any(rear < drift * 1 s))",
        "held(goal < 1 m, 0.1 s) or since(speed > 0 m/s, within 0.05 s goal < 1 m, 1 s)",
        "rate(goal, 0.1 s) > 0 m/s implies within 30 s speed < drift",
    ]
    nodes = [parse_requirement(text, random_rules.ENVIRONMENT).node for text in texts]
    rules = tuple(Rule(f"r/R{i}", Expression(node), i, "Move") for i, node in enumerate(nodes))
    table = lower_rules(rules, margins=True)
    for seed in range(60):
        case = random_rules.random_case(seed, rules=1)
        case = replace(case, rules=RuleSet("r", rules), table=table, modes=[])
        random_rules.assert_same(case)


@pytest.mark.parametrize("name", BACKENDS)
def test_what_begins_otherwise_is_not_shared(random_rules, name):
    """Before its window is covered `held` is false and `once` is not the contrary of it, though both compute alike."""
    texts = ["held(not goal < 1 m, 1 s)", "once(goal < 1 m, 1 s)"]
    rules = [Rule(t, compile_expression(t, random_rules.ENVIRONMENT), i, "Stop") for i, t in enumerate(texts)]
    for order in (rules, rules[::-1]):
        machine = choose_backend(name).machine(lower_rules(order))
        machine.step(np.full(random_rules.SIZE, 5.0), 0.0)
        assert not any(machine.mask)


def test_a_rule_that_is_the_same_in_two_tables_keeps_its_state(random_rules):
    case = random_rules.random_case(5, rules=3)
    machine = choose_backend("numpy").machine(case.table)
    for x, t in case.rows:
        machine.step(x, t)
    old, new = case.table, lower_rules([*case.rules.rules[1:], *case.rules.rules[:1]])
    values = machine.values()
    carried = carry(values, old, new)
    for column in ("latched", "risen", "ready", "unknown", "enabled", "blind"):
        before, after = values[old.part(column)].tolist(), carried[new.part(column)].tolist()
        assert after == [*before[1:], before[0]]
    assert carried[0] == values[0]
    assert not math.isinf(carried[0])
