"""Analysis of a rule file: reads the file and runs all checks on its rules."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ...base.errors import Fault, InputError
from ...base.toml_table import Table
from ...expression import Environment
from ...interfaces.action import Action
from ..arguments import words
from ..include import RuleDocument
from ..rule import Rule, RuleSet
from ..rule_file import read_rules
from ..threshold import Override
from .case import Case
from .checks import check_first_window, check_guards, check_modes, check_parameters, check_period, check_times
from .pairs import check_pairs


class Examined(NamedTuple):
    """What the examination of a rule file has found.

    Attributes:
        rules: Rules of the file; None if it cannot be loaded.
        faults: Errors and warnings.
    """

    rules: RuleSet | None
    faults: list[Fault]


_KINDS = {"robot": "value of the robot", "threshold": "threshold", "alias": "alias"}
_PROSE = frozenset({"doc", "name", "tags", "modes", "trigger", "on_invalid", "require", "waits_for"})


def unused_names(document: RuleDocument) -> list[Fault]:
    """Warnings about aliases and thresholds of the file that its expressions do not use; included files are exempt."""
    root = document.table
    used = {
        word
        for text in _texts({key: root.data.get(key) for key in ("threshold", "alias", "rule")})
        for word in words(text)
    }
    return [
        Fault(
            f"the {_KINDS[kind]} '{name}' is not used in this file.",
            root.file,
            *table.position(name),
            hint="Remove it, or use it in a rule.",
            warning=True,
        )
        for kind in _KINDS
        for table in [Table(root.file, {}, (kind,), root.positions)]
        for name in (root.data[kind] if isinstance(root.data.get(kind), dict) else ())
        if name not in used
    ]


def _texts(value: Any, key: str = "") -> Iterator[str]:
    """Texts of a table that may be expressions; the texts of documentation, names and options are skipped."""
    if isinstance(value, Mapping):
        for inner, part in value.items():
            if inner not in _PROSE or isinstance(part, Mapping):
                yield from _texts(part, inner)
    elif isinstance(value, list):
        for part in value:
            yield from _texts(part, key)
    elif isinstance(value, str):
        yield value


def analyse_rules(rules: Sequence[Rule], environment: Environment, actions: Mapping[str, type[Action]]) -> list[Fault]:
    """Find probable mistakes in rules, such as a guard that never holds or a rule that never acts.

    Args:
        rules: Rules of one file.
        environment: Signals of the robot, with their bounds.
        actions: Actions of the agent, keyed by name.

    Returns:
        Warnings, errors about ties, and notes about questions that could not be decided.
    """
    case = Case(rules, environment)
    for rule in rules:
        check_guards(case, rule, actions.get(rule.action))
        check_times(case, rule)
        check_first_window(case, rule)
        if rule.action in actions:
            check_parameters(case, rule, actions[rule.action])
    check_pairs(case)
    return case.faults


def analyse_fit(
    rules: Sequence[Rule], environment: Environment, period: float, modes: Collection[str] | None = None
) -> list[Fault]:
    """Warnings about rules that do not fit the agent's control period or the modes of its mission.

    Args:
        rules: Rules of one file.
        environment: Signals of the robot, with their maximum ages.
        period: Control period [s].
        modes: Modes that the mission can set; None if unknown.
    """
    case = Case(rules, environment)
    for rule in rules:
        check_period(case, rule, period)
        if modes is not None:
            check_modes(case, rule, modes)
    return case.faults


def examine_rules(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    overrides: Mapping[str, Override] | None = None,
) -> Examined:
    """Errors and warnings of a rule file, as found by `read_rules` and `analyse_rules`, and its rules.

    Rules with errors are not analysed. Arguments as in `load_rules`. Faults are returned, never raised.
    """
    try:
        found, faults, document = read_rules(file, environment, actions, overrides)
    except InputError as error:
        return Examined(None, list(error.faults))
    wrong = {(fault.file, fault.line) for fault in faults if not fault.warning}
    unused = (fault for fault in unused_names(document) if (fault.file, fault.line) not in wrong)
    sound = [rule for rule in found.rules if not _lines(rule) & wrong]
    faults = _without_duplicates([*faults, *unused, *analyse_rules(sound, environment, actions)])
    return Examined(None if wrong else found, faults)


def _lines(rule: Rule) -> set[tuple[Path | None, int]]:
    """Lines of a rule's keys except `priority` and `action`. An error on one of these lines prevents its analysis."""
    exempt = ("priority", "action")
    return {(p.file, p.line) for key, p in rule.positions.items() if not key.startswith(exempt)}


def _without_duplicates(faults: list[Fault]) -> list[Fault]:
    """Remove duplicates, and faults with a message that is a prefix of another message at the same position."""
    return [
        fault
        for i, fault in enumerate(faults)
        if not any(
            (other.file, other.line, other.column) == (fault.file, fault.line, fault.column)
            and (other.message, other.warning) != (fault.message, fault.warning)
            and other.message.startswith(fault.message)
            for other in faults
        )
        and fault not in faults[:i]
    ]
