"""The process of an isolated actuator: performs the newest command, and is its device's watchdog."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import socket
import sys
import threading
import time

from ...clock import WallClock
from ...device import Actuator
from ...errors import DeviceError, InputError
from ...raised import describe, raised_at
from ..host import Host
from .channel import Channel, Close, Command, Done, Failed, Neutral, Ready, Start

GRACE = 1.0
"""[s] from SIGTERM or SIGHUP to the process's exit: the main process may end the run in order meanwhile."""

STOPS = 3
"""How often the device is sent to neutral before the process exits: one datagram may be lost."""

PAUSE = 0.02
"""[s] between two of these."""

LEAVE = 2.0
"""[s] that a driver may take for its last neutral and `close`; one that hangs is left."""


def run_process(descriptor: int) -> None:
    """Serve the main process until it closes the link or ends, then exit.

    Args:
        descriptor: The file descriptor of this process's end of the link.
    """
    parent = os.getppid()
    with socket.socket(fileno=descriptor) as end:
        end.set_inheritable(False)  # a process that the driver starts must not keep the link open
        channel = Channel(end)
        if isinstance(path := _receive(channel), list):
            sys.path[:] = path  # the user's driver imports what it imports in the main process
        if isinstance(start := _receive(channel), Start):
            DeviceProcess(channel, start, parent).run()


def _receive(channel: Channel) -> object:
    """The next message at the start; None if the main process has ended."""
    while (message := channel.next()) is None and not channel.ended:
        channel.wait()
    return message


class DeviceProcess:
    """The device, and its watchdog.

    The main thread calls nothing of the driver's, so that no driver can keep it: it reads messages, measures the age of
    the last command that the device has taken, and ends the process. The watchdog thus acts if the main process falls
    silent, and if the driver hangs in a command. One thread commands the device, another one sends it to neutral.

    Args:
        channel: The link to the main process.
        start: The first message.
        parent: Process number of the main process.
    """

    def __init__(self, channel: Channel, start: Start, parent: int) -> None:
        self._channel = channel
        self._maker = start.maker
        self._max_age = start.max_age
        self._parent = parent
        self._host = Host(WallClock())
        self._device: Actuator | None = None
        self._changed = threading.Condition()  # guards the next four
        self._newest: Command | None = None  # waits for the device
        self._stops = 0  # number of times that the device was sent to neutral
        self._stopping = False  # whether it is about to be sent there
        self._neutral_number = 0  # of the newest request for neutral
        self._fed: float | None = None  # when the device took its last command [s]; None while neutral
        self._leave_at = math.inf  # [s]
        self._signal = 0

    def run(self) -> None:
        """Serve until the link ends, or a signal ends the process; always exits in neutral."""
        ours, theirs = socket.socketpair()
        for each in (ours, theirs):
            each.setblocking(False)
        signal.set_wakeup_fd(theirs.fileno())
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._terminate)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the main process, which closes the link
        for target in (self._command_device, self._stop_device):
            threading.Thread(target=target, daemon=True).start()
        try:
            while self._serve(ours):
                pass
        except Exception as error:  # noqa: BLE001 - a defect of this file: the process ends, in neutral
            self._report(error)
        self._leave()

    def _serve(self, signals: socket.socket) -> bool:
        """Wait for a message or a deadline, and act on it; False at the end."""
        now, fed = time.monotonic(), self._fed
        deadline = math.inf if fed is None else fed + self._max_age
        # A command that the device takes meanwhile sets a deadline that is not earlier than now + max_age.
        self._channel.wait(max(min(deadline - now, self._max_age, self._leave_at - now), 0.0), signals)
        now, fed = time.monotonic(), self._fed
        if fed is not None and now >= fed + self._max_age:
            self._stop()
        messages = self._channel.receive()
        if self._channel.ended or Close() in messages or os.getppid() != self._parent:
            return False
        if self._signal:  # deaf to commands until the main process closes the link
            with contextlib.suppress(BlockingIOError):
                signals.recv(64)
            self._stop()
            return now < self._leave_at
        if messages:
            self._request(messages[-1])
        return True

    def _request(self, newest: Command | Neutral) -> None:
        if isinstance(newest, Neutral):
            self._stop(newest.number)
            return
        with self._changed:
            self._newest = newest
            self._changed.notify_all()

    def _stop(self, number: int = 0) -> None:
        """Let the device go to neutral, and drop a command that waits."""
        with self._changed:
            self._drop()
            self._stopping, self._neutral_number = True, max(number, self._neutral_number)
            self._changed.notify_all()
        self._fed = None

    def _drop(self) -> None:
        """Drop the command that waits; one that is on its way to the device ends in neutral."""
        self._newest = None
        self._stops += 1

    def _terminate(self, number: int, frame: object) -> None:
        self._signal = number
        self._leave_at = min(self._leave_at, time.monotonic() + GRACE)

    def _stop_device(self) -> None:
        """A thread: send the device to neutral whenever that is asked for, also while a command hangs."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._stopping)
                stops, number = self._stops, self._neutral_number
            self._neutral()
            with self._changed:
                self._stopping = self._stops != stops
                self._changed.notify_all()
            self._channel.send(Done(number))

    def _command_device(self) -> None:
        """A thread: make the device, then perform the newest command; it ends when the driver raises."""
        try:
            self._device = self._maker(self._host)
            self._channel.send(Ready(self._device.size))
            while True:
                self._perform(self._device, *self._take())
        except InputError as error:
            self._channel.send(Failed(str(error), error.faults))
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a user's driver may raise anything
            self._neutral()
            self._report(error)

    def _take(self) -> tuple[Command, int]:
        """The newest command, once there is one and the device is not being stopped; and the stops before it."""
        with self._changed:
            while self._newest is None or self._stopping:
                self._changed.wait()
            command, self._newest = self._newest, None
            return command, self._stops

    def _perform(self, device: Actuator, command: Command, stops: int) -> None:
        now = time.monotonic()
        if now - command.stamp < self._max_age:  # else it was held up on its way, and must not move the robot now
            self._fed = now if self._fed is None else self._fed
            device.command(command.values)
            if self._stops == stops:
                self._fed = time.monotonic()
            else:  # stopped while the command was on its way: neutral wins
                self._neutral()
        self._channel.send(Done(command.number))

    def _neutral(self) -> None:
        if self._device is None:
            return
        try:
            self._device.neutral()
        except Exception as error:  # noqa: BLE001 - it must not raise; the watchdog lives on if it does
            self._report(error)

    def _report(self, error: BaseException) -> None:
        """Tell the main process what was raised; what is no DeviceError with its type and place."""
        if isinstance(error, DeviceError):
            self._channel.send(Failed(str(error)))
        else:
            location = raised_at(error, self._device)
            self._channel.send(Failed(describe(error) + (f" ({location})" if location is not None else "")))

    def _leave(self) -> None:
        """Go to neutral several times, close the device, and exit, even if the driver hangs."""
        with self._changed:
            self._drop()
        last = threading.Thread(target=self._end, daemon=True)
        last.start()
        last.join(LEAVE)
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        os._exit(128 + self._signal if self._signal else 0)

    def _end(self) -> None:
        for _ in range(STOPS):
            self._neutral()
            time.sleep(PAUSE)
        for each in (self._device, self._host):
            if each is not None:
                with contextlib.suppress(Exception):  # the next one must be closed all the same
                    each.close()
