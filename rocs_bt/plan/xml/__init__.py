"""Trees in BehaviorTree.CPP's XML, version 4: read, checked, made, and written again."""

from .build import Outside, make_nodes
from .document import Document, TreeElement, read_document
from .element import Element, Source
from .load import load_tree
from .mission import mission_nodes, mission_tree, shipped_nodes, tags_of, values_of, xml_mission
from .model import Model
from .palette import palette
from .siblings import Survey, add_siblings, outer_trees, survey
from .stand_in import Stub, stub_nodes, times
from .verify import verify
from .write import write_tree

__all__ = [
    "Document",
    "Element",
    "Model",
    "Outside",
    "Source",
    "Stub",
    "Survey",
    "TreeElement",
    "add_siblings",
    "load_tree",
    "make_nodes",
    "mission_nodes",
    "mission_tree",
    "outer_trees",
    "palette",
    "read_document",
    "shipped_nodes",
    "stub_nodes",
    "survey",
    "tags_of",
    "times",
    "values_of",
    "verify",
    "write_tree",
    "xml_mission",
]
