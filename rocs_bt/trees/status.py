"""What a tick of a node comes to.

py_trees' Status has no word for *skipped*, and an Enum with members cannot be extended. So a tick gives back an
`Outcome`: a Status, or SKIPPED, which is told to the parent and never stored. As in BehaviorTree.CPP, a node that was
skipped is idle, which is INVALID in py_trees' words.
"""

from __future__ import annotations

from enum import Enum
from typing import Any, Final

from py_trees.common import Status

from ..errors import Fault
from .error import TreeError

RUNNING: Final = Status.RUNNING
SUCCESS: Final = Status.SUCCESS
FAILURE: Final = Status.FAILURE
IDLE: Final = Status.INVALID


class Skip(Enum):
    """The outcome of a node that was not to be ticked; its parent goes on as if it were not there."""

    SKIPPED = "SKIPPED"


SKIPPED: Final = Skip.SKIPPED

Outcome = Any
"""A Status or SKIPPED. It is Any to a type checker, because py_trees' methods that give it back promise a Status."""

_NAMES: dict[str, Outcome] = {
    "IDLE": IDLE,
    "RUNNING": RUNNING,
    "SUCCESS": SUCCESS,
    "FAILURE": FAILURE,
    "SKIPPED": SKIPPED,
}


def outcome_named(text: str) -> Outcome:
    """The outcome that a file names.

    Raises:
        TreeError: There is none of that name.
    """
    if text not in _NAMES:
        raise TreeError(Fault(f"{text!r} is no status.", hint=f"There are: {', '.join(_NAMES)}."))
    return _NAMES[text]


def outcome_name(outcome: Outcome) -> str:
    """How files name an outcome: IDLE where py_trees says INVALID."""
    return "IDLE" if outcome is IDLE else outcome.value
