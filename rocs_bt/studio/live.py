"""LivePage: event sink in the run's process that feeds the live page."""

from __future__ import annotations

import contextlib
import math
import os
import secrets
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from types import TracebackType

from ..current_folder import safe_path
from ..errors import InputError
from ..event import Event
from ..record import RunHeader
from . import frames

RATE = 10.0
"""Rate of updates of browsers [Hz]."""

_PACKAGES = str(Path(__file__).resolve().parents[2])
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
        self._leaving = threading.Event()
        self._sender = threading.Thread(target=lambda: None)  # replaced when a run begins
        self._writing_since = math.inf  # [s] on the monotonic clock; infinite while nothing is being written
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> LivePage:
        paths = [_PACKAGES, *filter(None, [safe_path()["PYTHONPATH"]])]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", __package__],  # -P: import nothing from the current folder
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        )
        with _killed_after(_START, self._process):
            self._write(frames.encode(self._settings))
            answer = None if self._process.stdout is None else frames.read(self._process.stdout)
        found = frames.Answer(error="its process ended.") if answer is None else frames.decode(answer, frames.Answer)
        if found.error:
            self._end(self._process)
            raise InputError(f"cannot start the live page: {found.error}")
        host = self._settings.host
        self.url = f"http://{f'[{host}]' if ':' in host else host}:{found.port}/{self._settings.token}/"
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._leaving.set()
        if self._process is None:
            return
        if self._sender.ident is not None:
            self._sender.join(_GOODBYE)
            if self._sender.is_alive():  # blocked in a write to a stalled process; closing the pipe would block too
                self._process.kill()
                self._sender.join()
        self._end(self._process)

    def begin(self, header: RunHeader) -> None:
        """Start showing a run.

        Raises:
            InputError: The context was not entered, or the page has already shown a run.
        """
        if self._process is None or self._sender.ident is not None:
            raise InputError("a live page shows one run, inside its 'with' block.")
        args = (frames.encode(header),)
        self._sender = threading.Thread(target=self._send, args=args, name="live page", daemon=True)
        self._sender.start()

    def wait(self) -> bool:
        """Keep the page up until Ctrl-C.

        Returns:
            Whether Ctrl-C was pressed; False if the page's process ended or stalled.
        """
        try:
            while self._process is not None and time.monotonic() - self._writing_since < _PATIENCE:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self._process.wait(1.0 / RATE)
                    return False
        except KeyboardInterrupt:
            return True
        if self._process is not None:
            self._process.kill()
        return False

    def _send(self, header: bytes) -> None:
        connected, leaving = self._write(header), False
        while not leaving:
            leaving = self._leaving.wait(1.0 / RATE)
            batch = [self._waiting.popleft() for _ in range(len(self._waiting))]
            if (
                len(batch) == _BACKLOG and self._process is not None
            ):  # the oldest events were dropped, so the page would be wrong
                self._process.kill()
            elif batch and connected:
                connected = self._write(frames.encode_events(batch))

    def _write(self, frame: bytes) -> bool:
        process = self._process
        if process is None or process.stdin is None:
            return False
        self._writing_since = time.monotonic()
        try:
            process.stdin.write(frame)
            process.stdin.flush()
        except OSError:  # the page's process has ended; the run continues
            return False
        finally:
            self._writing_since = math.inf
        return True

    def _end(self, process: subprocess.Popen[bytes]) -> None:
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):  # the process may have ended before reading everything
                    pipe.close()
        try:
            process.wait(_GOODBYE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        self._process = None


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
