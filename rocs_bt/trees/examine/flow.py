"""Data flow of a tree: the nodes that write and read each key of each blackboard."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from ...base.errors import Fault, InputError, did_you_mean
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
"""Ports that contain scripts, by node class."""

NAMING: Mapping[str, tuple[str, ...]] = {
    "SetBlackboard": ("output_key",),
    "WasEntryUpdated": ("entry",),
    "SkipUnlessUpdated": ("entry",),
    "WaitValueUpdate": ("entry",),
}
"""Ports that contain the name of a key, with or without braces, by node class."""


MAX_SUGGESTED = 100
"""Maximum number of keys of a blackboard for which faults suggest the nearest name, because that search is slow."""


@dataclass(frozen=True)
class Use:
    """Use of a blackboard key by a node.

    Attributes:
        node: Node that uses the key.
        attribute: Name of the port or condition that contains the key.
        key: The key as written in the node.
        reads: Whether the node reads the key and fails if it has no value.
        creates: Whether the node creates the key if it does not exist.
        changes: Whether the node writes the key.
        column: Position of the key in a script, counted from 0; None if the key is the value of a port.
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
    """Data flow of a tree: all uses of all blackboard keys.

    Attributes:
        uses: Uses of each key; the dictionary key is the blackboard that holds the key, and its name on it.
    """

    uses: Mapping[tuple[Board, str], list[Use]]

    def of(self, board: Board, key: str) -> list[Use]:
        """Uses of a key by all nodes.

        Args:
            board: Blackboard of one node.
            key: Name of the key for this node, which is resolved to the blackboard that holds it.
        """
        return self.uses.get(board.resolve(key), [])


def scripts_of(node: Node) -> Iterator[tuple[str, Script]]:
    """Attributes and scripts of a node, except scripts that it reads from the blackboard at run time."""
    yield from node.conditions.items()
    for port in SCRIPTS.get(node.tag, ()):
        text = node.given.get(port, "")
        if isinstance(text, str) and text and node.key(port) is None:
            try:
                yield port, parse_script(text)
            except InputError:  # reported when the node is made
                continue


def flow_of(tree: Tree) -> Flow:
    """Collect the uses of all blackboard keys of a tree.

    Args:
        tree: Tree to analyse.
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


def _port_uses(node: Node, port: Port) -> Iterator[Use]:
    given = node.given.get(port.name, port.default)
    key = pointed(given, port.name)
    if key is None and port.name in NAMING.get(node.tag, ()) and isinstance(given, str):
        key = given
    if key is None:
        for use in port.keys_in(given) if isinstance(given, str) else ():
            yield Use(node, port.name, use.key, not use.writes, use.writes, use.writes, use.column)
        return
    if port.direction is Direction.INPUT:
        yield Use(node, port.name, key, reads=port.default is not None)
    else:
        yield Use(node, port.name, key, creates=True, changes=True)


def flow_faults(tree: Tree, flow: Flow) -> Iterator[Fault]:
    """Warnings about keys that are read, or assigned by `=`, but that no node creates."""
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
                names = {*known.get(board, []), *board.remapping, *board.keys()}
                yield _unwritten(use, name, names)
            elif use.changes and entry is None:
                hint = f"Write {use.key} := ... to create it."
                message = f"'=' needs an existing key, but no node creates '{use.key}'."
                yield fault_at(use.node, message, hint, attribute=use.attribute, column=use.column)


def _unwritten(use: Use, name: str, known: Collection[str]) -> Fault:
    hint = did_you_mean(name, sorted(known), "Its blackboard") if len(known) <= MAX_SUGGESTED else ""
    also = "" if use.key == name else f" ('{name}' there)"
    message = f"the key '{use.key}'{also} is read, but no node writes it."
    return fault_at(use.node, message, hint, attribute=use.attribute, column=use.column)
