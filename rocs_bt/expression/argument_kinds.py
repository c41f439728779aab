"""Checks of the arguments of functions and operators, and the kinds of their results.

A group is a signal with several values, a slice of such a signal, or a value-by-value operation on it. A single number
is accepted as a group of one, because a rule must load both on a robot with one rear sonar and on one with six.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..base.units import ANGLE, NONE, TIME, Dimension
from .node import PLAIN, Kind, Node

DURATION = Kind(TIME)


class Misuse(Exception):
    """Raised if a function or operator has wrong arguments; the parser adds the position."""


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


def one_unit(args: Sequence[Node]) -> Kind:
    """A number in the common unit of values or groups, at least one."""
    if not args:
        raise Misuse("it needs at least one value.")
    return Kind(same_dimension(args, "it"))


def numbers(
    count: int, result: Callable[[Dimension], Kind], *, groups: bool = False
) -> Callable[[Sequence[Node]], Kind]:
    """Create the `kind` function of a function of numbers in one unit.

    Args:
        count: Number of arguments.
        result: Function from the unit to the kind of the result.
        groups: Whether an argument may be a group.
    """

    def kind(args: Sequence[Node]) -> Kind:
        _count(args, count)
        if not groups:
            _single(args)
        return result(same_dimension(args, "it"))

    return kind


one_group = numbers(1, Kind, groups=True)
index = numbers(1, lambda unit: PLAIN, groups=True)
direction = numbers(1, lambda unit: PLAIN)
change = numbers(1, lambda unit: Kind(unit / TIME))
length = numbers(2, Kind)
arc = numbers(2, lambda unit: Kind(ANGLE))


def truths(result: Kind) -> Callable[[Sequence[Node]], Kind]:
    """A result of one truth value or group of them."""

    def kind(args: Sequence[Node]) -> Kind:
        _count(args, 1)
        if not args[0].kind.boolean:
            raise Misuse(f"it needs comparisons, such as front < 0.3 m, but {args[0].text} is a number.")
        return result

    return kind


def each_value(args: Sequence[Node]) -> Kind:
    """As many values in the same unit."""
    _count(args, 1)
    return Kind(same_dimension(args, "it"), args[0].kind.size)


def limited(args: Sequence[Node]) -> Kind:
    """As `each_value`, with two limits."""
    _count(args, 3)
    _single(args[1:])
    return Kind(same_dimension(args, "it"), args[0].kind.size)


def root(args: Sequence[Node]) -> Kind:
    """A number in the root of a unit."""
    _count(args, 1)
    _single(args)
    dimension = same_dimension(args, "it")
    if any(e % 2 for e in dimension.exponents):
        raise Misuse(f"it needs a square, such as m2, but {args[0].text} is in {dimension}.")
    return Kind(Dimension(tuple(e // 2 for e in dimension.exponents)))


def angle(args: Sequence[Node]) -> Kind:
    """An angle of an angle."""
    _count(args, 1)
    _single(args)
    if same_dimension(args, "it") != ANGLE:
        raise Misuse(f"it needs an angle, but {args[0].text} is in {args[0].kind.dimension}.")
    return Kind(ANGLE)


def valid_values(args: Sequence[Node]) -> Kind:
    """A number of a group and of the least number of valid values."""
    _count(args, 2)
    group, least = args
    size = max(1, group.kind.size)
    if least.op != "number" or least.kind != PLAIN or least.value not in range(1, size + 1):
        raise Misuse(f"its second value must be a whole number from 1 to {size}, found {least.text}.")
    return Kind(same_dimension(args[:1], "it"))


def product(args: Sequence[Node]) -> Kind:
    """A number of a group and of a constant vector."""
    _count(args, 2)
    group, vector = args
    if vector.op != "vector":
        raise Misuse(f"its second value must be a list of numbers, such as [1, 0.5], found {vector.text}.")
    if max(1, group.kind.size) != vector.kind.size:
        raise Misuse(f"{group.text} has {max(1, group.kind.size)} values and {vector.text} has {vector.kind.size}.")
    return Kind(same_dimension([group], "it") * same_dimension([vector], "it"))


def past(count: int, result: Kind) -> Callable[[Sequence[Node]], Kind]:
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
