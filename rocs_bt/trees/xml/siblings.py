"""Trees that a document names and that stand in other files: one subtree per file, without `<include>`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ...errors import InputError
from .document import Document, TreeElement, read_document
from .element import Element
from .model import Model
from .version3 import below


def outer_trees(document: Document) -> set[str]:
    """The trees that a document names and does not hold."""
    named = {e.attributes.get("ID", "") for t in document.trees.values() for e in below(t.body) if e.tag == "SubTree"}
    return named - {"", *document.trees}


@dataclass
class Survey:
    """What several files of trees hold; of two trees or models with one name the first counts.

    Attributes:
        trees: Files by the trees in them.
        models: Models by ID.
        nodes: Elements by the node that they name.
        subtrees: Elements by the tree that they name.
    """

    trees: dict[str, Path] = field(default_factory=dict)
    models: dict[str, Model] = field(default_factory=dict)
    nodes: dict[str, list[Element]] = field(default_factory=dict)
    subtrees: dict[str, list[Element]] = field(default_factory=dict)


def survey(files: Iterable[Path]) -> Survey:
    """What several files of trees hold.

    Args:
        files: The files. Those that cannot be read are left out: their own check reports them.
    """
    found = Survey()
    for file in files:
        try:
            document = read_document(file)
        except InputError:
            continue
        found.models = {**document.models, **found.models}
        for name, tree in document.trees.items():
            if tree.included:
                continue
            found.trees.setdefault(name, file)
            for element in below(tree.body):
                uses = found.subtrees if element.tag == "SubTree" else found.nodes
                named = element.attributes.get("ID", "") if element.tag == "SubTree" else element.node_tag
                uses.setdefault(named, []).append(element)
    return found


def add_siblings(document: Document, beside: Mapping[str, Path]) -> None:
    """Add the trees of other files that a document, or an added tree, names and the document does not hold.

    Args:
        document: The document.
        beside: Files by the trees that they hold, as `Survey.trees` has them.
    """
    read: dict[Path, Document] = {}
    while names := sorted(outer_trees(document) & beside.keys()):
        for name in names:
            file = beside[name]
            other = read[file] if file in read else read.setdefault(file, read_document(file))
            tree = other.trees[name]
            document.trees[name] = TreeElement(name, tree.element, tree.body, included=True)
            for model in other.models.values():
                document.models.setdefault(model.name, model)
