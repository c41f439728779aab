"""Values that the annotations of any class declare: of a node, a planner, or a driver on hardware."""

from __future__ import annotations

import dataclasses
import inspect
import sys
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from .fields import MISSING, Field, class_error, own_annotations


def own_fields(cls: type) -> list[Field]:
    """Fields that the annotations of any class declare, without those of its bases."""
    if not (own := own_annotations(cls)):
        return []
    module = vars(sys.modules.get(cls.__module__, types))
    try:
        hints = typing.get_type_hints(types.SimpleNamespace(__annotations__=own), module, dict(vars(cls)), True)
    except (NameError, TypeError, SyntaxError, AttributeError) as error:
        hint = "Import the types also at run time, or begin the names of attributes that are no keys with '_'."
        raise class_error(cls, f"the annotations of '{cls.__name__}' cannot be read: {error}.", hint) from error
    return [Field.annotated(name, hints[name], _given(vars(cls).get(name, MISSING)), cls) for name in own]


def class_fields(cls: type) -> dict[str, Field]:
    """Fields that the annotations of any class and of its bases declare, by name; of a dataclass, those to make it."""
    found = {each.name: each for base in reversed(cls.__mro__) for each in own_fields(base)}
    if dataclasses.is_dataclass(cls):
        kept = {each.name: each for each in dataclasses.fields(cls) if each.init}
        return {name: replace(each, default=_default(kept[name])) for name, each in found.items() if name in kept}
    return {name: replace(each, default=_given(getattr(cls, name, MISSING))) for name, each in found.items()}


def _given(value: Any) -> Any:
    """Value of an attribute of a class as a default: a slot is none."""
    return MISSING if isinstance(value, types.MemberDescriptorType) else value


def _default(of: dataclasses.Field[Any]) -> Any:
    if of.default_factory is not dataclasses.MISSING:
        return of.default_factory()
    return MISSING if of.default is dataclasses.MISSING else of.default


def refuse_constructor(cls: type, positional: Sequence[str] = (), base: Any = object) -> None:
    """Refuse a class that cannot be constructed with some values by position.

    Args:
        cls: The class.
        positional: Names of the values.
        base: Base class of which the constructor takes other values.

    Raises:
        InputError: The constructor takes others, which are keys only if the class declares them by annotations.
    """
    form = f"__init__({', '.join(('self', *positional))})"
    if dataclasses.is_dataclass(cls):
        if positional:
            raise class_error(cls, f"'{cls.__name__}' is a dataclass.", f"Remove the decorator, and write {form}.")
        if "__dataclass_fields__" not in vars(cls) and (lost := own_annotations(cls)):
            message = f"'{cls.__name__}' extends a dataclass, and declares {', '.join(sorted(lost))} without being one."
            raise class_error(cls, message, "Write @dataclass above it.")
        return
    construct: Any = cls.__init__  # type: ignore[misc]  # of the class itself
    parameters = [*inspect.signature(construct).parameters.values()][1:]
    needed = [p for p in parameters if p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
    if more := [p.name for p in needed if p.kind is p.KEYWORD_ONLY] or [p.name for p in needed[len(positional) :]]:
        hint = f"Declare it by an annotation of the class, such as '{more[0]}: Metres = 0.3', and write {form}."
        if more[0] in positional:
            hint = f"Take {more[0]} by position: write {form}."
        raise class_error(cls, f"the constructor of '{cls.__name__}' needs {', '.join(more)}.", hint)
    most = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    is_open = any(p.kind is p.VAR_POSITIONAL for p in parameters)
    if (positional and construct is base.__init__) or (len(most) < len(positional) and not is_open):
        message = f"the constructor of '{cls.__name__}' does not take {' and '.join(positional)}."
        raise class_error(cls, message, f"Write {form}.")


def constructed(cls: Any, keys: Mapping[str, Any], *given: Any) -> Any:
    """Object of any class; the values of its keys are attributes when its constructor begins, or its arguments."""
    if hasattr(cls, "__dataclass_fields__"):
        return cls(*given, **keys)
    made = cls.__new__(cls)
    for name, value in keys.items():
        object.__setattr__(made, name, value)  # also a slot, or an attribute of a class that allows no change
    made.__init__(*given)
    return made
