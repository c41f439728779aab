"""The actions that a mission file brings along."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from typing import Any

from ..action import Action


def mission_actions(build: Callable[..., Any]) -> list[type[Action]]:
    """The action classes that stand in the mission's own file: writing one there is all it takes to use it."""
    module = sys.modules.get(getattr(inspect.unwrap(build), "__module__", ""))
    found = [v for v in vars(module).values() if isinstance(v, type) and issubclass(v, Action)] if module else []
    return [a for a in found if module is not None and a.__module__ == module.__name__ and not inspect.isabstract(a)]
