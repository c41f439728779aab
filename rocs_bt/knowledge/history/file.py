"""SQLite file of a journal: its tables, and opening, writing, compacting and reading.

Changes are stored in stretches. A stretch is a base state of one agent's graph and all changes that follow, with none
missing. A run has one stretch, or several if changes between them were lost.

The rows of a stretch in the table `change` are sorted by `place`. First come the changes that build the base state from
an empty graph; their places are at most the revision of the base state. Then come the later changes; the place of each
is its revision. Compaction extends the base state by the oldest later changes: it raises the revision of the base state
and deletes the rows that these changes supersede.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

from ...base.errors import RecordingError
from ...base.files import check_regular, is_file
from ...event import KnowledgeChanged
from ..schema import Schema
from .change_log import Stretch
from .state import State
from .values import dump, from_json, load, to_json

FORMAT = 2
_APPLICATION_ID = 0x726F6373  # "rocs", SQLite's application_id
#: Kinds of changes; the file contains the index in this tuple.
_WHAT = ("node added", "node removed", "attribute", "edge added", "edge changed", "edge removed")
_NUMBER = {what: number for number, what in enumerate(_WHAT)}
_STRETCHES = 64  # maximum number of stretches of one agent in a file, because each contains a whole base state
# Names and values are JSON texts.
_TABLES = """
CREATE TABLE IF NOT EXISTS stretch (
    id INTEGER PRIMARY KEY, run INTEGER NOT NULL, agent TEXT, label TEXT, revision INTEGER NOT NULL, t REAL NOT NULL
);
CREATE TABLE IF NOT EXISTS change (
    stretch INTEGER, place INTEGER, revision INTEGER NOT NULL, t REAL NOT NULL, what INTEGER NOT NULL,
    subject TEXT, name TEXT, value TEXT, attributes TEXT, PRIMARY KEY (stretch, place)
) WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS change_of ON change (stretch, subject, name);
"""
_DAMAGED = (sqlite3.Error, UnicodeDecodeError)  # the latter if SQLite's message quotes damaged text
_WAIT = 10.0  # [s] for another process that writes


def open_to_write(path: Path) -> sqlite3.Connection:
    """Open a journal for appending; it is created if missing. Use the connection from one thread at a time.

    Raises:
        RecordingError: The file is not a journal of rocs_bt, or cannot be written.
    """
    with _closed_on_fault(path, "written", str(path)) as connection:
        _check(connection, path, empty_is_valid=True)
        # A crash of the process loses nothing that was committed; a power failure may lose the newest commits.
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        if not connection.execute("PRAGMA application_id").fetchone()[0]:
            # Atomic: a process killed here leaves an empty file, which is initialised again.
            connection.executescript(
                f"BEGIN IMMEDIATE; {_TABLES} PRAGMA user_version = {FORMAT}; "
                f"PRAGMA application_id = {_APPLICATION_ID}; COMMIT;"
            )
    return connection


def open_to_read(path: Path) -> sqlite3.Connection:
    """Open a journal for reading, also while it is written. Use the connection from one thread at a time.

    Raises:
        RecordingError: There is no such file, or it is not a journal of rocs_bt.
    """
    if not is_file(path):
        raise RecordingError(f"there is no knowledge '{path}'. Write one: rocs-bt run SCENARIO --knowledge {path}")
    with _closed_on_fault(path, "read", f"{path.absolute().as_uri()}?mode=ro") as connection:
        _check(connection, path)
    return connection


# -- writing ----------------------------------------------------------------------------------------------------------


def next_run(connection: sqlite3.Connection) -> int:
    """An unused run number."""
    return 1 + int(connection.execute("SELECT coalesce(max(run), 0) FROM stretch").fetchone()[0])


def begin_stretch(connection: sqlite3.Connection, run: int, label: str, base: State) -> int:
    """Begin a stretch by writing its base state; returns the number of the stretch."""
    stretch = connection.execute(
        "INSERT INTO stretch (run, agent, label, revision, t) VALUES (?, ?, ?, ?, ?)",
        (run, dump(base.agent), dump(label), base.revision, base.t),
    ).lastrowid
    assert stretch is not None  # an INSERT returns one
    changes = list(base.changes())
    _insert(connection, stretch, enumerate(changes, -len(changes)))
    return stretch


def append(connection: sqlite3.Connection, stretch: int, changes: Iterable[KnowledgeChanged]) -> None:
    """Append changes to a stretch."""
    _insert(connection, stretch, ((change.revision, change) for change in changes))


def compact(connection: sqlite3.Connection, agent: str, keep: int) -> None:
    """Keep only the `keep` newest changes of an agent; older ones become part of the base of their stretch."""
    stretches = connection.execute(
        "SELECT id, revision FROM stretch WHERE agent IS ? ORDER BY id DESC", (dump(agent),)
    ).fetchall()
    left = keep
    for number, (stretch, base) in enumerate(stretches):
        last = connection.execute("SELECT max(place) FROM change WHERE stretch = ?", (stretch,)).fetchone()[0]
        count = max((base if last is None else last) - base, 0)  # revisions have no gaps
        if number and (left == 0 or number >= _STRETCHES):
            connection.execute("DELETE FROM change WHERE stretch = ?", (stretch,))
            connection.execute("DELETE FROM stretch WHERE id = ?", (stretch,))
        elif count > left:
            _fold(connection, stretch, base, last - left)
            count = left
        left = max(left - count, 0)


def _insert(connection: sqlite3.Connection, stretch: int, changes: Iterable[tuple[int, KnowledgeChanged]]) -> None:
    connection.executemany(
        "INSERT INTO change VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
        [
            (
                stretch,
                place,
                c.revision,
                c.t,
                _NUMBER[c.what],
                dump(c.subject),
                dump(c.name),
                dump(to_json(c.value)),
                dump({name: to_json(value) for name, value in c.attributes.items()}) if c.attributes else None,
            )
            for place, c in changes
        ],
    )


def _fold(connection: sqlite3.Connection, stretch: int, first: int, until: int) -> None:
    """Extend the base state of a stretch from revision `first` to `until`, and delete the superseded rows."""
    rows = connection.execute(
        "SELECT place, t, what, subject, name, value, attributes FROM change "
        "WHERE stretch = ? AND place > ? AND place <= ? ORDER BY place",
        (stretch, first, until),
    ).fetchall()
    for place, t, number, subject, name, value, attributes in rows:
        what, about = _WHAT[number], "WHERE stretch = ? AND subject = ?"
        edge = f"{about} AND name = ? AND value = ? AND what >= 3"
        if what == "attribute":
            connection.execute(
                f"DELETE FROM change {about} AND name = ? AND what = 2 AND place < ?", (stretch, subject, name, place)
            )
        elif what == "node removed":
            connection.execute(f"DELETE FROM change {about} AND what <= 2 AND place <= ?", (stretch, subject, place))
        elif what == "edge removed":
            connection.execute(f"DELETE FROM change {edge} AND place <= ?", (stretch, subject, name, value, place))
        elif what == "edge changed":  # the edge keeps its position among the others
            connection.execute(f"DELETE FROM change {edge} AND place = ?", (stretch, subject, name, value, place))
            connection.execute(
                f"UPDATE change SET revision = ?, t = ?, attributes = ? {edge} AND place < ?",
                (place, t, attributes, stretch, subject, name, value, place),
            )
    connection.execute("UPDATE stretch SET revision = ?, t = ? WHERE id = ?", (until, rows[-1][1], stretch))


# -- reading ----------------------------------------------------------------------------------------------------------


def read_runs(connection: sqlite3.Connection) -> list[tuple[int, str, str]]:
    """Number, agent and label of each run, oldest first."""
    rows = connection.execute("SELECT run, agent, label FROM stretch GROUP BY run, agent ORDER BY run, min(id)")
    return [(int(run), _name(agent), _name(label)) for run, agent, label in rows]


def read_stretches(
    connection: sqlite3.Connection, run: int, agent: str, schema: Schema, known: Iterable[Stretch] = ()
) -> Iterator[Stretch]:
    """The stretches of a run, oldest first, read in one transaction.

    Of the `known` stretches only new changes are read.
    """
    earlier = {stretch.id: stretch for stretch in known}
    connection.execute("BEGIN")
    try:
        for number, revision, t in connection.execute(
            "SELECT id, revision, t FROM stretch WHERE run = ? AND agent = ? ORDER BY id", (run, dump(agent))
        ).fetchall():
            before = earlier.get(number)
            if before is None or before.last < revision:
                base, changes = State(agent, schema), list[KnowledgeChanged]()
                for place, change in _read(connection, number, agent, None):
                    if place > revision:
                        changes.append(change)
                    else:
                        base.apply(change)
                base.t, base.revision = float(t), int(revision)
            else:
                count = revision - before.first
                base = before.base.copy() if count else before.base
                for change in before.changes[:count]:
                    base.apply(change)
                new = [change for _, change in _read(connection, number, agent, before.last)]
                changes = [*before.changes[count:], *new]
            yield Stretch(base, changes, number)
    finally:
        connection.execute("COMMIT")


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Convert the errors that a damaged file causes to a RecordingError."""
    try:
        yield
    except (sqlite3.Error, ValueError, TypeError, LookupError, AttributeError) as error:
        raise RecordingError(f"the knowledge '{path}' is damaged: {error}.") from error


def _read(
    connection: sqlite3.Connection, stretch: int, agent: str, since: int | None
) -> Iterator[tuple[int, KnowledgeChanged]]:
    """Read the changes of a stretch, each with its place; only those after the place `since`, unless it is None."""
    after = "" if since is None else f"AND place > {since:d}"
    for place, revision, t, what, subject, name, value, attributes in connection.execute(
        "SELECT place, revision, t, what, subject, name, value, attributes FROM change "
        f"WHERE stretch = ? {after} ORDER BY place",
        (stretch,),
    ):
        held = {} if attributes is None else {n: from_json(v) for n, v in load(attributes).items()}
        yield (
            place,
            KnowledgeChanged(
                t=float(t),
                agent=agent,
                what=_WHAT[what],
                subject=_name(subject),
                name=_name(name),
                value=from_json(load(value)),
                revision=int(revision),
                attributes=held,
            ),
        )


@lru_cache(4096)
def _name(stored: Any) -> str:
    name = load(stored)
    if not isinstance(name, str):
        raise ValueError(f"a name is {name!r:.80}")
    return name


@contextmanager
def _closed_on_fault(path: Path, done: str, address: str) -> Iterator[sqlite3.Connection]:
    """Context of a new connection, which is closed if a check of the file in the context fails."""
    connection = None
    try:
        check_regular(path)
        connection = sqlite3.connect(
            address, uri=address != str(path), timeout=_WAIT, isolation_level=None, check_same_thread=False
        )
        yield connection
    except (RecordingError, OSError, *_DAMAGED) as error:
        if connection is not None:
            connection.close()
        if isinstance(error, RecordingError):
            raise
        why = error.strerror if isinstance(error, OSError) else error
        raise RecordingError(f"the knowledge '{path}' cannot be {done}: {why}.") from error


def _check(connection: sqlite3.Connection, path: Path, empty_is_valid: bool = False) -> None:
    application = connection.execute("PRAGMA application_id").fetchone()[0]
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    tables = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    if application == 0 and tables == 0 and empty_is_valid:
        return
    if application != _APPLICATION_ID:
        found = "an empty database" if tables == 0 else "a database of another program"
        raise RecordingError(
            f"'{path}' is not a rocs_bt journal but {found}. Give a file that `run --knowledge` wrote."
        )
    if version != FORMAT:
        raise RecordingError(
            f"'{path}' has format {version}; this version of rocs_bt reads format {FORMAT}. Export it with the version "
            "that wrote it (rocs-bt knowledge export), then import the export (rocs-bt knowledge import)."
        )
