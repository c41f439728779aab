"""What the checker says of random rules, against z3: a solver that shares nothing with it."""

import itertools
import math
import random
import re
from collections import Counter
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.expression import Environment, compile_expression, parse
from rocs_bt.reactive import OnInvalid, Rule
from rocs_bt.reactive.analysis import analyse_rules
from rocs_bt.reactive.analysis.formula import Effort, Row
from rocs_bt.reactive.analysis.prover import Prover
from rocs_bt.reactive.analysis.sample import Samples
from rocs_bt.reactive.analysis.simplex import Span, solution
from rocs_bt.reactive.analysis.translate import conjunction, negation

from ..expression.trace import Trace
from .oracle import Oracle, z3

ENVIRONMENT = Environment.packed(
    [
        Signal("front", 3, (LENGTH,), bounds=(0.0, 5.0)),
        Signal("rear", 2, (LENGTH,), bounds=(0.1, 3.0)),
        Signal("goal", 1, (LENGTH,), bounds=(0.0, 8.0)),
        Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.5)),
    ]
)
LOW = [0.0] * 3 + [0.1] * 2 + [0.0, -1.0]
HIGH = [5.0] * 3 + [3.0] * 2 + [8.0, 1.5]


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


ORACLE = Oracle(ENVIRONMENT)
satisfiable = ORACLE.satisfiable


def compare(seed, counts):
    writer = Writer(seed)
    nodes = [parse(writer.truth(3), ENVIRONMENT) for _ in range(2)]
    prover = Prover(ENVIRONMENT, nodes)
    a, b = nodes
    for node in (a, negation(a), conjunction([a, b]), conjunction([a, negation(b)])):
        # Once as it comes, and once without the examples that are drawn, which spare it the work.
        for answer in (prover.decide(node), prover._proved(node)):
            known = satisfiable(node)
            if answer.never:
                assert known is not True, f"{seed}: said to be never true: {node.text}"
            if answer.example is not None:
                # Of drawn examples the interpreter's rounding decides, as it does on the robot.
                rounded = known is False and prover._proved(node).never
                assert known is not False or rounded, f"{seed}: z3 knows no example of {node.text}"
                counts["rounded", None] += rounded
                trace = Trace()
                trace.append(answer.example.tolist(), 0.0)
                assert trace.value(node) is True
                assert all(low <= v <= high for v, low, high in zip(answer.example, LOW, HIGH, strict=True))
            if answer.unknown:
                assert len(answer.unknown) > 10
            counts[("unknown" if answer.unknown else "never" if answer.never else "example", known)] += 1


def test_answers_are_z3s_or_cannot_decide():
    counts = Counter()
    for seed in range(40):
        compare(seed, counts)
    unknown = sum(count for (answer, _), count in counts.items() if answer == "unknown")
    assert counts["never", False] > 25, counts
    assert unknown < 0.1 * counts.total(), counts


INFINITE = Environment.packed(
    [
        Signal(signal.name, signal.size, signal.dimensions, bounds=(signal.bounds[0], math.inf))
        for signal in ENVIRONMENT.signals.values()
    ]
)


def compare_with_infinities(seed, counts):
    """z3 has no infinite numbers: what is said to be never true must not be true on any of many snapshots with some."""
    writer = Writer(seed)
    nodes = [parse(writer.truth(2), INFINITE) for _ in range(2)]
    prover = Prover(INFINITE, nodes)
    draw = np.random.default_rng(seed)
    values = np.array([0.0, 0.1, 0.5, 1.0, 2.0, 5.0, math.inf])
    rows = np.maximum(draw.choice(values, (3000, INFINITE.size)), [low for low, _ in prover.bounds])
    for node in (*nodes, negation(nodes[0]), conjunction(nodes), conjunction([nodes[0], negation(nodes[1])])):
        answer = prover._proved(node)
        (true,) = np.nonzero(Samples(rows).truth(node))
        if answer.never:
            found = [rows[i] for i in true[:5] if prover.confirmed(node, rows[i])]
            assert not found, f"{seed}: said to be never true: {node.text}: {found[0]}"
        if answer.example is not None:
            assert prover.confirmed(node, answer.example)
        counts["unknown" if answer.unknown else "never" if answer.never else "example", bool(len(true))] += 1


def test_infinite_values_are_not_forgotten():
    counts = Counter()
    for seed in range(50):
        compare_with_infinities(seed, counts)
    assert counts["never", False] > 10, counts
    assert counts["unknown", True] + counts["unknown", False] < 0.1 * counts.total(), counts


@pytest.mark.soak
def test_infinite_values_are_not_forgotten_for_long():
    counts = Counter()
    for seed in range(1000, 4000):
        compare_with_infinities(seed, counts)
    print(f"{counts.total()} answers held against snapshots with infinite values: {dict(counts)}")


@st.composite
def systems(draw):
    """Rows over five variables, and their spans."""
    numbers = st.integers(-3, 3)
    rows = draw(st.lists(st.tuples(st.tuples(*[numbers] * 5), numbers, st.booleans()), min_size=1, max_size=8))
    spans = [sorted(draw(st.tuples(st.integers(-4, 4), st.integers(-4, 4)))) for _ in range(5)]
    ends = draw(st.tuples(*[st.sampled_from(["closed", "open", "none"])] * 10))
    return rows, spans, ends


@settings(max_examples=300, deadline=None)
@given(systems())
def test_linear_inequalities_are_decided_as_z3_decides_them(system):
    told, limits, ends = system
    variables, solver, rows, spans = [z3.Real(f"v{i}") for i in range(5)], z3.Solver(), [], {}
    for i, (variable, (low, high)) in enumerate(zip(variables, limits, strict=True)):
        left, right = ends[2 * i : 2 * i + 2]
        span = Span.of(-math.inf if left == "none" else low, math.inf if right == "none" else high)
        spans[i] = replace(span, above=left == "open", under=right == "open", low_why=1 << 2 * i, high_why=2 << 2 * i)
        if spans[i].empty:
            return
        if left != "none":
            solver.add(variable > low if left == "open" else variable >= low)
        if right != "none":
            solver.add(variable < high if right == "open" else variable <= high)
    for k, (factors, constant, strict) in enumerate(told):
        terms = {i: f for i, f in enumerate(factors) if f}
        if len(terms) > 1:
            rows.append(Row(terms, Fraction(constant), strict, why=1 << 10 + k))
            total = sum(f * variables[i] for i, f in terms.items()) + constant
            solver.add(total < 0 if strict else total <= 0)
    values, why = solution(rows, spans, Effort(10**6, 10**6))
    assert (values is not None) is (solver.check() == z3.sat)
    if values is None:  # what it gives as the reason has no solution by itself, either
        kept = {i: replace(Span.of(-math.inf, math.inf), low_why=0, high_why=0) for i in spans}
        for i, span in spans.items():
            if why & span.low_why:
                kept[i] = replace(kept[i], low=span.low, above=span.above)
            if why & span.high_why:
                kept[i] = replace(kept[i], high=span.high, under=span.under)
        assert solution([row for row in rows if row.why & why], kept, Effort(10**6, 10**6))[0] is None
        return
    for row in rows:
        total = sum(f * values[i] for i, f in row.terms.items()) + row.constant
        assert total < 0 or (total == 0 and not row.strict)
    for i, value in values.items():
        assert not spans[i].cut(value, True, False).empty
        assert not spans[i].cut(value, False, False).empty


@pytest.mark.soak
def test_answers_are_z3s_or_cannot_decide_for_long():
    counts = Counter()
    for seed in range(1000, 6000):
        compare(seed, counts)
    print(f"{counts.total()} answers compared with z3's: {dict(counts)}")


def rules_of(seed):
    writer, found = Writer(seed), []
    for k in range(5):
        when = f"min(front) < {writer.metres()}" if writer.draw.random() < 0.5 else writer.truth(2)
        until = writer.one(None, f"min(front) > {writer.metres()}", writer.truth(1))
        rule = Rule(
            name=f"f/R{k}",
            when=compile_expression(when, ENVIRONMENT),
            until=None if until is None else compile_expression(until, ENVIRONMENT),
            priority=writer.draw.randrange(4),
            action=writer.one("A", "B"),
            on_invalid=OnInvalid.CLEAR,
        )
        found.append(rule)
    return found


PATTERNS = {
    "never": r"the guard of (\w+) never holds",
    "always": r"the guard of (\w+) always holds",
    "upside": r"when and until of (\w+) hold at once",
    "shadowed": r"(\w+) never acts",
    "tied": r"(\w+) has the same priority",
}


def test_findings_about_rules_are_z3s():
    """Each finding has to be so; each that z3 has is found, unless the checker says that it cannot decide."""
    seen = Counter()
    for seed in range(20):
        rules = rules_of(seed)
        faults = analyse_rules(rules, ENVIRONMENT, {})
        undecided = any(fault.note for fault in faults)
        expected = {kind: set() for kind in PATTERNS}
        dead = {r.name for r in rules if satisfiable(r.when.node) is False}
        for rule in rules:
            name, when = rule.name[2:], rule.when.node
            if rule.name in dead:
                expected["never"].add(name)
            if satisfiable(negation(when)) is False:
                expected["always"].add(name)
            if rule.until is not None and satisfiable(conjunction([when, rule.until.node])):
                expected["upside"].add(name)
        for above, rule in itertools.permutations(rules, 2):
            kept = rule.when.node if rule.until is None else negation(rule.until.node)
            freed = negation(above.when.node) if above.until is None else above.until.node
            if above.priority > rule.priority and rule.name not in dead:
                covered = satisfiable(conjunction([rule.when.node, negation(above.when.node)])) is False
                if covered and satisfiable(conjunction([kept, freed])) is False:
                    expected["shadowed"].add(rule.name[2:])
        for other, rule in itertools.combinations(rules, 2):
            if (other.priority, other.action == rule.action) == (rule.priority, False) and satisfiable(
                conjunction([other.when.node, rule.when.node])
            ):
                expected["tied"].add(rule.name[2:])
        found = {
            kind: {m[1] for f in faults if (m := re.match(pattern, f.message)) and not f.note}
            for kind, pattern in PATTERNS.items()
        }
        for kind, names in found.items():
            assert names <= expected[kind], (seed, kind)
            if not undecided:
                # Invalid signals, which z3 does not know, can let a rule act that is shadowed while all are valid.
                assert names == expected[kind] or kind == "shadowed", (seed, kind)
            seen[kind] += len(names)
    assert min(seen.values()) > 0, seen
