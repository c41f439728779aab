"""IsolatedActuator: main-process part of an actuator with its driver in a separate process."""

from __future__ import annotations

import os
import pathlib
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

from ...device import Actuator
from ...errors import ActuatorError, DeviceError, Fault, InputError
from .channel import Channel, Close, Command, Done, Failed, Neutral, Ready, Start
from .maker import ActuatorMaker

PATIENCE = 20
"""Number of checks, one per control period, without an answer after which the process counts as hung."""

EXIT_TIMEOUT = 3.0
"""Timeout for an orderly exit of the process [s], after which the process is killed."""

_PACKAGES = str(pathlib.Path(__file__).resolve().parents[3])


class IsolatedActuator(Actuator):
    """Actuator with its driver in a separate process with a watchdog.

    The process sends the device to neutral if it has received no command for `max_age`, even if the main process is
    dead, was stopped, or its interpreter is blocked. `command` and `neutral` send a request and return immediately; of
    several waiting requests only the newest is performed. The process runs in a session of its own, so that Ctrl-C,
    Ctrl-Z and the end of the terminal do not affect it.

    Args:
        maker: Function that constructs the driver, called in the process.
        max_age: Age of the last command at which the process sends the device to neutral [s].

    Raises:
        InputError: The driver is invalid, or the system is not POSIX.
        DeviceError: The driver cannot reach its device.
    """

    def __init__(self, maker: ActuatorMaker, max_age: float) -> None:
        if os.name != "posix":
            hint = "It needs a POSIX system, such as Linux."
            raise InputError(Fault(f"actuator '{maker.name}' cannot be isolated here.", hint=hint))
        ours, theirs = socket.socketpair()
        self._channel = Channel(ours)
        with theirs:
            self._process = _start(theirs)
        self._lock = threading.Lock()  # protects the following attributes
        self._number = self._answered = 0  # numbers of the newest request and of the newest answered one
        self._unanswered = 0  # checks since the process last answered
        self._failure: ActuatorError | None = None
        self._closed = False
        try:
            super().__init__(maker.name, self._ready(maker, max_age))
        except BaseException:  # raised again, after the process ended
            self.close()
            raise

    def command(self, values: Sequence[float]) -> None:
        with self._lock:
            self._read()
            if self._failure is not None:
                raise self._failure.with_traceback(None)
            self._number += 1
            self._channel.send(Command(self._number, time.monotonic(), list(values)))

    def neutral(self) -> None:
        with self._lock:
            self._number += 1
            self._channel.send(Neutral(self._number))

    def check(self) -> ActuatorError | None:
        """Read the messages of the process; this must be called once per control period.

        Returns:
            Failure of the driver or of its process; None without a failure.
        """
        with self._lock:
            self._read()
            self._unanswered = 0 if self._answered == self._number else self._unanswered + 1
            if self._unanswered > PATIENCE:
                why = "the driver hangs, or the process was stopped"
                self._fail("hung", f"its process has not answered for {PATIENCE} control periods: {why}")
            return self._failure

    def close(self) -> None:
        """End the process: it goes to neutral, closes the device and exits. It is killed after `EXIT_TIMEOUT`."""
        if self._closed:
            return
        self._closed = True
        self._channel.send(Close())
        self._channel.close()
        try:
            self._process.wait(EXIT_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _ready(self, maker: ActuatorMaker, max_age: float) -> int:
        """Send the start message and wait for the driver's construction; returns the number of values of a command."""
        self._channel.send([path or os.getcwd() for path in sys.path])
        self._channel.send(Start(maker, max_age))
        while True:
            self._channel.wait()
            for message in self._channel.receive():
                if isinstance(message, Ready):
                    return message.size
                if isinstance(message, Failed):
                    raise InputError(*message.faults) if message.faults else DeviceError(message.message)
            if self._channel.ended:
                raise DeviceError(f"actuator '{maker.name}': its process {self._end()} before the device was ready")

    def _read(self) -> None:
        """Read the messages of the process; only the first failure is kept."""
        for message in self._channel.receive():
            self._unanswered = 0
            if isinstance(message, Failed):
                self._fail("raised", message.message)
            elif isinstance(message, Done):
                self._answered = max(self._answered, message.number)
        if self._channel.ended:
            self._fail("ended", f"its process {self._end()}")

    def _fail(self, kind: str, why: str) -> None:
        self._failure = self._failure or ActuatorError(why, kind)

    def _end(self) -> str:
        """Text that says how the process has ended."""
        try:
            code = self._process.wait(0.1)  # its sockets close shortly before its exit status is available
        except subprocess.TimeoutExpired:
            return "closed its link"
        return f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"


def _start(theirs: socket.socket) -> subprocess.Popen[bytes]:
    paths = [_PACKAGES, *filter(None, [os.environ.get("PYTHONPATH")])]
    return subprocess.Popen(
        [
            sys.executable,
            "-P",
            "-m",
            __package__,
            str(theirs.fileno()),
        ],  # -P: nothing of the current folder is imported
        stdin=subprocess.DEVNULL,
        pass_fds=[theirs.fileno()],
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
    )
