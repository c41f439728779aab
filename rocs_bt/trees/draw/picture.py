"""Picture: content of a drawing of a tree, independent of the output format."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from py_trees.behaviour import Behaviour

from ...base.errors import Fault
from ...declare import MISSING, summary_of
from ..board import Board
from ..examine import Flow, Use, flow_of
from ..nodes import Direction, Node, SubTree, Tree, pointed
from ..nodes.port import ExactKey
from ..value import type_name
from ..xml.element import Element
from ..xml.stub import LenientStub, LenientStubWithChildren
from ..xml.write import value_text


@dataclass(frozen=True)
class Line:
    """Line on the card of a node: one port or condition.

    Attributes:
        name: Name of the port or condition.
        value: Value given in the file.
        comes_from: Text that says which nodes write the blackboard key, or its given value; empty for a literal.
        sign: `<` for inputs, `>` for outputs, `<>` for both, `if` for a condition.
    """

    name: str
    value: str
    comes_from: str = ""
    sign: str = "<"


@dataclass
class Card:
    """Card: a node in a drawing.

    Attributes:
        title: Name of the node.
        tag: Class of the node; empty if the name already shows it.
        kind: Control, Decorator, Action, Condition or SubTree.
        lines: Ports and conditions.
        depth: Depth in the tree, 0 for the root.
        stub: Whether the node is a stub for a node of an unknown class.
        location: Position in its file, such as `patrol.xml:12`.
        doc: Description of the node's class.
        children: Child nodes.
    """

    title: str
    tag: str
    kind: str
    lines: tuple[Line, ...]
    depth: int
    stub: bool = False
    location: str = ""
    doc: str = ""
    children: list[Card] = field(default_factory=list)


@dataclass(frozen=True)
class Key:
    """Blackboard key in a drawing.

    Attributes:
        board: Name of the blackboard.
        name: The key.
        type: Type of the key; empty for any type.
        value: Value before the first tick; empty if there is none.
        written: Names of the nodes that write the key.
        read: Names of the nodes that read the key.
    """

    board: str
    name: str
    type: str
    value: str
    written: tuple[str, ...]
    read: tuple[str, ...]


@dataclass(frozen=True)
class Picture:
    """Content of a drawing of a tree.

    Attributes:
        title: Title of the drawing.
        doc: Description of the tree.
        parameters: Defaults of the parameters that a scenario may set.
        cards: Cards of all nodes, parents before children, so the root is first.
        keys: All blackboard keys that nodes use.
        faults: Faults of the tree, as found by a check.
    """

    title: str
    doc: str
    parameters: Mapping[str, str]
    cards: Sequence[Card]
    keys: Sequence[Key]
    faults: Sequence[Fault] = ()

    @property
    def root(self) -> Card:
        """Card of the root."""
        return self.cards[0]


def picture_of(
    tree: Tree,
    title: str = "tree",
    doc: str = "",
    parameters: Mapping[str, str] | None = None,
    faults: Sequence[Fault] = (),
) -> Picture:
    """Create the drawing of a tree.

    Args:
        tree: Tree to draw.
        title: Title of the drawing.
        doc: Description of the tree.
        parameters: Defaults of the parameters that a scenario may set.
        faults: Faults of the tree, as found by a check.
    """
    flow = flow_of(tree)
    cards, made, depths = [], dict[Any, Card](), {tree.root.id: 0}
    for node in tree.nodes:
        depth = depths[node.id]
        card = made[node.id] = _card(node, tree, flow, depth)
        cards.append(card)
        depths.update({child.id: depth + 1 for child in node.children})
        if node is not tree.root and node.parent is not None:
            made[node.parent.id].children.append(card)
    return Picture(title, doc, dict(parameters or {}), cards, tuple(_keys(flow, title)), faults)


def _card(node: Behaviour, tree: Tree, flow: Flow, depth: int) -> Card:
    if not isinstance(node, Node):
        tag, kind = (
            type(node).__name__,
            "Control" if len(node.children) > 1 else "Decorator" if node.children else "Action",
        )
        return Card(node.name, tag, kind, (), depth)
    tag = f"SubTree {node.tree}" if isinstance(node, SubTree) else node.tag
    location, doc = "", "" if isinstance(node, SubTree) else summary_of(type(node))
    if isinstance(node.origin, Element):
        source = node.origin.source
        line, _ = source.position(node.origin.at)
        location = f"{source.file.name}:{line}" if source.file else f"line {line}"
    shown = "" if tag in (node.name, "Act") else tag
    stub = isinstance(node, (LenientStub, LenientStubWithChildren))
    lines = tuple(_lines(node, tree, flow))
    return Card(node.name, shown, node.kind, lines, depth, stub, location, "" if stub else doc)


def _lines(node: Node, tree: Tree, flow: Flow) -> Iterator[Line]:
    board = tree.boards[node]
    for name, value in given_ports(node):
        if (given := node.given.get(name)) is None:
            yield Line(name, value)
            continue
        port = node.ports.get(name)
        key = str(given) if isinstance(given, ExactKey) else pointed(given, name)
        comes_from = "" if key is None else _origin(node, board, key, flow)
        direction = Direction.INPUT if port is None else port.direction
        sign = {Direction.INPUT: "<", Direction.OUTPUT: ">", Direction.INOUT: "<>"}[direction]
        yield Line(name, value, comes_from, sign)
    if isinstance(node, SubTree) and node.autoremap:
        yield Line("_autoremap", "true", "all other keys refer to the parent tree")
    for name, script in node.conditions.items():
        yield Line(name, script.text, sign="if")


def _origin(node: Node, board: Board, key: str, flow: Flow) -> str:
    """Describe where the value of a key comes from: from which blackboard, and given or written by which nodes."""
    try:
        home, name = board.resolve(key)
    except ValueError:
        return ""
    where = "" if home is board and name == key else f"'{name}' of {home.name or 'the root'}, "
    entry = home.entry(name)
    if entry is not None and entry.value is not None:
        return f"{where}given: {value_text(entry.value)}"
    writers = dict.fromkeys(u.node.name for u in flow.of(board, key) if u.creates and u.node is not node)
    return where + (f"written by {', '.join(list(writers)[:3])}" if writers else "not written by any other node")


def _keys(flow: Flow, title: str) -> Iterator[Key]:
    for (board, name), uses in sorted(flow.uses.items(), key=lambda item: (item[0][0].name, item[0][1])):
        entry = board.entry(name)
        kind = "" if entry is None or entry.kind is None else type_name(entry.kind)
        value = "" if entry is None or entry.value is None else value_text(entry.value)
        written, read = (_names(u for u in uses if u.changes), _names(u for u in uses if not u.changes or u.reads))
        yield Key(board.name or title, name, kind, value, written, read)


def _names(uses: Iterator[Use]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(use.node.name for use in uses))


_LONGEST = 60  # characters of a value; longer ones are cut


def given_ports(node: Node) -> Iterator[tuple[str, str]]:
    """Names and values of the ports that the file or the mission gives."""
    yield from (node.written() or ("", {}))[1].items()
    for name, given in node.given.items():
        if given is not None and given is not MISSING:
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
