"""Messages between an isolated actuator and its process, over a socket pair."""

from __future__ import annotations

import contextlib
import pickle
import select
import socket
import struct
import threading
from dataclasses import dataclass
from typing import Any

from ...errors import Fault
from .maker import DeviceMaker

_LENGTH = struct.Struct("!I")


@dataclass(frozen=True)
class Start:
    """First message to the process.

    Attributes:
        maker: Constructs the device.
        max_age: Age of the last command at which the process goes to neutral [s].
    """

    maker: DeviceMaker
    max_age: float


@dataclass(frozen=True)
class Command:
    """A command for the device; only the newest one is performed.

    Attributes:
        number: Number of the request, counted from 1.
        stamp: Monotonic system time of the request [s].
        values: Values of the command, shape (n,), SI units.
    """

    number: int
    stamp: float
    values: list[float]


@dataclass(frozen=True)
class Neutral:
    """A request to go to neutral.

    Attributes:
        number: Number of the request, counted from 1.
    """

    number: int


@dataclass(frozen=True)
class Close:
    """A request to go to neutral, close the device and exit."""


@dataclass(frozen=True)
class Ready:
    """The device was constructed.

    Attributes:
        size: Number of values of a command.
    """

    size: int


@dataclass(frozen=True)
class Done:
    """All requests up to this number were performed, or replaced by newer ones.

    Attributes:
        number: Number of the request.
    """

    number: int


@dataclass(frozen=True)
class Failed:
    """The driver raised; the device was sent to neutral and takes no more commands.

    Attributes:
        message: Description of the exception.
        faults: Faults of an InputError; only the construction of the device raises one.
    """

    message: str
    faults: tuple[Fault, ...] = ()


class Channel:
    """One end of the socket pair. Only `wait` blocks; `send` is thread-safe.

    Args:
        end: The socket.

    Attributes:
        ended: Whether the other side has closed its end.
    """

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._socket = end
        self._buffer = bytearray()
        self._sending = threading.Lock()
        self._torn = False  # whether a partial message was sent; no message can follow it
        self.ended = False

    def send(self, message: Any) -> None:
        """Send a message; it is dropped if the other side has ended or the buffer is full."""
        body = pickle.dumps(message)
        frame = _LENGTH.pack(len(body)) + body
        with self._sending:
            if self._torn:
                return
            # `receive` detects the end of the other side, after its last messages.
            with contextlib.suppress(OSError):
                self._torn = self._socket.send(frame) < len(frame)

    def next(self) -> Any:
        """Oldest received message; None if there is none."""
        self._fill()
        return self._take()

    def receive(self) -> list[Any]:
        """All received messages, oldest first."""
        self._fill()
        return list(iter(self._take, None))

    def wait(self, timeout: float | None = None, *others: socket.socket) -> None:
        """Wait for a message, the other side's end, data on `others`, or the timeout [s]; None waits without limit."""
        poll = select.poll()
        for each in (self._socket, *others):
            poll.register(each, select.POLLIN)
        poll.poll(None if timeout is None else 1e3 * timeout)

    def close(self) -> None:
        """Close this end; the other side detects it."""
        self.ended = True
        self._socket.close()

    def _fill(self) -> None:
        """Read available data without blocking."""
        try:
            while chunk := self._socket.recv(65536):
                self._buffer += chunk
            self.ended = True
        except BlockingIOError:
            pass
        except OSError:
            self.ended = True

    def _take(self) -> Any:
        if len(self._buffer) < _LENGTH.size:
            return None
        end = _LENGTH.size + _LENGTH.unpack_from(self._buffer)[0]
        if len(self._buffer) < end:
            return None
        message = pickle.loads(self._buffer[_LENGTH.size : end])
        del self._buffer[:end]
        return message
