"""Stop signals: SIGINT (Ctrl-C), SIGTERM and SIGHUP as requests to end the run in order."""

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
    """Exception raised when a second signal is received before the run has ended in order."""

    def __init__(self, received: signal.Signals) -> None:
        self.signal = received
        super().__init__(f"ended at once by {received.name}")


class StopSignals:
    """Handler of the stop signals while its context is open, so that a run ends in order.

    The first signal is only recorded. The second raises EndedAtOnce in the main thread; from then on signals have their
    usual effect. A repeated SIGHUP does not count as a second signal, because a closing terminal may send it twice.
    Signals that the process ignores, as with `nohup` or in background jobs of a shell, stay ignored. Python allows
    signal handlers in the main thread only; in other threads the context has no effect.

    Args:
        notice: Text for stderr at the first signal; `{signal}` is replaced by the signal's name.

    Attributes:
        received: The first signal; None if none has been received.
    """

    def __init__(self, notice: str = "") -> None:
        self.received: signal.Signals | None = None
        self._notice = notice
        self._before: dict[signal.Signals, Any] = {}

    @property
    def reason(self) -> str:
        """Reason of the run's end, such as `SIGTERM ended the run`; empty before the first signal."""
        return "" if self.received is None else f"{self.received.name} ended the run"

    def deliver(self) -> None:
        """After the context, raise the recorded signal again with its usual effect; without a signal do nothing.

        Raises:
            KeyboardInterrupt: The signal was SIGINT, and Python's own handler is installed.
        """
        if self.received is not None:
            signal.raise_signal(self.received)

    def __enter__(self) -> StopSignals:
        if threading.current_thread() is threading.main_thread():
            for each in STOP_SIGNALS:
                # None: a handler that was not installed from Python and cannot be restored.
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
