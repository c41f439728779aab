"""Files of a run: recording, summary, report, and logs of trees for Groot2."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from ..agent import Agent
from ..base.errors import RecordingError
from ..base.files import write_whole
from ..plan import TreePlan
from ..record import FolderLock, Recorder, Recording, RunHeader, Summary
from ..trees.btlog import BtLog

RECORDING, SUMMARY, REPORT = "run.mcap", "summary.json", "report.html"

ReportWriter = Callable[[Recording, Summary, Path], None]
"""Writes the report of a recording with its summary to an HTML file."""


class RunFiles:
    """Writer of the files of one run; if the disk is full only the affected files are lost.

    Args:
        folder: Folder of the files; None writes no files.

    Attributes:
        recorder: Recorder of events; None before `begin`, and if no files are written.
        missing: One sentence for each file that could not be written, with the reason.
    """

    def __init__(self, folder: Path | None) -> None:
        self.recorder: Recorder | None = None
        self.missing: list[str] = []
        self._folder = folder
        self._lock: FolderLock | None = None
        self._logs = ExitStack()

    def begin(self, header: RunHeader, logged: Sequence[Agent] = ()) -> None:
        """Remove the files of an earlier run and start the recording.

        Raises:
            InputError: Another run is writing in the folder.
            RecordingError: The recording, or a log, cannot be written.
            OSError: The folder, or a file in it, cannot be written.
        """
        if self._folder is None:
            return
        self._folder.mkdir(parents=True, exist_ok=True)
        self._lock = FolderLock(self._folder)
        # If this run is killed, the folder must not contain the summary of an earlier one.
        for old in (self._folder / SUMMARY, self._folder / REPORT, *self._folder.glob("*.btlog")):
            old.unlink(missing_ok=True)
        self.recorder = Recorder(self._folder / RECORDING, header)
        for agent in logged:
            if isinstance(agent.plan, TreePlan):
                self._logs.callback(BtLog(self._folder / f"{agent.name}.btlog", agent.plan.tree, agent.plan.name).close)

    def end(self, summary: Summary) -> None:
        """Close the recording with its summary, close the logs, and write summary.json."""
        if self._folder is None or self.recorder is None:
            return
        recorder, path, text = self.recorder, self._folder / SUMMARY, summary.to_json()
        self.attempt("a log of a tree", self._logs.close)
        self.attempt("the recording", lambda: recorder.close(summary))
        self.attempt(f"the summary '{path}'", lambda: write_whole(path, text))

    def abandon(self) -> None:
        """Close the recording and the logs without a summary; a second call does nothing."""
        self.attempt("a log of a tree", self._logs.close)
        if self.recorder is not None:
            self.attempt("the recording", self.recorder.close)

    def report(self, write: ReportWriter, summary: Summary) -> Path | None:
        """Write report.html from the recording; returns its path, or None if it cannot be written."""
        if self._folder is None:
            return None
        recording, path = self._folder / RECORDING, self._folder / REPORT
        written = self.attempt(f"the report '{path}'", lambda: write(Recording.open(recording), summary, path))
        return path if written else None

    def unlock(self) -> None:
        """Allow other runs to write in the folder."""
        if self._lock is not None:
            self._lock.close()

    @property
    def recording(self) -> Path | None:
        """Path of the recording; None without a recording."""
        return None if self.recorder is None else self.recorder.path

    @property
    def unfinished(self) -> str:
        """Message that names missing files of a run that ended early and the command to create them; else empty."""
        if self._folder is None or self.recorder is None:
            return ""
        lacks = [name for name in (SUMMARY, REPORT) if not (self._folder / name).exists()]
        if not lacks:
            return ""
        names, those = " and no ".join(lacks), "it" if len(lacks) == 1 else "both"
        return f"There is no {names}. To create {those}: rocs-bt report {shlex.quote(str(self._folder))}"

    def attempt(self, what: str, step: Callable[[], None]) -> bool:
        """Run a step of writing; if it fails, add the failure to `missing` and return False."""
        try:
            step()
        except RecordingError as error:
            self.missing.append(str(error))
        except OSError as error:
            self.missing.append(f"{what} cannot be written: {error.strerror}.")
        else:
            return True
        return False
