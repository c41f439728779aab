"""What is read of a journal's file: runs, bases, changes, and single values."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from ...event import KnowledgeChanged, Value
from ..readable import Stamp
from ..schema import Schema
from .file import WHAT
from .state import State
from .values import Stored, from_sql, row_from_sql, to_sql

_NODE_REMOVED, _ATTRIBUTE = WHAT.index("node removed"), WHAT.index("attribute")
_CHANGES = "SELECT revision, t, what, subject, name, value, attributes FROM change WHERE stretch = ?"


class Written(NamedTuple):
    """What was written last to an attribute of a node of a kind."""

    kind: str
    value: Value


@contextmanager
def still(connection: sqlite3.Connection) -> Iterator[None]:
    """One look at the file, whatever is written to it meanwhile; part of a look that is under way."""
    if connection.in_transaction:
        yield
        return
    connection.execute("BEGIN")
    try:
        yield
    finally:
        connection.execute("COMMIT")


def runs(connection: sqlite3.Connection) -> list[tuple[int, str, str]]:
    """Number, agent and label of each run, the oldest first."""
    rows = connection.execute("SELECT run, agent, label FROM stretch GROUP BY run, agent ORDER BY run, min(id)")
    return [(int(run), text(agent), text(label)) for run, agent, label in rows]


def stretches(connection: sqlite3.Connection, run: int, agent: str) -> list[tuple[int, int, float, int, float]]:
    """Number, first revision and time, last revision and time of each stretch of a run, the oldest first."""
    found = []
    for stretch, revision, t in connection.execute(
        "SELECT id, revision, t FROM stretch WHERE run = ? AND agent = ? ORDER BY id", (run, to_sql(agent))
    ).fetchall():
        last = connection.execute(
            "SELECT revision, t FROM change WHERE stretch = ? ORDER BY revision DESC LIMIT 1", (stretch,)
        ).fetchone()
        found.append((stretch, revision, t, *(last or (revision, t))))
    return found


def time_of(connection: sqlite3.Connection, stretch: int, revision: int) -> float:
    """When a change was made [s]; -inf where it stands in the base by now."""
    row = connection.execute("SELECT t FROM change WHERE stretch = ? AND revision = ?", (stretch, revision)).fetchone()
    return float("-inf") if row is None else float(row[0])


def base(connection: sqlite3.Connection, stretch: int, agent: str, schema: Schema) -> State:
    """The state that a stretch begins from."""
    revision, t = connection.execute("SELECT revision, t FROM stretch WHERE id = ?", (stretch,)).fetchone()
    state, stamps = State(agent, schema, t, revision), {}
    for name, kind, at, written in connection.execute(
        "SELECT name, kind, t, revision FROM node WHERE stretch = ? ORDER BY place", (stretch,)
    ):
        stamps[text(name)] = Stamp(at, written)
        state.add(text(name), text(kind), stamps[text(name)])
    for node, name, value, at, written in connection.execute(
        "SELECT node, name, value, t, revision FROM attribute WHERE stretch = ?", (stretch,)
    ):
        state.write(text(node), text(name), from_sql(value), Stamp(at, written))
    for name, stamp in stamps.items():
        state.renew(name, stamp)  # that of its newest attribute is not always its own
    for source, relation, target, attributes, at, written in connection.execute(
        "SELECT source, relation, target, attributes, t, revision FROM edge WHERE stretch = ? ORDER BY place",
        (stretch,),
    ):
        state.relate(text(source), text(relation), text(target), row_from_sql(attributes), Stamp(at, written))
    return state


def changes(
    connection: sqlite3.Connection,
    stretch: int,
    agent: str,
    since: int,
    until: int,
    node: str | None = None,
    name: str | None = None,
) -> Iterator[KnowledgeChanged]:
    """Changes of a stretch after a revision and up to another, in their order."""
    where, values = "", []
    for column, wanted in (("subject", node), ("name", name)):
        if wanted is not None:
            where += f" AND {column} = ?"
            values.append(to_sql(wanted))
    for row in connection.execute(
        f"{_CHANGES}{where} AND revision > ? AND revision <= ? ORDER BY revision", (stretch, *values, since, until)
    ):
        yield _change(agent, row)


def replay(connection: sqlite3.Connection, stretch: int, state: State, until: int) -> None:
    """Apply the changes of a stretch after a state's revision and up to another; the state is as if one by one.

    Of the many values that an attribute had on the way the last one alone is looked at.
    """
    newest: dict[Stored, dict[Stored, tuple[Stored, float, int]]] = {}
    at = None
    for at in connection.execute(
        f"{_CHANGES} AND revision > ? AND revision <= ? ORDER BY revision", (stretch, state.revision, until)
    ):
        revision, t, what, subject, name, value, _ = at
        if what == _ATTRIBUTE:
            values = newest.get(subject)
            if values is None:
                values = newest[subject] = {}
            values[name] = value, t, revision
        else:
            if what <= _NODE_REMOVED:
                newest.pop(subject, None)
            state.apply(_change(state.agent, at))
    for subject, values in newest.items():
        node = text(subject)
        for name, (value, t, revision) in sorted(values.items(), key=_by_revision):
            state.write(node, text(name), from_sql(value), Stamp(t, revision))
    if at is not None:
        state.t, state.revision = at[1], at[0]


def value(connection: sqlite3.Connection, stretch: int, until: int, node: str, attribute: str) -> Written | None:
    """What was written to an attribute last, up to a revision; None where it was not, or there is no such node."""
    subject, name = to_sql(node), to_sql(attribute)
    life = (
        connection.execute(
            "SELECT what, revision, name FROM change INDEXED BY life_of "
            "WHERE stretch = ? AND subject = ? AND what <= 1 AND revision <= ? "
            "ORDER BY revision DESC LIMIT 1",
            (stretch, subject, until),
        ).fetchone()
        or connection.execute(
            "SELECT 0, place, kind FROM node WHERE stretch = ? AND name = ?", (stretch, subject)
        ).fetchone()
    )
    if life is None or WHAT[life[0]] == "node removed":
        return None
    row = (
        connection.execute(
            "SELECT value, revision FROM change INDEXED BY change_of "
            "WHERE stretch = ? AND subject = ? AND name = ? AND what = 2 "
            "AND revision <= ? ORDER BY revision DESC LIMIT 1",
            (stretch, subject, name, until),
        ).fetchone()
        or connection.execute(
            "SELECT value, revision FROM attribute WHERE stretch = ? AND node = ? AND name = ?",
            (stretch, subject, name),
        ).fetchone()
    )
    return None if row is None or row[1] < life[1] else Written(text(life[2]), from_sql(row[0]))


def text(stored: Stored) -> str:
    """A name.

    Raises:
        ValueError: It is none.
    """
    if type(stored) is str:
        return stored
    found = from_sql(stored)
    if not isinstance(found, str):
        raise ValueError(f"a name is {found!r}")
    return found


def _change(agent: str, row: Sequence[Any]) -> KnowledgeChanged:
    revision, t, what, subject, name, value, attributes = row
    return KnowledgeChanged(
        t=t, agent=agent, what=WHAT[what], subject=text(subject), name=text(name), value=from_sql(value),
        revision=revision, attributes=row_from_sql(attributes),
    )  # fmt: skip


def _by_revision(item: tuple[Stored, tuple[Stored, float, int]]) -> int:
    return item[1][2]
