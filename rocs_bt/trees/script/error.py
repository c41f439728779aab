"""What is wrong with a script, and where in it."""

from __future__ import annotations

from ...errors import Fault
from ..error import TreeError


class ScriptError(TreeError):
    """A script that cannot be read, or that could not go on.

    Args:
        text: The script.
        at: Where in it, counted from 0.
        fault: What is wrong.
    """

    def __init__(self, text: str, at: int, *faults: Fault | str) -> None:
        self.text = text
        self.column = at
        super().__init__(*faults)


def short(text: str) -> str:
    """A script in a message: the beginning of a long one."""
    return text if len(text) <= 80 else text[:77] + "..."
