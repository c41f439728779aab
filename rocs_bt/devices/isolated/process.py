"""Process of an isolated actuator: performs commands, and is the watchdog of the device."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import socket
import sys
import threading
import time

from ...base.clock import WallClock
from ...base.errors import DeviceError, InputError
from ...base.raised import describe, raised_at
from ...interfaces.device import Actuator
from ..host import Host
from ..last_neutral import repeat_neutral
from .channel import Channel, Close, Command, Done, Failed, Neutral, Ready, Start

GRACE = 1.0
"""Time from SIGTERM or SIGHUP to the exit of the process [s], in which the main process can end the run in order."""

CLOSE_TIMEOUT = 2.0
"""Timeout for the last neutral commands and `close` of the driver [s], after which the process exits anyway."""


def run_process(descriptor: int) -> None:
    """Serve the main process at a socket's file descriptor until it closes the channel or ends, then exit."""
    parent = os.getppid()
    with socket.socket(fileno=descriptor) as end:
        end.set_inheritable(False)  # child processes of the driver must not keep the channel open
        channel = Channel(end)
        if isinstance(path := _receive(channel), list):
            sys.path[:] = path  # the user's driver can import the same modules as in the main process
        if isinstance(start := _receive(channel), Start):
            DeviceProcess(channel, start, parent).run()


def _receive(channel: Channel) -> object:
    """Wait for the next message, before the driver exists; None if the main process has ended."""
    while (message := channel.next()) is None and not channel.ended:
        channel.wait()
    return message


class DeviceProcess:
    """Driver and watchdog of an isolated actuator.

    The main thread never calls the driver, so that no driver can block it. It reads messages, measures the age of the
    last command that the device has taken, and ends the process. The watchdog thus acts if the main process sends
    nothing, and also if the driver hangs in a command. A second thread commands the device, and a third sends it to
    neutral.
    """

    def __init__(self, channel: Channel, start: Start, parent: int) -> None:
        self._channel = channel
        self._maker = start.maker
        self._max_age = start.max_age
        self._parent = parent
        self._host = Host(WallClock())
        self._device: Actuator | None = None
        self._changed = threading.Condition()  # protects the next four
        self._newest: Command | None = None  # command that waits for the device
        self._stops = 0  # number of times that the device was sent to neutral
        self._stopping = False  # whether a neutral command is pending
        self._neutral_number = 0  # number of the newest request for neutral
        self._fed: float | None = None  # [s] time of the last command that the device took; None while neutral
        self._leave_at = math.inf  # [s]
        self._signal = 0

    def run(self) -> None:
        """Serve until the channel or a signal ends the process, which always exits with the device in neutral."""
        ours, theirs = socket.socketpair()
        for each in (ours, theirs):
            each.setblocking(False)
        signal.set_wakeup_fd(theirs.fileno())
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._terminate)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the main process, which closes the channel
        for target in (self._command_device, self._stop_device):
            threading.Thread(target=target, daemon=True).start()
        try:
            while self._serve(ours):
                pass
        except Exception as error:  # noqa: BLE001 - a bug in this file: the process ends in neutral
            self._report(error)
        self._leave()

    def _serve(self, signals: socket.socket) -> bool:
        """Wait for a message or a deadline, and handle it; returns False if the process must end."""
        now, fed = time.monotonic(), self._fed
        deadline = math.inf if fed is None else fed + self._max_age
        # A command that the device takes during the wait sets a deadline of at least now + max_age.
        self._channel.wait(max(min(deadline - now, self._max_age, self._leave_at - now), 0.0), signals)
        now, fed = time.monotonic(), self._fed
        if fed is not None and now >= fed + self._max_age:
            self._stop()
        messages = self._channel.receive()
        if self._channel.ended or Close() in messages or os.getppid() != self._parent:
            return False
        if self._signal:  # ignore commands until the main process closes the channel
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
        """Send the device to neutral and drop a waiting command."""
        with self._changed:
            self._drop()
            self._stopping, self._neutral_number = True, max(number, self._neutral_number)
            self._changed.notify_all()
        self._fed = None

    def _drop(self) -> None:
        """Drop a waiting command, and make a command in execution end in neutral."""
        self._newest = None
        self._stops += 1

    def _terminate(self, number: int, frame: object) -> None:
        self._signal = number
        self._leave_at = min(self._leave_at, time.monotonic() + GRACE)

    def _stop_device(self) -> None:
        """Thread function: send the device to neutral on request, also while a command hangs."""
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
        """Thread function: construct the driver, then perform commands; it ends if the driver raises an exception."""
        try:
            self._device = self._maker(self._host)
            self._channel.send(Ready(self._device.size, self._device.publishers))
            while True:
                self._perform(self._device, *self._take())
        except InputError as error:
            self._channel.send(Failed(str(error), error.faults))
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a user's driver may raise anything
            self._neutral()
            self._report(error)

    def _take(self) -> tuple[Command, int]:
        """Wait for a command while no neutral is pending; returns the newest command and the number of stops so far."""
        with self._changed:
            while self._newest is None or self._stopping:
                self._changed.wait()
            command, self._newest = self._newest, None
            return command, self._stops

    def _perform(self, device: Actuator, command: Command, stops: int) -> None:
        now = time.monotonic()
        if now - command.stamp < self._max_age:  # a delayed command must not move the robot
            self._fed = now if self._fed is None else self._fed
            device.command(command.values)
            done = time.monotonic()
            if self._stops == stops and done < now + self._max_age:
                self._fed = done
            else:  # stopped during the command, or the whole process was: what was sent late must not last
                self._neutral()
                self._fed = None
        self._channel.send(Done(command.number))

    def _neutral(self) -> None:
        if self._device is None:
            return
        try:
            self._device.neutral()
        except Exception as error:  # noqa: BLE001 - the watchdog must survive a faulty driver
            self._report(error, neutral=True)

    def _report(self, error: BaseException, *, neutral: bool = False) -> None:
        """Report an exception to the main process: a DeviceError by its message, others with type and location."""
        if isinstance(error, DeviceError):
            self._channel.send(Failed(str(error), neutral=neutral))
        else:
            location = raised_at(error, self._device)
            text = describe(error) + (f" ({location})" if location is not None else "")
            self._channel.send(Failed(text, neutral=neutral))

    def _leave(self) -> None:
        """Send the device to neutral several times, close it, and exit, even if the driver hangs."""
        with self._changed:
            self._drop()
        last = threading.Thread(target=self._end, daemon=True)
        last.start()
        last.join(CLOSE_TIMEOUT)
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        os._exit(128 + self._signal if self._signal else 0)

    def _end(self) -> None:
        repeat_neutral(self._neutral)
        for each in (self._device, self._host):
            if each is not None:
                with contextlib.suppress(Exception):  # the next one must be closed, too
                    each.close()
