"""Trees in BehaviorTree.CPP's XML format, version 4: reading, checks, creation of nodes, and writing."""

from .document import Document, Survey, TreeElement, add_siblings, included_files, outer_trees, read_document, survey
from .element import Element, Source
from .load import Outside, load_xml, make_nodes
from .model import Model
from .stub import Stub, stub_nodes, times
from .verify import verify
from .write import palette, write_tree

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
    "included_files",
    "load_xml",
    "make_nodes",
    "outer_trees",
    "palette",
    "read_document",
    "stub_nodes",
    "survey",
    "times",
    "verify",
    "write_tree",
]
