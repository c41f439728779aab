"""Document: the trees and models in an XML file and its included files, before any node is created."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ...base.errors import Fault, InputError, did_you_mean, unknown
from ...base.files import confined, is_file, read_text
from ...base.nesting import descendants
from .element import Element, Source
from .model import Model, read_models
from .scan import MAX_TEXT, scan
from .version_3 import convert, is_version_3

_INCLUDES = ("include", "import")
"""Tags, in lower case, of elements that include a file: BehaviorTree.CPP's, and py_trees' with `file` or `src`."""

MAX_FILES = 100
"""Maximum number of files that a document may include."""


@dataclass(frozen=True)
class TreeElement:
    """Tree that a document defines.

    Attributes:
        name: ID of the tree.
        element: The `<BehaviorTree>` element.
        body: Element of the tree's root node.
        included: Whether the tree is in an included file.
        defaults: Values of the tree's keys for a SubTree that omits them: attributes of `<BehaviorTree>`, as in
            py_trees.
    """

    name: str
    element: Element
    body: Element
    included: bool

    @property
    def defaults(self) -> dict[str, str]:
        return {n: v for n, v in self.element.attributes.items() if n not in ("ID", "name") and n[0] != "_"}


@dataclass
class Document:
    """Content of an XML document and its included files.

    Attributes:
        root: Root element of the file that was read first, which includes the others.
        named: Value of the attribute `main_tree_to_execute`; empty if missing.
        trees: Trees by ID, in the order of reading; those of included files are first.
        models: Declarations of nodes and subtrees in a TreeNodesModel, by ID.
        faults: Errors and warnings found while reading.
        files: Paths of all files, in the order of reading; the including file is first.
        library: Whether several trees may be entry points, so that no warning is given about unused trees.
        version_3: Root elements of the files of version 3; the outputs of their nodes are converted by `verify`.
    """

    root: Element
    named: str = ""
    trees: dict[str, TreeElement] = field(default_factory=dict)
    models: dict[str, Model] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)
    library: bool = False
    version_3: list[Element] = field(default_factory=list)

    def elements(self) -> Iterator[Element]:
        """Elements of all nodes, tree by tree."""
        for tree in self.trees.values():
            yield from descendants(tree.body)

    def own_trees(self) -> list[TreeElement]:
        """Trees of the file that was read first; all trees if it only includes others, as a project of Groot2 does."""
        return [tree for tree in self.trees.values() if not tree.included] or [*self.trees.values()]

    def entries(self) -> list[str]:
        """IDs of the trees that can be ticked: the main tree, or, if none is named, those that no other tree uses."""
        own = self.own_trees()
        return [self.main().name] if self.named or len(own) < 2 else [tree.name for tree in self._outermost(own)]

    def _outermost(self, trees: list[TreeElement]) -> list[TreeElement]:
        """Trees that no other tree uses; all trees if each is used."""
        used = {e.attributes.get("ID") for e in self.elements() if e.tag == "SubTree"}
        return [tree for tree in trees if tree.name not in used] or trees

    def main(self, wanted: str = "") -> TreeElement:
        """Tree to tick: the tree `wanted` if given, else the main tree that the document names, else its only tree.

        Raises:
            InputError: There is no such tree, or the document has several trees and names no main tree.
        """
        name = wanted or self.named
        if name:
            if name not in self.trees:
                fault = unknown("tree", name, self.trees, "The document")
                attribute = "" if wanted else "main_tree_to_execute"
                raise InputError(self.root.fault(fault.message, fault.hint, attribute=attribute))
            return self.trees[name]
        own = self.own_trees()
        if all(tree.included for tree in own):
            own = self._outermost(own)
        if len(own) != 1:
            hint = did_you_mean("", self.trees, "It") + ' Write <root main_tree_to_execute="...">, or use --tree ID.'
            raise InputError(self.root.fault("the document has several trees and names no main tree.", hint))
        return own[0]


def read_document(source: Path | str, *, within: Path | None = None) -> Document:
    """Read the trees and models of a document.

    Args:
        source: Path of a file, or text of a document.
        within: Folder in which included files must lie; by default the folder of the file. A text can include files
            only if it is given.

    Raises:
        InputError: The source cannot be read as a document. Faults within the document are in `Document.faults`.
    """
    if isinstance(source, str):
        return _Reader(within.resolve() if within else None).document(Source(source))
    file = source.resolve()
    return _Reader((within or file.parent).resolve()).document(Source(read_text(file), source))


class _Reader:
    def __init__(self, within: Path | None) -> None:
        self.within = within
        self.open: list[Path] = []
        self.done: set[Path] = set()
        self.room = MAX_TEXT

    def document(self, source: Source) -> Document:
        root, warnings = self._root(source)
        self.found = Document(root, named=root.attributes.get("main_tree_to_execute", "").strip())
        self._take(source, root, warnings, included=False)
        return self.found

    def _root(self, source: Source) -> tuple[Element, list[Fault]]:
        root, warnings = scan(source)
        if root.tag != "root":
            raise InputError(
                root.fault(f"the document begins with <{root.tag}> instead of <root>.", "Put it into <root>.")
            )
        return root, warnings

    def _take(self, source: Source, root: Element, warnings: list[Fault], included: bool) -> None:
        self.room -= len(source.text)
        if source.file is not None:
            self.found.files.append(source.file)
        self.found.faults += warnings
        self._version(root)
        self._children(root, included)
        if self._is_project():
            self.found.named = self.found.named or root.attributes.get("main_tree_to_execute", "").strip()

    def _is_project(self) -> bool:
        """Whether the file that was read first is a project of Groot2, which only includes the files with trees."""
        return all(child.tag != "BehaviorTree" for child in self.found.root.children)

    def _version(self, root: Element) -> None:
        faults, version = self.found.faults, root.attributes.get("BTCPP_format", "")
        if is_version_3(root):
            faults += convert(root)
            self.found.version_3.append(root)
        elif not version:
            message = "BTCPP_format is missing: the document is read as version 4."
            faults.append(root.fault(message, 'Write <root BTCPP_format="4">.', warning=True))
        elif version != "4":
            hint = "Supported versions: 4 and 3."
            faults.append(root.fault(f"the version {version!r} is unknown.", hint, attribute="BTCPP_format"))

    def _children(self, root: Element, included: bool) -> None:
        models = 0
        for child in root.children:
            if child.tag.lower() in _INCLUDES:
                self._include(child)
        for child in root.children:
            if child.tag == "BehaviorTree":
                self._tree(child, root, included)
            elif child.tag in ("TreeNodesModel", "TreeNodeModel"):
                models += 1
                if models > 1:
                    self.found.faults.append(child.fault("there is a second TreeNodesModel.", "Put them into one."))
                self.found.models.update({m.name: m for m in read_models(child, self.found.faults)})
            elif child.tag.lower() not in _INCLUDES:
                hint = did_you_mean(child.tag, ("BehaviorTree", "TreeNodesModel", "include"), "A document")
                message = f"<{child.tag}> is not expected here and is ignored."
                self.found.faults.append(child.fault(message, hint, warning=True))

    def _tree(self, element: Element, root: Element, included: bool) -> None:
        name = element.attributes.get("ID", "")
        faults, trees = self.found.faults, self.found.trees
        if not name:
            if len(root.children) > 1:
                faults.append(element.fault("the tree has no ID.", 'Write <BehaviorTree ID="Name">.'))
            name = f"BehaviorTree_{len(trees) + 1}"
        if len(element.children) != 1:
            message = f"the tree '{name}' has {len(element.children)} root nodes."
            faults.append(element.fault(message, "Put them into one, such as a Sequence."))
            if not element.children:
                return
        if name in trees:
            other = trees.pop(name).element
            where = f"{other.source.file or 'the text'}:{other.source.position(other.at)[0]}"
            message = f"there is another tree '{name}' ({where}), which this one replaces."
            faults.append(element.fault(message, "Rename one of them.", attribute="ID", warning=True))
        trees[name] = TreeElement(name, element, element.children[0], included)

    def _include(self, element: Element) -> None:
        try:
            file, source = self._included(element)
        except InputError as error:
            self.found.faults += (
                element.fault(f.message, f.hint, attribute="path") if f.file is None else f for f in error.faults
            )
            return
        if file in self.done:
            return
        self.done.add(file)
        self.open.append(file)
        try:
            self._take(source, *self._root(source), included=True)
        except InputError as error:
            self.found.faults += error.faults
        self.open.pop()

    def _included(self, element: Element) -> tuple[Path, Source]:
        given, own = element.attributes, element.source.file
        path = given.get("path") or given.get("file") or given.get("src") or ""
        if "ros_pkg" in element.attributes:
            raise InputError(Fault("'ros_pkg' needs ROS.", hint="Write the path of the file, relative to this one."))
        if not path:
            raise InputError(Fault("the include has no path.", hint='Write <include path="other.xml"/>.'))
        if self.within is None:
            raise InputError(Fault("a document that is not in a file cannot include files."))
        file = confined(path, own.resolve().parent if own else self.within, (self.within,))
        if file in self.open or (self.found.files and file == self.found.files[0].resolve()):
            chain = " -> ".join(p.name for p in (*self.open, file))
            raise InputError(Fault(f"'{path}' includes itself: {chain}.", hint="Remove one include."))
        if len(self.done) >= MAX_FILES:
            raise InputError(Fault(f"the document includes more than {MAX_FILES} files."))
        if not is_file(file):
            beside = sorted(p.name for p in file.parent.glob("*.xml")) if os.path.isdir(file.parent) else []
            raise InputError(unknown("file", path, beside))
        text = read_text(file)
        if len(text) > self.room:
            raise InputError(Fault(f"with '{path}' the document has more than {MAX_TEXT} characters."))
        return file, Source(text, file)


def included_files(file: Path) -> set[Path]:
    """Resolved paths of the files that a document includes, such as a project of Groot2; empty if it is unreadable."""
    try:
        return {path.resolve() for path in read_document(file).files[1:]}
    except InputError:
        return set()  # reported where the file itself is checked


def outer_trees(document: Document) -> set[str]:
    """IDs of trees to which SubTree elements of a document refer, but which the document does not contain."""
    named = {element.attributes.get("ID", "") for element in document.elements() if element.tag == "SubTree"}
    return named - {"", *document.trees}


@dataclass
class Survey:
    """Trees and models that several files define, and the elements that use them.

    If two trees or two models have the same ID, the first one counts.

    Attributes:
        trees: File that contains each tree, by the tree's ID.
        models: Declarations of nodes and subtrees, by ID.
        nodes: Elements that use each node class, by the name of the class.
        subtrees: SubTree elements that use each tree, by the tree's ID.
    """

    trees: dict[str, Path] = field(default_factory=dict)
    models: dict[str, Model] = field(default_factory=dict)
    nodes: dict[str, list[Element]] = field(default_factory=dict)
    subtrees: dict[str, list[Element]] = field(default_factory=dict)


def survey(files: Iterable[Path]) -> Survey:
    """Collect the trees and models that several files define, and the elements that use them.

    Args:
        files: Paths of the files. Unreadable files are skipped, because their own check reports them.
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
            for element in descendants(tree.body):
                uses = found.subtrees if element.tag == "SubTree" else found.nodes
                named = element.attributes.get("ID", "") if element.tag == "SubTree" else element.node_tag
                uses.setdefault(named, []).append(element)
    return found


def add_siblings(document: Document, beside: Mapping[str, Path]) -> list[Path]:
    """Add the trees of other files to which the document, or a tree added before, refers.

    A tree refers to the trees of its own file. If the document has a tree of the same name, that one counts, with a
    warning.

    Args:
        document: Document, extended in place.
        beside: File that may contain each tree, by the tree's ID, as in `Survey.trees`.

    Returns:
        Files of the added trees.

    Raises:
        InputError: A file cannot be read.
    """
    read: dict[Path, Document] = {}
    missing: set[str] = set()
    while names := sorted((outer_trees(document) & beside.keys()) - missing):
        for name in names:
            file = beside[name]
            other = read[file] if file in read else read.setdefault(file, read_document(file))
            if name not in other.trees:
                missing.add(name)
                continue
            _add(document, other, name)
            for model in other.models.values():
                document.models.setdefault(model.name, model)
    return [*read]


def _add(document: Document, other: Document, name: str) -> None:
    """Add a tree of another document, and the trees of that document to which it refers."""
    todo = [name]
    while todo:
        name = todo.pop()
        if name in document.trees:
            continue
        tree = other.trees[name]
        document.trees[name] = TreeElement(name, tree.element, tree.body, included=True)
        for element in descendants(tree.body):
            inner = element.attributes.get("ID", "") if element.tag == "SubTree" else ""
            if inner not in other.trees:
                continue
            present = document.trees.get(inner)
            if present is not None and present.element is not other.trees[inner].element:
                message = f"this tree replaces the tree '{inner}' of {other.files[0].name}, which '{name}' uses."
                document.faults.append(
                    present.element.fault(message, "Rename one of them.", attribute="ID", warning=True)
                )
            todo.append(inner)
