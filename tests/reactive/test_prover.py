"""The prover against the interpreter: examples are true, and what is said to be never true is true on no row."""

import math
import random
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED, TURN_RATE
from rocs_bt.expression import Environment, Expression, evaluate, operators, parse
from rocs_bt.reactive.analysis.case import Case
from rocs_bt.reactive.analysis.prover import Prover, conjunction, negation
from rocs_bt.reactive.analysis.sample import Samples

from .examined import ENVIRONMENT, INF


def judged(prover, node, rows):
    """The answer of z3 alone, and that with samples, after both were held against rows."""
    samples = Samples(rows)
    (true,) = np.nonzero(samples.truth(node))
    found = rows[true[0]] if true.size else None
    answers = prover._proved(node), prover.decide(node)
    for answer in answers:
        assert not answer.never or found is None, f"said to be never true: {node.text}: {found}"
        shown = [answer.example] if answer is answers[0] or answer.example is None else [prover.example(node)]
        for x in [answer.example, *shown] if answer.example is not None else ():
            assert node.temporal or evaluate(node, x) is True
            assert Samples(x[np.newaxis]).truth(node)
            assert all(low <= v <= high for v, (low, high) in zip(x, prover.bounds, strict=True))
        assert not answer.unknown or len(answer.unknown) > 10
    return answers


def rows_of(prover, values, count, seed=0):
    """Random rows of some values, within the bounds."""
    low, high = np.array(prover.bounds).T
    draw = np.random.default_rng(seed)
    rows = draw.choice(values, (count, len(low)))
    return np.clip(np.where(draw.random((count, 1)) < 0.3, rows[:, :1], rows), low, high)


VALUES = [-1.0, -0.3, 0.0, 0.1, 0.3, 0.5, 1.0, 1.5, 2.0, 3.5, 5.0, 5.6, INF]


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("sqrt(speed * speed) < -1 m/s", "sqrt(speed * speed)"),
        ("sign(speed) > 2", "sign(speed)"),
        ("hypot(speed, speed) < 0 m/s", "hypot(speed, speed)"),
    ],
)
def test_an_operator_without_a_meaning_in_z3_leaves_the_question_open(text, part, monkeypatch):
    node = parse(text, ENVIRONMENT)
    assert Prover(ENVIRONMENT, [node]).decide(node).never
    for op in ("sqrt", "sign", "hypot"):
        monkeypatch.setitem(operators.ROWS, op, replace(operators.ROWS[op], z3=None))
    answer = Prover(ENVIRONMENT, [node]).decide(node)
    assert answer.unknown == f"only a part of the meaning of '{part}' is known"
    assert answer.example is None


def test_an_open_question_says_that_all_steps_are_spent():
    node = parse("wrap_angle(turn_rate * 3 s) == 0.123456789 rad and speed != 0 m/s", ENVIRONMENT)
    prover = Prover(ENVIRONMENT, [node])
    prover._left = 1
    assert prover._proved(node).unknown.startswith("all questions about the rules together take more than ")


def moments(draw):
    """A guard on the past, from operators of which the prover knows a part."""
    a, b = (draw.choice(["speed", "min(front)/1 s", "goal_distance/1 s", "front[1]/1 s"]) for _ in range(2))
    test = draw.choice(
        [f"{a} > 1 m/s", f"{b} < 0.5 m/s", f"rate({a}, 0.2 s) > 0 m/s2", f"not (rate({b}, 0.1 s) < 2 m/s2)"]
    )
    other = draw.choice([f"{b} < 1 m/s", f"rate({a}, 0.1 s) >= inf m/s2", f"{a} == {b}"])
    past = [
        f"held({test}, 0.2 s)",
        f"once({test}, 0.2 s)",
        f"since({other}, {test}, 0.3 s)",
        f"time_since({test}) < 0.2 s",
        f"time_since({test}) > 0.2 s",
        f"min_valid(front + rate({a}, 0.1 s) * 1 s2, 2) < 1 m",
        f"(1 if {test} else 2) < 2",
        test,
        other,
    ]
    one, two, three = (draw.choice(["{}", "not ({})"]).format(draw.choice(past)) for _ in range(3))
    return draw.choice(
        [f"({one}) and ({two})", f"({one}) and ({two}) and ({three})", f"({one}) and ({two} or {three})"]
    )


def test_what_is_never_true_holds_at_no_time_of_a_random_run():
    """Also in the first window, in which a rate is invalid, and with infinite distances, whose rate is invalid."""
    draw, proved = random.Random(0), 0
    for seed in range(150):
        node = parse(moments(draw), ENVIRONMENT)
        prover = Prover(ENVIRONMENT, [node])
        if prover.decide(node).never:
            proved += 1
            guard, rows = Expression(node), rows_of(prover, VALUES, 100, seed)
            for k, x in enumerate(np.repeat(rows, 1 + seed % 4, axis=0)):
                assert guard(x, 0.05 * k) is not True, f"{node.text}: {x}"
    assert proved > 10


# What the past rules out.
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


@pytest.mark.parametrize("proved", [False, True])
def test_an_example_of_the_past_stands_for_a_while(proved):
    node = parse("held(min(front) < 0.4 m, 0.5 s) and time_since(speed > 1 m/s) < 1 s", ENVIRONMENT)
    prover = Prover(ENVIRONMENT, [node])
    x = (prover._proved if proved else prover.decide)(node).example
    guard = Expression(node)
    assert [guard(x, 0.1 * k) for k in range(20)][-1] is True


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


@pytest.mark.parametrize(
    "text", [*INFINITE, "1 m / (speed * 1 s) > 3", "sqrt(speed * 1 s/m) > 1", "min_valid(front / speed, 2) < 1 s"]
)
def test_infinite_values_are_values_too(text):
    node = parse(text, ENVIRONMENT)
    prover = Prover(ENVIRONMENT, [node])
    rows = rows_of(prover, VALUES, 4000)
    for each in (node, negation(node)):
        answer, _ = judged(prover, each, rows)
        assert not answer.unknown


# Whether each can be true at all, decided by z3 alone; speed is between -1 and 1.5 m/s.
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
    ("speed * turn_rate > 2.9 m*rad/s2 and speed < 1 m/s", False),
    ("speed * turn_rate > 2.9 m*rad/s2 and speed < 1.49 m/s", True),
    ("sqrt(hypot(speed, speed) * 1 m/s) > 1.19 m/s and speed < 0.99 m/s", False),
    ("hypot(speed, 0.3 m/s) < 0.29 m/s", False),
    ("1 s / (speed * 1 s2/m) > 0.7 and speed > 1.45 m/s", False),
    ("min(front) >= inf m and (front[0] - front[1] < 1 m or front[0] - front[1] >= 1 m)", False),
    ("speed == 0 m/s and (front[0] / speed < 1 s or front[0] / speed >= 1 s)", False),
    ("clip(speed, 1 m/s, 0 m/s) < 0.5 m/s", True),
    ("clip(speed, 0 m/s, 1 m/s) > 0.5 m/s and speed > 1.2 m/s", True),
    ("min(front) > 1e25 m and max(front) < inf m", True),
    ("argmin(front) == 2 and front[0] <= front[1] and front[1] <= front[2]", False),
    ("wrap_angle(turn_rate * 3 s) < -3 rad and turn_rate > 0 rad/s", True),
]


@pytest.mark.parametrize(("text", "possible"), DECIDED)
def test_cases_sums_and_products_are_decided(text, possible):
    node = parse(text, ENVIRONMENT)
    prover = Prover(ENVIRONMENT, [node])
    answer, _ = judged(prover, node, rows_of(prover, VALUES, 500))
    assert not answer.unknown
    assert answer.never is not possible


def test_values_are_shown_with_their_units():
    case = Case([], ENVIRONMENT)
    x = np.array([0.3, 1.0, 1.0, 1.0, 2.0, 2.0, INF, 0.25, 0.0, 3.0])
    nodes = [
        parse(text, ENVIRONMENT)
        for text in ("min(front) < 1 m", "min(rear) < goal_distance", "speed > 0 m/s and tags > 1")
    ]
    assert case.shown(x, nodes) == (
        "front[0] = 0.3 m, each other front = 1 m, each rear = 2 m, goal_distance = inf m, speed = 0.25 m/s, tags = 3"
    )


FINITE = Environment.packed(
    [
        Signal("front", 3, (LENGTH,), bounds=(0.0, 5.0)),
        Signal("rear", 2, (LENGTH,), bounds=(0.1, 3.0)),
        Signal("goal", 1, (LENGTH,), bounds=(0.0, 8.0)),
        Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.5)),
    ]
)
INFINITE_TOO = Environment.packed(
    [
        Signal(signal.name, signal.size, signal.dimensions, bounds=(signal.bounds[0], math.inf))
        for signal in FINITE.signals.values()
    ]
)


class Writer:
    """Random guards: sums, cases, groups, and now and then a product."""

    def __init__(self, seed):
        self.draw = random.Random(seed)

    def one(self, *options):
        return self.draw.choice(options)

    def metres(self):
        return f"{self.draw.randrange(0, 60) / 10} m"

    def number(self, depth):
        """A length."""
        if depth <= 0:
            return self.one("front[0]", "front[1]", "rear[1]", "goal", self.metres(), "min(front)", "max(rear)")
        a, b = self.number(depth - 1), self.number(depth - 1)
        k = self.draw.randrange(-20, 20) / 10
        return self.one(
            f"min({a}, {b})",
            f"max({a}, {b})",
            f"({a} + {b})",
            f"({a} - {b})",
            f"{k} * {a}",
            f"-({a})",
            f"abs({a})",
            f"clip({a}, 0.5 m, 2 m)",
            f"({a} if {self.truth(depth - 2)} else {b})",
            "mean(front)",
            "sum(rear)",
            f"max(front, {a})",
            "dot(front, [1, -0.5, 2])",
            f"({a}) / 2",
            f"{a} * side({b})",
            f"sign({a}) * {b}",
            f"count(front < {self.metres()}) * {a}",
            "min_valid(front, 2)",
            "mean(clip(front, 0 m, 1 m))",
            "speed * 2 s",
            "speed * speed * 1 s2/m",
        )

    def truth(self, depth):
        if depth <= 0 or self.draw.random() < 0.4:
            a, b, sign = self.number(min(depth, 1)), self.metres(), self.one("<", "<=", ">", ">=", "<", ">", "==", "!=")
            return self.one(
                f"{a} {sign} {b}",
                f"{a} {sign} {self.number(0)}",
                f"any(front {sign} {b})",
                f"all(front {sign} {b})",
                f"speed {sign} {self.draw.randrange(-12, 17) / 10} m/s",
                f"{self.metres()} < {a} < {b}",
            )
        a, b = self.truth(depth - 1), self.truth(depth - 1)
        return self.one(f"({a} and {b})", f"({a} or {b})", f"not ({a})", f"({a} if {b} else {self.truth(0)})", a)


def compare(seed, environment, counts):
    writer = Writer(seed)
    a, b = nodes = [parse(writer.truth(3), environment) for _ in range(2)]
    prover = Prover(environment, nodes)
    rows = rows_of(prover, [*VALUES[:-1], max(5.9, prover.bounds[0][1])], 2000, seed)
    for node in (a, negation(a), conjunction([a, b]), conjunction([a, negation(b)])):
        for answer in judged(prover, node, rows):
            counts["unknown" if answer.unknown else "never" if answer.never else "example"] += 1


@pytest.mark.parametrize("environment", [FINITE, INFINITE_TOO], ids=["finite", "infinite"])
def test_random_guards_are_decided(environment):
    counts = Counter()
    for seed in range(30):
        compare(seed, environment, counts)
    assert counts["never"] > 20, counts
    assert counts["unknown"] < 0.03 * counts.total(), counts


@pytest.mark.soak
@pytest.mark.parametrize("environment", [FINITE, INFINITE_TOO], ids=["finite", "infinite"])
def test_random_guards_are_decided_for_long(environment):
    counts = Counter()
    for seed in range(1000, 4000):
        compare(seed, environment, counts)
    print(f"{counts.total()} answers held against rows: {dict(counts)}")


FAR, GROUPS = 30.0, ("front", "left_gap", "right_gap", "rear")


def environment(beams):
    return Environment.packed(
        [
            *(
                Signal(name, beams, (LENGTH,), bounds=(0.02, FAR))
                for name in ("front", "left_gap", "right_gap", "rear")
            ),
            Signal("goal_distance", 1, (LENGTH,), bounds=(0.0, 100.0)),
            Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.5)),
            Signal("turn_rate", 1, (TURN_RATE,), bounds=(-3.0, 3.0)),
            Signal("stop_distance", 1, (LENGTH,), bounds=(0.0, 2.0)),
        ]
    )


# Whether each can be true.
GUARDS = [
    ("min(front) < min(0.40 m, max(goal_distance - 0.07 m, 0.05 m)) and speed > 0.05 m/s", True),
    ("mean(clip(left_gap, 0 m, 1 m)) - mean(clip(right_gap, 0 m, 1 m)) > 0.76 m and min(right_gap) < 0.2 m", True),
    ("mean(clip(left_gap, 0 m, 1 m)) - mean(clip(right_gap, 0 m, 1 m)) > 0.62 m and all(right_gap > 0.39 m)", False),
    ("mean(clip(rear, 0 m, 1 m)) - mean(clip(front, 0 m, 1 m)) > 0.36 m"
     " and mean(clip(left_gap, 0 m, 1 m)) - mean(clip(rear, 0 m, 1 m)) > 0.69 m", False),
    ("mean(clip(rear, 0 m, 1 m)) - mean(clip(front, 0 m, 1 m)) > 0.36 m"
     " and mean(clip(left_gap, 0 m, 1 m)) - mean(clip(rear, 0 m, 1 m)) > 0.59 m", True),
    ("count(right_gap < 0.37 m) >= 1 and all(right_gap > 0.78 m)", False),
    ("count(front < 1.93 m) >= 5 and sum(clip(front, 0 m, 1 m)) / 4 < 0.66 m and min(rear) < 1.2 m", True),
    ("speed * 1 s > max(left_gap) - 1.44 m and mean(front) < stop_distance + 0.3 m", True),
    ("speed * 1 s > max(left_gap) - 0.3 m and min(left_gap) > 1.81 m", False),
    ("abs(min(front) - min(rear)) > 0.57 m and abs(min(rear) - min(left_gap)) < 0.1 m"
     " and abs(min(front) - min(left_gap)) < 0.46 m", False),
    ("side(mean(left_gap) - mean(right_gap)) * turn_rate > 1.9 rad/s and mean(left_gap) < mean(right_gap)"
     " and turn_rate > -1.8 rad/s", False),
    ("min_valid(front, 3) < 0.4 m and max(min(front), min(rear)) > 1.5 m and any(rear < 1.6 m)", True),
]  # fmt: skip  # the answer is beside its guard


@pytest.mark.parametrize("beams", [16, 24])
@pytest.mark.parametrize(("text", "possible"), GUARDS)
def test_guards_of_real_size_are_decided(text, possible, beams):
    known = environment(beams)
    node = parse(text, known)
    prover = Prover(known, [node])
    answer, _ = judged(prover, node, rows_of(prover, VALUES, 200))
    assert not answer.unknown
    assert answer.never is not possible
