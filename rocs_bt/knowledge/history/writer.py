"""What is written to a journal's file: bases, changes, and the oldest changes folded into the base."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Sequence

from ...event import KnowledgeChanged
from .file import WHAT
from .state import State
from .values import Stored, plain, row_to_sql, to_sql

_WHAT = {what: number for number, what in enumerate(WHAT)}
_STRETCHES = 64  # that a file holds of one agent, for each has a base
Row = tuple[Stored | float, ...]


def begin_stretch(connection: sqlite3.Connection, run: int, label: str, base: State) -> int:
    """Write a base; its stretch's number is returned."""
    stretch = connection.execute(
        "INSERT INTO stretch (run, agent, label, revision, t) VALUES (?, ?, ?, ?, ?)",
        (run, to_sql(base.agent), to_sql(label), base.revision, base.t),
    ).lastrowid
    assert stretch is not None  # an INSERT has one
    connection.executemany("INSERT INTO node VALUES (?, ?, ?, ?, ?, ?)", _node_rows(stretch, base))
    connection.executemany("INSERT INTO attribute VALUES (?, ?, ?, ?, ?, ?)", _attribute_rows(stretch, base))
    connection.executemany("INSERT INTO edge VALUES (?, ?, ?, ?, ?, ?, ?, ?)", _edge_rows(stretch, base))
    return stretch


def next_run(connection: sqlite3.Connection) -> int:
    """A number that no run of this file has."""
    return 1 + int(connection.execute("SELECT coalesce(max(run), 0) FROM stretch").fetchone()[0])


def append(connection: sqlite3.Connection, stretch: int, changes: Iterable[KnowledgeChanged]) -> None:
    """Write changes after those that the stretch has."""
    connection.executemany(
        "INSERT INTO change VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
        [
            (
                stretch, c.revision, c.t, _WHAT[c.what], to_sql(c.subject), to_sql(c.name), to_sql(c.value),
                row_to_sql(c.attributes),
            )
            for c in changes
        ],
    )  # fmt: skip


def compact(connection: sqlite3.Connection, agent: str, keep: int) -> None:
    """Keep the newest changes of an agent only; what came before them is left as the base they begin from."""
    stretches = connection.execute(
        "SELECT id, revision FROM stretch WHERE agent IS ? ORDER BY id DESC", (to_sql(agent),)
    ).fetchall()
    left = keep
    for place, (stretch, base) in enumerate(stretches):
        last = connection.execute("SELECT max(revision) FROM change WHERE stretch = ?", (stretch,)).fetchone()[0]
        count = 0 if last is None else last - base  # revisions have no gaps
        if place and (left == 0 or place >= _STRETCHES):
            _forget(connection, stretch)
        elif count > left:
            _fold(connection, stretch, last - left)
            count = left
        left = max(left - count, 0)


def _fold(connection: sqlite3.Connection, stretch: int, until: int) -> None:
    """Move the changes up to a revision into the base."""
    rows = connection.execute(
        "SELECT revision, t, what, subject, name, value, attributes FROM change "
        "WHERE stretch = ? AND revision <= ? ORDER BY revision",
        (stretch, until),
    ).fetchall()
    for row in rows:
        _apply(connection, stretch, row)
    connection.execute("UPDATE stretch SET revision = ?, t = ? WHERE id = ?", (until, rows[-1][1], stretch))
    connection.execute("DELETE FROM change WHERE stretch = ? AND revision <= ?", (stretch, until))


def _apply(connection: sqlite3.Connection, stretch: int, row: Sequence[Stored]) -> None:
    """One change, made in the base: what `State.apply` does."""
    revision, t, what, subject, name, value, attributes = row
    if what == 2:  # an attribute
        connection.execute(
            "REPLACE INTO attribute VALUES (?, ?, ?, ?, ?, ?)", (stretch, subject, name, value, t, revision)
        )
        connection.execute(
            "UPDATE node SET t = ?, revision = ? WHERE stretch = ? AND name = ?", (t, revision, stretch, subject)
        )
    elif what == 0:  # a node is added
        connection.execute(
            "REPLACE INTO node VALUES (?, ?, ?, ?, ?, ?)", (stretch, subject, name, t, revision, revision)
        )
    elif what == 1:  # a node is removed
        connection.execute("DELETE FROM attribute WHERE stretch = ? AND node = ?", (stretch, subject))
        connection.execute("DELETE FROM node WHERE stretch = ? AND name = ?", (stretch, subject))
    elif what == 5:  # an edge is removed
        connection.execute(
            "DELETE FROM edge WHERE stretch = ? AND source = ? AND relation = ? AND target = ?",
            (stretch, subject, name, value),
        )
    else:
        connection.execute(
            "INSERT INTO edge VALUES (?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO UPDATE SET "
            "attributes = excluded.attributes, t = excluded.t, revision = excluded.revision",
            (stretch, subject, name, value, attributes, t, revision, revision),
        )


def _forget(connection: sqlite3.Connection, stretch: int) -> None:
    for table in ("change", "node", "attribute", "edge"):
        connection.execute(f"DELETE FROM {table} WHERE stretch = ?", (stretch,))
    connection.execute("DELETE FROM stretch WHERE id = ?", (stretch,))


def _node_rows(stretch: int, base: State) -> Iterable[Row]:
    nodes = base.nodes()
    for place, name in enumerate(nodes, -len(nodes)):  # whatever comes later has its revision as its place
        stamp = base.stamp(name)
        yield stretch, to_sql(name), to_sql(base.kind(name)), stamp.t, stamp.revision, place


def _attribute_rows(stretch: int, base: State) -> Iterable[Row]:
    for name in base.nodes():
        for attribute, stamp in base.written(name).items():
            value = to_sql(plain(base.get(name, attribute)))
            yield stretch, to_sql(name), to_sql(attribute), value, stamp.t, stamp.revision


def _edge_rows(stretch: int, base: State) -> Iterable[Row]:
    edges = base.edges()
    for place, (source, relation, target) in enumerate(edges, -len(edges)):
        row = base.targets(source, relation)[target]
        known = {name: plain(value) for name, value in (base.edge(source, relation, target) or {}).items()}
        yield (
            stretch, to_sql(source), to_sql(relation), to_sql(target), row_to_sql(known), row["t"], row["revision"],
            place,
        )  # fmt: skip
