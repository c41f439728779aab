"""Replacement of a subtree of a running mission by a tree of an XML mission."""

from __future__ import annotations

from pathlib import Path

from py_trees.behaviour import Behaviour

from ..base.errors import Fault, InputError, did_you_mean
from ..base.nesting import descendants
from ..trees.examine import flow_of
from ..trees.nodes import Node, SubTree, Tree
from ..trees.nodes.swap import swapped_part
from ..trees.xml.model import ModelPort
from .context import MissionContext
from .xml_mission import content_tree, defaults_of, document_of, input_ports, port_value


def replacement(mission: MissionContext, source: Path | str, main: str = "") -> Node:
    """Create a tree of an XML mission that can replace a subtree of a running one, with the blackboard of its place.

    Returns the root; the defaults of the tree's ports are its `initial_keys`.

    Raises:
        InputError: The document has errors.
    """
    document = document_of(mission, source)
    name = document.main(main).name
    root = content_tree(document, mission, (), name)
    root.initial_keys = {**root.initial_keys, **defaults_of(document, name)}
    return root


def place_faults(
    tree: Tree, old: Behaviour, mission: MissionContext, source: Path | str, main: str = ""
) -> list[Fault]:
    """Faults of a replacement at its place: values that a port's type excludes, and ports without a value.

    A port has a value if the blackboard of the place has one, if a remaining node writes it, or by its default.
    """
    document, part = document_of(mission, source), swapped_part(old)
    name, board, leaving = document.main(main).name, tree.boards[part], set(descendants(part))
    uses = flow_of(tree).uses.items()
    created = {key for key, each in uses if any(use.creates and use.node not in leaving for use in each)}
    given = sorted({*board.remapping, *board.keys(), *(key for on, key in created if on is board)})
    place = f"the SubTree '{old.name}'" if isinstance(old, SubTree) else f"the place of '{old.name}'"
    found = []
    for port, needed in input_ports(document, name).items():
        entry = board.entry(port.name)
        if entry is not None and isinstance(entry.value, str):
            found += _misfit(port, entry.value)
        elif needed and not (port.name in given or port.name in board or board.resolve(port.name) in created):
            hint = f"{did_you_mean(port.name, given, 'It') if given else 'It gives nothing.'} Or declare a default."
            message = f"the tree '{name}' needs '{port.name}', which {place} does not give."
            found.append(port.element.fault(message, hint, attribute="name"))
    return found


def _misfit(port: ModelPort, text: str) -> list[Fault]:
    """Faults of a text that a port cannot have."""
    try:
        port_value(port, text)
    except InputError as error:
        return [
            port.element.fault(f"the port '{port.name}': {f.message}", f.hint, attribute="type") for f in error.faults
        ]
    return []
