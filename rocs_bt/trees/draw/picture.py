"""Picture: what is shown of a tree, whatever it is drawn with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from py_trees.behaviour import Behaviour

from ...errors import Fault
from ..board import Board, type_name
from ..examine import Flow, Use, flow_of
from ..nodes import REQUIRED, Direction, Node, SubTree, Tree, pointed
from ..nodes.port import ExactKey
from ..xml.element import Element
from ..xml.stub import LenientStub, LenientStubWithChildren
from ..xml.write import value_text


@dataclass(frozen=True)
class Line:
    """A port or a condition of a node.

    Attributes:
        name: Its name.
        value: What the file gives for it.
        comes_from: Where a key comes from, or goes to; empty for a literal.
        sign: `<` for what is read, `>` for what is written, `<>` for both, `if` for a condition.
    """

    name: str
    value: str
    comes_from: str = ""
    sign: str = "<"


@dataclass
class Card:
    """A node.

    Attributes:
        title: Its name.
        tag: What it is, where the name does not say it.
        kind: Control, Decorator, Action, Condition or SubTree.
        lines: Its ports and conditions.
        depth: 0 for the root.
        stub: Whether it only stands in for a node that is not here.
        location: Where it stands, such as `patrol.xml:12`.
        doc: What its class is for.
        children: The nodes below it.
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
    """A key of a board.

    Attributes:
        board: The board's name.
        name: The key.
        type: Its type; empty where any will do.
        value: Its value before the first tick; empty where it has none.
        written: The nodes that write it.
        read: The nodes that read it.
    """

    board: str
    name: str
    type: str
    value: str
    written: tuple[str, ...]
    read: tuple[str, ...]


@dataclass(frozen=True)
class Picture:
    """A tree to be drawn.

    Attributes:
        title: What it is called.
        doc: What it is for.
        parameters: What a scenario may set, and the defaults.
        cards: All nodes, the root first, parents before children.
        keys: All keys that anything uses.
        faults: What a check finds.
    """

    title: str
    doc: str
    parameters: Mapping[str, str]
    cards: Sequence[Card]
    keys: Sequence[Key]
    faults: Sequence[Fault] = ()

    @property
    def root(self) -> Card:
        """The card of the root."""
        return self.cards[0]


def picture_of(
    tree: Tree,
    title: str = "tree",
    doc: str = "",
    parameters: Mapping[str, str] | None = None,
    faults: Sequence[Fault] = (),
) -> Picture:
    """What is shown of a tree.

    Args:
        tree: The tree, bound.
        title: What it is called.
        doc: What it is for.
        parameters: What a scenario may set, and the defaults.
        faults: What a check finds.
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
    location, doc = "", "" if isinstance(node, SubTree) else type(node).description()
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
    for name, given in (node.written() or ("", {}))[1].items():
        yield Line(name, given)
    for name, given in node.given.items():
        if given is None or given is REQUIRED:
            continue
        port = node.ports.get(name)
        key = str(given) if isinstance(given, ExactKey) else pointed(given, name)
        comes_from = "" if key is None else _origin(node, board, key, flow)
        direction = Direction.INPUT if port is None else port.direction
        sign = {Direction.INPUT: "<", Direction.OUTPUT: ">", Direction.INOUT: "<>"}[direction]
        yield Line(name, value_text(given, None if port is None else port.dimension), comes_from, sign)
    if isinstance(node, SubTree) and node.autoremap:
        yield Line("_autoremap", "true", "all other keys are those of the tree above")
    for name, script in node.conditions.items():
        yield Line(name, script.text, sign="if")


def _origin(node: Node, board: Board, key: str, flow: Flow) -> str:
    """Where a key lives, and who else writes it."""
    try:
        home, name = board.resolve(key)
    except ValueError:
        return ""
    where = "" if home is board and name == key else f"'{name}' of {home.name or 'the root'}, "
    entry = home.entry(name)
    if entry is not None and entry.value is not None:
        return f"{where}given: {value_text(entry.value)}"
    writers = dict.fromkeys(u.node.name for u in flow.of(board, key) if u.creates and u.node is not node)
    return where + (f"written by {', '.join(list(writers)[:3])}" if writers else "written by nobody else")


def _keys(flow: Flow, title: str) -> Iterator[Key]:
    for (board, name), uses in sorted(flow.uses.items(), key=lambda item: (item[0][0].name, item[0][1])):
        entry = board.entry(name)
        kind = "" if entry is None or entry.kind is None else type_name(entry.kind)
        value = "" if entry is None or entry.value is None else value_text(entry.value)
        written, read = (_names(u for u in uses if u.changes), _names(u for u in uses if not u.changes or u.reads))
        yield Key(board.name or title, name, kind, value, written, read)


def _names(uses: Iterator[Use]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(use.node.name for use in uses))
