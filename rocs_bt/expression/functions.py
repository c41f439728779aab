"""The functions of the language: what each takes and what kind it gives.

A group is a signal, a slice of one, or anything computed value by value from one; where a group is wanted a single
number stands for a group of one, since the same rule must load on a robot with one rear sonar and with six.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ..units import ANGLE, NONE, TIME, Dimension
from .node import PLAIN, TRUTH, Kind, Node


class Misuse(Exception):
    """A function that was given the wrong things; the parser adds the place."""


@dataclass(frozen=True)
class Function:
    """A function of the language.

    Attributes:
        usage: How it is written.
        doc: What it gives.
        kind: The kind of a call's result; raises Misuse. It is not given the window.
        window: Whether the last thing in its brackets is a length of time.
    """

    usage: str
    doc: str
    kind: Callable[[Sequence[Node]], Kind]
    window: bool = False


def same_dimension(args: Sequence[Node], what: str) -> Dimension:
    """The dimension that all args share.

    Raises:
        Misuse: They do not, or are no numbers; the message shows both sides.
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
    """The size of value-by-value work: 0 where all are single, else the size that all groups share."""
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
    """Temporal operations on truth values."""

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
    "min": Function("min(group) or min(a, b, ...)", "the least value", _reduce),
    "max": Function("max(group) or max(a, b, ...)", "the greatest value", _reduce),
    "sum": Function("sum(group)", "the sum", _total),
    "mean": Function("mean(group)", "the mean", _total),
    "any": Function("any(group < a)", "whether one comparison holds", _truths(TRUTH)),
    "all": Function("all(group < a)", "whether all comparisons hold", _truths(TRUTH)),
    "count": Function("count(group < a)", "how many comparisons hold", _truths(PLAIN)),
    "abs": Function("abs(a)", "the size without the sign, value by value", _absolute),
    "clip": Function("clip(a, low, high)", "a between low and high, value by value; high wins", _clip),
    "hypot": Function("hypot(a, b)", "the length of the diagonal", _hypot),
    "sign": Function("sign(a)", "-1, 0 or 1", _sign),
    "side": Function("side(a)", "-1 or 1; side(0) is 1, so that a turn is never zero", _sign),
    "sqrt": Function("sqrt(a)", "the square root; of a negative number invalid", _root),
    "wrap_angle": Function("wrap_angle(a)", "the same angle in (-180, 180] deg; of an infinite one invalid", _angle),
    "min_valid": Function(
        "min_valid(group, k)", "the least of the valid values; invalid only if fewer than k are valid", _min_valid
    ),
    "argmin": Function("argmin(group)", "which value is the least, from 0; of equal ones the first", _least_at),
    "dot": Function("dot(group, [a, b, ...])", "the sum of the products with constants", _dot),
    "atan2": Function("atan2(y, x)", "the angle of the point (x, y)", _atan2),
    "held": Function("held(test, 0.2 s)", "whether the test has held for so long", _past(1, TRUTH), True),
    "once": Function("once(test, 2 s)", "whether the test held at any time in the last 2 s", _past(1, TRUTH), True),
    "since": Function(
        "since(a, b, 2 s)", "whether b held in the last 2 s, and a ever since then", _past(2, TRUTH), True
    ),
    "time_since": Function("time_since(test)", "how long ago the test held last; inf: never", _past(1, Kind(TIME))),
    "rate": Function("rate(a, 0.5 s)", "how fast a changes, over the last 0.5 s", _rate, True),
}
