"""Missions in XML files, with the interface of the `build` function of a Python mission."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from py_trees.behaviour import Behaviour

from ..base.errors import Fault, InputError, unknown
from ..base.units import NONE
from ..declare import MISSING, Field
from ..interfaces.vocabulary import vocabulary_of
from ..trees.nodes import Direction, Node, Port, Registry, SubTree, pointer, port_of
from ..trees.nodes.subtree import literal
from ..trees.value import from_string
from ..trees.xml.document import Document, add_siblings, outer_trees, read_document
from ..trees.xml.element import Element
from ..trees.xml.load import make_nodes
from ..trees.xml.model import ModelPort, annotation
from ..trees.xml.verify import verify
from .action_node import action_nodes
from .context import MissionContext
from .dialects import Defined, dialect_in, elsewhere, recognised, shipped_nodes, tags_of
from .goal_keys import main_keys
from .parameters import mission_arguments, mission_parameters

Build = Callable[..., Any]


def values_of(document: Document) -> set[str]:
    """All attribute values of nodes in a document's trees."""
    return {value for element in document.elements() for value in element.attributes.values()}


def xml_mission(
    file: Path | str,
    *,
    main: str = "",
    within: Path | None = None,
    nodes: Callable[[set[str]], Sequence[type[Node]]] = lambda tags: (),
    defined: Defined | None = None,
    missions: Callable[[str], Build | None] = lambda name: None,
    beside: Mapping[str, Path] = MappingProxyType({}),
    dialect: str = "",
    stubs: Sequence[type[Node]] = (),
    inputs: Collection[str] = (),
) -> Callable[..., Behaviour]:
    """Create the `build` function of a mission in an XML file.

    The parameters of `build` are the input ports that the TreeNodesModel declares for the main tree, in
    `<SubTree ID="Main">`. The type of a port is a C++ type, or a unit such as `m/s`; a default such as `0.5 m/s` also
    defines the unit. Parameters are written to the blackboard as keys, numbers in SI units. Each action of the robot is
    available as a node, with the action's parameters as ports.

    Args:
        file: Path of the file, or text of the document.
        main: ID of the tree to tick; by default the document's main tree.
        within: Folder in which included files must lie; by default the folder of the file.
        nodes: Function from names of node classes to those of these classes that the project defines.
        defined: Function from names of node classes to those that the project defines; by default it asks `nodes`.
        missions: Function from the ID in a SubTree to the `build` function of the mission with this name, or None.
        beside: Other files with trees that a SubTree may use, by the IDs of these trees.
        dialect: `nav2` for nodes with Nav2's semantics, `nav2_servers` for nodes that call a running Nav2, each
            possibly with a distribution, as in `nav2:jazzy`; `rocs` for rocs_bt's own; empty to recognise it.
        stubs: Node classes that replace those of the same name, for a check.
        inputs: Further keys of the blackboard that are required parameters, for a check.

    Raises:
        InputError: The file cannot be read, or has several trees and names no main tree.
    """
    document = read_document(file, within=within)
    add_siblings(document, beside)
    document.library = len(document.entries()) > 1 if main else False
    path = file if isinstance(file, Path) else None
    defined = defined or (lambda tags: {node.tag for node in nodes(tags)})
    declared, dialect = dialect, dialect_in(document, dialect, defined)
    own, notes = list(nodes(tags_of(document) - set(shipped_nodes(dialect)))), recognised(path, declared, dialect)

    def make(mission: MissionContext) -> Behaviour:
        mission.report(*notes)
        if words is not None:
            mission.dialect = dialect  # also of the trees that replace a part of this one
            words.begin(mission.board, used)
        return mission_tree(document, mission, own, missions, main, dialect, stubs)

    words, _ = vocabulary_of(dialect)
    used = {} if words is None else main_keys(document, main, shipped_nodes(dialect))
    known = () if words is None else words.inputs
    keys: dict[str, bool] = {key: used[key] for key in known if key in used} | dict.fromkeys(inputs, True)
    return _Build(path, document, main, make, keys, notes)


class _Build:
    """XML document with the interface of a `build` function: it is called with a Mission and the parameters.

    Args:
        file: Path of the document; None for a text.
        document: The document.
        main: ID of the main tree; empty for the document's main tree.
        make: Function that creates the tree.
        keys: Keys that are parameters, and whether each is required.
        notes: Notes about the document for the user.
    """

    def __init__(
        self,
        file: Path | None,
        document: Document,
        main: str,
        make: Callable[[MissionContext], Behaviour],
        keys: Mapping[str, bool] = MappingProxyType({}),
        notes: Sequence[Fault] = (),
    ) -> None:
        main = document.main(main).name
        declared = _parameters(document, main)
        required = {k: Field.annotated(k, str, MISSING, _Build) for k, r in keys.items() if r and k not in declared}
        self._optional = {k for k, r in keys.items() if not r and k not in declared}
        optional = {k: Field.annotated(k, str, "", _Build) for k in sorted(self._optional)}
        self.parameters = {**required, **declared, **optional}
        self.__name__ = "build"
        self.__doc__ = f"The tree '{main}' of {'a document' if file is None else file.name}."
        self.file, self.notes = file, notes
        self._make = make

    def __call__(self, mission: MissionContext, **values: Any) -> Behaviour:
        if missing := [name for name, each in self.parameters.items() if each.required and name not in values]:
            raise TypeError(f"build needs {', '.join(missing)}")
        for name, each in self.parameters.items():
            value = values.pop(name, each.default)
            if value or name not in self._optional:  # otherwise a node of the mission writes the key
                mission.board.set_local(name, value)
        if values:
            raise TypeError(f"build takes no {', '.join(values)}")
        return self._make(mission)


def mission_tree(
    document: Document,
    mission: MissionContext,
    nodes: Sequence[type[Node]] = (),
    missions: Callable[[str], Build | None] = lambda name: None,
    main: str = "",
    dialect: str = "",
    stubs: Sequence[type[Node]] = (),
) -> Node:
    """Create the main tree of a document for a mission; arguments as in `xml_mission`.

    Raises:
        InputError: The tree has errors; the exception lists all of them.
    """
    dialect = dialect_in(document, dialect, lambda names: {node.tag for node in nodes} & names)
    registry = mission_nodes(mission.actions, nodes, dialect).replaced(stubs)
    outside = {name: _outside(mission, build) for name in outer_trees(document) if (build := missions(name))}
    faults = [*document.faults, *verify(document, registry, main=main, outside=outside, elsewhere=elsewhere())]
    wrong = [fault for fault in faults if not fault.warning]
    if wrong and not mission.check_options:
        raise InputError(*wrong)
    mission.report(*faults)
    # A check continues with the valid parts, so that it reports all faults at once.
    return make_nodes(document, registry, main=main, outside=outside, lenient=bool(wrong))


def mission_nodes(actions: Mapping[str, Any], nodes: Sequence[type[Node]] = (), dialect: str = "") -> Registry:
    """All node classes that a mission file may use: built-in nodes, the robot's actions, and the project's own nodes.

    Args:
        actions: Actions of the robot, keyed by name.
        nodes: Node classes of the project.
        dialect: `nav2` for nodes with Nav2's semantics, `nav2_servers` for nodes that call a running Nav2, each
            possibly with a distribution, as in `nav2:jazzy`; else rocs_bt's own.
    """
    shipped = shipped_nodes(dialect)
    return shipped.with_([*(node for node in action_nodes(actions) if node.tag not in shipped), *nodes])


def embedded(
    mission: MissionContext, source: Path | str, nodes: Sequence[type[Node]], main: str, values: Any
) -> SubTree:
    """Load an XML tree as a subtree of a Python mission.

    `source` is the path of a file, the text of a document, or the name of a mission in XML.

    Raises:
        InputError: The tree has errors; the exception lists all of them.
    """
    document = document_of(mission, source)
    name = document.main(main).name
    if ports := [port.name for port in input_ports(document, name)]:  # else any key may be given, as in a file
        known = {*ports, *main_keys(document, name, shipped_nodes(mission.dialect))}
        if wrong := [key for key in values if key not in known and key[0] != "_"]:
            raise InputError(*(unknown(f"port of the tree '{name}'", key, ports) for key in wrong))
    given = {**defaults_of(document, name), **values}
    return SubTree(name, content_tree(document, mission, nodes, main), ID=name, **given)


def document_of(mission: MissionContext, source: Path | str) -> Document:
    """Read a document that a mission uses: a file, a text, or the mission in XML of this name.

    Raises:
        InputError: The document cannot be read, or no mission in XML has this name.
    """
    files = mission.content.tree_files()
    if isinstance(source, str) and "<" not in source:
        if source not in files:
            raise InputError(unknown("mission in XML", source, files))
        source = files[source]
    document = read_document(source, within=mission.content.root_of(source) if isinstance(source, Path) else None)
    add_siblings(document, files)
    return document


def content_tree(document: Document, mission: MissionContext, nodes: Sequence[type[Node]], main: str) -> Node:
    """Create a tree of a document with the nodes, missions and dialect of the mission that uses it."""
    own = {node.tag for node in nodes}
    dialect = dialect_in(document, mission.dialect, lambda names: {*own, *mission.content.defined_nodes(names)})
    known = {*shipped_nodes(dialect), *own}
    content = mission.content.load_nodes(tags_of(document) - known)
    return mission_tree(document, mission, [*content, *nodes], mission.content.python_tree, main, dialect)


def _outside(mission: MissionContext, build: Build) -> Callable[[Element], Behaviour]:
    """Create a function from a SubTree element to the tree of another mission; the attributes are its parameters."""

    def make(element: Element) -> Behaviour:
        declared = mission_parameters(build)
        given = {n: v for n, v in element.node_attributes().items() if n in declared}
        for name, value in given.items():
            if pointer(value) is not None:
                hint = "Write a value: the tree is created before the first tick."
                message = f"the parameter '{name}' of a Python mission cannot be a key."
                raise InputError(element.fault(message, hint, attribute=name))
        try:
            values = {n: _typed(declared[n], v) for n, v in given.items()}
            root = build(mission, **mission_arguments(build, values))
        except InputError as error:
            raise InputError(*(f if f.file else element.fault(f.message, f.hint) for f in error.faults)) from error
        if not isinstance(root, Behaviour):
            raise InputError(element.fault(f"the mission '{element.attributes['ID']}' returns no tree."))
        return root

    return make


def _typed(each: Field, text: str) -> object:
    """Convert an attribute's text to the type that the value would have in a scenario file (TOML)."""
    return from_string(text, each.hint) if each.hint in (int, bool) or each.dimension == NONE else text


def input_ports(document: Document, main: str) -> dict[ModelPort, bool]:
    """Declared input ports of a tree, and whether each has no default."""
    model, defaults = document.models.get(main), document.trees[main].defaults
    ports = [] if model is None or model.kind != "SubTree" else [*model.ports.values()]
    inputs = [port for port in ports if port.direction is not Direction.OUTPUT]
    return {port: port.default is None and port.name not in defaults for port in inputs}


def port_value(port: ModelPort, text: str) -> Any:
    """Value of a port for a text in the form of a file.

    Raises:
        InputError: The text does not have the declared type.
    """
    return Port(port_of(annotation(port), name=port.name)).value(text)


def defaults_of(document: Document, main: str) -> dict[str, Any]:
    """Defaults of the ports of a tree, by name; numbers in SI units."""
    return {name: each.default for name, each in _parameters(document, main).items() if not each.required}


def _parameters(document: Document, main: str) -> dict[str, Field]:
    """Parameters of `build`, from the main tree's model and `<BehaviorTree>`, those with defaults last."""
    model = document.models.get(main)
    found, faults = dict[str, Field](), list[Fault]()
    for port in model.ports.values() if model is not None else ():
        if not port.name.isidentifier():
            faults.append(port.element.fault(f"'{port.name}' cannot be a parameter.", attribute="name"))
            continue
        try:
            default = MISSING if port.default is None else port_value(port, port.default)
            found[port.name] = Field.annotated(port.name, annotation(port), default, _Build)
        except InputError as error:
            faults += (port.element.fault(f.message, f.hint, attribute="default") for f in error.faults)
    for name, text in document.trees[main].defaults.items():
        if name.isidentifier() and pointer(text) is None and name not in found:
            value = literal(text)
            found[name] = Field.annotated(name, str if isinstance(value, str) else float, value, _Build)
    if faults:
        raise InputError(*faults)
    return dict(sorted(found.items(), key=lambda item: not item[1].required))
