"""Runs that the studio starts: each is `rocs-bt run --live` in a process of its own, with the studio as its page."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Literal

import msgspec

from ..base.current_folder import child_environment
from ..base.errors import Fault, InputError, unknown
from ..base.files import is_file
from ..catalog import Catalog
from ..compare.record import EpisodeRecord
from ..compare.replay import episode_folder
from ..compare.store import FILE, EpisodeStore
from ..record.file.folder_lock import free_folder, writer_of
from ..running.run_command import RunCommand
from . import frames
from .feed import Feed
from .live import STUDIO
from .runs import Runs, end_of

_LINES = 200  # of the output of a run that are kept
_WIDE = 1000  # [bytes] of a line of the output; a longer one becomes several
_REST = 2.0  # [s] for the rest of the data and of the output after the end of a process
_GOODBYE = 10.0  # [s] for the runs to write their files when the studio ends


class Start(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A run that a person wants.

    Attributes:
        scenario: Name of the scenario.
        seed: Seed of the run.
        mode: Mode of the run.
        duration: Maximum duration [s]; None for that of the scenario.
        watch_rules: Whether to reload rule files that change.
    """

    scenario: str
    seed: int = 1
    mode: Literal["lockstep", "threaded"] = "lockstep"
    duration: float | None = None
    watch_rules: bool = False

    @property
    def folder(self) -> str:
        """Name of the folder of the run."""
        return f"{self.scenario}-{self.seed}"

    def arguments(self) -> list[str]:
        """Arguments of `rocs-bt`."""
        given = ["run", self.scenario, f"--seed={self.seed}", f"--mode={self.mode}", "--live"]
        given += [] if self.duration is None else [f"--for={self.duration:g}"]
        return [*given, *(["--watch-rules"] if self.watch_rules else [])]


class Play(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An episode of a comparison that a person wants to see."""

    planner: str
    scene: str
    seed: int

    @property
    def folder(self) -> str:
        """Name of the folder of the run."""
        return episode_folder(self.planner, self.scene, self.seed).name

    def arguments(self) -> list[str]:
        """Arguments of `rocs-bt`."""
        return ["run", self.scene, f"--planner={self.planner}", f"--seed={self.seed}"]


def stored_episodes(runs: Path) -> dict[Play, EpisodeRecord]:
    """Episodes that comparisons of the project have stored, sorted by scene and seed."""
    folder = runs / "compare"
    if not is_file(folder / FILE):
        return {}
    with EpisodeStore(folder) as store:
        found = {Play(each.planner, each.scene, each.seed): each for each in store.all()}
    return dict(sorted(found.items(), key=lambda item: (item[0].scene, item[0].seed, item[0].planner)))


class Launcher:
    """Starts runs of a project, passes commands to them, and ends them."""

    def __init__(self, catalog: Catalog, runs: Runs, url: str) -> None:
        self._catalog = catalog
        self._runs = runs
        self._url = url
        self._children: dict[str, _Child] = {}
        self._lock = threading.Lock()

    def start(self, wanted: Start) -> str:
        """Start a run; returns its name.

        Raises:
            InputError: There is no such scenario, a value is not possible, or the run's folder has links.
        """
        scenarios = {entry.name for entry in self._catalog.fresh().list("scenario")}
        if wanted.scenario not in scenarios:
            raise InputError(unknown("scenario", wanted.scenario, scenarios))
        if wanted.seed < 0:
            raise InputError(f"a seed is 0 or more, found {wanted.seed}.")
        return self._started(wanted)

    def play(self, wanted: Play) -> str:
        """Play an episode that a comparison has stored; returns the name of its run.

        Raises:
            InputError: There is no such episode, or the run's folder has links.
        """
        if wanted not in stored_episodes(self._runs.folder):
            raise InputError(f"no episode of {wanted.planner} in {wanted.scene} with seed {wanted.seed} is stored.")
        return self._started(wanted)

    def _started(self, wanted: Start | Play) -> str:
        with self._lock:
            folder = self._folder(wanted.folder)
            arguments = [*wanted.arguments(), f"--out={folder}", *([] if self._catalog.code else ["--no-code"])]
            child = self._children[folder.name] = _Child(arguments, folder, self._url, self._place)
        self._runs.show(folder.name, child.feed)
        return folder.name

    def control(self, name: str, command: RunCommand) -> None:
        """Pass a command to a run.

        Raises:
            InputError: The run was not started here, or is over.
        """
        self._child(name).send(command)

    def output(self, name: str) -> str:
        """Last lines that a run which was started here has printed; empty for another run."""
        child = self._children.get(name)
        return "" if child is None else child.output

    def stop(self, name: str) -> None:
        """End a run in order, as Ctrl-C does; the second time it ends at once.

        Raises:
            InputError: The run was not started here, or is over.
        """
        self._child(name).stop()

    def end(self) -> None:
        """End all runs in order."""
        going = [child for child in self._children.values() if not child.over]
        for child in going:
            child.stop()
        for child in going:
            child.wait(_GOODBYE)

    @property
    def _place(self) -> Path:
        return self._runs.folder.parent

    def _child(self, name: str) -> _Child:
        child = self._children.get(name)
        if child is None or child.over:
            hint = "Only runs that were started here, and that go on, can be controlled."
            raise InputError(Fault(f"the run '{name}' cannot be controlled.", hint=hint))
        return child

    def _folder(self, name: str) -> Path:
        """Folder of a run; one in which no other run writes."""
        folder, child = self._runs.folder / name, self._children.get(name)
        busy = (child is not None and not child.over) or (folder.exists() and writer_of(folder))
        return _unlinked(free_folder(folder) if busy else folder, self._runs.folder)


def _unlinked(folder: Path, runs: Path) -> Path:
    """Folder for a run, checked: the run's files stay in the folder of the runs and replace nothing outside."""
    links = [folder] if not folder.resolve().is_relative_to(runs.resolve()) else []
    links += [path for path in sorted(folder.iterdir()) if path.is_symlink()] if folder.is_dir() else []
    if links:
        message = f"the run cannot write to '{folder}': '{links[0]}' is a link, which leads to '{links[0].resolve()}'."
        raise InputError(Fault(message, hint="Remove the link, or choose another seed."))
    return folder


class _Child:
    """Process of a run.

    It gets a socket of its own to the studio, since content may print to standard output at any time.
    """

    def __init__(self, arguments: Sequence[str], folder: Path, url: str, place: Path) -> None:
        self.feed = Feed(control=True)
        self._folder = folder
        self._printed: deque[tuple[bool, str]] = deque(maxlen=_LINES)  # whether to standard error, and a line
        self._over = threading.Event()
        self._socket, theirs = socket.socketpair()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "rocs_bt", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                cwd=place,
                pass_fds=[theirs.fileno()],
                env={**child_environment(), STUDIO: f"{theirs.fileno()} {url}"},
                start_new_session=True,  # Ctrl-C is for the studio, which then ends its runs in order
            )
        self._commands = frames.Sender(self._socket.makefile("wb"))
        self._reader = threading.Thread(target=self._read, name="run", daemon=True)
        self._reader.start()

    @property
    def over(self) -> bool:
        """Whether the run is over."""
        return self.feed.closed

    @property
    def output(self) -> str:
        """Last lines that the run, its content and the processes that they have started have printed."""
        return "\n".join(line for _, line in list(self._printed))

    def send(self, command: RunCommand) -> None:
        """Pass a command to the run."""
        self._commands.send(frames.encode(command))

    def stop(self) -> None:
        """Ask the run to end."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)

    def wait(self, seconds: float) -> None:
        """Wait until the run has written its files; then it is killed."""
        self._reader.join(seconds)
        if self._reader.is_alive():
            self._process.kill()
            self._reader.join()

    def _read(self) -> None:
        """Feed what the run sends until it ends; the feed ends with it, also after data that cannot be read."""
        missing = "the studio cannot read the data of the run."
        try:
            missing = self._receive()
        finally:
            self.feed.close({"missing": missing, **(end_of(self._folder) or {})})

    def _receive(self) -> str:
        """Feed what the run sends until it has ended; returns why the page is not complete, empty if it is."""
        process, wrong = self._process, ""
        talk = [threading.Thread(target=self._listen, args=(error,), daemon=True) for error in (False, True)]
        for thread in (*talk, threading.Thread(target=self._part, daemon=True)):
            thread.start()
        try:
            with self._socket.makefile("rb") as stream:
                frames.receive(stream, self.feed)
        except Exception as error:  # noqa: BLE001 - boundary: a run may send anything
            wrong = f"the studio cannot read the data of the run, and has ended it: {error}"
            self.stop()
        code = process.wait()
        self._over.set()
        self._socket.close()
        for thread in talk:
            thread.join(_REST)
        said = "\n".join(line for error, line in list(self._printed) if error)
        return wrong or ("" if code in (0, 1) else said or f"the run ended with exit code {code}.")

    def _part(self) -> None:
        """End the data with the process: one that it has started may hold the socket open."""
        self._process.wait()
        if not self._over.wait(_REST):
            with suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)

    def _listen(self, error: bool) -> None:
        """Keep the last lines that are printed, so that no process waits for a reader."""
        stream = self._process.stderr if error else self._process.stdout
        if stream is not None:
            with stream:
                while line := stream.readline(_WIDE):
                    self._printed.append((error, line.decode("utf-8", "replace").rstrip("\r\n")))
