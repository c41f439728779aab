"""Channel: messages between an isolated actuator and its process, over a socket pair."""

from __future__ import annotations

import contextlib
import pickle
import select
import socket
import struct
import threading
from dataclasses import dataclass
from typing import Any

from ...base.errors import Fault
from .maker import ActuatorMaker

_LENGTH = struct.Struct("!I")


@dataclass(frozen=True)
class Start:
    """First message to the process, which contains what it needs to construct the driver.

    Attributes:
        maker: Function that constructs the driver.
        max_age: Age of the last command at which the process sends the device to neutral [s].
    """

    maker: ActuatorMaker
    max_age: float


@dataclass(frozen=True)
class Command:
    """Request to command the device; of several waiting commands only the newest is performed.

    Attributes:
        number: Number of the request, counted from 1.
        stamp: Time of the request on the system's monotonic clock [s].
        values: Values of the command, shape (n,), SI units.
    """

    number: int
    stamp: float
    values: list[float]


@dataclass(frozen=True)
class Neutral:
    """Request to send the device to neutral."""

    number: int  # counted from 1


@dataclass(frozen=True)
class Close:
    """Request to send the device to neutral, close it, and exit."""


@dataclass(frozen=True)
class Ready:
    """Message of the process: the driver was constructed."""

    size: int
    publishers: frozenset[bytes] = frozenset()  # identifiers of the device's publishers on its network


@dataclass(frozen=True)
class Done:
    """Message of the process: all requests up to this number were performed, or replaced by newer ones."""

    number: int


@dataclass(frozen=True)
class Failed:
    """Message of the process: the driver raised an exception, so the device was sent to neutral for good."""

    message: str
    # If the exception is an InputError, which only the construction of the driver raises.
    faults: tuple[Fault, ...] = ()
    neutral: bool = False  # whether `neutral` raised it, so that the process cannot stop the device


class Channel:
    """One end of the socket pair, which sends and receives messages. Only `wait` blocks; `send` is thread-safe."""

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._socket = end
        self._buffer = bytearray()
        self._sending = threading.Lock()
        self._torn = False  # whether a message was sent only in part, so that none can follow
        self.ended = False

    def send(self, message: Any) -> None:
        """Send a message. It is dropped if the other side has closed its end, or if the buffer is full."""
        body = pickle.dumps(message)
        frame = _LENGTH.pack(len(body)) + body
        with self._sending:
            if self._torn:
                return
            # Errors are ignored: `receive` detects that the other side has closed its end, after its last messages.
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
        """Wait for a message, for data on other sockets, or until the other side closes its end.

        Args:
            timeout: Maximum time [s]; None to wait without limit.
            others: Other sockets.
        """
        poll = select.poll()
        for each in (self._socket, *others):
            poll.register(each, select.POLLIN)
        poll.poll(None if timeout is None else 1e3 * timeout)

    def close(self) -> None:
        """Close this end, which the other side detects."""
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
