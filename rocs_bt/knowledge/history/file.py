"""The SQLite file of a journal: its tables, and how it is opened.

A `stretch` is an unbroken run of changes of one agent after a base. The base is the state at the stretch's `revision`,
as rows of `node`, `attribute` and `edge`; the changes after it are rows of `change`, revision after revision. A run is
one stretch, or several where changes between them could not be kept. Compaction moves the oldest changes into the base.
"""

from __future__ import annotations

import sqlite3
from pathlib import Path

from ...errors import RecordingError

FORMAT = 1
_OURS = 0x726F6373  # "rocs", SQLite's application_id
#: The kinds of a change, whose place in the list is their number in the file.
WHAT = ("node added", "node removed", "attribute", "edge added", "edge changed", "edge removed")
_TABLES = """
CREATE TABLE IF NOT EXISTS stretch (
    id INTEGER PRIMARY KEY, run INTEGER NOT NULL, agent, label, revision INTEGER NOT NULL, t REAL NOT NULL
);
CREATE TABLE IF NOT EXISTS change (
    stretch INTEGER, revision INTEGER, t REAL NOT NULL, what INTEGER NOT NULL, subject, name, value, attributes,
    PRIMARY KEY (stretch, revision)
) WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS change_of ON change (stretch, subject, name);
CREATE INDEX IF NOT EXISTS life_of ON change (stretch, subject) WHERE what <= 1;
CREATE INDEX IF NOT EXISTS change_to ON change (stretch, value, name) WHERE what >= 3;
CREATE TABLE IF NOT EXISTS node (
    stretch INTEGER, name, kind, t REAL NOT NULL, revision INTEGER NOT NULL, place INTEGER NOT NULL,
    PRIMARY KEY (stretch, name)
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS attribute (
    stretch INTEGER, node, name, value, t REAL NOT NULL, revision INTEGER NOT NULL,
    PRIMARY KEY (stretch, node, name)
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS edge (
    stretch INTEGER, source, relation, target, attributes, t REAL NOT NULL, revision INTEGER NOT NULL,
    place INTEGER NOT NULL, PRIMARY KEY (stretch, source, relation, target)
) WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS edge_to ON edge (stretch, target, relation);
"""
_DAMAGED = (sqlite3.Error, UnicodeDecodeError)  # the latter where what SQLite says quotes damaged text
_WAIT = 10.0  # [s] for another process that writes


def open_to_write(path: Path) -> sqlite3.Connection:
    """Open a journal to add to it; it is made where there is none. Its threads must take turns.

    Raises:
        RecordingError: It is no journal of ours, or cannot be written.
    """
    try:
        connection = sqlite3.connect(path, timeout=_WAIT, isolation_level=None, check_same_thread=False)
    except sqlite3.Error as error:
        raise RecordingError(f"the knowledge '{path}' cannot be written: {error}.") from error
    try:
        _check(connection, path, empty_is_ours=True)
        # After a crash of the process nothing that was committed is lost; after a power cut the newest may be.
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        if not connection.execute("PRAGMA application_id").fetchone()[0]:
            _make(connection)
    except _DAMAGED as error:
        connection.close()
        raise RecordingError(f"the knowledge '{path}' cannot be written: {error}.") from error
    except RecordingError:
        connection.close()
        raise
    return connection


def open_to_read(path: Path) -> sqlite3.Connection:
    """Open a journal to read it, while it is written or not. Its threads must take turns.

    Raises:
        RecordingError: There is none, or it is no journal of ours.
    """
    if not path.is_file():
        raise RecordingError(f"there is no knowledge '{path}'. Write one: rocs-bt run SCENARIO --knowledge {path}")
    try:
        connection = sqlite3.connect(
            f"{path.absolute().as_uri()}?mode=ro",
            uri=True,
            timeout=_WAIT,
            isolation_level=None,
            check_same_thread=False,
        )
    except sqlite3.Error as error:
        raise RecordingError(f"the knowledge '{path}' cannot be read: {error}.") from error
    try:
        _check(connection, path)
    except (RecordingError, *_DAMAGED) as error:
        connection.close()
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"the knowledge '{path}' cannot be read: {error}.") from error
    return connection


def _make(connection: sqlite3.Connection) -> None:
    """All or nothing: a process that is killed here leaves an empty file, which is made again."""
    connection.executescript(
        f"BEGIN IMMEDIATE; {_TABLES} PRAGMA user_version = {FORMAT}; PRAGMA application_id = {_OURS}; COMMIT;"
    )


def _check(connection: sqlite3.Connection, path: Path, empty_is_ours: bool = False) -> None:
    ours = connection.execute("PRAGMA application_id").fetchone()[0]
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    tables = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    if ours == 0 and tables == 0 and empty_is_ours:
        return
    if ours != _OURS:
        found = "it is an empty database" if tables == 0 else "it is a database of something else"
        raise RecordingError(f"'{path}' is no knowledge of ours: {found}. Give a file that `run --knowledge` wrote.")
    if version != FORMAT:
        raise RecordingError(f"'{path}' has format {version}; this version of rocs_bt reads format {FORMAT}.")
