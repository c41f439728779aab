"""Translation of typed expression trees to formulas.

A comparison becomes a linear sum that is compared with 0. A subexpression with cases (`min`, `abs`, `clip`, `if`,
`side`, `count`) becomes a variable with a definition: `m = min(a, b)` becomes
`m <= a and m <= b and (a <= m or b <= m)`. So the length of a formula is proportional to that of its expression. Any
other subexpression, such as a product of signals, becomes a variable of which only the range is known. A temporal
operator becomes an undetermined truth value; of its meaning, the formula contains only that `held(a)` implies a, and
that a implies `once(a)`. Therefore an unsatisfiable formula proves that the expression is never true, but a solution is
only a candidate.

All values are assumed valid: an invalid comparison is neither true nor false.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import reduce

from ...expression import PLAIN, TRUTH, Kind, Node, evaluate
from .formula import FALSE, TRUE, Bound, Effort, Exhausted, Formula, Undecided, below_zero, join
from .interval import Range, range_of

_EXTREMES = frozenset({"min", "max", "min_valid", "abs"})
_SWITCHES = frozenset({"side", "sign", "count", "if"})
_FLIPPED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


@dataclass
class _Sum:
    """Linear sum of variables, and of subexpressions with cases to which no variable is assigned yet."""

    terms: dict[int, Fraction] = field(default_factory=dict)
    # Subexpressions with cases to which no variable is assigned yet.
    parts: dict[Node, Fraction] = field(default_factory=dict)
    constant: Fraction | float = Fraction(0)
    met: set[int] = field(default_factory=set)  # variables that can be infinite and were both added and subtracted


class Translator:
    """Translator of expressions over the same signals. All formulas share their variables, so they can be joined.

    Attributes:
        unknown: Subexpressions of which only the range is known, keyed by their variable.
        reasons: Reasons why comparisons could not be translated, as keys; all values are None.
    """

    def __init__(self, size: int, bounds: Callable[[int], Range], effort: Effort) -> None:
        self.unknown: dict[int, Node] = {}
        self.reasons: dict[str, None] = {}
        self._size = size
        self._bounds = bounds
        self._effort = effort
        self._numbers: dict[Node, int] = {}
        self._nodes: dict[int, Node] = {}
        self._ranges: dict[int, Range] = {}
        self._definitions: dict[int, Formula] = {}

    def formula(self, node: Node) -> Formula:
        """Formula of a scalar boolean expression, including the definitions of all its variables."""
        self.unknown, self.reasons, self._definitions = {}, {}, {}
        guard = self._truth(node, True)
        return join(True, [guard, *self._definitions.values()])

    def range(self, var: int) -> Range:
        """Range of a variable."""
        if var < self._size:
            return self._bounds(var)
        if var not in self._ranges:
            node = self._nodes[var]
            self._ranges[var] = (0.0, 1.0) if node.kind.boolean else range_of(node, self._bounds)
        return self._ranges[var]

    def _finite(self, var: int) -> bool:
        return not any(map(math.isinf, self.range(var)))

    def _number(self, node: Node) -> int:
        number = self._numbers.setdefault(node, self._size + len(self._numbers))
        self._nodes[number] = node
        return number

    def _unknown(self, node: Node) -> int:
        number = self._number(node)
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
        return Bound(self._unknown(node), not wanted, Fraction(int(wanted)), False)

    def _comparison(self, node: Node, wanted: bool) -> Formula:
        """Formula of a comparison; an undetermined truth value if the comparison cannot be translated."""
        pairs = zip(node.args, node.signs, node.args[1:], strict=False)
        try:
            return join(wanted, [self._compare(a, sign if wanted else _FLIPPED[sign], b) for a, sign, b in pairs])
        except Exhausted:
            raise
        except Undecided as reason:
            self.reasons[f"'{node.text}': {reason}"] = None
            return self._literal(node, wanted)

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
        """Formula `total < 0`, or `total <= 0` unless `strict`.

        A single `min` or `max` in the sum needs no variable, because `min(a, b) < c` is `a < c or b < c`.
        """
        self._effort.spend(4)
        if len(total.parts) == 1 and not isinstance(total.constant, float):
            ((part, factor),) = total.parts.items()
            if part.op in _EXTREMES:
                every = (part.op in ("max", "abs")) is (factor > 0)
                return join(every, (self._below(self._with(total, value, factor), strict) for value in _values(part)))
        for part, factor in total.parts.items():
            self._add_variable(total, self._defined(part), factor)
        return self._row(total, strict)

    def _with(self, total: _Sum, value: Node, factor: Fraction) -> _Sum:
        """Copy of a sum without its subexpressions with cases, plus `factor * value`."""
        found = _Sum(dict(total.terms), {}, total.constant, set(total.met))
        self._add(found, value, factor)
        return found

    def _row(self, total: _Sum, strict: bool) -> Formula:
        """Formula `total < 0`, or `total <= 0` unless `strict`, for a sum of variables only.

        Between equal infinite values `<` is false and `<=` is true.
        """
        row = below_zero(total.terms, total.constant, strict, self._finite)
        ends = [Bound(var, (end > 0) is strict, end, strict) for var in total.met for end in (math.inf, -math.inf)]
        return join(strict, [row, *ends])

    def _defined(self, part: Node) -> int:
        """Variable of a subexpression with cases; its definition is added to the formula once."""
        var = self._number(part)
        if var not in self._definitions:
            self._definitions[var] = self._definition(var, part)
        return var

    def _definition(self, var: int, part: Node) -> Formula:
        def equal(value: Node) -> Formula:
            return join(True, [self._between(var, value, Fraction(sign)) for sign in (1, -1)])

        if part.op in _EXTREMES:
            sign = Fraction(-1 if part.op in ("max", "abs") else 1)
            values = _values(part)
            beyond = [self._between(var, value, sign) for value in values]
            return join(True, [*beyond, join(False, [self._between(var, value, -sign) for value in values], var)])
        cases = [join(True, [self._truth(test, True), equal(value)]) for test, value in _cases(part)]
        return join(False, cases, var)

    def _between(self, var: int, value: Node, sign: Fraction) -> Formula:
        """Formula `variable <= value` if the sign is 1, `variable >= value` if it is -1."""
        total = _Sum({var: sign})
        self._add(total, value, -sign)
        return self._below(total, strict=False)

    def _add(self, total: _Sum, node: Node, factor: Fraction) -> None:
        """Add `factor * node` to a sum."""
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
            case "count":
                for test in elements(args[0]):
                    self._add(total, Node("if", PLAIN, (test, _number_node(1.0), _number_node(0.0))), factor)
            case "clip":
                value, low, high = args
                inner = Node("max", node.kind, (value, low), text=node.text)
                self._add(total, Node("min", node.kind, (inner, high), text=node.text), factor)
            case _ if _has_cases(node):
                before = total.parts.get(node, Fraction(0))
                if before * factor < 0 and not self._finite(self._number(node)):
                    total.met.add(self._defined(node))
                total.parts[node] = before + factor
            case _:
                self._add_variable(total, self._unknown(node), factor)

    def _add_variable(self, total: _Sum, var: int, factor: Fraction) -> None:
        before = total.terms.get(var, Fraction(0))
        if before * factor < 0 and not self._finite(var):
            total.met.add(var)  # inf < inf is false, independent of the rest of the sum
        total.terms[var] = before + factor


def element(node: Node, i: int) -> Node:
    """Expression of the i-th value of an expression with a group of values; a scalar is returned unchanged."""
    if not node.kind.size:
        return node
    if node.op == "vector":
        return node.args[i]
    kind = Kind(node.kind.dimension, 0, node.kind.boolean)
    if node.op == "read":
        return replace(node, kind=kind, start=node.start + i, stop=node.start + i + 1, text=f"{node.text}[{i}]")
    return replace(node, kind=kind, args=tuple(element(arg, i) for arg in node.args))


def elements(node: Node) -> list[Node]:
    """Expression of each value of an expression with a group of values."""
    return [element(node, i) for i in range(max(1, node.kind.size))]


def _has_cases(node: Node) -> bool:
    if node.op == "*":
        return any(arg.op in _SWITCHES and _switched(arg) for arg in node.args)
    return node.op in _EXTREMES | _SWITCHES and not node.kind.size


def _switched(node: Node) -> bool:
    """Whether an expression with cases can have only a few constant values."""
    return node.op != "if" or all(arg.constant or (arg.op in _SWITCHES and _switched(arg)) for arg in node.args[1:])


def _values(extreme: Node) -> list[Node]:
    """Expressions of which a `min`, `max`, `min_valid` or `abs` is the minimum or maximum."""
    if extreme.op == "abs":
        (arg,) = extreme.args
        return [arg, Node("neg", arg.kind, (arg,), text=f"-({arg.text})")]
    groups = extreme.args if extreme.op != "min_valid" else extreme.args[:1]
    return [value for group in groups for value in elements(group)]


def _cases(node: Node) -> list[tuple[Node, Node]]:
    """Condition and value of each case of an expression. The cases are exhaustive."""
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
        case "count":
            each = [Node("if", PLAIN, (test, _number_node(1.0), zero)) for test in elements(args[0])]
            return [(_TRUE, reduce(lambda a, b: Node("+", PLAIN, (a, b)), each))]
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
    """Expression that is true if all given expressions are."""
    return nodes[0] if len(nodes) == 1 else Node("and", TRUTH, tuple(nodes), text=" and ".join(n.text for n in nodes))


def negation(node: Node) -> Node:
    """Expression that is true if the given one is false."""
    return node.args[0] if node.op == "not" else _not(node)


def unknown_texts(found: Mapping[int, Node]) -> list[str]:
    """Source texts of subexpressions, without duplicates and empty texts."""
    return list(dict.fromkeys(node.text for node in found.values() if node.text))
