"""Outcome of a tick: a py_trees Status or SKIPPED.

py_trees' Status has no *skipped*, and an Enum with members cannot be extended. A tick therefore returns an `Outcome`: a
Status, or SKIPPED, which only the parent receives and which is never stored. As in BehaviorTree.CPP, a skipped node is
idle; py_trees calls this INVALID.
"""

from __future__ import annotations

from enum import Enum
from typing import Any, Final

from py_trees.common import Status

from ..base.errors import Fault
from .error import TreeError

RUNNING: Final = Status.RUNNING
SUCCESS: Final = Status.SUCCESS
FAILURE: Final = Status.FAILURE
IDLE: Final = Status.INVALID


class Skip(Enum):
    """Outcome of a node that must not be ticked; its parent continues as if the node did not exist."""

    SKIPPED = "SKIPPED"


SKIPPED: Final = Skip.SKIPPED

Outcome = Any
"""A Status or SKIPPED; typed Any because py_trees' methods that return it are annotated with Status."""

_NAMES: dict[str, Outcome] = {
    "IDLE": IDLE,
    "RUNNING": RUNNING,
    "SUCCESS": SUCCESS,
    "FAILURE": FAILURE,
    "SKIPPED": SKIPPED,
}


def outcome_named(text: str) -> Outcome:
    """Outcome by its name in files, such as `SUCCESS`.

    Raises:
        TreeError: No outcome has this name.
    """
    if text not in _NAMES:
        raise TreeError(Fault(f"unknown status {text!r}.", hint=f"Statuses: {', '.join(_NAMES)}."))
    return _NAMES[text]


def outcome_name(outcome: Outcome) -> str:
    """Name of an outcome in files: IDLE for py_trees' INVALID."""
    return "IDLE" if outcome is IDLE else outcome.value
