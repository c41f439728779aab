"""Export to and import from GraphML, through networkx, for yEd, Gephi, Cytoscape and similar programs."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from ...errors import Fault, InputError, KnowledgeError
from ..schema import SCHEMA, Schema
from .importer import EdgeEntry, Importer, NodeEntry
from .state import State
from .values import dump, from_json, load, to_json

# Characters that XML cannot hold, and the carriage return, which XML reads back as a line feed.
_NO_XML = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_UNREADABLE = (SyntaxError, ValueError, TypeError, LookupError, AttributeError, RecursionError)


def to_graphml(state: State) -> str:
    """A state as GraphML, with relations as edge keys, and lists and poses as JSON texts.

    The write times of single attributes are lost.

    Raises:
        KnowledgeError: A text has characters that XML does not allow; export it as JSON.
    """
    import networkx

    graph = networkx.MultiDiGraph(agent=_scalar(state.agent), t=state.t, revision=state.revision)
    for name in state.nodes():
        t, revision = state.stamp(name)
        written = {a: state.get(name, a) for a in sorted(state.written(name))}
        graph.add_node(_scalar(name), kind=state.kind(name), **_scalars(written), t=t, revision=revision)
    for source, relation, target in state.edges():
        row = state.targets(source, relation)[target]
        known = state.edge(source, relation, target) or {}
        graph.add_edge(source, target, key=relation, **_scalars(known), t=row["t"], revision=row["revision"])
    return "\n".join(networkx.generate_graphml(graph)) + "\n"


def from_graphml(text: str, file: Path, schema: Schema = SCHEMA) -> State:
    """Read a state from GraphML and check it against a schema; attributes get the write time of their node.

    Args:
        text: GraphML, from `to_graphml` or another program.
        file: File of the text, for messages.
        schema: Allowed kinds and relations; its types decide which texts are JSON of a list or a pose.

    Raises:
        InputError: All faults.
    """
    import networkx

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about keys without a type, which are read as texts
            graph = networkx.parse_graphml(text, node_type=str, edge_key_type=str, force_multigraph=True)
    except (networkx.NetworkXException, *_UNREADABLE) as error:
        raise InputError(Fault(f"this is not valid GraphML: {error}.", file)) from error
    t, revision = graph.graph.get("t", -math.inf), graph.graph.get("revision", 0)
    if not isinstance(t, float) or math.isnan(t) or type(revision) is not int or not 0 <= revision <= 2**62:
        raise InputError(Fault(f"its time and revision must be numbers, found {t!r:.40} and {revision!r:.40}.", file))
    importer = Importer(file, str(graph.graph.get("agent", "")), schema)
    for name, given in graph.nodes(data=True):
        kind = schema.kinds.get(str(given.get("kind")))
        _take(importer, NodeEntry, {"name": name, "kind": given.pop("kind", None)}, given, kind)
    for source, target, relation, given in graph.edges(keys=True, data=True):
        declared = schema.relations.get(relation)
        _take(importer, EdgeEntry, {"source": source, "relation": relation, "target": target}, given, declared)
    return importer.done(t, revision)


def _take(importer: Importer, entry: type[Any], names: dict[str, Any], given: dict[str, Any], owner: Any) -> None:
    declared: Mapping[str, Any] = {} if owner is None else owner.attributes
    stamp = {"t": given.pop("t", 0.0), "revision": given.pop("revision", 0)}
    try:
        values = {name: _value(value, declared.get(name)) for name, value in given.items()}
        made = msgspec.convert({**names, **stamp, "attributes": values}, entry)
    except (msgspec.ValidationError, ValueError) as error:
        importer.fault(f"{' '.join(map(str, names.values()))}: {error}.")
        return
    if entry is NodeEntry:
        importer.node(made)
    else:
        importer.edge(made)


def _value(value: Any, declared: Any) -> Any:
    a_list = declared is not None and declared.type not in (str, float, int, bool)
    if not a_list or not isinstance(value, str):
        return value
    return from_json(load(value))


def _scalars(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _scalar(value) for name, value in values.items() if value is not None}


def _scalar(value: Any) -> Any:
    if isinstance(value, tuple):
        return dump(to_json(value))
    if isinstance(value, str) and _NO_XML.search(value):
        raise KnowledgeError(f"GraphML cannot hold the text {value!r:.60}; export as JSON, which can.")
    return value
