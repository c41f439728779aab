"""Lossless JSON export and import of one graph state."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from json.scanner import py_make_scanner  # type: ignore[attr-defined]  # typeshed lacks it
from pathlib import Path
from typing import Any, NoReturn

import msgspec

from ...base.errors import Fault, InputError
from ...base.nesting import check_nesting
from ..schema import SCHEMA, Schema
from .importer import EdgeEntry, Importer, NodeEntry
from .state import State
from .values import dump, from_json, to_json

FORMAT = "knowledge/1"
_KEYS = ("format", "agent", "t", "revision", "nodes", "edges")


def to_json_text(state: State) -> str:
    """A state as lossless JSON, one line per node and edge; equal states give equal texts."""
    head = {"format": FORMAT, "agent": state.agent, "t": to_json(state.t), "revision": state.revision}
    lines = ",\n".join(f"{_text(key)}: {_text(value)}" for key, value in head.items())
    nodes, edges = ",\n".join(map(_text, _nodes(state))), ",\n".join(map(_text, _edges(state)))
    return f'{{\n{lines},\n"nodes": [\n{nodes}\n],\n"edges": [\n{edges}\n]\n}}\n'


def from_json_text(text: str, file: Path, schema: Schema = SCHEMA) -> State:
    """Read a state from JSON and check it against a schema.

    Args:
        text: JSON, from `to_json_text` or another program.
        file: File of the text, for messages.
        schema: Allowed kinds and relations.

    Raises:
        InputError: All faults, each at its line and column.
    """
    values = _read(text, file)
    t, revision = _head(values, file)
    importer = Importer(file, values["agent"], schema)
    positions = _Positions(text)
    kinds: tuple[tuple[str, type[NodeEntry | EdgeEntry], Callable[[Any], None]], ...]
    kinds = ("nodes", NodeEntry, importer.node), ("edges", EdgeEntry, importer.edge)
    for key, kind, take in kinds:
        for index, value in enumerate(values[key]):
            before = len(importer.faults)
            try:
                take(_entry(value, kind))
            except (msgspec.ValidationError, ValueError) as error:
                importer.fault(f"this is not {'a node' if kind is NodeEntry else 'an edge'}: {error}.")
            if len(importer.faults) > before:
                line, column = positions.of(key, index)
                importer.faults[-1] = replace(importer.faults[-1], line=line, column=column)
    return importer.done(t, revision)


class _Positions:
    """Positions of list elements in a JSON document; computed only when a fault needs one, because this is slow."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._offsets: dict[int, int] = {}
        self._values: dict[str, Any] = {}

    def of(self, key: str, index: int) -> tuple[int, int]:
        """1-based line and column of an element of the list `key`; both 0 if the element is not an object."""
        if not self._values:
            decoder: Any = json.JSONDecoder()
            inner = decoder.parse_object

            def parse_object(start: tuple[str, int], *rest: Any) -> tuple[Any, int]:
                value, end = inner(start, *rest)
                self._offsets[id(value)] = start[1] - 1
                return value, end

            decoder.parse_object = parse_object
            decoder.scan_once = py_make_scanner(decoder)
            with contextlib.suppress(RecursionError):  # nested lists; then no position is known
                self._values = decoder.decode(self._text)
        offset = self._offsets.get(id(self._values[key][index])) if self._values else None
        if offset is None:
            return 0, 0
        return self._text.count("\n", 0, offset) + 1, offset - self._text.rfind("\n", 0, offset)


def _read(text: str, file: Path) -> dict[str, Any]:
    """Parse a text to a JSON object; raises InputError."""
    try:
        check_nesting(text)
        values = json.JSONDecoder(object_pairs_hook=_once, parse_constant=_refuse).decode(text)
        if not isinstance(values, dict):
            raise ValueError("it must be an object, such as {}")
    except json.JSONDecodeError as error:
        raise InputError(Fault(f"this is not valid JSON: {error.msg}.", file, error.lineno, error.colno)) from error
    except ValueError as error:  # too many digits, NaN, a repeated key
        raise InputError(Fault(f"this is not valid JSON: {error}.", file, 1, 1)) from error
    return values


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        twice = next(name for name in found if sum(name == other for other, _ in pairs) > 1)
        raise ValueError(f"'{twice}' is repeated in one object")
    return found


def _refuse(name: str) -> NoReturn:
    raise ValueError(f'{name} is not allowed; write {{"float": "inf"}}')


def _head(values: dict[str, Any], file: Path) -> tuple[float, int]:
    """Check the top-level keys of a JSON document and return its time [s] and revision."""
    faults = [f"there is no '{key}'; a file of knowledge has {', '.join(_KEYS)}." for key in _KEYS if key not in values]
    faults += [
        f"unknown key '{key}'; a file of knowledge has {', '.join(_KEYS)}." for key in values if key not in _KEYS
    ]
    if (found := values.get("format", FORMAT)) != FORMAT:
        faults.append(f"the format is {found!r:.40}; this version of rocs_bt reads {FORMAT!r}.")
    agent, revision = values.get("agent", ""), values.get("revision", 0)
    if not isinstance(agent, str):
        faults.append(f"the agent must be a text, found {agent!r:.40}.")
    if type(revision) is not int or not 0 <= revision <= 2**62:
        faults.append(f"the revision must be a whole number from 0, found {revision!r:.40}.")
    try:
        t = from_json(values.get("t", 0.0))
    except ValueError:
        t = None
    if isinstance(t, bool) or not isinstance(t, (int, float)) or math.isnan(t) or (abs(t) > 1e15 and t != -math.inf):
        faults.append(f"the time must be a number of seconds, found {values.get('t')!r:.40}.")
    faults += [f"'{key}' must be a list." for key in ("nodes", "edges") if not isinstance(values.get(key, []), list)]
    if faults:
        raise InputError(*(Fault(fault, file) for fault in faults))
    return float(t), revision  # type: ignore[arg-type]  # checked above


def _entry(value: Any, kind: type[NodeEntry | EdgeEntry]) -> Any:
    entry = msgspec.convert(value, kind)
    entry.attributes = {name: from_json(given) for name, given in entry.attributes.items()}
    return entry


def _nodes(state: State) -> Iterator[dict[str, Any]]:
    for name in state.nodes():
        t, revision = state.stamp(name)
        written = sorted(state.written(name).items())
        yield {
            "name": name,
            "kind": state.kind(name),
            "t": t,
            "revision": revision,
            "attributes": {a: to_json(state.get(name, a)) for a, _ in written},
            "stamps": {a: list(stamp) for a, stamp in written},
        }


def _edges(state: State) -> Iterator[dict[str, Any]]:
    for source, relation, target in state.edges():
        row = state.targets(source, relation)[target]
        known = state.edge(source, relation, target) or {}
        yield {
            "source": source,
            "relation": relation,
            "target": target,
            "t": row["t"],
            "revision": row["revision"],
            "attributes": {a: to_json(value) for a, value in sorted(known.items())},
        }


def _text(value: Any) -> str:
    return dump(value)
