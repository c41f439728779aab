"""Keys that a mission must give to its main tree, such as the goal of a Nav2 mission."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from ..base.errors import InputError
from ..base.nesting import descendants
from ..trees.nodes import CONDITIONS, Direction, Node, pointed
from ..trees.script import parse_script
from ..trees.xml.document import Document
from ..trees.xml.element import Element

Use = tuple[str, bool]
"""Use of a key: the key, and whether it is written there before any read."""
_Resolve = Callable[[str], str | None]


def main_keys(document: Document, main: str, nodes: Mapping[str, type[Node]]) -> dict[str, bool]:
    """Keys of the main tree's blackboard that its nodes use, and whether each is read before any node writes it.

    "Before" is the order of the document. Attributes of nodes without a class in `nodes` count as inputs.
    """
    found: dict[str, bool] = {}
    name = document.main(main).name
    for key, written in _uses(document, name, nodes, lambda key: key.removeprefix("@"), (name,)):
        found.setdefault(key, not written)
    return found


def _uses(
    document: Document, tree: str, nodes: Mapping[str, type[Node]], resolve: _Resolve, open_trees: tuple[str, ...]
) -> Iterator[Use]:
    """Uses of keys of the main blackboard, in a tree and its subtrees.

    Args:
        document: Document with the tree.
        tree: ID of the tree.
        nodes: Node classes, by name.
        resolve: Function from a key of the tree to the key of the main blackboard, or None if it is another one's.
        open_trees: IDs of the tree and its ancestors; a tree that contains itself is not followed.
    """
    for element in descendants(document.trees[tree].body):
        inner = element.attributes.get("ID", "")
        if element.tag != "SubTree":
            found = _node_uses(element, nodes.get(element.node_tag))
            yield from ((key, written) for own, written in found if (key := resolve(own)) is not None)
        elif inner in document.trees and inner not in open_trees:
            yield from _uses(document, inner, nodes, _within(document, element, resolve), (*open_trees, inner))


def _within(document: Document, element: Element, resolve: _Resolve) -> _Resolve:
    """Function from a key inside a SubTree to the key of the main blackboard, or None."""
    given = {**document.trees[element.attributes["ID"]].defaults, **element.attributes}
    remapped = given.get("_autoremap", "").lower() in ("true", "1")

    def inner(key: str) -> str | None:
        if key.startswith("@"):
            return key[1:]
        if key in given:
            outer = pointed(given[key], key)
            return None if outer is None else resolve(outer)
        return resolve(key) if remapped and not key.startswith("_") else None

    return inner


def _node_uses(element: Element, node: type[Node] | None) -> Iterator[Use]:
    """Uses of keys of its own blackboard by a node: first its inputs, then its scripts, then its outputs."""
    ports = {} if node is None else node.ports
    given = {n: p.default for n, p in ports.items() if isinstance(p.default, str)} | element.attributes
    written = []
    for name, value in given.items():
        port, key = ports.get(name), pointed(value, name)
        if name in CONDITIONS or (port is not None and port.is_code and key is None):
            written += _assigned(value)
        elif node is not None and node.tag == "SetBlackboard" and name == "output_key":
            written.append(key or value)
        elif key is not None and port is not None and port.direction is Direction.OUTPUT:
            written.append(key)
        elif key is not None:
            yield key, False
    yield from ((key, True) for key in written)


def _assigned(code: str) -> list[str]:
    try:
        return [assignment.target.name for assignment in parse_script(code).writes()]
    except InputError:
        return []  # reported where the script is checked
