"""Signals that ask a process to end: SIGINT (Ctrl-C), SIGTERM and SIGHUP, taken as a request to end the run."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from types import FrameType
from typing import Any

STOP_SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that end a run; Windows has no SIGHUP."""


class EndedAtOnce(KeyboardInterrupt):
    """A second signal came before the run had ended in order.

    Attributes:
        signal: The second signal.
    """

    def __init__(self, received: signal.Signals) -> None:
        self.signal = received
        super().__init__(f"ended at once by {received.name}")


class StopSignals:
    """Takes the stop signals while its context is open, so that a run ends in order.

    The first signal is only noted. The second raises EndedAtOnce in the main thread; from then on signals have their
    usual effect. A terminal that closes may send SIGHUP twice, by its shell and by the kernel: after a SIGHUP another
    one is no second signal. Signals that the process ignores (`nohup`, a shell's background jobs) stay ignored.
    Python allows handlers in the main thread only; elsewhere the context changes nothing.

    Args:
        notice: Written to stderr at the first signal; `{signal}` in it becomes the signal's name.

    Attributes:
        received: The first signal; None before it.
    """

    def __init__(self, notice: str = "") -> None:
        self.received: signal.Signals | None = None
        self._notice = notice
        self._before: dict[signal.Signals, Any] = {}

    @property
    def reason(self) -> str:
        """Why the run ends, such as `SIGTERM ended the run`; empty before the first signal."""
        return "" if self.received is None else f"{self.received.name} ended the run"

    def deliver(self) -> None:
        """Give the signal that was noted its usual effect, after the context; nothing if there was none.

        Raises:
            KeyboardInterrupt: It was SIGINT, and Python's own handler is in place.
        """
        if self.received is not None:
            signal.raise_signal(self.received)

    def __enter__(self) -> StopSignals:
        if threading.current_thread() is threading.main_thread():
            for each in STOP_SIGNALS:
                # None: a handler that Python does not know, and could not put back.
                if signal.getsignal(each) not in (signal.SIG_IGN, None):
                    self._before[each] = signal.signal(each, self._take)
        return self

    def __exit__(self, *exc: object) -> None:
        for each, before in self._before.items():
            signal.signal(each, before)
        self._before.clear()

    def _take(self, number: int, frame: FrameType | None) -> None:
        received = signal.Signals(number)
        if self.received is None:
            self.received = received
            with contextlib.suppress(OSError):  # the terminal may be gone; a plain write may interrupt another one
                os.write(2, self._notice.format(signal=received.name).encode())
            return
        if self.received == received == getattr(signal, "SIGHUP", None):
            return
        self.__exit__()
        raise EndedAtOnce(received)
