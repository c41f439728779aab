"""Nodes of behaviour trees with the semantics of BehaviorTree.CPP, as subclasses of py_trees' behaviours.

Unlike in py_trees, a tick is a chain of direct calls instead of generators, because these are faster.
"""

from ..status import FAILURE, RUNNING, SKIPPED, SUCCESS, Outcome
from .changes import Changes
from .family import Control, Decorator, Instant, Leaf, halt
from .guard import CONDITIONS
from .node import Node
from .port import REQUIRED, Code, Direction, InOut, Input, KeyUse, Output, Port, pointed, pointer
from .registry import BUILTIN, Registry, children_faults, nodes_of
from .runtime import Runtime, Watch
from .subtree import SubTree
from .tree import Tree, descendants

__all__ = [
    "BUILTIN",
    "CONDITIONS",
    "FAILURE",
    "REQUIRED",
    "RUNNING",
    "SKIPPED",
    "SUCCESS",
    "Changes",
    "Code",
    "Control",
    "Decorator",
    "Direction",
    "InOut",
    "Input",
    "Instant",
    "KeyUse",
    "Leaf",
    "Node",
    "Outcome",
    "Output",
    "Port",
    "Registry",
    "Runtime",
    "SubTree",
    "Tree",
    "Watch",
    "children_faults",
    "descendants",
    "halt",
    "nodes_of",
    "pointed",
    "pointer",
]
