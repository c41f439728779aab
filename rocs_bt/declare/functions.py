"""Fields that a function declares by its keyword-only parameters, such as `build` of a mission."""

from __future__ import annotations

import inspect
import typing
from collections.abc import Callable, Sequence
from typing import Any

from ..base.errors import Fault, InputError
from .fields import MISSING, Field


def keyword_fields(
    function: Callable[..., Any], positional: Sequence[str], what: str, write: str
) -> tuple[dict[str, Field], bool]:
    """Keyword-only parameters of a function by name, and whether it takes others (`**rest`).

    Args:
        function: The function; an attribute `parameters`, if it has one, contains the fields.
        positional: Names of the parameters that are passed by position.
        what: Name of the function, for messages.
        write: Advice on its form.

    Raises:
        InputError: The signature does not have the expected form; contains all faults.
    """
    if (known := getattr(function, "parameters", None)) is not None:
        return dict(known), False
    try:
        signature = inspect.signature(function)
        hints = typing.get_type_hints(function, include_extras=True)
    except (TypeError, NameError, AttributeError, SyntaxError) as error:
        raise InputError(Fault(f"the parameters of {what} cannot be read: {error}.")) from error
    given = [p for i, p in enumerate(signature.parameters.values()) if i or p.name != "self"]
    by_position = [p for p in given if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    by_name = [p for p in given if p.kind is p.KEYWORD_ONLY]
    faults = []
    if len(by_position) < len(positional) and not any(p.kind is p.VAR_POSITIONAL for p in given):
        faults.append(Fault(f"{what} takes no {positional[len(by_position)]}.", hint=write))
    for parameter in by_position[len(positional) :]:
        hint = f"Write a '*' before it: parameters are passed by name. {write}"
        faults.append(Fault(f"parameter '{parameter.name}' of {what} is not keyword-only.", hint=hint))
    for parameter in (p for p in by_name if p.name not in hints):
        hint = "Write for example 'cruise: MetresPerSecond = 0.5'."
        faults.append(Fault(f"parameter '{parameter.name}' of {what} has no type.", hint=hint))
    if faults:
        raise InputError(*faults)
    defaults = {p.name: MISSING if p.default is p.empty else p.default for p in by_name}
    found = {name: Field.annotated(name, hints[name], default, object) for name, default in defaults.items()}
    return found, any(p.kind is p.VAR_KEYWORD for p in given)


def constructor_fields(cls: type, positional: Sequence[str]) -> dict[str, Field]:
    """Keyword-only parameters that the constructor of a class takes, by name.

    A constructor that ends in `**rest` also takes the parameters of its base class.

    Raises:
        InputError: A constructor does not have the expected form; contains all faults.
    """
    found: dict[str, Field] = {}
    for base in cls.__mro__:
        make = vars(base).get("__init__")
        if not inspect.isfunction(make):
            continue
        form = f"Write: def __init__({', '.join(['self', *positional, '*', '...'])})."
        own, more = keyword_fields(make, positional, f"{base.__name__}.__init__", form)
        found = own | found
        if not more:
            break
    return found
