"""Store: records of all played episodes in one SQLite file, with atomic writes."""

from __future__ import annotations

import json
import sqlite3
import weakref
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from ..base.errors import Fault, InputError
from ..base.files import check_regular, write_whole
from .key import computing
from .record import EpisodeRecord, decode_record, encode_record

FILE = "episodes.sqlite"
_WAIT = 60.0  # [s] timeout while another sweep writes to the same store
_TABLES = (
    "create table if not exists versions (id integer primary key, told text unique not null)",
    """create table if not exists episodes (
    key text primary key, planner text not null, family text not null, scene text not null, seed integer not null,
    outcome text not null, record text not null, wall real not null, cpu real not null,
    versions integer not null references versions (id)
) without rowid""",
)
_COLUMNS = ("key", "planner", "family", "scene", "seed", "outcome", "record", "wall", "cpu", "versions")
_PUT = "insert or replace into episodes values (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"


@dataclass(frozen=True)
class Cost:
    """Computation time of an episode. It is not part of the record because it differs between repetitions.

    Attributes:
        wall: Wall-clock time [s].
        cpu: CPU time [s].
    """

    wall: float
    cpu: float


class EpisodeStore:
    """Store of episodes by key; a context manager. Several sweeps may use one store at the same time.

    Args:
        folder: Folder of the file, created if missing; None for a store in memory.

    Raises:
        InputError: The file is damaged or not a store; every method may raise this too.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder
        database = ":memory:" if folder is None else str(folder / FILE)
        try:
            if folder is not None:
                folder.mkdir(parents=True, exist_ok=True)
                check_regular(folder / FILE)
            self._db = sqlite3.connect(database, timeout=_WAIT, isolation_level=None, check_same_thread=False)
            # A store in memory is closed with its sweep, by the thread that drops the last reference.
            self._end = weakref.finalize(self, self._db.close)
        except (OSError, sqlite3.Error) as error:
            raise InputError(self._fault(f"cannot be opened: {error}")) from error
        try:
            self._begin()
        except InputError:
            self.close()
            raise

    def _begin(self) -> None:
        self._do("pragma journal_mode = wal")
        self._do("pragma synchronous = normal")  # a power cut may lose the last episodes but not damage the file
        for statement in _TABLES:
            self._do(statement)
        if tuple(row[1] for row in self._do("pragma table_info(episodes)")) != _COLUMNS:
            raise InputError(self._fault("was made by another version of rocs_bt"))
        versions = json.dumps(dict(computing()), sort_keys=True)
        self._do("insert or ignore into versions (told) values (?)", (versions,))
        (self._versions,) = self._do("select id from versions where told = ?", (versions,)).fetchone()

    def _do(self, statement: str, values: tuple[Any, ...] = ()) -> sqlite3.Cursor:
        try:
            return self._db.execute(statement, values)
        except sqlite3.DatabaseError as error:
            raise InputError(self._fault(f"cannot be used: {error}")) from error

    def _fault(self, why: str) -> Fault:
        store = "the store in memory" if self.folder is None else f"the store {self.folder / FILE}"
        hint = "Choose another folder, or move this file away; its episodes are then played again."
        return Fault(f"{store} {why}.", hint=hint)

    def __enter__(self) -> EpisodeStore:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._end()

    def put(self, record: EpisodeRecord, cost: Cost) -> None:
        """Store an episode atomically."""
        r = record
        row = (r.key, r.planner, r.family, r.scene, r.seed, r.outcome, encode_record(r).decode(), cost.wall, cost.cpu)
        self._do(_PUT, (*row, self._versions))

    def get(self, key: str) -> EpisodeRecord | None:
        """Record of the episode with a key; None if it is not stored."""
        found = self._do("select record from episodes where key = ?", (key,)).fetchone()
        try:
            return None if found is None else decode_record(found[0])
        except msgspec.DecodeError as error:
            raise InputError(self._fault(f"holds a damaged record of the episode {key[:12]}...: {error}")) from error

    def outcome(self, key: str) -> str:
        """Outcome of the episode with a key; empty if it is not stored."""
        found = self._do("select outcome from episodes where key = ?", (key,)).fetchone()
        return "" if found is None else str(found[0])

    def records(self, keys: Iterable[str]) -> Iterator[EpisodeRecord]:
        """Records of the episodes with these keys, in this order; keys without a stored episode are skipped."""
        for key in keys:
            if (record := self.get(key)) is not None:
                yield record

    def all(self) -> list[EpisodeRecord]:
        """Records of all episodes."""
        return [*self.records(key for (key,) in self._do("select key from episodes").fetchall())]

    def cost(self, keys: Iterable[str]) -> Cost:
        """Total computation time of the stored episodes with these keys."""
        rows = [self._do("select wall, cpu from episodes where key = ?", (key,)).fetchone() for key in keys]
        return Cost(sum(row[0] for row in rows if row), sum(row[1] for row in rows if row))

    def export(self, file: Path, keys: Iterable[str] | None = None) -> int:
        """Write episodes as JSON lines, sorted by planner, family, scene and seed; returns their number.

        Args:
            file: Output file.
            keys: Keys of the episodes; all by default.
        """
        order = "order by planner, family, scene, seed, key"
        wanted = None if keys is None else set(keys)
        lines = [
            f"{text}\n"
            for key, text in self._do(f"select key, record from episodes {order}")
            if wanted is None or key in wanted
        ]
        write_whole(file, "".join(lines))
        return len(lines)

    def count(self) -> int:
        """Number of episodes."""
        (count,) = self._do("select count(*) from episodes").fetchone()
        return int(count)
