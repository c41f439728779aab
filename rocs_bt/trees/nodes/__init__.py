"""Nodes of behaviour trees with the semantics of BehaviorTree.CPP, as subclasses of py_trees' behaviours.

Unlike in py_trees, a tick is a chain of direct calls instead of generators, because these are faster.
"""

from ..status import FAILURE, RUNNING, SKIPPED, SUCCESS, Outcome
from .base_classes import Control, Decorator, Instant, Leaf, halt
from .changes import Changes
from .guard import CONDITIONS
from .node import Node
from .port import (
    ConditionText,
    Direction,
    InOut,
    KeyUse,
    Output,
    Port,
    ScriptText,
    Syntax,
    pointed,
    pointer,
    port_of,
)
from .registry import BUILTIN, Registry, children_faults, nodes_of
from .runtime import Runtime, Watch
from .subtree import SubTree
from .tree import Tree

ADVICE = {"Input": "A port that the node reads is a plain annotation, such as `person: str` or `times: int = 1`."}
"""Advice about names that this module does not have (see `rocs_bt.base.raised`)."""

__all__ = [
    "BUILTIN",
    "CONDITIONS",
    "FAILURE",
    "RUNNING",
    "SKIPPED",
    "SUCCESS",
    "Changes",
    "ConditionText",
    "Control",
    "Decorator",
    "Direction",
    "InOut",
    "Instant",
    "KeyUse",
    "Leaf",
    "Node",
    "Outcome",
    "Output",
    "Port",
    "Registry",
    "Runtime",
    "ScriptText",
    "SubTree",
    "Syntax",
    "Tree",
    "Watch",
    "children_faults",
    "halt",
    "nodes_of",
    "pointed",
    "pointer",
    "port_of",
]
