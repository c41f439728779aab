"""LivePage: the run's side of the live page, one more event sink."""

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

from ...errors import InputError
from ...event import Event
from ..header import RunHeader
from . import frames

RATE = 10.0
"""How often browsers hear news [Hz]."""

_PACKAGES = str(Path(__file__).resolve().parents[3])
_START = 60.0  # [s] within which the page's process must serve
_PATIENCE = 3.0  # [s] without reading anything, after which the page's process counts as stalled
_GOODBYE = 5.0  # [s] that the page's process has to take what is left, and again to end
_BACKLOG = 100_000  # events that may wait; a page that is further behind is given up, so its memory is bounded


class LivePage:
    """Shows a run in browsers while it goes on; a context manager, and an event sink.

        with LivePage() as page:
            print(page.url)
            rocs_bt.run("exp1", live=page)
            page.wait()

    `emit` only appends to a list. One thread sends what came ten times a second to a process of its own, which serves
    the page on loopback behind a token. A page that broke, stalled, or that nobody looks at never holds a run up:
    leaving takes at most some seconds, after which the page's process is killed.

    Args:
        port: Where it is served; 0 for any port that is free.
        host: The loopback address to serve on.

    Raises:
        InputError: On entering: the port is taken, or the host is no loopback address.

    Attributes:
        url: The page's address, with its token; empty until it is entered.
    """

    def __init__(self, port: int = 0, host: str = "127.0.0.1") -> None:
        self.url = ""
        self._settings = frames.Settings(host, port, secrets.token_urlsafe(16))
        self._waiting: deque[Event] = deque(maxlen=_BACKLOG)
        self.emit: Callable[[Event], None] = self._waiting.append
        self._leaving = threading.Event()
        self._sender = threading.Thread(target=lambda: None)  # until a run begins
        self._writing_since = math.inf  # [s] on the monotonic clock; infinite while nothing is being written
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> LivePage:
        paths = [_PACKAGES, *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", __package__],  # -P: nothing of the current folder is imported
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
            raise InputError(f"there is no live page: {found.error}")
        host = self._settings.host
        self.url = f"http://{f'[{host}]' if ':' in host else host}:{found.port}/{self._settings.token}/"
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._leaving.set()
        if self._process is None:
            return
        if self._sender.ident is not None:
            self._sender.join(_GOODBYE)
            if self._sender.is_alive():  # it writes to a process that reads no more; closing the pipe would wait too
                self._process.kill()
                self._sender.join()
        self._end(self._process)

    def begin(self, header: RunHeader) -> None:
        """The run begins.

        Raises:
            InputError: The page was not entered, or has shown a run already.
        """
        if self._process is None or self._sender.ident is not None:
            raise InputError("a live page shows one run, between entering and leaving it.")
        args = (frames.encode(header),)
        self._sender = threading.Thread(target=self._send, args=args, name="live page", daemon=True)
        self._sender.start()

    def wait(self) -> bool:
        """Keep the page up until a person interrupts.

        Returns:
            Whether a person interrupted; False if the page's process ended or stalled.
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
        heard, leaving = self._write(header), False
        while not leaving:
            leaving = self._leaving.wait(1.0 / RATE)
            batch = [self._waiting.popleft() for _ in range(len(self._waiting))]
            if len(batch) == _BACKLOG and self._process is not None:  # the oldest were lost: it would show nonsense
                self._process.kill()
            elif batch and heard:
                heard = self._write(frames.encode_events(batch))

    def _write(self, frame: bytes) -> bool:
        process = self._process
        if process is None or process.stdin is None:
            return False
        self._writing_since = time.monotonic()
        try:
            process.stdin.write(frame)
            process.stdin.flush()
        except OSError:  # the page's process is gone; the run goes on
            return False
        finally:
            self._writing_since = math.inf
        return True

    def _end(self, process: subprocess.Popen[bytes]) -> None:
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):  # what was not sent yet has nobody to go to
                    pipe.close()
        try:
            process.wait(_GOODBYE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        self._process = None


@contextlib.contextmanager
def _killed_after(seconds: float, process: subprocess.Popen[bytes]) -> Iterator[None]:
    """Kill a process if the block takes longer [s]: whatever waits for that process goes on then."""
    timer = threading.Timer(seconds, process.kill)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
