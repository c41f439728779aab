"""Data flow of a tree: which nodes write and read each key of each blackboard."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import Fault, InputError, did_you_mean
from ..board import Board
from ..nodes import Direction, Node, Port, SubTree, Tree, pointed
from ..nodes.tree import fault_at
from ..script import Script, parse_script

SCRIPTS: Mapping[str, tuple[str, ...]] = {
    "Script": ("code",),
    "ScriptCondition": ("code",),
    "Precondition": ("if",),
    "TestNode": ("return_status_script", "success_script", "failure_script", "post_script"),
}
"""Ports of nodes that contain scripts."""

NAMING: Mapping[str, tuple[str, ...]] = {
    "SetBlackboard": ("output_key",),
    "WasEntryUpdated": ("entry",),
    "SkipUnlessUpdated": ("entry",),
    "WaitValueUpdate": ("entry",),
}
"""Ports of nodes that name a key, with or without braces."""


MAX_SUGGESTED = 100
"""Maximum number of keys to search for the nearest name; each fault compares its key with all of them."""


@dataclass(frozen=True)
class Use:
    """Use of a key by a node.

    Attributes:
        node: The node.
        attribute: Port or condition.
        key: The key as written in the node.
        reads: Whether the node requires a value.
        creates: Whether the node creates the key if it does not exist.
        changes: Whether the node writes the key.
        column: Position in a script, counted from 0; None for a port.
    """

    node: Node
    attribute: str
    key: str
    reads: bool = False
    creates: bool = False
    changes: bool = False
    column: int | None = None


@dataclass(frozen=True)
class Flow:
    """All uses of all keys of a tree.

    Attributes:
        uses: Uses by blackboard and the key's name there.
    """

    uses: Mapping[tuple[Board, str], list[Use]]

    def of(self, board: Board, key: str) -> list[Use]:
        """Uses of a key, given by its name on a node's blackboard."""
        return self.uses.get(board.resolve(key), [])


def scripts_of(node: Node) -> Iterator[tuple[str, Script]]:
    """Scripts of a node by attribute, except scripts read from the blackboard."""
    yield from node.conditions.items()
    for port in SCRIPTS.get(node.tag, ()):
        text = node.given.get(port, "")
        if isinstance(text, str) and text and node.key(port) is None:
            try:
                yield port, parse_script(text)
            except InputError:  # reported when the node is made
                continue


def flow_of(tree: Tree) -> Flow:
    """Data flow of a tree.

    Args:
        tree: The tree, bound.
    """
    found: dict[tuple[Board, str], list[Use]] = {}
    for node in tree.nodes:
        if not isinstance(node, Node):
            continue
        board = tree.boards[node]
        for use in _uses(node):
            if use.key.count("@") <= 1 and use.key not in tree.board.enums:
                found.setdefault(board.resolve(use.key), []).append(use)
    return Flow(found)


def _uses(node: Node) -> Iterator[Use]:
    if not isinstance(node, SubTree):
        for port in node.ports.values():
            yield from _port_uses(node, port)
    for attribute, script in scripts_of(node):
        written = {id(a.target) for a in script.writes()}
        for name in script.reads():
            yield Use(node, attribute, name.name, reads=True, column=name.at, changes=id(name) in written)
        for a in script.writes():
            if a.operator in (":=", "="):
                creates = a.operator == ":="
                yield Use(node, attribute, a.target.name, creates=creates, changes=True, column=a.target.at)


def _port_uses(node: Node, port: Port[Any]) -> Iterator[Use]:
    given = node.given.get(port.name, port.default)
    key = pointed(given, port.name)
    if key is None and port.name in NAMING.get(node.tag, ()) and isinstance(given, str):
        key = given
    if key is None:
        return
    if port.direction is Direction.INPUT:
        yield Use(node, port.name, key, reads=port.default is not None)
    else:
        yield Use(node, port.name, key, creates=True, changes=True)


def flow_faults(tree: Tree, flow: Flow) -> Iterator[Fault]:
    """Faults of keys that are read, or assigned by `=`, but never created."""
    known: dict[Board, list[str]] = {}
    for (board, name), uses in flow.uses.items():
        if any(use.creates for use in uses):
            known.setdefault(board, []).append(name)
    for (board, name), uses in flow.uses.items():
        entry = board.entry(name)
        if any(use.creates for use in uses) or (entry is not None and entry.value is not None):
            continue
        for use in uses:
            if use.reads:
                yield _unwritten(use, name, known.get(board, []))
            elif use.changes and entry is None:
                hint = f"Write {use.key} := ... to create it."
                message = f"'=' needs an existing key, but no node creates '{use.key}'."
                yield fault_at(use.node, message, hint, attribute=use.attribute, column=use.column)


def _unwritten(use: Use, name: str, known: list[str]) -> Fault:
    hint = did_you_mean(name, known, "The board") if len(known) <= MAX_SUGGESTED else ""
    also = "" if use.key == name else f" ('{name}' there)"
    message = f"the key '{use.key}'{also} is read, but no node writes it."
    return fault_at(use.node, message, hint, attribute=use.attribute, column=use.column)
