"""A rule file, read and examined."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

from ...action import Action
from ...document import Table
from ...errors import Fault, InputError
from ...expression import Environment
from ..include import read_documents
from ..rule import Rule
from ..rule_file import read_rules
from ..threshold import Override
from .analyse import analyse_fit, analyse_rules
from .unused import unused_names


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
