"""Missions in XML files, with the same interface as a Python mission's `build`."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from py_trees.behaviour import Behaviour

from ..action import Parameter
from ..errors import Fault, InputError
from ..trees.board import from_string
from ..trees.nodes import BUILTIN, Node, Registry, SubTree, pointer
from ..trees.xml.document import Document, add_siblings, below, outer_trees, read_document
from ..trees.xml.element import Element
from ..trees.xml.load import make_nodes
from ..trees.xml.model import ModelPort, annotation
from ..trees.xml.verify import verify
from ..units import NONE, convert
from .action_node import action_nodes
from .context import MissionContext
from .nav2 import ELSEWHERE, GOAL_KEYS, NAV2
from .parameters import mission_arguments, mission_parameters

Build = Callable[..., Any]


def tags_of(document: Document) -> set[str]:
    """All node classes that a document's trees name, including SubTree."""
    return {e.node_tag for tree in document.trees.values() for e in below(tree.body)}


def values_of(document: Document) -> set[str]:
    """All attribute values of nodes in a document's trees."""
    return {v for tree in document.trees.values() for e in below(tree.body) for v in e.attributes.values()}


def xml_mission(
    file: Path | str,
    *,
    main: str = "",
    within: Path | None = None,
    nodes: Callable[[set[str]], Sequence[type[Node]]] = lambda tags: (),
    missions: Callable[[str], Build | None] = lambda name: None,
    beside: Mapping[str, Path] = MappingProxyType({}),
    dialect: str = "",
) -> Callable[..., Behaviour]:
    """`build` function of a mission in an XML file.

    Its parameters are the input ports that the TreeNodesModel declares for the main tree, as `<SubTree ID="Main">`. The
    type of a port is a C++ type, or a unit such as `m/s`; a default such as `0.5 m/s` also defines the unit. Parameters
    become keys of the blackboard, as SI numbers. The actions of the robot are nodes, with the actions' parameters as
    ports.

    Args:
        file: Path of the file, or text of the document.
        main: ID of the tree; the document's main tree by default.
        within: Folder that must contain included files; the file's own by default.
        nodes: Function that returns those of a project's node classes that have these names.
        missions: Function that returns the `build` of another mission, which a SubTree may name, or None.
        beside: Other files by the IDs of their trees, which a SubTree may name.
        dialect: `nav2` for Nav2's semantics of nodes that exist in Nav2.

    Raises:
        InputError: The file cannot be read, or its main tree is ambiguous.
    """
    document = read_document(file, within=within)
    add_siblings(document, beside)
    document.library = len(document.entries()) > 1 if main else False
    own = list(nodes(tags_of(document) - set(shipped_nodes(dialect))))
    path = file if isinstance(file, Path) else None

    def make(mission: MissionContext) -> Behaviour:
        return mission_tree(document, mission, own, missions, main, dialect)

    keys = [key for key in GOAL_KEYS if dialect == "nav2" and f"{{{key}}}" in _read_in(document)]
    return _Build(path, document, main, make, keys)


def _read_in(document: Document) -> set[Any]:
    """All attribute values in a document's trees, and the defaults that Nav2's nodes read."""
    found: set[Any] = set(values_of(document))
    for element in document.elements():
        node = NAV2.get(element.node_tag)
        ports = node.ports.values() if node is not None else ()
        found |= {p.default for p in ports if isinstance(p.default, str) and p.name not in element.attributes}
    return found


class _Build:
    """Document with the interface of a `build` function: called with a Mission and the parameters."""

    def __init__(
        self,
        file: Path | None,
        document: Document,
        main: str,
        make: Callable[[MissionContext], Behaviour],
        keys: Iterable[str] = (),
    ) -> None:
        main = document.main(main).name
        parameters = _parameters(document, main)
        kind, text = inspect.Parameter.KEYWORD_ONLY, str
        declared = {p.name for p in parameters}
        parameters[:0] = [inspect.Parameter(k, kind, annotation=text) for k in keys if k not in declared]
        self.__name__ = "build"
        self.__doc__ = f"The tree '{main}' of {'a document' if file is None else file.name}."
        self.__annotations__ = {p.name: p.annotation for p in parameters}
        first = inspect.Parameter("mission", inspect.Parameter.POSITIONAL_OR_KEYWORD)
        self.__signature__ = inspect.Signature([first, *parameters])
        self.file = file
        self._make = make

    def __call__(self, mission: MissionContext, **values: Any) -> Behaviour:
        given = inspect.signature(self).bind(mission, **values)
        given.apply_defaults()
        for name, value in list(given.arguments.items())[1:]:
            mission.board.set_local(name, value)
        return self._make(mission)


def mission_tree(
    document: Document,
    mission: MissionContext,
    nodes: Sequence[type[Node]] = (),
    missions: Callable[[str], Build | None] = lambda name: None,
    main: str = "",
    dialect: str = "",
) -> Behaviour:
    """Main tree of a document for a mission, with its robot's actions as nodes.

    Raises:
        InputError: All faults of the tree.
    """
    registry = mission_nodes(mission.actions, nodes, dialect)
    outside = {name: _outside(mission, build) for name in outer_trees(document) if (build := missions(name))}
    faults = [*document.faults, *verify(document, registry, main=main, outside=outside, elsewhere=ELSEWHERE)]
    wrong = [fault for fault in faults if not fault.warning]
    if wrong and not mission.check_options:
        raise InputError(*wrong)
    mission.report(*faults)
    # A check continues with the valid parts, so that it reports all faults at once.
    return make_nodes(document, registry, main=main, outside=outside, lenient=bool(wrong))


def mission_nodes(actions: Mapping[str, Any], nodes: Sequence[type[Node]] = (), dialect: str = "") -> Registry:
    """All nodes that a mission's file may name: built-in nodes, a robot's actions, and a project's own nodes.

    Args:
        actions: Action table.
        nodes: Node classes of the project.
        dialect: `nav2` for Nav2's semantics of nodes that exist in Nav2.
    """
    shipped = shipped_nodes(dialect)
    return shipped.with_([*(node for node in action_nodes(actions) if node.tag not in shipped), *nodes])


def shipped_nodes(dialect: str = "") -> Registry:
    """Nodes that every mission of a dialect may name, except its robot's actions."""
    return NAV2 if dialect == "nav2" else BUILTIN


def embedded(
    mission: MissionContext, source: Path | str, nodes: Sequence[type[Node]], main: str, values: Any
) -> SubTree:
    """XML tree as a subtree of a Python mission.

    Args:
        mission: The mission.
        source: Path of a file, or text of a document.
        nodes: Additional node classes that it names.
        main: ID of the tree; the document's main tree by default.
        values: Remappings and values of the subtree's keys.

    Raises:
        InputError: All faults of the tree.
    """
    document = read_document(source)
    name = document.main(main).name
    return SubTree(name, mission_tree(document, mission, nodes, main=main), ID=name, **values)


def _outside(mission: MissionContext, build: Build) -> Callable[[Element], Behaviour]:
    """Function that makes the tree of another mission, with the attributes of a SubTree as its parameters."""

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


def _typed(parameter: Parameter, text: str) -> object:
    """Convert an attribute's text to the type that the value would have in a scenario file (TOML)."""
    if parameter.type in (int, bool) or (parameter.type is float and parameter.dimension in (None, NONE)):
        return from_string(text, parameter.type)
    return text


def _parameters(document: Document, main: str) -> list[inspect.Parameter]:
    """Keyword-only parameters from the model of the main tree.

    Raises:
        InputError: All ports with an invalid type or default.
    """
    model = document.models.get(main)
    found, faults = [], list[Fault]()
    for port in model.ports.values() if model is not None else ():
        if not port.name.isidentifier():
            faults.append(port.element.fault(f"'{port.name}' cannot be a parameter.", attribute="name"))
            continue
        try:
            found.append(_parameter(port))
        except InputError as error:
            faults += (port.element.fault(f.message, f.hint, attribute="default") for f in error.faults)
    if faults:
        raise InputError(*faults)
    return sorted(found, key=lambda p: p.default is not inspect.Parameter.empty)


def _parameter(port: ModelPort) -> inspect.Parameter:
    hint, default = annotation(port), inspect.Parameter.empty
    value: Any = default
    if port.default is not None:
        parameter = Parameter.annotated(port.name, hint, False, None)
        value = port.default
        if parameter.type is float:
            value = convert(port.default, parameter.dimension or NONE, port.name)
        elif parameter.type is not str:
            value = from_string(port.default, parameter.type)
    return inspect.Parameter(port.name, inspect.Parameter.KEYWORD_ONLY, default=value, annotation=hint)
