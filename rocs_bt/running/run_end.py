"""RunEnd: writes and closes all files of a run, however it ends: normally, by a signal or by a failure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ..record import Summary
from .options import RunOptions
from .run_files import ReportWriter, RunFiles
from .run_result import RunResult
from .stop_signals import EndedAtOnce, StopSignals


class RunEnd:
    """Handler of the end of one run: closes and writes all files.

        end = RunEnd(options, write_report)
        with end.guarded() as stack:  # callbacks of this stack run before the report is written
            end.listen()              # first: from here on a signal ends the run in order
            end.files.begin(header)
            end.attempt(play)         # an exception is raised after all files are written
            end.summarise(summary)
        return end.result()

    Args:
        options: Options of the run.
        write_report: Writes the report.

    Attributes:
        files: Files of the run.
        signals: Stop signals.
    """

    def __init__(self, options: RunOptions, write_report: ReportWriter) -> None:
        self.files = RunFiles(None if options.out is None else Path(options.out))
        self.signals = StopSignals() if options.signals is None else options.signals
        self._deliver = options.signals is None
        self._report = write_report if options.report else None
        self._last = ExitStack()
        self._summary: Summary | None = None
        self._failure: Exception | None = None
        self._page: Path | None = None

    @contextmanager
    def guarded(self) -> Iterator[ExitStack]:
        """Context that closes the files and writes the report, however the `with` block ends.

        Without a summary there is no report.

        Raises:
            EndedAtOnce: A second signal was received; its note names the missing files.
        """
        try:
            with self._last:
                self._last.callback(self.files.unlock)  # after the report
                try:
                    with ExitStack() as stack:
                        yield stack
                except Exception as error:  # such as a device that fails to close: the report is still written
                    if self._summary is None:
                        raise
                    self._failure = self._failure or error
                self._write_report()
        except EndedAtOnce as error:
            if text := self.files.unfinished:
                error.add_note(text)
            raise

    def listen(self) -> None:
        """Start to handle stop signals."""
        self._last.enter_context(self.signals)

    def attempt(self, play: Callable[[], object]) -> None:
        """Call a part of the run, and keep its exception; `result` raises the first exception kept."""
        try:
            play()
        except Exception as error:  # noqa: BLE001 - boundary: `result` raises it after all files are written
            self._failure = self._failure or error

    def summarise(self, summary: Summary) -> None:
        """Close the recording with its summary, and write summary.json."""
        self._summary = summary
        self.files.end(summary)

    def result(self) -> RunResult:
        """Result of the run; call it after the context `guarded` has been left.

        Raises:
            Exception: First exception of the run; its notes contain the result.
            KeyboardInterrupt: SIGINT ended the run.
        """
        if self._summary is None:
            raise RuntimeError("the run ended without a summary")
        result = RunResult(
            summary=self._summary,
            recording=self.files.recording,
            report=self._page,
            missing=tuple(self.files.missing),
        )
        if self._failure is not None:
            self._failure.add_note(f"{result}" + ("" if self._page is None else f"\nReport: {self._page}"))
            raise self._failure
        if self._deliver:
            self.signals.deliver()
        return result

    def _write_report(self) -> None:
        if self._summary is None or self._report is None:
            return
        try:
            self._page = self.files.report(self._report, self._summary)
        except Exception as error:  # noqa: BLE001 - a defect of the report must not lose the outcome
            self._failure = self._failure or error
