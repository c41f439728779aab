"""What came of an agent's knowledge over a run, in a table that people can read."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ...event import KnowledgeChanged, Value


@dataclass
class Learnt:
    """One thing that was learnt over a run: an attribute, a relation, or that there is a node.

    Attributes:
        subject: The node.
        what: The attribute, the relation, or the node's kind.
        first: What it was at first.
        last: What it was at the end; None where it was gone.
        count: How often it changed.
        begin: When it was learnt [s].
        end: When it changed last [s].
    """

    subject: str
    what: str
    first: str
    last: str
    count: int
    begin: float
    end: float


def learnt(changes: Iterable[KnowledgeChanged], since: float) -> list[Learnt]:
    """Everything that changed after a time [s], each thing once, in the order in which it first did.

    A node that comes with attributes, as nearly all do, is told by them.
    """
    rows: dict[tuple[str, str], Learnt] = {}
    for change in changes:
        what, told = _told(change)
        key = change.subject, what
        row = rows.get(key)
        if row is None:
            rows[key] = Learnt(change.subject, what, told, told, int(change.t > since), change.t, change.t)
            continue
        row.last = told
        row.end = change.t
        row.count += change.t > since
    return [row for row in rows.values() if row.count]


def value_text(value: Value | tuple[float, ...]) -> str:
    """A value for people."""
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "not known"}[value]
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        return "(" + ", ".join(value_text(v) for v in value) + ")"
    return str(value)


def _told(change: KnowledgeChanged) -> tuple[str, str]:
    if change.what == "attribute":
        return change.name, value_text(change.value)
    if change.what.startswith("edge"):
        held = ", ".join(f"{n} {value_text(v)}" for n, v in change.attributes.items())
        return f"{change.name} {change.value}", held or {"edge removed": "no"}.get(change.what, "yes")
    return change.name, {"node added": "there", "node removed": "gone"}[change.what]
