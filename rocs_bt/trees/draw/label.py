"""Labels of nodes in lists and logs: the name, and the ports that the file gives."""

from __future__ import annotations

import re
from collections.abc import Iterator

from py_trees.behaviour import Behaviour

from ..board import Board
from ..nodes import REQUIRED, Node, pointed
from ..nodes.port import ExactKey
from ..xml.write import value_text

_LONGEST = 60  # characters of a value; longer ones are cut


def given_ports(node: Node) -> Iterator[tuple[str, str]]:
    """Names and values of the ports that the file or the mission gives."""
    yield from (node.written() or ("", {}))[1].items()
    for name, given in node.given.items():
        if given is not None and given is not REQUIRED:
            port = node.ports.get(name)
            yield name, value_text(given, None if port is None else port.dimension)


def port_keys(node: Behaviour) -> Iterator[tuple[str, str, Board]]:
    """Ports that refer to a blackboard: name, key, and the blackboard on which the key is looked up."""
    if not isinstance(node, Node):
        return
    for name, given in ({name: port.default for name, port in node.ports.items()} | {**node.given}).items():
        key = str(given) if isinstance(given, ExactKey) else pointed(given, name)
        if key is not None:
            yield name, key, node.board


def ports_text(node: Behaviour) -> str:
    """Given ports as text to follow the node's name, such as `(goal="kitchen", cruise="0.4 m/s")`.

    Ports with a value that is part of the name are omitted. Empty if there is no port to show.
    """
    if not isinstance(node, Node):
        return ""
    shown = []
    for name, value in given_ports(node):
        if not re.search(rf"(?<!\w){re.escape(value)}(?!\w)", node.name):
            text = " ".join(value.split())
            shown.append(f'{name}="{text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"}"')
    return f"({', '.join(shown)})" if shown else ""
