"""Loading a tree from XML, without a mission: the door for libraries and tests."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from py_trees.behaviour import Behaviour

from ...errors import InputError
from ..nodes import BUILTIN, Node
from .build import Outside, make_nodes
from .document import read_document
from .verify import verify


def load_xml(
    source: Path | str,
    nodes: Mapping[str, type[Node]] = BUILTIN,
    *,
    main: str = "",
    within: Path | None = None,
    strict: bool = False,
    outside: Outside | None = None,
) -> Behaviour:
    """The main tree of a document in BehaviorTree.CPP's XML, version 4 (or 3, which is converted).

        root = load_xml(Path("patrol.xml"))
        tree = Tree(root, clock=clock)

    Args:
        source: A file, or the text of a document.
        nodes: The node classes that it may name.
        main: The ID of the tree; what `main_tree_to_execute` says, or the only one, by default.
        within: The folder that included files must lie in; the file's own by default.
        strict: Whether names that BehaviorTree.CPP 4.10 refuses are faults.
        outside: Trees that stand elsewhere.

    Returns:
        Its root, to be bound by a `Tree`.

    Raises:
        InputError: All that is wrong with it, each at its line and column.
    """
    document = read_document(source, within=within)
    faults = [*document.faults, *verify(document, nodes, main=main, outside=outside, strict=strict)]
    try:
        document.main(main)
    except InputError as error:
        faults += error.faults
    if wrong := [fault for fault in faults if not fault.warning]:
        raise InputError(*wrong)
    return make_nodes(document, nodes, main=main, outside=outside)
