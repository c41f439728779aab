"""Single nodes and edges as they were at a revision, looked up in a journal's file by its indexes."""

from __future__ import annotations

import sqlite3
from collections.abc import Collection
from typing import Any, NamedTuple

from ...event import Value
from ..readable import Stamp
from .file import WHAT
from .reader import text
from .values import from_sql, row_from_sql, to_sql

# From each name to the next by the index, however many changes each has, and of each the newest change alone.
_NEWEST = """
WITH RECURSIVE each(name) AS (
    SELECT min(name) FROM change INDEXED BY change_of WHERE stretch = :stretch AND subject = :node
    UNION ALL
    SELECT (
        SELECT min(name) FROM change INDEXED BY change_of
        WHERE stretch = :stretch AND subject = :node AND name > each.name
    ) FROM each WHERE each.name IS NOT NULL
)
SELECT newest.name, newest.value, newest.t, newest.revision
FROM each JOIN change AS newest ON newest.stretch = :stretch AND newest.revision = (
    SELECT revision FROM change INDEXED BY change_of
    WHERE stretch = :stretch AND subject = :node AND name = each.name AND what = 2
    AND revision > :since AND revision <= :until ORDER BY revision DESC LIMIT 1
)
"""
_ADDED, _REMOVED = WHAT.index("edge added"), WHAT.index("edge removed")


class EdgeFound(NamedTuple):
    """An edge's attributes as they were written, and when."""

    attributes: dict[str, Value]
    stamp: Stamp


def first_revision(connection: sqlite3.Connection, stretch: int) -> int | None:
    """The oldest revision of which a stretch tells; None where it is gone."""
    row = connection.execute("SELECT revision FROM stretch WHERE id = ?", (stretch,)).fetchone()
    return None if row is None else int(row[0])


def kind_of(connection: sqlite3.Connection, stretch: int, until: int, node: str) -> tuple[str, Stamp, bool] | None:
    """A node's kind, when it was added or, from the base, written last, and whether it is from the base."""
    subject = to_sql(node)
    life = connection.execute(
        "SELECT what, name, t, revision FROM change INDEXED BY life_of "
        "WHERE stretch = ? AND subject = ? AND what <= 1 AND revision <= ? ORDER BY revision DESC LIMIT 1",
        (stretch, subject, until),
    ).fetchone()
    if life is not None:
        return None if life[0] else (text(life[1]), Stamp(life[2], life[3]), False)
    row = connection.execute(
        "SELECT kind, t, revision FROM node WHERE stretch = ? AND name = ?", (stretch, subject)
    ).fetchone()
    return None if row is None else (text(row[0]), Stamp(row[1], row[2]), True)


def written(
    connection: sqlite3.Connection, stretch: int, until: int, node: str, since: int | None
) -> dict[str, tuple[Value, Stamp]]:
    """What was written last to each attribute of a node, and when, from the base (None) or since a revision."""
    subject = to_sql(node)
    rows = connection.execute(_NEWEST, {"stretch": stretch, "node": subject, "since": since or 0, "until": until})
    newest = rows.fetchall()
    if since is None:
        base = connection.execute(
            "SELECT name, value, t, revision FROM attribute WHERE stretch = ? AND node = ?", (stretch, subject)
        )
        newest = [*base, *newest]
    return {text(name): (from_sql(value), Stamp(t, revision)) for name, value, t, revision in newest}


def edges(
    connection: sqlite3.Connection, stretch: int, until: int, node: str, relation: str, forward: bool
) -> dict[str, EdgeFound]:
    """The edges of a relation from a node, or to it, by their other end, as they were related."""
    here, there, by = ("source", "target", "") if forward else ("target", "source", "INDEXED BY edge_to ")
    told, other, index = ("subject", "value", "change_of") if forward else ("value", "subject", "change_to")
    asked = (stretch, to_sql(node), to_sql(relation))
    found = {}
    for end, attributes, t, revision in connection.execute(
        f"SELECT {there}, attributes, t, revision FROM edge {by}"
        f"WHERE stretch = ? AND {here} = ? AND relation = ? ORDER BY place",
        asked,
    ):
        found[text(end)] = EdgeFound(row_from_sql(attributes), Stamp(t, revision))
    for what, stored, attributes, t, revision in connection.execute(
        f"SELECT what, {other}, attributes, t, revision FROM change INDEXED BY {index} "
        f"WHERE stretch = ? AND {told} = ? AND name = ? AND what >= 3 AND revision <= ? ORDER BY revision",
        (*asked, until),
    ):
        end = text(stored)
        if what in (_ADDED, _REMOVED):  # one that is added comes last, wherever an older one stood
            found.pop(end, None)
        if what != _REMOVED:
            found[end] = EdgeFound(row_from_sql(attributes), Stamp(t, revision))
    return found


def names(connection: sqlite3.Connection, stretch: int, until: int, kinds: Collection[str] | None) -> list[str]:
    """The nodes of some kinds, or all, as they were added."""
    where, wanted = "", list[Any]()
    if kinds is not None:
        where, wanted = f" AND kind IN ({', '.join('?' * len(kinds))})", [to_sql(kind) for kind in kinds]
    base = connection.execute(f"SELECT name FROM node WHERE stretch = ?{where} ORDER BY place", (stretch, *wanted))
    found = dict.fromkeys(text(name) for (name,) in base)
    for stored, what, kind in connection.execute(
        "SELECT subject, what, name FROM change INDEXED BY life_of "
        "WHERE stretch = ? AND what <= 1 AND revision <= ? ORDER BY revision",
        (stretch, until),
    ):
        name = text(stored)
        found.pop(name, None)
        if not what and (kinds is None or text(kind) in kinds):
            found[name] = None
    return [*found]
