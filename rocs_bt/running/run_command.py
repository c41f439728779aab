"""Commands of a person to a run: pause, step, continue, swap a subtree, reload a rule file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol, runtime_checkable

import msgspec


class RunCommand(msgspec.Struct, frozen=True, kw_only=True):
    """Command of a person to a run, applied at the beginning of the next control period.

    Attributes:
        kind: `pause`, `step` (one control period, then pause), `continue`, `swap` or `reload`.
        by: Name of the person or program, for the recording.
        agent: Agent of a swap or reload; may be empty if only one agent has such a node or rule file.
        node: Path or name of the root of the subtree to swap.
        mission: XML mission with the new tree, by name or file.
        tree: ID of the new tree in the mission; empty for its main tree.
        rules: Name of the rule file to reload.
    """

    kind: Literal["pause", "step", "continue", "swap", "reload"]
    by: str = "the page"
    agent: str = ""
    node: str = ""
    mission: str = ""
    tree: str = ""
    rules: str = ""


@runtime_checkable
class CommandSource(Protocol):
    """Source of commands of a run, such as the live page."""

    def take(self) -> Sequence[RunCommand]:
        """Commands since the last call, in order. Called between control periods; must not wait."""
