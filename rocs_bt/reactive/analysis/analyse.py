"""All checks of a rule set."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from ...action import Action
from ...errors import Fault
from ...expression import Environment
from ..rule import Rule
from .case import Case
from .fit import check_modes, check_period, check_times
from .guards import check_guards, check_parameters
from .pairs import check_pairs


def analyse_rules(rules: Sequence[Rule], environment: Environment, actions: Mapping[str, type[Action]]) -> list[Fault]:
    """What the rules say themselves that cannot be meant; warnings, and notes where something cannot be decided.

    Args:
        rules: Rules of one file.
        environment: The robot's signals, with their bounds.
        actions: The agent's actions by name.
    """
    case = Case(rules, environment)
    for rule in rules:
        check_guards(case, rule, actions.get(rule.action))
        check_times(case, rule)
        if rule.action in actions:
            check_parameters(case, rule, actions[rule.action])
    check_pairs(case)
    return case.faults


def analyse_fit(
    rules: Sequence[Rule], environment: Environment, period: float, modes: Collection[str] | None = None
) -> list[Fault]:
    """How the rules fit an agent; warnings.

    Args:
        rules: Rules of one file.
        environment: The robot's signals, with their greatest ages.
        period: The control period [s].
        modes: The modes that its mission can set; None where they are not known.
    """
    case = Case(rules, environment)
    for rule in rules:
        check_period(case, rule, period)
        if modes is not None:
            check_modes(case, rule, modes)
    return case.faults
