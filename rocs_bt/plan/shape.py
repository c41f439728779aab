"""What a mission must give back, whoever asks: a check, or a run."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.composites import Composite

from ..errors import Fault
from ..trees.nodes import descendants


def shape_faults(root: object) -> list[Fault]:
    """Why what `build` returned cannot be ticked; empty when it can."""
    if not isinstance(root, Behaviour):
        hint = "Return the root of a py_trees tree, or a Plan."
        return [Fault(f"build returned {root!r}, which is no py_trees behaviour.", hint=hint)]
    return [
        Fault(f"'{node.name}' has no children.", hint="Give it some, or leave it out.")
        for node in descendants(root)
        if isinstance(node, Composite) and not node.children
    ]
