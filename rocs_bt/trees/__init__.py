"""Behaviour-tree engine: nodes, blackboards, scripts, XML, drawing, checks and the log for Groot2.

The package has no dependency on robots, missions or agents; `plan` connects its trees to an agent. Any module that
needs trees may import it: `plan`, `record`, `check`, the command line, and programs without a robot.

    from rocs_bt.trees import Tree, load_xml

    tree = Tree(load_xml(Path("door.xml")))
    tree.settle()
"""

from py_trees.behaviour import Behaviour

from .board import Board
from .btlog import BtLog
from .error import TreeError, TreeWarning
from .examine import examine
from .nodes import (
    BUILTIN,
    FAILURE,
    RUNNING,
    SKIPPED,
    SUCCESS,
    ConditionText,
    Control,
    Decorator,
    InOut,
    Instant,
    Leaf,
    Node,
    Outcome,
    Output,
    Registry,
    ScriptText,
    SubTree,
    Tree,
)
from .xml import load_xml, palette, write_tree

__all__ = [
    "BUILTIN",
    "FAILURE",
    "RUNNING",
    "SKIPPED",
    "SUCCESS",
    "Behaviour",
    "Board",
    "BtLog",
    "ConditionText",
    "Control",
    "Decorator",
    "InOut",
    "Instant",
    "Leaf",
    "Node",
    "Outcome",
    "Output",
    "Registry",
    "ScriptText",
    "SubTree",
    "Tree",
    "TreeError",
    "TreeWarning",
    "examine",
    "load_xml",
    "palette",
    "write_tree",
]
