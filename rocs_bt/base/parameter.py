"""Parameters of users' classes and functions: declared by annotations, read from files in SI units."""

from __future__ import annotations

import functools
import inspect
import numbers
import types
import typing
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .errors import Fault, InputError, unknown
from .units import FINITE, NONE, Bounds, Dimension, convert

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

    Plain types, literals, lists and tuples of these, and unions are checked, with numbers of numpy; a value of any
    other type is accepted.
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


Positions = Mapping[str, tuple[int, int]]
"""Line and column of values in a file, by name; the name of a value in a table is `TABLE.NAME`."""


def keyword_parameters(
    function: Callable[..., Any], positional: Sequence[str], what: str, write: str
) -> tuple[dict[str, Parameter], bool]:
    """Keyword-only parameters that a function declares, by name, and whether it accepts others (`**rest`).

    Raises:
        InputError: The signature does not have the expected form; the error contains all faults.
    """
    try:
        signature = inspect.signature(function)
        hints = typing.get_type_hints(function, include_extras=True)
    except (TypeError, NameError, AttributeError, SyntaxError) as error:
        raise InputError(Fault(f"the parameters of {what} cannot be read: {error}.")) from error
    given = list(signature.parameters.values())
    if given and given[0].name == "self":
        given = given[1:]
    by_position = [p for p in given if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    open_end = any(p.kind is p.VAR_POSITIONAL for p in given)
    found, faults = {}, []
    if len(by_position) < len(positional) and not open_end:
        faults.append(Fault(f"{what} takes no {positional[len(by_position)]}.", hint=write))
    for parameter in by_position[len(positional) :]:
        hint = "Write a '*' before it: parameters are passed by name."
        faults.append(Fault(f"parameter '{parameter.name}' of {what} is not keyword-only.", hint=f"{hint} {write}"))
    for parameter in (p for p in given if p.kind is p.KEYWORD_ONLY):
        if parameter.name not in hints:
            hint = "Write for example 'cruise: MetresPerSecond = 0.5'."
            faults.append(Fault(f"parameter '{parameter.name}' of {what} has no type.", hint=hint))
            continue
        required = parameter.default is parameter.empty
        default = None if required else parameter.default
        found[parameter.name] = Parameter.annotated(parameter.name, hints[parameter.name], required, default)
    if faults:
        raise InputError(*faults)
    return found, any(p.kind is p.VAR_KEYWORD for p in given)


def class_parameters(cls: type, positional: Sequence[str]) -> dict[str, Parameter]:
    """Keyword-only parameters that the constructor of a class takes, by name.

    A constructor that ends in `**rest` also takes the parameters of its base class. A class with an attribute
    `declares` takes the parameters of that class.

    Raises:
        InputError: A constructor does not have the expected form; the error lists all faults.
    """
    found: dict[str, Parameter] = {}
    for base in cls.__mro__:
        if declared := vars(base).get("declares"):
            return found | {k: p for k, p in field_parameters(declared).items() if k not in found}
        make = vars(base).get("__init__")
        if not inspect.isfunction(make):
            continue
        form = f"Write: def __init__(self, {', '.join(positional)}, *, ...)."
        own, more = keyword_parameters(make, positional, f"{base.__name__}.__init__", form)
        found |= {name: parameter for name, parameter in own.items() if name not in found}
        if not more:
            return found
    return found


def field_parameters(declared: type) -> Mapping[str, Parameter]:
    """Parameters that the annotations of a class declare, by name, in order.

    Their bounds allow infinite values, because the class checks values itself.
    """
    return _field_parameters(declared)


@functools.cache
def _field_parameters(declared: type) -> Mapping[str, Parameter]:
    hints = typing.get_type_hints(declared, include_extras=True)
    found = {}
    for name, hint in hints.items():
        if name[0] == "_" or typing.get_origin(hint) is typing.ClassVar:
            continue
        required, default = not hasattr(declared, name), getattr(declared, name, None)
        each = typing.get_args(hint)[0] if typing.get_origin(hint) is tuple else hint
        dimension = Parameter.annotated(name, each, required, None).dimension
        kind = Parameter.annotated(name, hint, required, None).type
        found[name] = Parameter(name, kind, dimension, required, default, Bounds(infinite=True))
    return found


def read_arguments(
    declared: Mapping[str, Parameter],
    values: Mapping[str, object],
    owner: str,
    *,
    file: Path | None = None,
    positions: Positions | None = None,
) -> dict[str, Any]:
    """Convert values from a file to keyword arguments, with numbers in SI units.

    Raises:
        InputError: A name, a type, a unit or a value is invalid, or a required parameter is missing; the error contains
            all faults.
    """
    faults = []
    positions = positions or {}
    start = f"{owner[:1].upper()}{owner[1:]}"
    for name in values:
        if name not in declared:
            faults.append(unknown("parameter", name, declared, start).at(file, *positions.get(name, (0, 0))))
    missing = [name for name, parameter in declared.items() if parameter.required and name not in values]
    if missing:
        faults.append(Fault(f"{owner} needs {', '.join(missing)}.", hint=f"It takes: {', '.join(declared)}."))
    arguments: dict[str, Any] = {}
    for name in (name for name in values if name in declared):
        try:
            arguments[name] = read_argument(declared[name], values[name], file, positions)
        except InputError as error:
            place = positions.get(declared[name].name, (0, 0))
            faults.extend(error.at(file, *place).faults)
    if faults:
        raise InputError(*faults)
    return arguments


def read_argument(
    parameter: Parameter, value: object, file: Path | None = None, positions: Positions | None = None
) -> Any:
    """Convert a value from a file for one parameter: all numbers in it to SI units, others unchanged.

    A table is declared as a TypedDict, tables by name as a Mapping.

    Raises:
        InputError: The type, the unit or the number is invalid.
    """
    kind = parameter.type
    if typing.get_origin(kind) in (typing.Union, types.UnionType):
        kinds = [each for each in typing.get_args(kind) if each is not type(None)]
        return read_argument(_part(parameter, kinds[0]), value, file, positions) if len(kinds) == 1 else value
    if typing.is_typeddict(kind) or typing.get_origin(kind) is Mapping:
        return _table(parameter, value, file, positions)
    if kind is float:
        number = convert(value, parameter.dimension or NONE, parameter.name)
        if faults := parameter.faults(number, parameter.name):
            raise InputError(*faults)
        return number
    if typing.get_origin(kind) in _LISTS:
        return _list(parameter, value)
    plain = kind in (str, int, bool) or typing.get_origin(kind) is typing.Literal
    if plain and (wanted := misfit(kind, value)) is not None:
        raise InputError(Fault(f"{parameter.name} must be {wanted}, found {value!r}."))
    if kind is int and (faults := parameter.faults(value, parameter.name)):
        raise InputError(*faults)
    return value


def _table(parameter: Parameter, value: object, file: Path | None, positions: Positions | None) -> dict[str, Any]:
    """Convert the values of a table, or of each table in a table of tables."""
    if not isinstance(value, dict):
        raise InputError(Fault(f"{parameter.name} must be a table, found {value!r:.80}."))
    hints: Mapping[str, Any]
    if typing.is_typeddict(parameter.type):
        hints = typing.get_type_hints(parameter.type, include_extras=True)
    else:
        hints = dict.fromkeys(value, typing.get_args(parameter.type)[1])
    declared = {key: Parameter.annotated(f"{parameter.name}.{key}", hint, False, None) for key, hint in hints.items()}
    return read_arguments(declared, value, parameter.name, file=file, positions=positions)


def _list(parameter: Parameter, value: object) -> list[Any] | tuple[Any, ...]:
    if not isinstance(value, (list, tuple)):
        raise InputError(Fault(f"{parameter.name} must be a list, found {value!r}."))
    kinds = typing.get_args(parameter.type)
    is_tuple = typing.get_origin(parameter.type) is tuple
    if not is_tuple or kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    if len(kinds) != len(value):
        raise InputError(Fault(f"{parameter.name} must have {len(kinds)} values, found {len(value)}."))
    found = [read_argument(_part(parameter, kind), each) for kind, each in zip(kinds, value, strict=True)]
    return tuple(found) if is_tuple else found


def _part(parameter: Parameter, kind: Any) -> Parameter:
    """Parameter for an element of a list, or for the type in an optional, with the dimension of the whole parameter."""
    part = Parameter.annotated(parameter.name, kind, parameter.required, None)
    if parameter.dimension not in (None, NONE) and part.dimension in (None, NONE):
        return replace(part, dimension=parameter.dimension, bounds=parameter.bounds)
    return part
