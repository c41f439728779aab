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

from ..base.errors import Fault, InputError
from .fields import MISSING, Field, own_annotations


def own_fields(cls: type) -> list[Field]:
    """Fields that the annotations of any class declare, without those of its bases."""
    if not (own := own_annotations(cls)):
        return []
    module = vars(sys.modules.get(cls.__module__, types))
    try:
        hints = typing.get_type_hints(types.SimpleNamespace(__annotations__=own), module, dict(vars(cls)), True)
    except (NameError, TypeError, SyntaxError, AttributeError) as error:
        hint = "Import the types also at run time, or begin the names of attributes that are no keys with '_'."
        raise InputError(Fault(f"the annotations of '{cls.__name__}' cannot be read: {error}.", hint=hint)) from error
    return [Field.annotated(name, hints[name], vars(cls).get(name, MISSING), cls) for name in own]


def class_fields(cls: type) -> dict[str, Field]:
    """Fields that the annotations of any class and of its bases declare, by name; of a dataclass, those to make it."""
    found = {each.name: each for base in reversed(cls.__mro__) for each in own_fields(base)}
    if dataclasses.is_dataclass(cls):
        kept = {each.name: each for each in dataclasses.fields(cls) if each.init}
        return {name: replace(each, default=_default(kept[name])) for name, each in found.items() if name in kept}
    return {name: replace(each, default=getattr(cls, name, MISSING)) for name, each in found.items()}


def _default(of: dataclasses.Field[Any]) -> Any:
    if of.default_factory is not dataclasses.MISSING:
        return of.default_factory()
    return MISSING if of.default is dataclasses.MISSING else of.default


def refuse_parameters(cls: type, positional: Sequence[str]) -> None:
    """Refuse a class with a constructor that needs more than some values by position.

    Raises:
        InputError: It needs others, which are keys only if the class declares them by annotations.
    """
    if dataclasses.is_dataclass(cls):
        return
    parameters = [*inspect.signature(cls.__init__).parameters.values()][1:]  # type: ignore[misc]  # of the class itself
    needed = [p for p in parameters if p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
    if more := [p.name for p in needed if p.kind is p.KEYWORD_ONLY] or [p.name for p in needed[len(positional) :]]:
        form = f"__init__({', '.join(('self', *positional))})"
        hint = f"Declare it by an annotation of the class, such as '{more[0]}: Metres = 0.3', and write {form} or none."
        raise InputError(Fault(f"the constructor of '{cls.__name__}' needs {', '.join(more)}.", hint=hint))


def constructed(cls: Any, keys: Mapping[str, Any], *given: Any) -> Any:
    """Object of any class; the values of its keys are attributes when its constructor begins, or its arguments."""
    if hasattr(cls, "__dataclass_fields__"):
        return cls(*given, **keys)
    made = cls.__new__(cls)
    vars(made).update(keys)
    made.__init__(*given)
    return made
