"""Trees that a document names and that stand in other files: one subtree per file, without `<include>`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from ...errors import InputError
from .document import Document, TreeElement, read_document
from .model import Model
from .version3 import below


def outer_trees(document: Document) -> set[str]:
    """The trees that a document names and does not hold."""
    named = {e.attributes.get("ID", "") for t in document.trees.values() for e in below(t.body) if e.tag == "SubTree"}
    return named - {"", *document.trees}


def survey(files: Iterable[Path]) -> tuple[dict[str, Path], dict[str, Model]]:
    """Files by the trees that they hold, and the models in them; of two with one name the first counts.

    Args:
        files: Files of trees. Files that cannot be read are left out: their own check reports them.
    """
    found: dict[str, Path] = {}
    models: dict[str, Model] = {}
    for file in files:
        try:
            document = read_document(file)
        except InputError:
            continue
        for name, tree in document.trees.items():
            if not tree.included:
                found.setdefault(name, file)
        models = {**document.models, **models}
    return found, models


def add_siblings(document: Document, beside: Mapping[str, Path]) -> None:
    """Add the trees of other files that a document, or an added tree, names and the document does not hold.

    Args:
        document: The document.
        beside: Files by the trees that they hold, as `survey` returns them.
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
