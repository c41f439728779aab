"""Values that a script reads, as text for people."""

from __future__ import annotations

from ..board import Board
from .arithmetic import shown
from .form import parse_script


def script_reading(text: str, board: Board) -> str:
    """Text of a script with the present values of the keys that it reads, such as `tries > 2, tries = 1`.

    Args:
        text: The script.
        board: Blackboard of the script's node.
    """
    found: dict[str, str] = {}
    for name in parse_script(text).reads():
        entry = board.entry(name.name)
        if entry is not None:
            value = entry.value
            found[name.name] = f"{value:.3g}" if isinstance(value, float) else shown(value)
        elif name.name not in (board.enums or {}):
            found[name.name] = "nothing"
    return ", ".join([text.strip(), *(f"{name} = {value}" for name, value in found.items())])
