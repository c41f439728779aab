"""Texts in the file of a mission that may name modes, or nodes that the mission adds to Knowledge."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from ..actions import ACTIONS
from ..actions.heading import looked_at
from ..base.errors import InputError
from ..base.files import read_text

_GOALS = ("goal", "leader", "heading")
"""Names of parameters for a place or a robot to go to or to look at."""


def words_in(mission: Path) -> set[str] | None:
    """All words in the string literals of a mission's file; None if the file is unreadable.

    A check uses them to find modes that the mission never sets.
    """
    try:
        text = read_text(mission)
        if mission.suffix != ".py":
            return set(re.findall(r"\w+", text))
        found = _texts(text)
    except (InputError, ValueError, SyntaxError, RecursionError, MemoryError):
        return None
    return {word for value in found for word in re.findall(r"\w+", value)}


def nodes_in(files: Iterable[Path]) -> set[str]:
    """Strings in content files that may name nodes of Knowledge which the content itself adds.

    A string that occurs only as the goal of an action is not included, since something else must then add the node.
    """
    found: Counter[str] = Counter()
    goals: Counter[str] = Counter()
    for file in files:
        try:
            text = read_text(file)
            if file.suffix == ".py":
                found.update(_texts(text))
                goals.update(_goals(text))
            else:
                found.update(looked_at(value) or value for value in re.findall(r"""=\s*["']([^"']*)["']""", text))
                goals.update(_xml_goals(text))
        except (InputError, ValueError, SyntaxError, RecursionError, MemoryError):
            continue  # reported where the file itself is checked
    return {text for text, count in found.items() if count > max(1, goals[text])}


def _xml_goals(text: str) -> list[str]:
    """Goals of actions and subtrees in an XML mission; other nodes may add these goals to Knowledge."""
    tags = re.findall(r"<(\w+)((?:[^<>\"']|\"[^\"]*\"|'[^']*')*)>", text)
    going = [attributes for tag, attributes in tags if tag == "SubTree" or tag in ACTIONS]
    given = [pair for each in going for pair in re.findall(r"""(\w+)\s*=\s*["']([^"']*)["']""", each)]
    return [looked_at(value) or value for name, value in given if name in _GOALS]


def _goals(python: str) -> list[str]:
    """Goals of actions and subtrees in a Python mission; other nodes may add these goals to Knowledge."""
    found = [node for node in ast.walk(ast.parse(python)) if isinstance(node, ast.Call)]
    calls = [call for call in found if isinstance(call.func, ast.Attribute) and call.func.attr in ("act", "tree")]
    values = [word.value for call in calls for word in call.keywords if word.arg in _GOALS]
    texts = [node.value for node in values if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    return [looked_at(text) or text for text in texts]


def _texts(python: str) -> list[str]:
    """String constants in a Python file."""
    found = [node.value for node in ast.walk(ast.parse(python)) if isinstance(node, ast.Constant)]
    return [looked_at(value) or value for value in found if isinstance(value, str)]
