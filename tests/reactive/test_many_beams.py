"""Rules of real size, over groups of 16 and 24 beams: each question is decided, and as z3 decides it."""

import random
from collections import Counter

import pytest

from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED, TURN_RATE
from rocs_bt.expression import Environment, parse
from rocs_bt.reactive.analysis.prover import Prover
from rocs_bt.reactive.analysis.translate import conjunction, negation

from ..expression.trace import Trace
from .oracle import Oracle

GROUPS = ("front", "left_gap", "right_gap", "rear")
FAR = 30.0


def environment(beams):
    return Environment.packed(
        [
            *(Signal(name, beams, (LENGTH,), bounds=(0.02, FAR)) for name in GROUPS),
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
]  # fmt: skip  # a table


@pytest.mark.parametrize("beams", [16, 24])
@pytest.mark.parametrize(("text", "possible"), GUARDS)
def test_guards_of_real_size_are_decided(text, possible, beams):
    known = environment(beams)
    node = parse(text, known)
    answer = Prover(known, [node])._proved(node)  # without the examples that are drawn
    assert answer.unknown == ""
    assert answer.never is not possible
    if possible:
        trace = Trace()
        trace.append(answer.example.tolist(), 0.0)
        assert trace.value(node) is True
    assert Oracle(known, milliseconds=300).satisfiable(node) in (possible, None)


class Writer:
    """Random guards as people write them for robots."""

    def __init__(self, seed):
        self.draw = random.Random(seed)

    def metres(self, low=0.1, high=2.0):
        return f"{self.draw.uniform(low, high):.2f} m"

    def group(self):
        return self.draw.choice(GROUPS)

    def number(self):
        a, b = self.group(), self.group()
        return self.draw.choice(
            [
                f"min({a})",
                f"min({a}, {b})",
                f"max({a})",
                f"mean({a})",
                f"mean(clip({a}, 0 m, {self.metres(0.5)}))",
                f"max(min({a}), min({b}))",
                f"min({a}, goal_distance)",
                f"sum(clip({a}, 0 m, 1 m)) / 4",
            ]
        )

    def limit(self):
        return self.draw.choice(
            [
                self.metres(),
                self.metres(),
                f"min({self.metres()}, max(goal_distance - 0.07 m, 0.05 m))",
                f"stop_distance + {self.metres(0.05, 0.4)}",
                f"max({self.metres()}, abs(speed) * 1 s)",
                f"goal_distance - {self.metres(0.05, 0.2)}",
            ]
        )

    def comparison(self):
        a, b, m = self.group(), self.group(), self.metres()
        return self.draw.choice(
            [
                f"{self.number()} < {self.limit()}",
                f"{self.number()} > {self.limit()}",
                f"any({a} < {m})",
                f"all({a} > {m})",
                f"count({a} < {m}) >= {self.draw.randrange(1, 6)}",
                f"speed > {self.draw.uniform(0, 1):.2f} m/s",
                f"abs(speed) < {self.draw.uniform(0, 1):.2f} m/s",
                f"mean(clip({a}, 0 m, 1 m)) - mean(clip({b}, 0 m, 1 m)) > {self.metres(0.05, 0.8)}",
                f"abs(min({a}) - min({b})) > {self.metres(0.05, 1.0)}",
                f"speed * 1 s > {self.number()} - {m}",
                f"min_valid({a}, 3) < {m}",
                f"side(mean({a}) - mean({b})) * turn_rate > {self.draw.uniform(0, 2):.1f} rad/s",
            ]
        )

    def guard(self):
        text = self.comparison()
        for _ in range(self.draw.randrange(4)):
            text = f"({text}) {self.draw.choice(['and', 'and', 'or'])} ({self.comparison()})"
        return text


def compare(seeds, beams, milliseconds):
    """How often which answer was given: by the checker, by z3."""
    known, counts = environment(beams), Counter()
    oracle = Oracle(known, milliseconds)
    for seed in seeds:
        writer = Writer(seed)
        a, b = (parse(writer.guard(), known) for _ in range(2))
        prover = Prover(known, [a, b])
        for node in (a, negation(a), conjunction([a, b]), conjunction([a, negation(b)])):
            answer, possible = prover.decide(node), oracle.satisfiable(node)
            assert not (answer.never and possible), f"{seed}: said to be never true: {node.text}"
            assert answer.example is None or possible is not False, f"{seed}: z3 knows no example of {node.text}"
            counts["unknown" if answer.unknown else "never" if answer.never else "example", possible] += 1
    return counts


def test_random_guards_over_24_beams_are_decided_as_z3_decides_them():
    counts = compare(range(20, 32), 24, milliseconds=300)
    assert counts["unknown", True] == counts["unknown", False] == 0, counts
    assert counts["unknown", None] <= 2, counts
    assert counts["never", False] > 1, counts


@pytest.mark.soak
def test_random_guards_over_many_beams_for_long():
    for beams in (8, 16, 24):
        counts = compare(range(1000, 1150), beams, milliseconds=2000)
        unknown = sum(count for (answer, _), count in counts.items() if answer == "unknown")
        print(f"{beams} beams, {counts.total()} questions: {unknown} cannot be decided; {dict(counts)}")
        assert unknown <= 0.02 * counts.total()
