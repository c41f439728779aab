"""The seam to whatever carries frames between peers, and the one inside a process."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Protocol


class Link(Protocol):
    """One peer's end of a network. It may lose, delay, repeat and disorder frames; it must not alter them."""

    def send(self, frame: bytes, to: str | None = None) -> None:
        """Send to one peer, or to all others; must not block, and not raise where nobody is reached."""
        ...

    def poll(self) -> None:
        """Hand over what has come meanwhile, where no other thread does."""
        ...

    def close(self) -> None:
        """Leave."""
        ...


class Network(Protocol):
    """What carries frames between peers."""

    def join(self, origin: str, deliver: Callable[[bytes], None], lost: Callable[[str], None]) -> Link:
        """Become a peer.

        Args:
            origin: Its name.
            deliver: Called with each frame for it, on any thread.
            lost: Called with a peer that can no longer be reached, on any thread, where the network notices.
        """
        ...


class LocalNetwork:
    """Between agents of one process: at once, in order, and without loss."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._peers: dict[str, Callable[[bytes], None]] = {}

    def join(self, origin: str, deliver: Callable[[bytes], None], lost: Callable[[str], None]) -> Link:
        """Become a peer."""
        with self._lock:
            self._peers = {**self._peers, origin: deliver}
        return _LocalLink(self, origin)

    def send(self, sender: str, frame: bytes, to: str | None) -> None:
        """Hand a frame to whom it is for."""
        for origin, deliver in self._peers.items():
            if origin != sender and to in (None, origin):
                deliver(frame)

    def leave(self, origin: str) -> None:
        """Be a peer no more."""
        with self._lock:
            self._peers = {o: d for o, d in self._peers.items() if o != origin}


class _LocalLink:
    def __init__(self, network: LocalNetwork, origin: str) -> None:
        self._network = network
        self._origin = origin

    def send(self, frame: bytes, to: str | None = None) -> None:
        self._network.send(self._origin, frame, to)

    def poll(self) -> None:
        """Nothing waits: frames are handed over as they are sent."""

    def close(self) -> None:
        self._network.leave(self._origin)
