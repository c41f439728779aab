"""Declarations of the parameters of actions, missions and drivers, as derived from annotations."""

from __future__ import annotations

import numbers
import types
import typing
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .errors import Fault
from .units import FINITE, NONE, Bounds, Dimension

_WORDS: Mapping[Any, str] = {float: "a number", int: "a whole number", str: "a text", bool: "true or false"}
_NUMBERS: Mapping[Any, type] = {float: numbers.Real, int: numbers.Integral}
_LISTS = (list, tuple, Sequence)


@dataclass(frozen=True)
class Parameter:
    """Declaration of a parameter of an action, a mission or a driver.

    Attributes:
        name: Name of the parameter.
        type: Type of the values: the annotation without its metadata.
        dimension: Dimension of the number, or of each number of a list; None for other types.
        required: Whether the parameter has no default, so that a value must be given.
        default: Default value; None if the parameter is required.
        bounds: Range of valid numbers, SI units.
    """

    name: str
    type: Any
    dimension: Dimension | None
    required: bool
    default: Any
    bounds: Bounds = FINITE

    @classmethod
    def annotated(cls, name: str, hint: Any, required: bool, default: Any) -> Parameter:
        """Create a parameter from its annotation, such as `PositiveMetresPerSecond`.

        Args:
            name: Name of the parameter.
            hint: Annotation.
            required: Whether a value must be given.
            default: Default value.
        """
        extras = getattr(hint, "__metadata__", ())
        plain = hint.__origin__ if extras else hint
        dimension = next((e for e in extras if isinstance(e, Dimension)), NONE if plain is float else None)
        # Annotated flattens nested annotations; the outermost comes last and takes precedence.
        bounds = next((e for e in reversed(extras) if isinstance(e, Bounds)), FINITE)
        return cls(name, plain, dimension, required, default, bounds)

    def faults(self, value: Any, what: str) -> list[Fault]:
        """Check the type and the bounds of a value; returns the faults.

        Args:
            value: Value in SI units.
            what: Name of the parameter in messages, such as `cruise of GoTo`.
        """
        if (wanted := misfit(self.type, value)) is not None:
            return [Fault(f"{what} must be {wanted}, found {value!r:.80}.")]
        return self.bound_faults(value, what)

    def bound_faults(self, value: Any, what: str) -> list[Fault]:
        """Check only the bounds of a value, not its type; returns the faults. Arguments as in `faults`."""
        if self.dimension is None and self.type is not int:
            return []
        wrong = next((v for v in _numbers(value) if not self.bounds.admit(v)), None)
        if wrong is None:
            return []
        unit = "" if self.dimension in (None, NONE) else f" {self.dimension}"
        return [Fault(f"{what} must be {self.bounds}, found {wrong:g}{unit}.")]


def misfit(kind: Any, value: Any) -> str | None:
    """Check the type of a value; returns None if it fits, else the expected type in words.

    Args:
        kind: Expected type: an annotation without metadata. Plain types, literals, lists and tuples of these, and
            unions are checked; a value of any other type is accepted.
        value: Value to check; numbers of numpy are accepted as numbers.
    """
    if type(value) is kind:
        return None
    if kind in _WORDS:
        fits = isinstance(value, _NUMBERS.get(kind, kind)) and not isinstance(value, bool)
        return None if fits else _WORDS[kind]
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Literal:
        return None if value in parts else " or ".join(repr(part) for part in parts if part != "")
    if origin is typing.Annotated:
        return misfit(parts[0], value)
    if origin in (typing.Union, types.UnionType):
        wanted = [misfit(part, value) for part in parts if part is not type(None)]
        return None if (value is None and type(None) in parts) or None in wanted else " or ".join(map(str, wanted))
    return _misfit_of_list(origin, parts, value) if (origin or kind) in _LISTS else None


def _misfit_of_list(origin: Any, parts: tuple[Any, ...], value: Any) -> str | None:
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Collection):
        return "a list"
    if origin is tuple and parts and parts[-1] is not Ellipsis:
        if len(value) != len(parts):
            return f"a list of {len(parts)} values"
        kinds = parts
    else:
        kinds = (parts[0] if parts else Any,) * len(value)
    wanted = next((w for kind, each in zip(kinds, value, strict=True) if (w := misfit(kind, each)) is not None), None)
    return None if wanted is None else f"a list in which each is {wanted}"


def _numbers(value: Any) -> Iterator[float]:
    """All numbers in a value, which may be a nested list."""
    if isinstance(value, numbers.Real):
        yield float(value)
    elif isinstance(value, Iterable) and not isinstance(value, str):
        for part in value:
            yield from _numbers(part)
