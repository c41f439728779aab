"""Nodes and trees that a mission in XML may use, with their ports."""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass, replace
from pathlib import Path

from ...actions import action_table
from ...base.errors import InputError
from ...base.files import read_text
from ...base.nesting import descendants
from ...catalog import Catalog, make_entry
from ...check.xml_mission import declared_dialect
from ...declare import summary_of
from ...plan import mission_nodes, shipped_nodes
from ...plan.dialects import recognise
from ...trees.nodes import CONDITIONS, Node, Port
from ...trees.xml.write import type_name, value_text
from .elements import Element, parse

KEY = re.compile(r"\{(@?[A-Za-z_]\w*)\}")
"""Regular expression of a port value that is a key of the blackboard."""

ORDER = ("Control", "Decorator", "Action", "Condition", "SubTree")
"""Kinds of nodes in the order of a palette."""


@dataclass(frozen=True)
class PortInfo:
    """Port of a node.

    Attributes:
        name: Name.
        direction: `input`, `output` or `inout`.
        type: Type of the values: a unit such as `m/s`, or a C++ type.
        default: Text of the default; None if a value is required.
        doc: Description.
    """

    name: str
    direction: str = "input"
    type: str = ""
    default: str | None = ""
    doc: str = ""


@dataclass(frozen=True)
class NodeInfo:
    """Node that a mission may use.

    Attributes:
        name: Tag of the node; the ID of a SubTree.
        kind: `Control`, `Decorator`, `Action`, `Condition` or `SubTree`.
        doc: First sentence of its description.
        ports: Ports in the order of declaration.
        file: File with the tree; None for another node.
        line: Line of the tree, 1-based.
        source: Class that defines the node; None for a tree.
    """

    name: str
    kind: str
    doc: str = ""
    ports: tuple[PortInfo, ...] = ()
    file: Path | None = None
    line: int = 0
    source: type | None = None

    def definition(self) -> tuple[Path, int] | None:
        """File and line of its definition; None if the source is not at hand."""
        if self.source is None:
            return None if self.file is None else (self.file, self.line)
        try:
            return Path(inspect.getsourcefile(self.source) or ""), inspect.getsourcelines(self.source)[1]
        except (OSError, TypeError):
            return None

    @property
    def text(self) -> str:
        """Text of a new node, with its required ports."""
        required = [port.name for port in self.ports if port.default is None and port.direction != "output"]
        given = "".join(f' {name}=""' for name in required)
        tag, own = ("SubTree", f' ID="{self.name}"') if self.kind == "SubTree" else (self.name, "")
        return f"<{tag}{own}{given}/>"


def vocabulary(path: Path, text: str, *, code: bool = True) -> dict[str, NodeInfo]:
    """Nodes and trees that a mission may use, by tag and, for trees, by `SubTree ID`; in the order of a palette.

    Args:
        path: File of the mission; it need not exist.
        text: Text of the mission.
        code: Whether Python content of the project may run; without it, nodes of the project are left out.
    """
    catalog = Catalog.here(path.parent, code=code)
    dialect = dialect_of(path, text, catalog)
    shipped = shipped_nodes(dialect)
    try:
        own = [node for node in catalog.load_nodes() if node.tag not in shipped] if code else []
    except InputError:
        own = []  # the check reports what does not load
    nodes = mission_nodes(_ACTIONS, own, dialect)
    found = [_node(cls) for tag, cls in nodes.items() if cls.kind in ORDER and tag != "SubTree"]
    found += _trees(path, text, catalog)
    ordered = sorted(found, key=lambda node: (ORDER.index(node.kind), node.name))
    return {f"SubTree {node.name}" if node.kind == "SubTree" else node.name: node for node in ordered}


def dialect_of(path: Path, text: str, catalog: Catalog) -> str:
    """Dialect of a mission: as a scenario declares it, or as recognised from its nodes."""
    declared = declared_dialect(make_entry(path, "mission", "file"), catalog)
    return declared or recognise(set(re.findall(r"<([A-Za-z_]\w*)", text)), catalog.defined_nodes)


def _port(port: Port) -> PortInfo:
    default = None if port.required else ""
    if default is not None and port.default is not None:
        default = value_text(port.default, port.dimension)
    return PortInfo(port.name, port.direction.value.removesuffix("_port"), type_name(port), default, port.doc)


_ACTIONS = action_table()


def _node(cls: type[Node]) -> NodeInfo:
    ports = [_port(port) for port in cls.ports.values()]
    source: type = _ACTIONS.get(getattr(cls, "action", ""), cls)
    return NodeInfo(cls.tag, cls.kind, summary_of(source), (*ports, *_COMMON), source=source)


_COMMON = (
    PortInfo("name", doc="name of the node in reports"),
    *(PortInfo(name, type="script", doc="condition or script, as in BehaviorTree.CPP") for name in CONDITIONS),
)
"""Attributes that every node has."""


def _trees(path: Path, text: str, catalog: Catalog) -> list[NodeInfo]:
    """Trees that a SubTree can use: of this text, and missions of the catalog."""
    found = {info.name: info for info in trees_in(path, text)}
    for name, file in catalog.tree_files().items():
        if name not in found and file.resolve() != path.resolve():
            try:
                own = {info.name: info for info in trees_in(file, read_text(file))}
            except InputError:
                continue
            if name in own:
                found[name] = own[name]
    for entry in catalog.list("mission"):
        if entry.path.suffix == ".py":
            found.setdefault(entry.name, NodeInfo(entry.name, "SubTree", entry.doc, file=entry.path, line=1))
    return list(found.values())


def trees_in(path: Path, text: str) -> list[NodeInfo]:
    """Trees that a text defines, each with the keys that it uses as ports."""
    document = parse(text, tolerant=True)
    assert document is not None  # a tolerant parser always returns one
    models = {e.value("ID"): e for e in descendants(document) if e.tag == "SubTree" and _in_models(e)}
    found = []
    for tree in descendants(document):
        if tree.tag == "BehaviorTree" and (name := tree.value("ID")):
            keys = dict.fromkeys(KEY.findall(text[tree.inner : tree.close]))
            ports = {key: PortInfo(key, "inout", "key") for key in keys if key[0] not in "_@"}
            for port in models[name].children if name in models else ():
                given = port.value("name") or ""
                info = PortInfo(given, port.tag.removesuffix("_port"), port.value("type") or "", port.value("default"))
                ports[given] = replace(info, doc=text[port.inner : port.close].strip())
            line = text.count("\n", 0, tree.start) + 1
            found.append(NodeInfo(name, "SubTree", f"tree of {path.name}", tuple(ports.values()), path, line))
    return found


def _in_models(element: Element) -> bool:
    return element.parent is not None and element.parent.tag == "TreeNodesModel"
