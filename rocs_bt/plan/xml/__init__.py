"""Trees in BehaviorTree.CPP's XML, version 4: read, checked, made, and written again."""

from .build import Outside, make_nodes
from .document import Document, TreeElement, read_document
from .element import Element, Source
from .load import load_tree
from .mission import mission_nodes, mission_tree, outer_trees, tags_of, values_of, xml_mission
from .palette import palette
from .verify import verify
from .write import write_tree

__all__ = [
    "Document",
    "Element",
    "Outside",
    "Source",
    "TreeElement",
    "load_tree",
    "make_nodes",
    "mission_nodes",
    "mission_tree",
    "outer_trees",
    "palette",
    "read_document",
    "tags_of",
    "values_of",
    "verify",
    "write_tree",
    "xml_mission",
]
