"""knowledge.html: self-contained page that draws an agent's knowledge at any time of a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import msgspec

from ...event import KnowledgeChanged
from ...knowledge import Schema
from ...knowledge.history import ChangeLog
from ...knowledge.history.values import to_json
from ..page import render_page
from .drawing import LOOK, Edge, colors_of, picture
from .learnt import learnt

MOST = 50_000
"""Maximum number of changes in a page; if there are more, values that are soon overwritten are omitted."""
_CODES = {"node added": 0, "node removed": 1, "attribute": 2, "edge added": 3, "edge changed": 3, "edge removed": 4}


def render_knowledge(log: ChangeLog) -> str:
    """Render a change log as HTML, with search and a time slider."""
    logged = log.all_changes()
    changes = thinned(logged, MOST)
    kinds = {c.subject: c.name for c in changes if c.what == "node added"}
    edges: dict[Edge, int] = {}
    for change in changes:
        if change.what.startswith("edge"):
            edges.setdefault((change.subject, change.name, str(change.value)), len(edges))
    state = log.as_of()
    data = {
        "agent": log.agent,
        "begin": log.begin,
        "end": log.end,
        "nodes": list(kinds.items()),
        "edges": list(edges),
        "units": _units(state.schema, set(kinds.values())),
        "changes": _rows(changes, {name: i for i, name in enumerate(kinds)}, edges),
    }
    return render_page(
        "knowledge.html",
        log=log,
        nodes=len(state.nodes()),
        relations=len(state.edges()),
        count=len(logged),
        thinned=len(logged) - len(changes),
        kinds=list(colors_of(kinds.values()).items()),
        picture=picture(kinds, list(edges), log.agent, LOOK),
        learnt=learnt(logged, log.begin),
        # JSON has `<` only in strings, where this escape is equivalent; so no string can end the script element.
        data=msgspec.json.encode(_readable(data)).decode().replace("<", "\\u003c"),
    )


def thinned(changes: Sequence[KnowledgeChanged], most: int) -> list[KnowledgeChanged]:
    """Omit values that are soon overwritten if there are more than `most` changes."""
    if len(changes) <= most:
        return list(changes)
    span = (changes[-1].t - changes[0].t) or 1.0
    kept, newest = [], set()
    for change in reversed(changes):
        key = change.what, change.subject, change.name, int((change.t - changes[0].t) / span * _MOMENTS)
        if change.what in ("attribute", "edge changed"):
            if key in newest:
                continue
            newest.add(key)
        kept.append(change)
    return kept[::-1]


_MOMENTS = 500  # number of time intervals of a thinned log; in each, only the last value is kept


def _rows(changes: Iterable[KnowledgeChanged], nodes: dict[str, int], edges: dict[Edge, int]) -> list[list[Any]]:
    rows: list[list[Any]] = []
    for change in changes:
        code = _CODES[change.what]
        if code >= 3:
            row = [change.t, code, edges[change.subject, change.name, str(change.value)]]
            rows.append([*row, {n: to_json(v) for n, v in change.attributes.items()}] if code == 3 else row)
        elif change.subject in nodes:
            row = [change.t, code, nodes[change.subject]]
            rows.append([*row, change.name, to_json(change.value)] if code == 2 else row)
    return rows


def _units(schema: Schema, kinds: Iterable[str]) -> dict[str, dict[str, str]]:
    """Units of the attributes by kind, without dimensionless ones."""
    found: dict[str, dict[str, str]] = {}
    for kind in kinds:
        declared = schema.kinds[kind].attributes if kind in schema.kinds else {}
        units = {name: ", ".join(dict.fromkeys(str(d) for d in a.dimensions)) for name, a in declared.items()}
        found[kind] = {name: unit for name, unit in units.items() if unit != "1"}
    return found


def _readable(value: Any) -> Any:
    """Replace invalid Unicode in all texts of plain data."""
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode()
    if isinstance(value, dict):
        return {_readable(name): _readable(inner) for name, inner in value.items()}
    return [_readable(inner) for inner in value] if isinstance(value, (list, tuple)) else value
