"""A rule file, read and examined."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...action import Action
from ...document import Table
from ...errors import Fault, InputError
from ...expression import Environment
from ..include import Document, read_documents
from ..rule import Rule
from ..rule_file import read_rules
from ..threshold import Override
from .case import Case
from .checks import check_guards, check_modes, check_pairs, check_parameters, check_period, check_times

_WORD = re.compile(r"[A-Za-z_]\w*")
_PROSE = frozenset({"doc", "name", "tags", "modes", "trigger", "on_invalid"})


def unused_names(document: Document) -> list[Fault]:
    """Aliases and thresholds that no expression of the file names; warnings. What it includes may serve others, too."""
    root = document.table
    used = {word for text in _texts({key: root.data.get(key) for key in ("alias", "rule")}) for word in words(text)}
    return [
        Fault(
            f"nothing in this file uses the {kind} '{name}'.",
            root.file, *table.position(name),
            hint="Take it out, or use it in a rule.",
            warning=True,
        )
        for kind in ("threshold", "alias")
        for table in [Table(root.file, {}, (kind,), root.positions)]
        for name in (root.data[kind] if isinstance(root.data.get(kind), dict) else ())
        if name not in used
    ]  # fmt: skip


def words(text: str) -> set[str]:
    """The names in an expression."""
    return set(_WORD.findall(text))


def _texts(value: Any, key: str = "") -> Iterator[str]:
    """The expressions in a table, not what is written for people."""
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


def examine_rules(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    overrides: Mapping[str, Override] | None = None,
) -> list[Fault]:
    """All that is wrong or doubtful in a rule file: what `check_rules` finds, and what its rules cannot mean.

    Rules that are wrong themselves are not examined. Takes what `load_rules` takes, and raises nothing.
    """
    try:
        found, faults = read_rules(file, environment, actions, "", overrides or {})
        unused = unused_names(read_documents(file)[-1])
    except InputError as error:
        return list(error.faults)
    wrong = {(fault.file, fault.line) for fault in faults if not fault.warning}
    faults = [*faults, *(fault for fault in unused if (fault.file, fault.line) not in wrong)]
    sound = [rule for rule in found.rules if not _places(rule) & wrong]
    return _told_once([*faults, *analyse_rules(sound, environment, actions)])


def examine_fit(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    overrides: Mapping[str, Override] | None,
    period: float,
    modes: Collection[str] | None,
) -> list[Fault]:
    """What `check_rules` finds, and how the rules fit an agent's period and modes; see `analyse_fit`."""
    try:
        found, faults = read_rules(file, environment, actions, "", overrides or {})
    except InputError as error:
        return list(error.faults)
    return [*faults, *analyse_fit(found.rules, environment, period, modes)]


def _places(rule: Rule) -> set[tuple[Path | None, int]]:
    """The lines where what is examined of a rule can be wrong; priorities and actions are examined in any case."""
    apart = ("priority", "action")
    return {(place.file, place.line) for key, place in rule.places.items() if not key.startswith(apart)}


def _told_once(faults: list[Fault]) -> list[Fault]:
    """Without what another fault tells at the same place in more words, or again."""
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
