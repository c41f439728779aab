"""Networks that carry frames between peers: the interface, one inside a process, and a simulated one.

The simulated network loses, delays, repeats and parts, the same in every run with one seed: for tests and simulations.
"""

from __future__ import annotations

import heapq
import threading
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Protocol

import numpy as np


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


@dataclass(frozen=True)
class Impairments:
    """How bad a network is.

    Attributes:
        loss: The part of frames that never arrives [1].
        latency: The shortest time that a frame takes [s].
        jitter: How much longer it may take, uniformly [s]; so frames overtake each other.
        repeats: The part of frames that arrives twice [1].
    """

    loss: float = 0.0
    latency: float = 0.0
    jitter: float = 0.0
    repeats: float = 0.0


class SimulatedNetwork:
    """Frames arrive when their time has come, and somebody polls.

    Args:
        now: The time by which frames travel [s].
        rng: Draws every loss and delay.
        trouble: How bad it is; may be changed at any time.

    Attributes:
        trouble: How bad it is.
        sent: Frames that were sent, counted for each peer that they were for.
    """

    def __init__(
        self, now: Callable[[], float], rng: np.random.Generator, impairments: Impairments = Impairments()
    ) -> None:
        self.impairments = impairments
        self.sent = 0
        self._now = now
        self._rng = rng
        self._peers: dict[str, Callable[[bytes], None]] = {}
        self._travelling: list[tuple[float, int, str, str, bytes]] = []
        self._side: dict[str, int] = {}

    def join(self, origin: str, deliver: Callable[[bytes], None], lost: Callable[[str], None]) -> Link:
        """Become a peer. Nobody is told who is lost: peers must notice by themselves."""
        self._peers[origin] = deliver
        return _SimulatedLink(self, origin)

    def part(self, *sides: Collection[str]) -> None:
        """Let no frame pass between these sides any more; peers that are not named are together on one more side."""
        self._side = {origin: number for number, side in enumerate(sides, 1) for origin in side}

    def heal(self) -> None:
        """Let all frames pass again."""
        self._side = {}

    def kill(self, origin: str) -> None:
        """A peer is gone without a word; what is on its way to it is lost."""
        self._peers.pop(origin, None)

    def send(self, sender: str, frame: bytes, to: str | None) -> None:
        """Put a frame on its way."""
        for origin in [o for o in self._peers if o != sender and to in (None, o)]:
            self.sent += 1
            impairments = self.impairments
            lost, delays = self._rng.random() < impairments.loss, self._rng.random(2)
            copies = 0 if lost else 2 if self._rng.random() < impairments.repeats else 1
            for delay in delays[:copies].tolist():
                at = self._now() + impairments.latency + impairments.jitter * delay
                heapq.heappush(self._travelling, (at, self.sent, sender, origin, frame))

    def poll(self) -> None:
        """Hand over every frame whose time has come; one between parted sides is lost."""
        while self._travelling and self._travelling[0][0] <= self._now() + 5e-7:
            _, _, sender, origin, frame = heapq.heappop(self._travelling)
            if origin in self._peers and self._side.get(sender, 0) == self._side.get(origin, 0):
                self._peers[origin](frame)


class _SimulatedLink:
    def __init__(self, network: SimulatedNetwork, origin: str) -> None:
        self._network = network
        self._origin = origin

    def send(self, frame: bytes, to: str | None = None) -> None:
        self._network.send(self._origin, frame, to)

    def poll(self) -> None:
        self._network.poll()

    def close(self) -> None:
        self._network.kill(self._origin)
