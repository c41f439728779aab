"""A user's own driver: the keys of robot.toml that its constructor takes.

The keyword-only parameters of `__init__` are the keys; their annotations are the units:

    class Beacon(MujocoSensor):
        def __init__(self, name, mount, *, reach: Metres = 10.0):
            super().__init__(name, mount)
            self.reach = reach
"""

from __future__ import annotations

import dataclasses
import inspect
import typing

from ..action import Parameter
from ..arguments import keyword_parameters


def constructor_parameters(cls: type, place: str) -> dict[str, Parameter]:
    """The keys that a driver's class takes, by name.

    A constructor that ends in `**rest` takes the keys of the class that it extends, too; a class that extends a
    shipped driver without a constructor of its own takes that driver's keys.

    Args:
        cls: The class.
        place: The constructor's second argument: `mount` in MuJoCo, `host` on hardware.

    Raises:
        InputError: A constructor has another form than `(self, name, mount, *, ...)`; all that is wrong with it.
    """
    found: dict[str, Parameter] = {}
    for base in cls.__mro__:
        if declared := vars(base).get("declares"):
            return found | {k: p for k, p in _of_dataclass(declared).items() if k not in found}
        make = vars(base).get("__init__")
        if not inspect.isfunction(make):
            continue
        what, form = f"{base.__name__}.__init__", f"Write: def __init__(self, name, {place}, *, ...)."
        own, more = keyword_parameters(make, ("name", place), what, form)
        found |= {name: parameter for name, parameter in own.items() if name not in found}
        if not more:
            return found
    return found


def _of_dataclass(declared: type) -> dict[str, Parameter]:
    """The keys of a shipped driver."""
    hints = typing.get_type_hints(declared, include_extras=True)
    missing = dataclasses.MISSING
    return {
        field.name: Parameter.annotated(field.name, hints[field.name], field.default is missing, field.default)
        for field in dataclasses.fields(declared)
    }
