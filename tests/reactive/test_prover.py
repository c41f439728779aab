"""The prover behind the checks: what can be true, decided by cases, sums and ranges, beside the interpreter."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rocs_bt.expression import parse
from rocs_bt.reactive.analysis.interval import range_of
from rocs_bt.reactive.analysis.prover import Prover
from rocs_bt.reactive.analysis.simplex import Span
from rocs_bt.reactive.analysis.translate import conjunction, negation

from ..expression.trace import Trace
from .examined import ENVIRONMENT, INF

FOREVER = [
    "held(min(front) < 0.4 m, 0.5 s) and min(front) > 0.5 m",
    "not once(speed > 1 m/s, 0.5 s) and speed > 1.2 m/s",
    "since(speed > 1 m/s, min(front) < 0.4 m, 2 s) and speed < 0.5 m/s and min(front) > 0.6 m",
    "held(speed > 1 m/s, 1 s) and not held(speed > 1 m/s, 1 s)",
    "time_since(speed > 1 m/s) < 0 s",
]


@pytest.mark.parametrize("text", FOREVER)
def test_what_the_past_rules_out_is_proved(text):
    node = parse(text, ENVIRONMENT)
    assert Prover(ENVIRONMENT, [node]).decide(node).never


def test_an_example_of_the_past_stands_for_a_while():
    node = parse("held(min(front) < 0.4 m, 0.5 s) and time_since(speed > 1 m/s) < 1 s", ENVIRONMENT)
    x = Prover(ENVIRONMENT, [node]).decide(node).example
    trace = Trace()
    for k in range(20):
        trace.append(x.tolist(), 0.1 * k)
    assert trace.value(node) is True


# Infinite ranges: each guard against all snapshots of a grid, by the interpreter.
INFINITE = [
    "front[0] < inf m",
    "not (front[0] < inf m)",
    "front[0] >= inf m",
    "front[0] + 1 m < 2 * front[0]",
    "front[0] + 1 m >= 2 * front[0] and front[0] > 1 m",
    "front[0] - 1 m < front[0]",
    "not (front[0] - 1 m < front[0])",
    "front[0] <= front[1] - 1 m and front[1] <= front[0] - 1 m",
    "max(front) < min(front)",
    "not (max(front) >= min(front))",
    "front[0] > goal_distance + 1 m and goal_distance > front[0]",
    "min(front) > inf m",
    "max(front[0] + 1 m, 3 m) >= front[0] * 2",
    "not (max(front[0] + 1 m, 3 m) >= front[0] * 2 or front[0] > 0.9 m)",
    "mean(front) > 3 m and front[1] < 0.1 m",
    "front[0] == front[1] and front[1] == front[2] + 1 m",
    "abs(front[0] - 3 m) < 1 m and front[0] > 5 m",
    "min(front) < min(0.4 m, goal_distance) and not (min(front) < goal_distance)",
    "goal_distance * -1 > -inf m",
    "1.6 * max(front) <= max(front)",
    "(min(front) + max(rear)) >= rear[1]",
    "(min(front) - max(rear)) == front[0] and front[0] != 5.6 m",
    "front[0] == front[1] and 1.6 * max(front) <= max(front) and front[0] < 3 m",
]


@pytest.mark.parametrize("text", INFINITE)
def test_infinite_values_are_values_too(text):
    node = parse(text, ENVIRONMENT)
    answer = Prover(ENVIRONMENT, [node])._proved(node)
    grid = [0.0, 0.3, 1.0, 2.0, 3.5, INF]
    for a in grid:
        for b in grid:
            for c in grid:
                x = [a, b, c, a, 1.0, 1.0, b, 0.5, 0.0, 2.0]
                trace = Trace()
                trace.append(x, 0.0)
                assert not (trace.value(node) and answer.never), (a, b, c)
    if answer.example is not None:
        trace = Trace()
        trace.append(answer.example.tolist(), 0.0)
        assert trace.value(node) is True


# Whether each can be true at all, decided without drawing any examples; speed is between -1 and 1.5 m/s.
DECIDED = [
    ("abs(speed) > 1.4 m/s", True),
    ("abs(speed) > 1.6 m/s", False),
    ("abs(speed) < 0 m/s", False),
    ("-abs(speed) < -1.2 m/s", True),
    ("clip(speed, 0 m/s, 1 m/s) > 1 m/s", False),
    ("clip(speed, 0 m/s, 1 m/s) < 0.5 m/s", True),
    ("side(speed) > 0.5 and speed < 0 m/s", False),
    ("side(speed) < 0 and speed < 0 m/s", True),
    ("sign(speed) == 0", True),
    ("sign(speed) < 0 and speed >= 0 m/s", False),
    ("count(front < 1 m) >= 5", False),
    ("count(front < 1 m) >= 4", True),
    ("count(front < 1 m) == 2 and max(front) < 1 m", False),
    ("sum(front) < 1 m and max(front) > 1 m", False),
    ("dot(rear, [1, -1]) > 0 m and rear[0] < rear[1]", False),
    ("dot(rear, [1, -1]) > 0 m and rear[0] < 1 m", True),
    ("(1 m if speed > 0 m/s else 2 m) > min(rear) and min(rear) > 1.5 m and speed > 0.1 m/s", False),
    ("(1 m if speed > 0 m/s else 2 m) > min(rear) and min(rear) > 1.5 m", True),
    ("argmin(front) > 3", False),
    ("hypot(speed, speed) > 3.1 m/s", False),
    ("wrap_angle(turn_rate * 1 s) > 4 rad", False),
    ("mean(clip(front, 0 m, 1 m)) > 0.9 m and min(front) < 0.5 m", False),
    ("min_valid(front, 2) < 0.4 m and min(front) > 0.4 m", False),
    ("any(front < rear[0]) and all(front > rear[0])", False),
    ("0 m < min(front) < 1 m and min(front) == 1 m", False),
    ("speed / 2 > 0.7 m/s and speed != 1.5 m/s", True),
    ("speed / 2 > 0.7 m/s and speed <= 1.4 m/s", False),
    ("side(speed) * turn_rate > 1 rad/s and speed < 0 m/s and turn_rate > -1 rad/s", False),
]


@pytest.mark.parametrize(("text", "possible"), DECIDED)
def test_cases_and_sums_are_decided(text, possible):
    node = parse(text, ENVIRONMENT)
    prover = Prover(ENVIRONMENT, [node])
    answer = prover._proved(node)
    assert not answer.unknown
    assert answer.never is not possible
    assert possible is (answer.example is not None and prover.confirmed(node, answer.example))


RANGED = [
    "speed",
    "-speed",
    "speed + rear[0] / 1 s",
    "speed - 2 * turn_rate * 1 m/rad",
    "speed * turn_rate",
    "speed / 2",
    "min(rear)",
    "max(front[0], rear)",
    "sum(rear)",
    "mean(rear)",
    "abs(speed)",
    "abs(turn_rate - 3 rad/s)",
    "clip(speed, 0 m/s, 1 m/s)",
    "clip(rear[0], goal_distance, 2 m)",
    "hypot(rear[0] + 1 m, goal_distance + 1 m - 0 m)",
    "atan2(speed, turn_rate * 1 m/rad)",
    "sign(speed)",
    "side(speed)",
    "sqrt(goal_distance * 1 m)",
    "wrap_angle(turn_rate * 3 s)",
    "argmin(front)",
    "count(front < 1 m)",
    "dot(rear, [1, -2])",
    "min_valid(front, 3)",
    "1 m if speed > 0 m/s else rear[0]",
    "1 m / (goal_distance + 1 m)",
    "1 m / (speed * 1 s)",
]


@pytest.mark.parametrize("text", RANGED)
def test_no_value_lies_outside_of_the_range(text):
    node = parse(text, ENVIRONMENT)
    prover = Prover(ENVIRONMENT, [node])
    low, high = range_of(node, lambda index: prover.bounds[index])
    values = prover.samples.value(node)
    values = values[~np.isnan(values)]
    assert len(values) > 100
    assert low - 1e-9 <= values.min()
    assert values.max() <= high + 1e-9


def test_drawn_and_proved_answers_agree():
    texts = [*INFINITE, *FOREVER, "min(front) < 0.4 m", "speed * speed > 1 m2/s2", "count(front < 1 m) >= 3"]
    nodes = [parse(text, ENVIRONMENT) for text in texts]
    prover = Prover(ENVIRONMENT, nodes)
    for node in [*nodes, *map(negation, nodes), conjunction([nodes[0], nodes[-1]])]:
        drawn, proved = prover._sampled(node), prover._proved(node)
        assert not (drawn and proved.never), node.text


def test_values_are_shown_with_their_units():
    from rocs_bt.reactive.analysis.case import Case

    case = Case([], ENVIRONMENT)
    x = np.array([0.3, 1.0, 1.0, 1.0, 2.0, 2.0, INF, 0.25, 0.0, 3.0])
    nodes = [
        parse(text, ENVIRONMENT)
        for text in ("min(front) < 1 m", "min(rear) < goal_distance", "speed > 0 m/s and tags > 1")
    ]
    assert case.shown(x, nodes) == (
        "front[0] = 0.3 m, each other front = 1 m, each rear = 2 m, goal_distance = inf m, speed = 0.25 m/s, tags = 3"
    )


@given(st.tuples(st.floats(allow_nan=False), st.floats(allow_nan=False)).map(sorted))
@example([0.1, 1000.0])
@example([-1000.0, -0.1])
@example([0.0, 8.1])
def test_a_picked_value_is_inside_and_no_farther_from_0_than_it_must_be(ends):
    low, high = ends
    value = Span.of(low, high).pick()
    assert low <= value <= high
    if math.isfinite(low) and math.isfinite(high):
        assert low < value < high or low == high
        nearest = min(max(0, Fraction(low)), Fraction(high))
        assert abs(value - nearest) <= max(4, abs(nearest))
