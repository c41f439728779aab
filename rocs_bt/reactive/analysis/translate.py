"""From a typed tree to a formula.

A comparison is taken apart until linear sums are left: `min(a, b) < c` is `a < c or b < c`, `min(a, b) > c` is
`a > c and b > c`, and what has cases (`max`, `abs`, `clip`, `if`, `side`, `sign`, `count`) likewise. What remains, such
as products of signals, is a variable of which only its range is known. Of the past `held(a)` says that a is now,
`once(a)` that it was if it is; the rest of what they say is a truth value of its own. So a formula without a solution
means an expression that is never true; a solution is a candidate only.

Values are taken to be valid: an invalid comparison is neither true nor false.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from ...expression import PLAIN, TRUTH, Kind, Node, evaluate
from .formula import FALSE, TRUE, Effort, Formula, Literal, Undecided, below_zero, join
from .interval import Range, range_of

MAX_CASES = 600  # comparisons that one comparison may come apart into
MAX_INSIDE = 12  # what has cases and stands in one sum

_PIECEWISE = frozenset({"min", "max", "min_valid", "clip", "abs", "if", "side", "sign", "count"})
_FLIPPED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_SWITCHES = frozenset({"side", "sign", "count", "if"})


@dataclass
class _Sum:
    """A sum, while it is taken apart: variables, and parts with cases."""

    terms: dict[int, Fraction] = field(default_factory=dict)
    parts: dict[Node, Fraction] = field(default_factory=dict)
    constant: Fraction | float = Fraction(0)
    met: bool = False  # whether a variable that can be infinite was taken from itself

    def copy(self) -> _Sum:
        """Another one like it."""
        return _Sum(dict(self.terms), dict(self.parts), self.constant, self.met)

    def without(self, part: Node) -> _Sum:
        """A copy without a part."""
        parts = dict(self.parts)
        del parts[part]
        return _Sum(dict(self.terms), parts, self.constant, self.met)


class Translator:
    """Translates expressions over the same signals, so that their formulas can be joined.

    Args:
        size: How many values a snapshot has.
        bounds: What each of them can be.
        effort: What it may take.

    Attributes:
        unknown: What stands for no linear sum, by the number of its variable.
        reasons: Why comparisons were not taken apart, as the keys.
    """

    def __init__(self, size: int, bounds: Callable[[int], Range], effort: Effort) -> None:
        self.unknown: dict[int, Node] = {}
        self.reasons: dict[str, None] = {}
        self._size = size
        self._bounds = bounds
        self._numbers: dict[Node, int] = {}
        self._effort = effort
        self._deep, self._inside = True, False
        self._made = 0

    def formula(self, node: Node, deep: bool = True) -> Formula:
        """The formula of a single truth value.

        Args:
            node: The expression.
            deep: Whether to take apart what has cases; else it is a variable, too.

        """
        self._deep = deep
        return self._truth(node, True)

    def range(self, var: int) -> Range:
        """What a variable can be."""
        return self._bounds(var) if var < self._size else range_of(self.unknown[var], self._bounds)

    def _finite(self, var: int) -> bool:
        return not any(map(math.isinf, self.range(var)))

    def _number(self, node: Node) -> int:
        number = self._numbers.setdefault(node, self._size + len(self._numbers))
        self.unknown[number] = node
        return number

    def _truth(self, node: Node, wanted: bool) -> Formula:
        args = node.args
        match node.op:
            case "truth":
                return TRUE if bool(node.value) is wanted else FALSE
            case "not":
                return self._truth(args[0], not wanted)
            case "and" | "or":
                return join((node.op == "and") is wanted, (self._truth(arg, wanted) for arg in args))
            case "any" | "all":
                parts = (self._truth(element(args[0], i), wanted) for i in range(max(1, args[0].kind.size)))
                return join((node.op == "all") is wanted, parts)
            case "if":
                test, then, other = args
                first = join(True, [self._truth(test, True), self._truth(then, wanted)])
                return join(False, [first, join(True, [self._truth(test, False), self._truth(other, wanted)])])
            case "compare":
                return self._comparison(node, wanted)
            case "held" if wanted:
                return join(True, [self._truth(args[0], True), self._literal(node, True)])
            case "once" if not wanted:
                return join(True, [self._truth(args[0], False), self._literal(node, False)])
            case "since" if wanted:
                now = join(False, [self._truth(args[1], True), self._truth(args[0], True)])
                return join(True, [now, self._literal(node, True)])
            case "since":
                return join(True, [self._truth(args[1], False), self._literal(node, False)])
        return self._literal(node, wanted)

    def _literal(self, node: Node, wanted: bool) -> Formula:
        return Literal(self._number(node), wanted)

    def _comparison(self, node: Node, wanted: bool) -> Formula:
        """As exactly as it can be: in its cases, else as one sum, else as a truth value of which nothing is known."""
        if self._inside:
            return self._pairs(node, wanted)
        deep, self._inside = self._deep, True
        try:
            for self._deep in (True, False) if deep else (False,):
                self._made = 0
                try:
                    return self._pairs(node, wanted)
                except Undecided as reason:
                    self.reasons[f"'{node.text}': {reason}"] = None
            return self._literal(node, wanted)
        finally:
            self._deep, self._inside = deep, False

    def _pairs(self, node: Node, wanted: bool) -> Formula:
        pairs = zip(node.args, node.signs, node.args[1:], strict=False)
        return join(wanted, [self._compare(a, sign if wanted else _FLIPPED[sign], b) for a, sign, b in pairs])

    def _compare(self, a: Node, sign: str, b: Node) -> Formula:
        if sign in ("==", "!="):
            signs = ("<=", ">=") if sign == "==" else ("<", ">")
            return join(sign == "==", [self._compare(a, s, b) for s in signs])
        if sign in (">", ">="):
            a, b = b, a
        total = _Sum()
        self._add(total, a, Fraction(1))
        self._add(total, b, Fraction(-1))
        return self._below(total, strict=sign in ("<", ">"))

    def _below(self, total: _Sum, strict: bool) -> Formula:
        """That a sum is less than 0."""
        self._made += 1
        self._effort.spend(4)
        if self._made > MAX_CASES or len(total.parts) > MAX_INSIDE:
            raise Undecided(f"it has more than {MAX_CASES} cases")
        if not total.parts:
            if total.met and (total.constant or any(total.terms.values())):
                raise Undecided("a signal that can be infinite stands on both sides")
            return below_zero(total.terms, total.constant, strict, self._finite)
        part, factor = next(iter(total.parts.items()))
        rest = total.without(part)

        def holds(instead: Node, by: Fraction = factor) -> Formula:
            tried = rest.copy()
            self._add(tried, instead, by)
            return self._below(tried, strict)

        match part.op:
            case "min" | "max" | "min_valid":
                groups = part.args if part.op != "min_valid" else part.args[:1]
                every = (part.op == "max") is (factor > 0)
                return join(every, (holds(value) for group in groups for value in elements(group)))
            case "abs":
                return join(factor > 0, (holds(part.args[0], by) for by in (factor, -factor)))
        return join(False, (join(True, [self._truth(test, True), holds(value)]) for test, value in _cases(part)))

    def _add(self, total: _Sum, node: Node, factor: Fraction) -> None:
        """Add a number to a sum, so many times."""
        args = node.args
        if node.constant:
            total.constant = _plus(total.constant, factor, _constant(node))
            return
        match node.op:
            case "read":
                self._add_variable(total, node.start, factor)
            case "neg":
                self._add(total, args[0], -factor)
            case "+" | "-":
                self._add(total, args[0], factor)
                self._add(total, args[1], factor if node.op == "+" else -factor)
            case "*" if args[0].constant:
                self._add(total, args[1], factor * _finite_constant(args[0]))
            case "*" if args[1].constant:
                self._add(total, args[0], factor * _finite_constant(args[1]))
            case "/" if args[1].constant and _finite_constant(args[1]):
                self._add(total, args[0], factor / _finite_constant(args[1]))
            case "sum" | "mean":
                values = elements(args[0])
                for value in values:
                    self._add(total, value, factor / len(values) if node.op == "mean" else factor)
            case "dot":
                for value, weight in zip(elements(args[0]), args[1].args, strict=True):
                    self._add(total, value, factor * _finite_constant(weight))
            case _ if self._deep and _has_cases(node):
                total.parts[node] = total.parts.get(node, Fraction(0)) + factor
            case _:
                self._add_variable(total, self._number(node), factor)

    def _add_variable(self, total: _Sum, var: int, factor: Fraction) -> None:
        before = total.terms.get(var, Fraction(0))
        if before * factor < 0 and not self._finite(var):
            total.met = True  # inf < inf is false, whatever the sums around them are
        total.terms[var] = before + factor


def element(node: Node, i: int) -> Node:
    """The i-th value of a group as an expression; a single value stands for each."""
    if not node.kind.size:
        return node
    if node.op == "vector":
        return node.args[i]
    kind = Kind(node.kind.dimension, 0, node.kind.boolean)
    if node.op == "read":
        return replace(node, kind=kind, start=node.start + i, stop=node.start + i + 1, text=f"{node.text}[{i}]")
    return replace(node, kind=kind, args=tuple(element(arg, i) for arg in node.args))


def elements(node: Node) -> list[Node]:
    """Each value of a group."""
    return [element(node, i) for i in range(max(1, node.kind.size))]


def _has_cases(node: Node) -> bool:
    if node.op == "*":
        return any(arg.op in _SWITCHES and _switched(arg) for arg in node.args)
    return node.op in _PIECEWISE and not node.kind.size


def _switched(node: Node) -> bool:
    """Whether a value is one of a few constants."""
    return node.op != "if" or all(arg.constant or (arg.op in _SWITCHES and _switched(arg)) for arg in node.args[1:])


def _cases(node: Node) -> list[tuple[Node, Node]]:
    """What a value is in which case; together the cases are all there are."""
    args = node.args
    zero = _number_node(0.0)
    match node.op:
        case "if":
            return [(args[0], args[1]), (_not(args[0]), args[2])]
        case "side":
            least = _compared(args[0], ">=")
            return [(least, _number_node(1.0)), (_not(least), _number_node(-1.0))]
        case "sign":
            more, less = _compared(args[0], ">"), _compared(args[0], "<")
            return [(more, _number_node(1.0)), (less, _number_node(-1.0)), (_compared(args[0], "=="), zero)]
        case "clip":
            value, low, high = args
            return [(_TRUE, Node("min", node.kind, (Node("max", node.kind, (value, low)), high), text=node.text))]
        case "count":
            tests = elements(args[0])
            total = zero
            for test in tests:
                total = Node("+", PLAIN, (total, Node("if", PLAIN, (test, _number_node(1.0), zero))))
            return [(_TRUE, total)]
    switch, other = args if args[0].op in _SWITCHES and _switched(args[0]) else args[::-1]
    return [(test, Node("*", node.kind, (value, other), text=node.text)) for test, value in _cases(switch)]


_TRUE = Node("truth", TRUTH, value=True, text="True")


def _number_node(value: float) -> Node:
    return Node("number", PLAIN, value=value, text=f"{value:g}")


def _not(node: Node) -> Node:
    return Node("not", TRUTH, (node,), text=f"not ({node.text})")


def _compared(node: Node, sign: str) -> Node:
    zero = Node("number", Kind(node.kind.dimension), value=0.0, text="0")
    return Node("compare", TRUTH, (node, zero), signs=(sign,), text=f"{node.text} {sign} 0")


def _constant(node: Node) -> float:
    value = evaluate(node, ())
    if value is None:
        raise Undecided(f"'{node.text}' has no value")
    return float(value)


def _finite_constant(node: Node) -> Fraction:
    value = _constant(node)
    if math.isinf(value):
        raise Undecided(f"'{node.text}' is infinite")
    return Fraction(value)


def _plus(constant: Fraction | float, factor: Fraction, value: float) -> Fraction | float:
    if isinstance(constant, float) or math.isinf(value):
        return float(constant) + float(factor) * value
    return constant + factor * Fraction(value)


def conjunction(nodes: Sequence[Node]) -> Node:
    """That all expressions are true."""
    return nodes[0] if len(nodes) == 1 else Node("and", TRUTH, tuple(nodes), text=" and ".join(n.text for n in nodes))


def negation(node: Node) -> Node:
    """That an expression is false."""
    return node.args[0] if node.op == "not" else _not(node)


def unknown_texts(found: Mapping[int, Node]) -> list[str]:
    """How the parts of which nothing is known were written."""
    return list(dict.fromkeys(node.text for node in found.values() if node.text))
