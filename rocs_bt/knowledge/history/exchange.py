"""Files of knowledge: lossless JSON of the states of agents' graphs."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Iterator, Mapping
from json.scanner import py_make_scanner  # type: ignore[attr-defined]  # typeshed lacks it
from pathlib import Path
from typing import Annotated, Any, NoReturn, TypeAlias, TypeVar

import msgspec

from ...base.clock import SimulatedClock
from ...base.errors import Fault, InputError, KnowledgeError
from ...base.files import is_file, read_text
from ...base.nesting import check_nesting
from ...event import NullSink, Value
from ..attribute import plain
from ..declaration import checked
from ..graph import KnowledgeGraph
from ..readable import Stamp
from ..schema import SCHEMA, Schema
from .state import GraphState, typed

FORMAT = "knowledge/1"
_INT64 = 1 << 63
_ENCODE = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode
_Revision = Annotated[int, msgspec.Meta(ge=0, le=2**62)]
_Time = Annotated[float, msgspec.Meta(ge=-1e15, le=1e15)]
_Entry = TypeVar("_Entry", bound=msgspec.Struct)
_Where: TypeAlias = tuple[str | int, ...]  # keys and indices from the top of the document


class _Node(msgspec.Struct, forbid_unknown_fields=True):
    """A node; `stamps` has time [s] and revision of each attribute, by default those of the node."""

    name: Annotated[str, msgspec.Meta(min_length=1)]
    kind: str
    t: _Time
    revision: _Revision
    attributes: dict[str, Any] = {}
    stamps: dict[str, tuple[_Time, _Revision]] = {}


class _Edge(msgspec.Struct, forbid_unknown_fields=True):
    source: str
    relation: str
    target: str
    t: _Time
    revision: _Revision
    attributes: dict[str, Any] = {}


class _Agent(msgspec.Struct, forbid_unknown_fields=True):
    """State of an agent; its time is null before its first change."""

    agent: str
    t: _Time | None
    revision: _Revision
    nodes: list[Any]
    edges: list[Any]


# -- writing ----------------------------------------------------------------------------------------------------------


def to_json_text(*states: GraphState) -> str:
    """The states of agents as lossless JSON, one line per node and edge; equal states give equal texts."""
    agents = ",\n".join(map(_agent_text, states))
    return f'{{\n"format": "{FORMAT}",\n"agents": [\n{agents}\n]\n}}\n'


def _agent_text(state: GraphState) -> str:
    t = state.t if math.isfinite(state.t) else None
    head = ", ".join(
        f'"{key}": {_ENCODE(value)}' for key, value in (("agent", state.agent), ("t", t), ("revision", state.revision))
    )
    nodes, edges = ",\n".join(map(_ENCODE, _nodes(state))), ",\n".join(map(_ENCODE, _edges(state)))
    return f'{{{head},\n"nodes": [\n{nodes}\n],\n"edges": [\n{edges}\n]}}'


def _nodes(state: GraphState) -> Iterator[dict[str, Any]]:
    for name in state.nodes():
        t, revision = state.stamp(name)
        written = sorted(state.written(name).items())
        yield {
            "name": name,
            "kind": state.kind(name),
            "t": t,
            "revision": revision,
            "attributes": {a: _encoded(state.get(name, a)) for a, _ in written},
            "stamps": {a: list(stamp) for a, stamp in written},
        }


def _edges(state: GraphState) -> Iterator[dict[str, Any]]:
    for source, relation, target in state.edges():
        row = state.targets(source, relation)[target]
        known = state.edge(source, relation, target) or {}
        yield {
            "source": source,
            "relation": relation,
            "target": target,
            "t": row["t"],
            "revision": row["revision"],
            "attributes": {a: _encoded(value) for a, value in sorted(known.items())},
        }


def _encoded(value: Any) -> Any:
    """A value for JSON; infinities, NaN and large integers become objects, such as `{"float": "inf"}`."""
    if type(value) is float:
        return value if math.isfinite(value) else {"float": repr(value)}
    if type(value) is int and not -_INT64 <= value < _INT64:
        return {"int": hex(value)}  # decimal digits are limited, and read back as float elsewhere
    if isinstance(value, (list, tuple)):
        return [_encoded(v) for v in value]
    return value


# -- reading ----------------------------------------------------------------------------------------------------------


def read_knowledge(file: Path, schema: Schema = SCHEMA) -> dict[str, GraphState]:
    """Read a file of knowledge; see `from_json_text`.

    Raises:
        InputError: There is no such file, it cannot be read, or it has faults.
    """
    if not is_file(file):
        hint = f"Write one: rocs-bt run SCENARIO --knowledge {file}"
        raise InputError(Fault(f"there is no knowledge '{file}'.", hint=hint))
    return from_json_text(read_text(file), file, schema)


def from_json_text(text: str, file: Path, schema: Schema = SCHEMA) -> dict[str, GraphState]:
    """Read the states of agents, by name, from JSON and check them against a schema.

    Args:
        text: JSON, from `to_json_text` or another program.
        file: File of the text, for messages.
        schema: Allowed kinds and relations.

    Raises:
        InputError: All faults, each at its line and column.
    """
    document, reader = _parsed(text, file), _Reader(schema)
    reader.document(document)
    if reader.faults:
        positions = _Positions(text)
        raise InputError(*(Fault(what, file, *positions.of(where)) for where, what in reader.faults))
    return reader.states


class _Reader:
    """Builds the states in a document and collects its faults, each with its place in the document."""

    def __init__(self, schema: Schema) -> None:
        self.states: dict[str, GraphState] = {}
        self.faults: list[tuple[_Where, str]] = []
        self._schema = schema

    def document(self, document: Mapping[str, Any]) -> None:
        """Read a whole document."""
        keys = ("format", "agents")
        for key in [*(key for key in keys if key not in document), *(key for key in document if key not in keys)]:
            what = "unknown key" if key in document else "there is no"
            self.faults.append(((), f"{what} '{key}'; a file of knowledge has {' and '.join(keys)}."))
        if (found := document.get("format", FORMAT)) != FORMAT:
            self.faults.append(((), f"the format is {found!r:.40}; this version of rocs_bt reads {FORMAT!r}."))
        if not isinstance(agents := document.get("agents", []), list):
            self.faults.append(((), "'agents' must be a list."))
            agents = []
        for index, value in enumerate(agents):
            where = ("agents", index)
            with self._at(where):
                agent = _converted(value, _Agent, "the knowledge of an agent")
                if agent.agent in self.states:
                    raise KnowledgeError(f"agent '{agent.agent}' is there twice.")
                self._state(where, agent)

    def _state(self, where: _Where, agent: _Agent) -> None:
        state = self.states[agent.agent] = GraphState(agent.agent, self._schema)
        # A live graph takes the same nodes and edges, because it has all the checks.
        graph = KnowledgeGraph(SimulatedClock(1.0), NullSink(), agent.agent, self._schema)
        for index, value in enumerate(agent.nodes):
            with self._at((*where, "nodes", index)):
                _add(_converted(value, _Node, "a node"), graph, state)
        for index, value in enumerate(agent.edges):
            with self._at((*where, "edges", index)):
                _relate(_converted(value, _Edge, "an edge"), graph, state)
        state.t, state.revision = -math.inf if agent.t is None else agent.t, agent.revision

    @contextlib.contextmanager
    def _at(self, where: _Where) -> Iterator[None]:
        try:
            yield
        except (KnowledgeError, ValueError) as error:
            self.faults.append((where, str(error)))


def _converted(value: Any, kind: type[_Entry], name: str) -> _Entry:
    """An entry of a document; raises ValueError."""
    try:
        entry = msgspec.convert(value, kind)
        if isinstance(entry, _Node | _Edge):
            entry.attributes = {name: _decoded(given) for name, given in entry.attributes.items()}
    except (msgspec.ValidationError, ValueError) as error:
        raise ValueError(f"this is not {name}: {error}.") from error
    return entry


def _decoded(value: Any) -> Value:
    """A value that `_encoded` has encoded; raises ValueError for an object that it does not write."""
    if isinstance(value, list):
        return [_decoded(v) for v in value]  # type: ignore[misc]  # lists in JSON are of numbers here
    match value:
        case {"float": "inf" | "-inf" | "nan" as text} if len(value) == 1:
            return float(text)
        case {"int": str(text)} if len(value) == 1 and len(text) <= 4096:
            return int(text, 16)
        case dict():
            shape = '{"float": "inf"} or {"int": "0x..."}'
            raise ValueError(f"an object must be {shape}, found the keys {list(value)[:3]}")
    return value  # type: ignore[no-any-return]  # a JSON value, checked by the schema later


def _add(node: _Node, graph: KnowledgeGraph, state: GraphState) -> None:
    declared = graph.schema.kind(node.kind).attributes
    values = _checked((node.kind, node.name), declared, node.attributes)
    graph.add(node.name, node.kind, **values)
    if unknown := node.stamps.keys() - values.keys():
        raise KnowledgeError(f"'{node.name}' has a stamp of '{min(unknown)}', but no such attribute.")
    stamp = Stamp(node.t, node.revision)
    state.add(node.name, node.kind, stamp)
    for name, value in values.items():
        state.write(node.name, name, plain(value), Stamp(*node.stamps.get(name, stamp)))


def _relate(edge: _Edge, graph: KnowledgeGraph, state: GraphState) -> None:
    source, relation, target = edge.source, edge.relation, edge.target
    declared = graph.schema.relation(relation)
    values = _checked((source, relation, target), declared.attributes, edge.attributes)
    if there := graph.related(source, relation):
        if target in there:
            raise KnowledgeError(f"the edge {source} -{relation}-> {target} is there twice.")
        if declared.single:
            raise KnowledgeError(f"'{source}' {relation} '{there[0]}' already, and may have one only.")
    # An attribute that the file omits was unknown, even if it has a default.
    unknown = dict.fromkeys(name for name, each in declared.attributes.items() if not each.required)
    graph.relate(source, relation, target, **(unknown | values))
    known = {name: plain(value) for name, value in (graph.edge(source, relation, target) or {}).items()}
    state.relate(source, relation, target, known, Stamp(edge.t, edge.revision))


def _checked(owner: tuple[str, ...], declared: Mapping[str, Any], given: Mapping[str, Value]) -> dict[str, Any]:
    return checked(owner, declared, {name: typed(value, declared.get(name)) for name, value in given.items()})


def _parsed(text: str, file: Path) -> dict[str, Any]:
    """Parse a text to a JSON object; raises InputError."""
    try:
        check_nesting(text)
        document = json.JSONDecoder(object_pairs_hook=_once, parse_constant=_refuse).decode(text)
        if not isinstance(document, dict):
            raise ValueError("it must be an object, such as {}")
    except json.JSONDecodeError as error:
        raise InputError(Fault(f"this is not valid JSON: {error.msg}.", file, error.lineno, error.colno)) from error
    except ValueError as error:  # too many digits, NaN, a repeated key
        raise InputError(Fault(f"this is not valid JSON: {error}.", file, 1, 1)) from error
    return document


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        twice = next(name for name in found if sum(name == other for other, _ in pairs) > 1)
        raise ValueError(f"'{twice}' is repeated in one object")
    return found


def _refuse(name: str) -> NoReturn:
    raise ValueError(f'{name} is not allowed; write {{"float": "inf"}}')


class _Positions:
    """Positions of objects in a JSON document; computed only if there are faults, because this is slow."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._offsets: dict[int, int] = {}
        self._document: Any = None
        decoder: Any = json.JSONDecoder()
        inner = decoder.parse_object

        def parse_object(start: tuple[str, int], *rest: Any) -> tuple[Any, int]:
            value, end = inner(start, *rest)
            self._offsets[id(value)] = start[1] - 1
            return value, end

        decoder.parse_object = parse_object
        decoder.scan_once = py_make_scanner(decoder)
        with contextlib.suppress(RecursionError):  # nested lists; then no position is known
            self._document = decoder.decode(text)

    def of(self, where: _Where) -> tuple[int, int]:
        """1-based line and column of an object; those of the object around it if it is another value."""
        value, offset = self._document, 0
        for key in (*where, None):
            offset = self._offsets.get(id(value), offset)
            value = None if value is None or key is None else value[key]
        return self._text.count("\n", 0, offset) + 1, offset - self._text.rfind("\n", 0, offset)
