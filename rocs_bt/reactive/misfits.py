"""Parameters of rules' actions that a robot cannot carry out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from ..action import Action, misfits_of
from ..errors import Fault
from ..expression import Expression
from ..knowledge import Knowledge
from .rule import Argument, Rule


def rule_misfits(rules: Iterable[Rule], actions: Mapping[str, type[Action]], knowledge: Knowledge) -> Iterator[Fault]:
    """Faults of constant parameters of rules' actions that a robot cannot carry out.

    Args:
        rules: Rules without other faults.
        actions: The agent's actions by name.
        knowledge: Knowledge of the robot.
    """
    for rule in rules:
        known = {n: _known(a) for n, a in rule.arguments.items() if not isinstance(a.value, Expression)}
        for name, reason in misfits_of(actions[rule.action], known, knowledge):
            places = (rule.places.get(key) for key in (f"action.{name}", "action", ""))
            place = next(p for p in places if p is not None)
            yield Fault(f"{name} of {rule.action}: {reason}.", place.file, place.line, place.column)


def _known(argument: Argument) -> Any:
    """An argument's value, with NaN for what of a list depends on signals."""
    value = argument.value
    if isinstance(value, tuple):
        return [math.nan if isinstance(part, Expression) else part for part in value]
    return value
