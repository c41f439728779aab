"""IsolatedActuator: main-process part of an actuator with its driver in a separate process."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

from ...base.clock import WallClock
from ...base.current_folder import child_environment
from ...base.errors import ActuatorError, DeviceError, Fault, InputError
from ...interfaces.device import Actuator
from ..host import Host
from .channel import Channel, Close, Command, Done, Failed, Neutral, Ready, Start
from .maker import ActuatorMaker
from .silence import TICK, Silence
from .standby import Standby

EXIT_TIMEOUT = 3.0
"""Timeout for an orderly exit of the process [s], after which the process is killed."""


class IsolatedActuator(Actuator):
    """Actuator with its driver in a separate process with a watchdog.

    The process sends the device to neutral if it has received no command for `max_age`, even if the main process is
    dead, was stopped, or its interpreter is blocked. `command` and `neutral` send a request and return immediately; of
    several waiting requests only the newest is performed. The process runs in a session of its own, so that Ctrl-C,
    Ctrl-Z and the end of the terminal do not affect it.

    A thread supervises the process. If the process ends or answers nothing for `max_age`, the thread kills it, and
    opens the device in the main process (see `Standby`) to send it to neutral. A process that only waits for a
    processor is not killed at once: the actuator is `late` then, and its caller holds the robot. So is every silent
    process of a device with two owners, because the standby sends neutral at once: a publisher of Fast DDS can wait
    for 333 ms while a peer in shared memory is checked (eProsima/Fast-DDS issue 6535).

    Args:
        maker: Function that constructs the driver, called in the process.
        max_age: Age of the last command at which the process sends the device to neutral [s].
        host: Host for the driver of the standby, in the main process; None for one of its own.

    Raises:
        InputError: The driver is invalid, or the system is not POSIX.
        DeviceError: The driver cannot reach its device.
    """

    def __init__(self, maker: ActuatorMaker, max_age: float, host: Host | None = None) -> None:
        if os.name != "posix":
            hint = "It needs a POSIX system, such as Linux."
            raise InputError(Fault(f"actuator '{maker.name}' cannot be isolated here.", hint=hint))
        ours, theirs = socket.socketpair()
        self._channel = Channel(ours)
        with theirs:
            self._process = _start(theirs)
        self._lock = threading.Lock()  # protects the following attributes
        self._number = self._answered = 0  # numbers of the newest request and of the newest answered one
        self._failure: ActuatorError | None = None
        self._closed = False
        self._silence = Silence(max_age, self._process.pid, patient=maker.two_owners)
        self._thread = threading.Thread(target=self._supervise, name=f"{maker.name}/supervisor", daemon=True)
        self._standby: Standby | None = None
        try:
            super().__init__(maker.name, self._ready(maker, max_age))
            own = host or Host(WallClock())
            self._standby = Standby(lambda: maker(own), early=maker.two_owners)
        except BaseException:  # raised again, after the process ended
            self.close()
            raise
        self._thread.start()

    def command(self, values: Sequence[float]) -> None:
        with self._lock:
            if self._failure is not None:
                raise self._failure.with_traceback(None)
            self._number += 1
            self._channel.send(Command(self._number, time.monotonic(), list(values)))

    def neutral(self) -> None:
        with self._lock:
            self._number += 1
            self._channel.send(Neutral(self._number))
        if self._standby is not None:
            self._standby.stop() if self.late else self._standby.neutral()

    @property
    def late(self) -> bool:
        """Whether the process answers late, but does not count as hung yet."""
        return self._silence.late

    def check(self) -> ActuatorError | None:
        """Failure of the driver or of its process; None without a failure."""
        return self._failure

    def close(self) -> None:
        """End the process: it goes to neutral, closes the device and exits. It is killed after `EXIT_TIMEOUT`."""
        if self._closed:
            return
        self._closed = True
        if self._thread.ident is not None:
            self._thread.join(EXIT_TIMEOUT)
        if self._standby is not None:
            self._standby.close()
        self._channel.send(Close())
        self._channel.close()
        try:
            self._process.wait(EXIT_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._kill()

    def _ready(self, maker: ActuatorMaker, max_age: float) -> int:
        """Send the start message and wait for the driver's construction; returns the number of values of a command."""
        self._channel.send([path or os.getcwd() for path in sys.path])
        self._channel.send(Start(maker, max_age))
        while True:
            self._channel.wait()
            for message in self._channel.receive():
                if isinstance(message, Ready):
                    self.publishers = message.publishers
                    return message.size
                if isinstance(message, Failed):
                    raise InputError(*message.faults) if message.faults else DeviceError(message.message)
            if self._channel.ended:
                raise DeviceError(f"actuator '{maker.name}': its process {self._end()} before the device was ready")

    def _supervise(self) -> None:
        """Thread function: read the messages of the process, until its first failure or `close`."""
        last = time.monotonic()
        while self._failure is None and not self._closed:
            self._channel.wait(TICK)
            raised, helpless, progress, was_late = "", False, False, self.late
            for message in self._channel.receive():
                if isinstance(message, Failed):
                    raised, helpless = raised or message.message, helpless or message.neutral
                elif isinstance(message, Done):
                    progress, self._answered = True, max(self._answered, message.number)
            now = time.monotonic()
            why = self._silence.after(now - last, progress=progress, waiting=self._answered != self._number)
            last = now
            if self.late and not was_late and self._standby is not None:
                self._standby.stop()
            if helpless:  # the driver's neutral raises there: perhaps that of a new driver does not
                self._replace("raised", raised)
            elif raised:  # the process has sent the device to neutral, and goes on to do so on request
                self._fail("raised", raised)
            elif self._channel.ended or self._process.poll() is not None:
                self._replace("ended", f"its process {self._end()}")
            elif why:
                self._replace("hung", f"its process {why}: the driver hangs, or the process was stopped")

    def _replace(self, kind: str, why: str) -> None:
        """Kill the process, so that it commands nothing more, and send the device to neutral from here."""
        if self._closed:
            return
        self._kill()
        problem = "" if self._standby is None else self._standby.take_over()
        self._fail(kind, why + (f"; the main process cannot send neutral: {problem}" if problem else ""))

    def _kill(self) -> None:
        self._process.kill()
        with contextlib.suppress(subprocess.TimeoutExpired):  # a process that waits for a device cannot be killed
            self._process.wait(EXIT_TIMEOUT)

    def _fail(self, kind: str, why: str) -> None:
        with self._lock:
            self._failure = self._failure or ActuatorError(why, kind)

    def _end(self) -> str:
        """Text that says how the process has ended."""
        try:
            code = self._process.wait(0.1)  # its sockets close shortly before its exit status is available
        except subprocess.TimeoutExpired:
            return "closed its link"
        return f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"


def _start(theirs: socket.socket) -> subprocess.Popen[bytes]:
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
        env=child_environment(),
    )
