"""The end of a run, however it comes: in order, by a signal, by a failure of the engine, on a full disk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..words import counted
from .run_files import RunFiles
from .stop_signals import EndedAtOnce, StopSignals


@dataclass(frozen=True)
class RunResult:
    """What a run left behind.

    Attributes:
        summary: Content of summary.json (docs/architecture.md).
        recording: Path of run.mcap; None if nothing was recorded.
        report: Path of report.html; None if none was written.
        missing: What could not be written, as on a full disk, and why; a sentence each.
    """

    summary: Mapping[str, Any]
    recording: Path | None = None
    report: Path | None = None
    missing: tuple[str, ...] = ()

    @property
    def success(self) -> bool:
        """Whether every agent succeeded."""
        return all(outcome == "success" for outcome in self.outcomes.values())

    @property
    def outcomes(self) -> dict[str, str]:
        """Each agent's outcome, by its name."""
        return {name: agent["outcome"] for name, agent in self.summary["agents"].items()}

    def __str__(self) -> str:
        summary = self.summary
        took = f"{summary['sim_time']:.1f} s {'simulated' if summary['simulated'] else 'driven'}"
        lines = [f"{summary['scenario']}, seed {summary['seed']}, {took}"]
        for name, agent in summary["agents"].items():
            reason = f": {agent['reason']}" if agent["reason"] else ""
            collisions = "" if agent["collisions"] is None else f"{counted(agent['collisions'], 'collision')}, "
            lines.append(
                f"{name} {agent['outcome']}{reason}; {agent['path_length']:.2f} m, {collisions}"
                f"{counted(agent['reflex_activations'], 'reflex', 'es')}, {counted(agent['replans'], 're-plan')}"
            )
            lines += [f"  fault at {fault}" for fault in agent["faults"]]
        return "\n".join([*lines, *self.missing])


class RunEnd:
    """Sees to the end of one run.

        end = RunEnd(out, report, signals)
        with end.guarded() as stack:  # what is pushed on it is closed before the report is written
            end.listen()              # first: from here on a signal ends the run in order
            end.files.begin(header)
            end.attempt(play)         # what it raises is kept until all files are written
            end.summarise(summary)
        return end.result()

    Args:
        out: Folder of the run's files; None for none.
        report: Whether a report is written.
        signals: Signals of a caller who looks at them afterwards; None to give them their usual effect in `result`.

    Attributes:
        files: The files.
        signals: The signals that end the run.
    """

    def __init__(self, out: Path | str | None, report: bool, signals: StopSignals | None) -> None:
        self.files = RunFiles(None if out is None else Path(out))
        self.signals = StopSignals() if signals is None else signals
        self._deliver = signals is None
        self._wanted = report
        self._last = ExitStack()
        self._summary: Mapping[str, Any] | None = None
        self._failure: Exception | None = None
        self._page: Path | None = None

    @contextmanager
    def guarded(self) -> Iterator[ExitStack]:
        """Whatever ends the block, its files are written; without a summary they are only closed.

        Raises:
            EndedAtOnce: A second signal came; it names the files that are missing.
        """
        try:
            with self._last:
                try:
                    with ExitStack() as stack:
                        yield stack
                except Exception as error:
                    if self._summary is None:
                        raise
                    self._failure = self._failure or error  # such as a device that does not let go
                self._write_report()
        except EndedAtOnce as error:
            if text := self.files.unfinished:
                error.add_note(text)
            raise

    def listen(self) -> None:
        """From now on signals end the run in order."""
        self._last.enter_context(self.signals)

    def attempt(self, play: Callable[[], object]) -> None:
        """Play the run; the first exception is raised again by `result`."""
        try:
            play()
        except Exception as error:  # noqa: BLE001 - the boundary: it is raised when all files are written
            self._failure = self._failure or error

    def summarise(self, summary: Mapping[str, Any]) -> None:
        """Close the recording with its summary, and write summary.json."""
        self._summary = summary
        self.files.end(summary)

    def result(self) -> RunResult:
        """The result, after `guarded`.

        Raises:
            Exception: What the run raised; its notes hold the result.
            KeyboardInterrupt: A signal ended the run whose usual effect that is.
        """
        result = RunResult(self._summary or {}, self.files.recording, self._page, tuple(self.files.missing))
        if self._failure is not None:
            self._failure.add_note(f"{result}" + ("" if self._page is None else f"\nReport: {self._page}"))
            raise self._failure
        if self._deliver:
            self.signals.deliver()
        return result

    def _write_report(self) -> None:
        if self._summary is None or not self._wanted:
            return
        try:
            self._page = self.files.report(self._summary)
        except Exception as error:  # noqa: BLE001 - a defect of the report must not lose the outcome
            self._failure = self._failure or error
