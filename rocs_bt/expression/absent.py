"""Faults about signals that a robot lacks."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from ..base.errors import Fault, unknown

ABSENT = "the robot has no signal"
"""Beginning of the message about a signal that other robots have."""

NO_NAME = re.compile(r"no signal (?:or alias )?is named '(\w+)'\.")
"""Message about a name that is no signal, with the name as a group."""

_ADD_MAP = (
    "The robot has no map: add a LocalMap with its scanner to robot.toml, as [[analyze]] with "
    'class = "LocalMap" (docs/navigation.md).'
)
_ADD_TRACKER = (
    "The robot tracks nothing that moves: add a TrackObjects with its scanner to robot.toml, as [[analyze]] with "
    'class = "TrackObjects" (docs/navigation.md).'
)
_SOURCES = {  # signals of blocks that any robot may have
    "contact_time": _ADD_MAP,
    "collision_time": _ADD_TRACKER,
    "predicted_clearance": _ADD_TRACKER,
}


def absent_name(name: str, known: Iterable[str]) -> Fault:
    """Create a fault about a name that is neither a signal nor an alias."""
    fault = unknown("signal or alias", name, known)
    return replace(fault, hint=_SOURCES.get(name, fault.hint))


def is_absent(fault: Fault) -> bool:
    """Whether a fault is about a signal that the robot lacks."""
    return bool(NO_NAME.search(fault.message)) or fault.message.startswith(ABSENT)


def one_for_each_signal(faults: Iterable[Fault]) -> list[Fault]:
    """Remove all but the first fault about each signal that the expressions of a file use and a robot lacks."""
    seen, kept = set[tuple[Path | None, str]](), []
    for fault in faults:
        if is_absent(fault):
            found = NO_NAME.search(fault.message)
            key = fault.file, found[1] if found else fault.message
            if key in seen:
                continue
            seen.add(key)
        kept.append(fault)
    return kept
