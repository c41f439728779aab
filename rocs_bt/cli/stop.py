"""SIGINT, SIGTERM and SIGHUP end a command as an exception, so that no half file and no child process remains."""

from __future__ import annotations

import os
import signal
import socket
import threading
from types import FrameType

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
PATIENCE = 0.8
"""Time after which a command that is in a library, such as one waiting for a locked database, ends at once [s]."""

_raised = threading.Event()


class Ended(KeyboardInterrupt):
    """Exception by which a signal ends a command."""

    def __init__(self, received: signal.Signals) -> None:
        self.signal = received
        super().__init__("" if received == signal.SIGINT else f"ended by {received.name}.")


def end_by_signals() -> None:
    """Install the handlers in this process; signals that it ignores, as with `nohup`, stay ignored."""
    for each in SIGNALS:
        if signal.getsignal(each) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(each, _end)
    ours, theirs = socket.socketpair()
    theirs.setblocking(False)
    signal.set_wakeup_fd(theirs.detach(), warn_on_full_buffer=False)
    os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
    threading.Thread(target=_watch, args=(ours,), name="signals", daemon=True).start()


def _end(number: int, frame: FrameType | None) -> None:
    _raised.set()
    raise Ended(signal.Signals(number))


def _watch(received: socket.socket) -> None:
    """End the process if the main thread, which may be inside a library, does not raise the exception."""
    while number := received.recv(1):
        # A run installs its own handlers, which end it in order.
        if signal.getsignal(number[0]) is _end and not _raised.wait(PATIENCE) and signal.getsignal(number[0]) is _end:
            os._exit(128 + number[0])
