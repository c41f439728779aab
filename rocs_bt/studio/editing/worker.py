"""Worker: answers questions about texts in processes of its own, so that content cannot hold up or end an editor."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import CancelledError, Future
from typing import Any, ParamSpec, TypeVar

from ...base.errors import Fault, InputError
from ...base.python_content import has_changed_content
from ...compare.pool import EXIT_TIMEOUT, WorkerDied, WorkerPool

P = ParamSpec("P")
T = TypeVar("T")

LIMIT = 10.0
"""Time limit of an answer [s]."""


class Superseded(InputError):
    """A newer question about the same text has replaced this one."""


class Worker:
    """Two processes that answer questions: one for checks, which may be slow, and one for all others.

    A process that has loaded a Python file which has changed since is replaced.

    Args:
        limit: Time limit of an answer [s].
    """

    def __init__(self, limit: float = LIMIT) -> None:
        self._limit = limit
        self._pools = WorkerPool(1), WorkerPool(1)
        self._lock = threading.Lock()
        self._newest: dict[Hashable, Future[Any]] = {}

    def ask(self, key: Hashable, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a function in a process, and wait for its result.

        Args:
            key: Questions with the same key replace those that have not begun.
            function: Function to call, with values that can be pickled; one named `faults` or `look` is a check.
            args: Its arguments.
            kwargs: Its named arguments.

        Raises:
            Superseded: A newer question with this key has come.
            InputError: The function raised it, or took longer than the limit, or ended its process.
        """
        pool = self._pools[function.__name__ in ("faults", "look")]
        with self._lock:
            if (older := self._newest.get(key)) is not None:
                older.cancel()
            future = self._newest[key] = pool.submit(_answer, self._limit, function, args, kwargs)
        try:
            result: T = future.result()
            return result
        except CancelledError:
            raise Superseded("a newer text is checked.") from None
        except WorkerDied as error:
            raise InputError(self._reason(error)) from error
        finally:
            with self._lock:
                if self._newest.get(key) is future:
                    del self._newest[key]

    def close(self) -> None:
        """End the processes."""
        for pool in self._pools:
            pool.shutdown(cancel_futures=True)

    def _reason(self, error: WorkerDied) -> Fault:
        if error.exit_code == EXIT_TIMEOUT:
            message = f"the check of this text took longer than {self._limit:g} s and was stopped."
            return Fault(message, hint="The next change starts it again; rocs-bt check has no limit.")
        code = error.exit_code
        return Fault(f"a Python file of the project ended the process of the check (exit code {code}).")


def _answer(limit: float, function: Callable[..., T], args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> T:
    """Answer a question in the worker's process."""
    if has_changed_content():
        os._exit(0)  # the pool asks again, in a new process
    # The default action for this signal ends the process at once and in silence, whatever holds the interpreter.
    signal.setitimer(signal.ITIMER_REAL, limit)
    try:
        return function(*args, **kwargs)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
