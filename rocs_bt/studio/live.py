"""LivePage: event sink in the run's process that feeds the page of a run, and takes the commands of its browsers."""

from __future__ import annotations

import contextlib
import math
import os
import secrets
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import IO

import msgspec

from ..base.current_folder import child_environment
from ..base.errors import InputError
from ..event import Event
from ..record import RunHeader
from ..running.run_command import RunCommand
from . import frames

RATE = 10.0
"""Rate of updates of browsers [Hz]."""

STUDIO = "ROCS_BT_STUDIO"
"""Environment variable of a run that the studio has started: number of its socket to the studio, and its URL."""

_START = 60.0  # [s] time limit for the start of the page's process
_PATIENCE = 3.0  # [s] duration of a blocked write after which the page's process counts as stalled
_GOODBYE = 5.0  # [s] time limit for the page's process to read the remaining events, and another one to end
_BACKLOG = 100_000  # maximum number of waiting events, to limit memory; with more, the page is abandoned


class LivePage:
    """Shows a running episode in browsers; a context manager and event sink.

        with LivePage() as page:
            print(page.url)
            rocs_bt.run("exp1", live=page)
            page.wait()

    `emit` only appends an event to a list. A thread sends new events at 10 Hz to a separate process. This process
    serves the page on loopback; the URL contains a secret token. A page that has failed or stalled never blocks the
    run. Leaving the context waits at most a few seconds for the page's process and then kills it.
    A run that the studio has started has the studio as its page, and talks with it on a socket that it inherits.

    Args:
        port: Port to serve on; 0 for any free port.
        host: Loopback address to serve on.

    Raises:
        InputError: On entering: the port is in use, or the host is no loopback address.

    Attributes:
        url: URL of the page with its token; empty before the context is entered.
    """

    def __init__(self, port: int = 0, host: str = "127.0.0.1") -> None:
        self.url = ""
        self._settings = frames.Settings(host, port, secrets.token_urlsafe(16))
        self._waiting: deque[Event] = deque(maxlen=_BACKLOG)
        self.emit: Callable[[Event], None] = self._waiting.append
        self._commands: deque[RunCommand] = deque()
        self._leaving = threading.Event()
        self._sender = threading.Thread(target=lambda: None)  # replaced when a run begins
        self._writing_since = math.inf  # [s] on the monotonic clock; infinite while nothing is being written
        self._process: subprocess.Popen[bytes] | None = None
        self._pipe: frames.Sender | None = None

    def __enter__(self) -> LivePage:
        place = os.environ.pop(STUDIO, "")  # not for the processes that this run starts
        commands = self._join_studio(place) if place else self._start()
        threading.Thread(target=self._listen, args=(commands,), name="live commands", daemon=True).start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._leaving.set()
        if self._sender.ident is not None:
            self._sender.join(_GOODBYE)
        if self._process is None:
            return
        if self._sender.is_alive():  # blocked in a write to a stalled process; closing the pipe would block too
            self._process.kill()
            self._sender.join()
        self._end(self._process)

    def begin(self, header: RunHeader) -> None:
        """Start showing a run.

        Raises:
            InputError: The context was not entered, or the page has already shown a run.
        """
        if self._pipe is None or self._sender.ident is not None:
            raise InputError("a live page shows one run, inside its 'with' block.")
        self._sender = threading.Thread(target=self._send, args=(header,), name="live page", daemon=True)
        self._sender.start()

    def take(self) -> list[RunCommand]:
        """Commands of the browsers since the last call, in order."""
        return [self._commands.popleft() for _ in range(len(self._commands))]

    def wait(self) -> bool:
        """Keep the page up until Ctrl-C; the page of the studio stays up by itself.

        Returns:
            Whether Ctrl-C was pressed; False if the page's process ended or stalled.
        """
        if self._process is None:
            return True
        try:
            while time.monotonic() - self._writing_since < _PATIENCE:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self._process.wait(1.0 / RATE)
                    return False
        except KeyboardInterrupt:
            return True
        self._process.kill()
        return False

    def _start(self) -> IO[bytes]:
        """Start the page's process; returns the stream of its commands."""
        self._process = process = subprocess.Popen(
            [sys.executable, "-P", "-m", __package__],  # -P: import nothing from the current folder
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=child_environment(),
        )
        if process.stdin is None or process.stdout is None:
            raise RuntimeError("the page's process has no pipes")
        self._pipe = frames.Sender(process.stdin)
        with _killed_after(_START, process):
            self._write(frames.encode(self._settings))
            answer = frames.read(process.stdout)
        found = (
            frames.PageReply(error="its process ended.") if answer is None else frames.decode(answer, frames.PageReply)
        )
        if found.error:
            self._end(process)
            raise InputError(f"cannot start the live page: {found.error}")
        self.url = found.url
        return process.stdout

    def _join_studio(self, place: str) -> IO[bytes]:
        """Take the socket to the studio, given by its number and the studio's URL; returns the stream of commands."""
        number, _, self.url = place.partition(" ")
        with socket.socket(fileno=int(number)) as end:
            end.set_inheritable(False)
            self._pipe = frames.Sender(end.makefile("wb"))
            return end.makefile("rb")

    def _listen(self, stream: IO[bytes]) -> None:
        """Take the commands of the browsers; a page that has gone must not keep a run paused."""
        with contextlib.suppress(OSError, ValueError, msgspec.MsgspecError):
            while (data := frames.read(stream)) is not None:
                self._commands.append(frames.decode(data, RunCommand))
        if not self._leaving.is_set():
            self._commands.append(RunCommand(kind="continue", by="the end of the page"))

    def _send(self, header: RunHeader) -> None:
        connected, leaving = self._write(frames.encode(header)), False
        while not leaving:
            leaving = self._leaving.wait(1.0 / RATE)
            batch = [self._waiting.popleft() for _ in range(len(self._waiting))]
            if len(batch) == _BACKLOG and connected:  # the oldest events were dropped, so the page would be wrong
                connected = False
                if self._process is not None:
                    self._process.kill()
            elif batch and connected:
                connected = self._write(frames.encode_events(batch))

    def _write(self, frame: bytes) -> bool:
        if self._pipe is None:
            return False
        self._writing_since = time.monotonic()
        sent = self._pipe.send(frame)
        self._writing_since = math.inf
        return sent  # if not, the page's process has ended; the run continues

    def _end(self, process: subprocess.Popen[bytes]) -> None:
        with contextlib.suppress(OSError):  # the process may have ended before reading everything
            if process.stdin is not None:
                process.stdin.close()
        try:
            process.wait(_GOODBYE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout is not None:
            process.stdout.close()
        self._process = self._pipe = None


@contextlib.contextmanager
def _killed_after(seconds: float, process: subprocess.Popen[bytes]) -> Iterator[None]:
    """Kill a process if the `with` block takes longer than `seconds`, so that nothing waits for ever."""
    timer = threading.Timer(seconds, process.kill)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
