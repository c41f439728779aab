"""Runs of a project: their list, and each as a page, from its recording or while it goes on."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import msgspec

from ..base.errors import Fault, InputError, RecordingError, unknown
from ..base.files import is_file, read_bytes
from ..record import Recording, Summary
from ..record.file.folder_lock import writer_of
from .feed import Feed
from .pack import Json
from .report import KILLED, about_end, missing_of, packed_run
from .requests import Answer
from .site import PACKED

_GOES_ON = "The run goes on; this is its recording up to now."
_RECORDING, _SUMMARY = "run.mcap", "summary.json"
_MOST = 300  # runs of the list, the newest
_MOST_SUMMARY = 4_000_000  # [bytes]
_POLL = 0.25  # [s]
_FRESH = 5.0  # [s] since the last write, within which a run may go on where the system does not tell the writer
_KEPT = 6  # packed runs that are kept


class _Result(msgspec.Struct):
    outcome: str
    reason: str | None = None


class _Short(msgspec.Struct):
    """What the list needs of summary.json."""

    sim_time: float
    agents: dict[str, _Result]


class Runs:
    """Runs in a folder, and those that are given.

    Args:
        folder: Folder `runs` of the project; it may be missing.
        given: Run that was named on the command line; None for none.
    """

    def __init__(self, folder: Path, given: Path | None = None) -> None:
        self.folder = folder
        self._given = given
        self._lock = threading.Lock()
        self._rows: dict[tuple[str, int, int], Json] = {}
        self._packed: dict[tuple[str, int, int], bytes] = {}
        self._growing: dict[str, Feed] = {}
        self._live: dict[str, Feed] = {}

    def list(self) -> list[Json]:
        """The newest runs first: name, state, and what summary.json has."""
        found = sorted(((_time(folder / _RECORDING), name, folder) for name, folder in self._folders().items()))
        return [self._row(name, folder, t) for t, name, folder in reversed(found[-_MOST:])]

    def show(self, name: str, feed: Feed) -> None:
        """Show a run that this process has started by its feed, as long as it goes on."""
        with self._lock:
            self._live[name] = feed

    def head(self, name: str, *, whole: bool = False) -> Answer:
        """What a page needs first: a packed run, the head of one that goes on, or `null` before it has begun.

        With `whole`, a run that goes on is packed too, up to now.
        """
        if (live := self._live.get(name)) is not None:
            head = live.head()
            if not live.closed and not (whole and head != b"null"):
                return Answer(head)
            if live.closed and head == b"null":  # it ended before it began, or is an episode, which sends nothing
                with self._lock:
                    if name in self._folders() and self._live.get(name) is live:
                        del self._live[name]  # then the recording of this name is shown
                if missing := str((live.about or {}).get("missing", "")):
                    raise InputError(missing)
        file = self._folder(name) / _RECORDING
        if not whole and _grows(file):
            return Answer(self._follow(name, file).head())
        return Answer(self._pack(name, file), PACKED)

    def feed(self, name: str) -> Feed:
        """Feed of a run that goes on.

        Raises:
            InputError: The run does not go on.
        """
        feeds = [feed for known in (self._live, self._growing) if (feed := known.get(name)) is not None]
        if not feeds:
            raise InputError(Fault(f"the run '{name}' does not go on.", hint="Load the page again."))
        return min(feeds, key=lambda feed: feed.closed)  # another process may write a new run of this name

    def _folders(self) -> dict[str, Path]:
        """Folders of runs by name; links that lead out of the folder are left out."""
        inside = self.folder.resolve()
        folders = {path.parent.name: path.parent for path in self.folder.glob(f"*/{_RECORDING}")}
        kept = {name: at for name, at in folders.items() if (at / _RECORDING).resolve().is_relative_to(inside)}
        return kept if self._given is None else {**kept, self._given.name: self._given}

    def _folder(self, name: str) -> Path:
        folders = self._folders()
        if name not in folders:
            raise RecordingError(str(unknown("run", name, folders)))
        return folders[name]

    def _row(self, name: str, folder: Path, t: float) -> Json:
        row: Json = {"name": name, "t": t}
        summary = folder / _SUMMARY
        if ((live := self._live.get(name)) is not None and not live.closed) or (
            not is_file(summary) and _grows(folder / _RECORDING)
        ):
            return {**row, "state": "running"}
        try:
            stat = summary.stat()
            key = name, stat.st_mtime_ns, stat.st_size
            if key not in self._rows:
                self._rows[key] = _short(read_bytes(summary, _MOST_SUMMARY))
        except FileNotFoundError:
            return {**row, "state": "cut off"}
        except (OSError, msgspec.MsgspecError) as error:
            return {**row, "state": "damaged", "reason": f"summary.json cannot be read: {error}"}
        return {**row, "state": "over", **self._rows[key]}

    def _follow(self, name: str, file: Path) -> Feed:
        """Feed of a recording that another process writes."""
        with self._lock:
            feed = self._growing.get(name)
            if feed is None or feed.closed:
                feed = self._growing[name] = Feed()
                threading.Thread(target=_grow, args=(file, feed), name="growing run", daemon=True).start()
            return feed

    def _pack(self, name: str, file: Path) -> bytes:
        try:
            stat = file.stat()
        except OSError as error:
            raise RecordingError(f"the recording '{file}' cannot be read: {error.strerror}.") from error
        key = name, stat.st_mtime_ns, stat.st_size
        if key not in self._packed:
            end = _GOES_ON if _grows(file) else KILLED
            packed = packed_run(Recording.open(file), _summary(file.parent), end=end)
            with self._lock:
                self._packed[key] = packed
                while len(self._packed) > _KEPT:
                    del self._packed[next(iter(self._packed))]
        return self._packed[key]


def end_of(folder: Path) -> Json | None:
    """What the summary of a run adds to its page; None without a summary."""
    summary = _summary(folder)
    return None if summary is None else {"results": about_end(summary)}


def _grow(file: Path, feed: Feed) -> None:
    """Feed what a process writes into a recording, until it is complete or the process has ended."""
    while True:
        try:
            recording = Recording.open(file)
            break
        except RecordingError:  # its header is not written yet
            if not _grows(file):
                feed.close({"missing": "The run ended before its recording had a header."})
                return
            time.sleep(_POLL)
    feed.begin(recording.header, recording.fresh())
    going = True
    while going:
        going = _grows(file) and not recording.complete and not recording.damage
        if events := recording.fresh():
            feed.take(events)
        elif going:
            time.sleep(_POLL)
    feed.close({"missing": missing_of(recording, KILLED), **(end_of(file.parent) or {})})


def _grows(file: Path) -> bool:
    """Whether a process writes a recording."""
    if Path("/proc/locks").exists():
        return bool(writer_of(file.parent))
    return not is_file(file.parent / _SUMMARY) and time.time() - _time(file) < _FRESH


def _short(data: bytes) -> Json:
    short = msgspec.json.decode(data, type=_Short)
    outcomes = {name: result.outcome for name, result in short.agents.items()}
    alone = len(outcomes) == 1
    bad = (
        f"{'' if alone else f'{name}: '}{result.reason}"
        for name, result in short.agents.items()
        if result.outcome != "success"
    )
    return {"duration": short.sim_time, "outcomes": outcomes, "reason": next(bad, "")}


def _summary(folder: Path) -> Summary | None:
    try:
        return msgspec.json.decode(read_bytes(folder / _SUMMARY, _MOST_SUMMARY), type=Summary)
    except (OSError, msgspec.MsgspecError):
        return None


def _time(file: Path) -> float:
    try:
        return file.stat().st_mtime
    except OSError:
        return 0.0
