"""WorkerPool: local processes as a `concurrent.futures.Executor` that replaces processes that die."""

from __future__ import annotations

import functools
import multiprocessing
import os
import pickle
import queue
import signal
import tempfile
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, ParamSpec, TypeVar

from ..base.current_folder import environment, safe_path
from ..base.errors import RocsError

P = ParamSpec("P")
T = TypeVar("T")

EXIT_TIMEOUT = -signal.SIGALRM
"""Exit code of a process that ended because its task exceeded the wall limit; the task is not tried again."""

_THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
_TRIES = 2  # of a task if its process dies
_starting = threading.Lock()


class WorkerDied(RocsError):
    """Every attempt at a task ended with the death of the worker process, or one attempt exceeded the wall limit.

    Attributes:
        exit_code: Exit code of the last process; negative for a signal.
    """

    def __init__(self, exit_code: int | None) -> None:
        self.exit_code = exit_code
        why = (
            "it took longer than the wall limit"
            if exit_code == EXIT_TIMEOUT
            else f"its process died (exit code {exit_code})"
        )
        super().__init__(why)

    def __reduce__(self) -> tuple[Any, ...]:
        return WorkerDied, (self.exit_code,)


class WorkerPool(Executor):
    """Pool of worker processes. A process that dies is replaced, and its task is tried again in a new process.

    A task that exceeds its wall limit would do so again, and is not tried again.

    The standard `ProcessPoolExecutor`, in contrast, becomes unusable when one process dies, and cannot end a process
    that hangs.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._tasks: queue.SimpleQueue[tuple[Future[Any], bytes] | None] = queue.SimpleQueue()
        self._closed = threading.Event()
        self._cancelled = threading.Event()
        self._scratch = tempfile.TemporaryDirectory(prefix="rocs_bt-", ignore_cleanup_errors=True)
        self._slots = [_Slot(f"rocs_bt worker {number}", self._scratch.name) for number in range(workers)]
        self._threads = [threading.Thread(target=self._serve, args=(slot,), daemon=True) for slot in self._slots]
        for thread in self._threads:
            thread.start()

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Queue a task.

        Raises:
            RuntimeError: The pool is shut down.
        """
        if self._closed.is_set():
            raise RuntimeError("the pool is shut down and accepts no tasks.")
        future: Future[T] = Future()
        self._tasks.put((future, pickle.dumps((fn, args, kwargs))))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when all tasks are done; with `cancel_futures` kill them now."""
        if cancel_futures:
            self._cancelled.set()
            for slot in self._slots:
                slot.kill()
        if not self._closed.is_set():
            self._closed.set()
            for _ in self._threads:
                self._tasks.put(None)
        if wait:
            for thread in self._threads:
                thread.join()
            self._scratch.cleanup()

    def _serve(self, slot: _Slot) -> None:
        """Run queued tasks in the process of a slot until the pool is shut down; each slot has a thread for this."""
        while (task := self._tasks.get()) is not None:
            future, payload = task
            if self._cancelled.is_set():
                future.cancel()
            if future.set_running_or_notify_cancel():
                try:
                    succeeded, value = self._try(slot, payload)
                except WorkerDied as error:
                    succeeded, value = False, error
                future.set_result(value) if succeeded else future.set_exception(value)
        slot.close()

    def _try(self, slot: _Slot, payload: bytes) -> tuple[bool, Any]:
        for left in reversed(range(_TRIES)):
            try:
                return slot.do(payload)
            except WorkerDied as error:
                if not left or error.exit_code == EXIT_TIMEOUT or self._cancelled.is_set():
                    raise
        raise WorkerDied(None)


class _Slot:
    """Place for one worker process, started when first needed and again after its death."""

    def __init__(self, name: str, scratch: str) -> None:
        self._name = name
        # One numerics thread per process, since there is one process per core.
        self._environment = {**os.environ, **_THREADS, "TMPDIR": scratch}
        self._process: BaseProcess | None = None
        self._killed = False
        self._connection: Connection | None = None

    def do(self, payload: bytes) -> tuple[bool, Any]:
        """Run a pickled task; returns whether it succeeded, and its result or exception. Raises WorkerDied."""
        process, connection = self._started()
        try:
            connection.send_bytes(payload)
            wait([connection, process.sentinel])
            answer: tuple[bool, Any] = connection.recv()
        except (EOFError, OSError):
            process.join()
            self._process = None
            connection.close()
            raise WorkerDied(process.exitcode) from None
        return answer

    def kill(self) -> None:
        """Kill the process, even if it is just being started."""
        with _starting:
            self._killed = True
            if self._process is not None:
                self._process.kill()

    def close(self) -> None:
        """Close the connection, so that the process ends, and wait for it."""
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self._process.join()

    def _started(self) -> tuple[BaseProcess, Connection]:
        if self._process is None or self._connection is None:
            self._connection, theirs = multiprocessing.Pipe()
            arguments = (theirs, self._environment)
            process = _context().Process(target=_worker_loop, args=arguments, name=self._name, daemon=True)
            with _starting, environment({**_THREADS, **safe_path()}):
                process.start()
                self._process = process
                if self._killed:
                    process.kill()
            theirs.close()
        return self._process, self._connection


@functools.cache
def _context() -> Any:
    """Start method of processes: forks of a server process that has imported the engine; else new interpreters.

    Forks of this process would lose the threads of physics and solvers; the server process has no threads.
    """
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([f"{__package__}.runner"])
    return context


def _worker_loop(connection: Connection, environment: Mapping[str, str]) -> None:
    """Main loop of a worker: receive a task, run it, send the result; ends when the connection closes."""
    os.environ.clear()
    os.environ.update(environment)  # the server that was forked has the environment of the first pool
    tempfile.tempdir = None
    threading.Thread(target=_end_with_parent, name="parent watch", daemon=True).start()
    while True:
        try:
            fn, args, kwargs = pickle.loads(connection.recv_bytes())
        except (EOFError, OSError):
            return
        try:
            answer: tuple[bool, Any] = True, fn(*args, **kwargs)
        except Exception as error:  # noqa: BLE001 - process boundary: exceptions of a task go to its caller
            answer = False, error
        try:
            connection.send(answer)
        except OSError:
            return


def _end_with_parent() -> None:
    """End this process when its parent process ends, even during a task, because nothing can use its result then."""
    if (parent := multiprocessing.parent_process()) is not None:
        wait([parent.sentinel])
        os._exit(0)  # no parent reads the exit code
