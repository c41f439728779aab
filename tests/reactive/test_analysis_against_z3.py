"""What the checker says of random rules, against z3: a solver that shares nothing with it."""

import itertools
import random
import re
from collections import Counter
from fractions import Fraction

import pytest

from rocs_bt.expression import Environment, Trace, compile_expression, evaluate, parse
from rocs_bt.reactive import OnInvalid, Rule
from rocs_bt.reactive.analysis import analyse_rules
from rocs_bt.reactive.analysis.prover import Prover
from rocs_bt.reactive.analysis.translate import conjunction, negation
from rocs_bt.signal import Signal
from rocs_bt.units import LENGTH, SPEED

z3 = pytest.importorskip("z3", reason="z3-solver, the oracle, is not installed")

ENVIRONMENT = Environment.packed(
    [
        Signal("front", 3, (LENGTH,), bounds=(0.0, 5.0)),
        Signal("rear", 2, (LENGTH,), bounds=(0.1, 3.0)),
        Signal("goal", 1, (LENGTH,), bounds=(0.0, 8.0)),
        Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.5)),
    ]
)
SIZE = 7
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
            f"min({a}, {b})", f"max({a}, {b})", f"({a} + {b})", f"({a} - {b})", f"{k} * {a}", f"-({a})", f"abs({a})",
            f"clip({a}, 0.5 m, 2 m)", f"({a} if {self.truth(depth - 2)} else {b})", "mean(front)", "sum(rear)",
            f"max(front, {a})", "dot(front, [1, -0.5, 2])", f"({a}) / 2", f"{a} * side({b})", f"sign({a}) * {b}",
            f"count(front < {self.metres()}) * {a}", "min_valid(front, 2)", "mean(clip(front, 0 m, 1 m))",
            "speed * 2 s", "speed * speed * 1 s2/m",
        )  # fmt: skip

    def truth(self, depth):
        if depth <= 0 or self.draw.random() < 0.4:
            a, b, sign = self.number(min(depth, 1)), self.metres(), self.one("<", "<=", ">", ">=", "<", ">", "==", "!=")
            return self.one(
                f"{a} {sign} {b}", f"{a} {sign} {self.number(0)}", f"any(front {sign} {b})", f"all(front {sign} {b})",
                f"speed {sign} {self.draw.randrange(-12, 17) / 10} m/s", f"{self.metres()} < {a} < {b}",
            )  # fmt: skip
        a, b = self.truth(depth - 1), self.truth(depth - 1)
        return self.one(f"({a} and {b})", f"({a} or {b})", f"not ({a})", f"({a} if {b} else {self.truth(0)})", a)


VARIABLES = [z3.Real(f"x{i}") for i in range(SIZE)]
DOMAIN = [
    z3.And(v >= z3.Q(*Fraction(a).as_integer_ratio()), v <= z3.Q(*Fraction(b).as_integer_ratio()))
    for v, a, b in zip(VARIABLES, LOW, HIGH, strict=True)
]


def exact(value):
    return z3.Q(*Fraction(value).as_integer_ratio())


def least(values):
    found = values[0]
    for value in values[1:]:
        found = z3.If(value < found, value, found)
    return found


def greatest(values):
    return -least([-v for v in values])


def flat(values):
    return [v for value in values for v in (value if isinstance(value, list) else [value])]


def spread(node, values):
    """Value by value where it is a group."""
    if not node.kind.size:
        return single(node, values)
    rows = [[v[i] if isinstance(v, list) else v for v in values] for i in range(node.kind.size)]
    return [single(node, row) for row in rows]


SIGNS = {
    "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b, "!=": lambda a, b: a != b,
}  # fmt: skip


def single(node, v):
    match node.op:
        case "neg":
            return -v[0]
        case "+":
            return v[0] + v[1]
        case "-":
            return v[0] - v[1]
        case "*":
            return v[0] * v[1]
        case "/":
            return v[0] / v[1]
        case "compare":
            return z3.And([SIGNS[s](a, b) for s, a, b in zip(node.signs, v, v[1:], strict=False)])
        case "and":
            return z3.And(v)
        case "or":
            return z3.Or(v)
        case "not":
            return z3.Not(v[0])
        case "if":
            return z3.If(v[0], v[1], v[2])
        case "abs":
            return z3.If(v[0] < 0, -v[0], v[0])
        case "clip":
            return least([greatest(v[:2]), v[2]])
        case "side":
            return z3.If(v[0] >= 0, z3.RealVal(1), z3.RealVal(-1))
        case "sign":
            return z3.If(v[0] > 0, z3.RealVal(1), z3.If(v[0] < 0, z3.RealVal(-1), z3.RealVal(0)))
        case "min":
            return least(flat(v))
        case "max":
            return greatest(flat(v))
        case "min_valid":
            return least(flat(v[:1]))
        case "sum":
            return z3.Sum(flat(v))
        case "mean":
            return z3.Sum(flat(v)) / len(flat(v))
        case "dot":
            return z3.Sum([a * b for a, b in zip(flat(v[:1]), v[1], strict=True)])
        case "count":
            return z3.Sum([z3.If(c, z3.RealVal(1), z3.RealVal(0)) for c in flat(v)])
        case "any":
            return z3.Or(flat(v))
        case "all":
            return z3.And(flat(v))
    raise NotImplementedError(node.op)


def formula(node):
    if node.op == "truth":
        return z3.BoolVal(node.value)
    if node.op == "vector":
        return [exact(arg.value) for arg in node.args]
    if node.op == "read":
        group = VARIABLES[node.start : node.stop]
        return group if node.kind.size else group[0]
    if node.constant and not node.kind.boolean and not node.kind.size:
        return exact(evaluate(node, ()))
    return spread(node, [formula(arg) for arg in node.args])


def satisfiable(node):
    """True, False, or None where z3 gives up."""
    solver = z3.Solver()
    solver.set("timeout", 2000)
    solver.add(*DOMAIN, formula(node))
    found = solver.check()
    return None if found == z3.unknown else found == z3.sat


def compare(seed, counts):
    writer = Writer(seed)
    nodes = [parse(writer.truth(3), ENVIRONMENT) for _ in range(2)]
    prover = Prover(ENVIRONMENT, nodes)
    a, b = nodes
    for node in (a, negation(a), conjunction([a, b]), conjunction([a, negation(b)])):
        # Once as it comes, and once without the examples that are drawn, which spare it the work.
        for answer in (prover.ask(node), prover._proved(node)):
            known = satisfiable(node)
            if answer.never:
                assert known is not True, f"{seed}: said to be never true: {node.text}"
            if answer.example is not None:
                assert known is not False, f"{seed}: z3 knows no example of {node.text}"
                trace = Trace()
                trace.append(answer.example.tolist(), 0.0)
                assert trace.value(node) is True
                assert all(low <= v <= high for v, low, high in zip(answer.example, LOW, HIGH, strict=True))
            if answer.unknown:
                assert len(answer.unknown) > 10
            counts[("unknown" if answer.unknown else "never" if answer.never else "example", known)] += 1


def test_answers_are_z3s_or_cannot_decide():
    counts = Counter()
    for seed in range(80):
        compare(seed, counts)
    unknown = sum(count for (answer, _), count in counts.items() if answer == "unknown")
    assert counts["never", False] > 50, counts
    assert unknown < 0.1 * counts.total(), counts


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
    "always": r"the guard of (\w+) holds whatever",
    "upside": r"when and until of (\w+) hold at once",
    "shadowed": r"(\w+) never acts",
    "tied": r"\w+ and (\w+) have the same priority",
}


def test_findings_about_rules_are_z3s():
    """Each finding has to be so; each that z3 has is found, unless the checker says that it cannot decide."""
    seen = Counter()
    for seed in range(40):
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
        first = {}
        for rule in rules:
            other = first.setdefault(rule.priority, rule)
            if other.action != rule.action and satisfiable(conjunction([other.when.node, rule.when.node])):
                expected["tied"].add(rule.name[2:])
        found = {
            kind: {m[1] for f in faults if (m := re.match(pattern, f.message)) and not f.note}
            for kind, pattern in PATTERNS.items()
        }
        for kind, names in found.items():
            assert names <= expected[kind], (seed, kind)
            if not undecided:
                assert names == expected[kind], (seed, kind)
            seen[kind] += len(names)
    assert min(seen.values()) > 0, seen
