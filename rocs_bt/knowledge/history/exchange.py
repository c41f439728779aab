"""One state as a file for others: JSON, which says all, and GraphML, which other programs draw."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from ...errors import Fault, InputError
from ..schema import SCHEMA, Schema
from .intake import EdgeEntry, Intake, NodeEntry
from .positions import Scanner, place_of
from .state import State
from .values import dump, from_json, to_json

FORMAT = "knowledge/1"
E = TypeVar("E", NodeEntry, EdgeEntry)
_KEYS = ("format", "agent", "t", "revision", "nodes", "edges")


def to_json_text(state: State) -> str:
    """A state as JSON, a line a node and an edge: the same state gives the same text, and can be read back exactly."""
    head = {"format": FORMAT, "agent": state.agent, "t": to_json(state.t), "revision": state.revision}
    lines = ",\n".join(f"{_text(key)}: {_text(value)}" for key, value in head.items())
    nodes, edges = ",\n".join(map(_text, _nodes(state))), ",\n".join(map(_text, _edges(state)))
    return f'{{\n{lines},\n"nodes": [\n{nodes}\n],\n"edges": [\n{edges}\n]\n}}\n'


def from_json_text(text: str, file: Path, schema: Schema = SCHEMA) -> State:
    """The state that a JSON text holds, checked against a schema.

    Args:
        text: What `to_json_text` made, or somebody else.
        file: Where it stands, for messages.
        schema: What may stand in it.

    Raises:
        InputError: With everything that is wrong, each at its line and column.
    """
    try:
        values = Scanner(text, frozenset(("nodes", "edges"))).values
    except json.JSONDecodeError as error:
        raise InputError(Fault(f"this is no JSON: {error.msg}.", file, error.lineno, error.colno)) from error
    t, revision = _head(values, file)
    intake = Intake(file, values["agent"], schema)
    for offset, value in values["nodes"]:
        place = place_of(text, offset)
        if (node := _entry(value, NodeEntry, intake, place)) is not None:
            intake.node(node, *place)
    for offset, value in values["edges"]:
        place = place_of(text, offset)
        if (edge := _entry(value, EdgeEntry, intake, place)) is not None:
            intake.edge(edge, *place)
    return intake.done(t, revision)


def _head(values: dict[str, Any], file: Path) -> tuple[float, int]:
    """Time and revision; everything else at the top is checked too."""
    faults = [f"there is no '{key}'; a file of knowledge has {', '.join(_KEYS)}." for key in _KEYS if key not in values]
    faults += [f"'{key}' is nothing that a file of knowledge has." for key in values if key not in _KEYS]
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
    if faults:
        raise InputError(*(Fault(fault, file) for fault in faults))
    return float(t), revision  # type: ignore[arg-type]  # checked above


def _entry(value: Any, kind: type[E], intake: Intake, place: tuple[int, int]) -> E | None:
    try:
        entry = msgspec.convert(value, kind)
        entry.attributes = {name: from_json(given) for name, given in entry.attributes.items()}
    except (msgspec.ValidationError, ValueError) as error:
        what = "a node" if kind is NodeEntry else "an edge"
        intake.fault(f"this is not {what}: {error}.", *place)
        return None
    return entry


def _nodes(state: State) -> Iterator[dict[str, Any]]:
    for name in state.nodes():
        t, revision = state.stamp(name)
        written = sorted(state.written(name).items())
        yield {
            "name": name, "kind": state.kind(name), "t": t, "revision": revision,
            "attributes": {a: to_json(state.get(name, a)) for a, _ in written},
            "stamps": {a: list(stamp) for a, stamp in written},
        }  # fmt: skip


def _edges(state: State) -> Iterator[dict[str, Any]]:
    for source, relation, target in state.edges():
        row = state.targets(source, relation)[target]
        known = state.edge(source, relation, target) or {}
        yield {
            "source": source, "relation": relation, "target": target, "t": row["t"], "revision": row["revision"],
            "attributes": {a: to_json(value) for a, value in sorted(known.items())},
        }  # fmt: skip


def _text(value: Any) -> str:
    return dump(value)
