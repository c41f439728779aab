"""Functions of the expression language: checks of their arguments, and the kinds of their results.

A group is a signal with several values, a slice of such a signal, or a value-by-value operation on it. A single number
is accepted as a group of one, because a rule must load both on a robot with one rear sonar and on one with six.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ..base.units import ANGLE, NONE, TIME, Dimension
from .node import PLAIN, TRUTH, Kind, Node


class Misuse(Exception):
    """Raised if a function or operator has wrong arguments; the parser adds the position."""


@dataclass(frozen=True)
class Function:
    """Function of the expression language."""

    usage: str
    doc: str
    kind: Callable[[Sequence[Node]], Kind]  # kind of the result for the arguments without the window; raises Misuse
    window: bool = False  # whether the last argument is the length of a time window


def same_dimension(args: Sequence[Node], what: str) -> Dimension:
    """Common dimension of all arguments of a function or operator.

    Raises:
        Misuse: The dimensions differ, or an argument is not a number.
    """
    for arg in args:
        if arg.kind.boolean:
            raise Misuse(f"{what} needs numbers, but {arg.text} is true or false.")
        if arg.kind.dimension is None:
            raise Misuse(f"{what} needs one unit, but {arg.text} has {arg.kind.words}; use an index.")
        if arg.kind.dimension != args[0].kind.dimension:
            first = args[0]
            raise Misuse(
                f"{what} needs one unit, but {first.text} is in {first.kind.dimension} "
                f"and {arg.text} is in {arg.kind.dimension}."
            )
    return args[0].kind.dimension or NONE


def same_size(args: Sequence[Node], what: str) -> int:
    """Number of values of a value-by-value operation: that of all groups; 0 if all arguments are single values.

    Raises:
        Misuse: Two groups have different sizes.
    """
    groups = [arg for arg in args if arg.kind.size]
    for group in groups:
        if group.kind.size != groups[0].kind.size:
            raise Misuse(
                f"{what} needs groups of one size, but {groups[0].text} has {groups[0].kind.size} values "
                f"and {group.text} has {group.kind.size}."
            )
    return groups[0].kind.size if groups else 0


def _count(args: Sequence[Node], count: int) -> None:
    if len(args) != count:
        raise Misuse(f"it takes {count} {'value' if count == 1 else 'values'}, found {len(args)}.")


def _single(args: Sequence[Node]) -> None:
    for arg in args:
        if arg.kind.size:
            raise Misuse(f"it takes single values, but {arg.text} has {arg.kind.size}; use an index, min or max.")


def _reduce(args: Sequence[Node]) -> Kind:
    if not args:
        raise Misuse("it needs at least one value.")
    return Kind(same_dimension(args, "it"))


def _total(args: Sequence[Node]) -> Kind:
    _count(args, 1)
    return Kind(same_dimension(args, "it"))


def _truths(result: Kind) -> Callable[[Sequence[Node]], Kind]:
    def kind(args: Sequence[Node]) -> Kind:
        _count(args, 1)
        if not args[0].kind.boolean:
            raise Misuse(f"it needs comparisons, such as front < 0.3 m, but {args[0].text} is a number.")
        return result

    return kind


def _absolute(args: Sequence[Node]) -> Kind:
    _count(args, 1)
    return Kind(same_dimension(args, "it"), args[0].kind.size)


def _clip(args: Sequence[Node]) -> Kind:
    _count(args, 3)
    _single(args[1:])
    return Kind(same_dimension(args, "it"), args[0].kind.size)


def _hypot(args: Sequence[Node]) -> Kind:
    _count(args, 2)
    _single(args)
    return Kind(same_dimension(args, "it"))


def _sign(args: Sequence[Node]) -> Kind:
    _count(args, 1)
    _single(args)
    same_dimension(args, "it")
    return PLAIN


def _root(args: Sequence[Node]) -> Kind:
    _count(args, 1)
    _single(args)
    dimension = same_dimension(args, "it")
    if any(e % 2 for e in dimension.exponents):
        raise Misuse(f"it needs a square, such as m2, but {args[0].text} is in {dimension}.")
    return Kind(Dimension(tuple(e // 2 for e in dimension.exponents)))


def _angle(args: Sequence[Node]) -> Kind:
    _count(args, 1)
    _single(args)
    if same_dimension(args, "it") != ANGLE:
        raise Misuse(f"it needs an angle, but {args[0].text} is in {args[0].kind.dimension}.")
    return Kind(ANGLE)


def _min_valid(args: Sequence[Node]) -> Kind:
    _count(args, 2)
    group, least = args
    size = max(1, group.kind.size)
    if least.op != "number" or least.kind != PLAIN or least.value not in range(1, size + 1):
        raise Misuse(f"its second value must be a whole number from 1 to {size}, found {least.text}.")
    return Kind(same_dimension(args[:1], "it"))


def _dot(args: Sequence[Node]) -> Kind:
    _count(args, 2)
    group, vector = args
    if vector.op != "vector":
        raise Misuse(f"its second value must be a list of numbers, such as [1, 0.5], found {vector.text}.")
    if max(1, group.kind.size) != vector.kind.size:
        raise Misuse(f"{group.text} has {max(1, group.kind.size)} values and {vector.text} has {vector.kind.size}.")
    return Kind(same_dimension([group], "it") * same_dimension([vector], "it"))


def _atan2(args: Sequence[Node]) -> Kind:
    _count(args, 2)
    _single(args)
    same_dimension(args, "it")
    return Kind(ANGLE)


def _least_at(args: Sequence[Node]) -> Kind:
    _count(args, 1)
    same_dimension(args, "it")
    return PLAIN


def _past(count: int, result: Kind) -> Callable[[Sequence[Node]], Kind]:
    """Create the `kind` function of a temporal operator on truth values."""

    def kind(args: Sequence[Node]) -> Kind:
        _count(args, count)
        for arg in args:
            if not arg.kind.boolean:
                raise Misuse(f"it needs true or false, such as min(front) < 0.3 m, but {arg.text} is {arg.kind.words}.")
            if arg.kind.size:
                raise Misuse(f"it needs one true or false, but {arg.text} has {arg.kind.size}; use any or all.")
        return result

    return kind


def _rate(args: Sequence[Node]) -> Kind:
    _count(args, 1)
    _single(args)
    return Kind(same_dimension(args, "it") / TIME)


FUNCTIONS: Mapping[str, Function] = {
    "min": Function("min(group) or min(a, b, ...)", "the minimum", _reduce),
    "max": Function("max(group) or max(a, b, ...)", "the maximum", _reduce),
    "sum": Function("sum(group)", "the sum", _total),
    "mean": Function("mean(group)", "the mean", _total),
    "any": Function("any(group < a)", "whether at least one comparison is true", _truths(TRUTH)),
    "all": Function("all(group < a)", "whether all comparisons are true", _truths(TRUTH)),
    "count": Function("count(group < a)", "the number of true comparisons", _truths(PLAIN)),
    "abs": Function("abs(a)", "the absolute value, value by value", _absolute),
    "clip": Function("clip(a, low, high)", "a limited to low and high, value by value; high has precedence", _clip),
    "hypot": Function("hypot(a, b)", "the length of the vector (a, b)", _hypot),
    "sign": Function("sign(a)", "-1, 0 or 1", _sign),
    "side": Function("side(a)", "-1 or 1; side(0) is 1, so that a turn is never zero", _sign),
    "sqrt": Function("sqrt(a)", "the square root; invalid for a negative number", _root),
    "wrap_angle": Function("wrap_angle(a)", "the same angle in (-180, 180] deg; invalid if infinite", _angle),
    "min_valid": Function(
        "min_valid(group, k)", "the minimum of the valid values; invalid only if fewer than k are valid", _min_valid
    ),
    "argmin": Function("argmin(group)", "the index of the minimum, from 0; the first of equal values", _least_at),
    "dot": Function("dot(group, [a, b, ...])", "the dot product with constants", _dot),
    "atan2": Function("atan2(y, x)", "the angle of the point (x, y)", _atan2),
    "held": Function("held(test, 0.2 s)", "whether the test has been true for this time", _past(1, TRUTH), True),
    "once": Function("once(test, 2 s)", "whether the test was true at any time in the last 2 s", _past(1, TRUTH), True),
    "since": Function(
        "since(a, b, 2 s)", "whether b was true in the last 2 s, and a has been true since then", _past(2, TRUTH), True
    ),
    "time_since": Function("time_since(test)", "the time since the test last held; inf: never", _past(1, Kind(TIME))),
    "rate": Function("rate(a, 0.5 s)", "the mean rate of change of a over the last 0.5 s", _rate, True),
}
