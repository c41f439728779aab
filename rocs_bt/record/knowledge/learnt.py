"""Table of what an agent learnt in a run: a row for each attribute, relation and node that changed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ...event import KnowledgeChanged, Value


@dataclass
class Learnt:
    """Changes of one attribute, one relation, or the existence of one node over a run.

    Attributes:
        subject: Name of the node.
        what: Name of the attribute, relation and target, or kind of the node.
        first: First value, as text.
        last: Last value, as text.
        count: Number of changes.
        begin: Time of the first value [s].
        end: Time of the last change [s].
    """

    subject: str
    what: str
    first: str
    last: str
    count: int
    begin: float
    end: float


def learnt(changes: Iterable[KnowledgeChanged], since: float) -> list[Learnt]:
    """Table rows of everything that changed after the time `since` [s], in the order of the first change."""
    rows: dict[tuple[str, str], Learnt] = {}
    for change in changes:
        what, value = _described(change)
        key = change.subject, what
        row = rows.get(key)
        if row is None:
            rows[key] = Learnt(change.subject, what, value, value, int(change.t > since), change.t, change.t)
            continue
        row.last = value
        row.end = change.t
        row.count += change.t > since
    return [row for row in rows.values() if row.count]


def value_text(value: Value | tuple[float, ...]) -> str:
    """Format a value in human-readable form."""
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "unknown"}[value]
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        return "(" + ", ".join(value_text(v) for v in value) + ")"
    return str(value)


def _described(change: KnowledgeChanged) -> tuple[str, str]:
    """Name and new value of a Knowledge change, as texts."""
    if change.what == "attribute":
        return change.name, value_text(change.value)
    if change.what.startswith("edge"):
        held = ", ".join(f"{n} {value_text(v)}" for n, v in change.attributes.items())
        return f"{change.name} {change.value}", held or {"edge removed": "no"}.get(change.what, "yes")
    return change.name, {"node added": "exists", "node removed": "removed"}[change.what]
