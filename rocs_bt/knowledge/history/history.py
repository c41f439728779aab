"""History: the change log stored in a journal's file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from ...base.errors import InputError, KnowledgeError, RecordingError, unknown
from ..schema import SCHEMA, Schema
from .change_log import ChangeLog
from .file import open_to_read, read_runs, read_stretches, reading


@dataclass(frozen=True)
class RunEntry:
    """Run in a journal's file: its number, its agent, and a human-readable label."""

    number: int
    agent: str
    label: str


class History(ChangeLog):
    """Change log of one agent over one run, read from a journal's file; a context manager.

    Args:
        path: File that a `Journal` wrote, or is still writing.
        agent: Agent that owns the knowledge to read; may be omitted if the run has only one agent.
        run: Number of the run; the newest of that agent if omitted.
        schema: Types of the values; the schema of the project that wrote the file.

    Attributes:
        entry: Number, agent and label of the run.

    Raises:
        RecordingError: There is no such file, or it is damaged.
        InputError: No such agent or run; lists what exists.
    """

    def __init__(
        self, path: Path | str, agent: str | None = None, run: int | None = None, schema: Schema = SCHEMA
    ) -> None:
        self.path = Path(path)
        self._connection = open_to_read(self.path)
        try:
            self.entry = self._chosen(agent, run)
            super().__init__(self.entry.agent, self.entry.label, schema)
            self.refresh()
        except (InputError, RecordingError):
            self._connection.close()
            raise

    @staticmethod
    def runs(path: Path | str) -> list[RunEntry]:
        """All runs in a file, of all agents, oldest first.

        Raises:
            RecordingError: There is no such file, or it is damaged.
        """
        connection = open_to_read(Path(path))
        try:
            with reading(Path(path)):
                return [RunEntry(*row) for row in read_runs(connection)]
        finally:
            connection.close()

    def refresh(self) -> None:
        """Read the changes written since the last read, for a journal that is still being written.

        Raises:
            RecordingError: The file is damaged.
            KnowledgeError: The run has been deleted to make room for newer ones.
        """
        with reading(self.path):
            stretches = read_stretches(self._connection, self.entry.number, self.agent, self.schema, self.stretches)
            self.stretches = tuple(stretches)
        if not self.stretches:
            raise KnowledgeError(f"run {self.entry.number} of '{self.path}' is no longer kept.")

    def close(self) -> None:
        """Close the file; data that was read remains available."""
        self._connection.close()

    def __enter__(self) -> History:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _chosen(self, agent: str | None, run: int | None) -> RunEntry:
        with reading(self.path):
            entries = [RunEntry(*row) for row in read_runs(self._connection)]
        if agent is not None and agent not in (agents := list(dict.fromkeys(e.agent for e in entries))):
            raise InputError(unknown("agent", agent, agents, f"'{self.path}'"))
        entries = [e for e in entries if agent in (None, e.agent)]
        newest = entries[-1].number if entries else None
        found = [e for e in entries if e.number == (newest if run is None else run)]
        if not found:
            there = ", ".join(f"{e.number} ({e.label})" for e in entries) or "none"
            raise InputError(f"there is no run {'' if run is None else run} in '{self.path}'. It has: {there}.")
        if len(found) > 1:
            agents = [e.agent for e in found]
            raise InputError(f"'{self.path}' holds the knowledge of {', '.join(agents)}. Name one of them.")
        return found[0]
