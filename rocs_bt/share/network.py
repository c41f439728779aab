"""Networks that carry frames (encoded messages) between peers: interface, in-process network, simulated network.

The simulated network loses, delays and duplicates frames and can be partitioned, reproducibly for a seed. It is meant
for tests and simulations.
"""

from __future__ import annotations

import heapq
import threading
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Protocol

import numpy as np


class Link(Protocol):
    """One peer's end of a network. Frames may be lost, delayed, duplicated and reordered, but not altered."""

    def send(self, frame: bytes, to: str | None = None) -> None:
        """Send a frame to one peer, or to all others; must not block, and must not raise if no peer is reached."""

    def poll(self) -> None:
        """Deliver the frames that have arrived; does nothing if a thread of the network delivers them."""

    def close(self) -> None:
        """Leave the network."""


class Network(Protocol):
    """Transport of frames between peers."""

    def join(self, origin: str, deliver: Callable[[bytes], None], lost: Callable[[str], None]) -> Link:
        """Join the network.

        Args:
            origin: Name of the joining peer, `agent#start`.
            deliver: Called with each frame for the joining peer, on any thread.
            lost: Called with the name of a peer that is no longer reachable, on any thread, if the network detects it.
        """


class LocalNetwork:
    """Network between agents of one process: immediate, in order, without loss."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._peers: dict[str, Callable[[bytes], None]] = {}

    def join(self, origin: str, deliver: Callable[[bytes], None], lost: Callable[[str], None]) -> Link:
        """Join the network."""
        with self._lock:
            self._peers = {**self._peers, origin: deliver}
        return _Link(self, origin)

    def send(self, sender: str, frame: bytes, to: str | None) -> None:
        """Deliver a frame to one peer, or to all other peers if `to` is None."""
        for origin, deliver in self._peers.items():
            if origin != sender and to in (None, origin):
                deliver(frame)

    def poll(self) -> None:
        """Do nothing: frames are delivered as they are sent."""

    def leave(self, origin: str) -> None:
        """Leave the network."""
        with self._lock:
            self._peers = {o: d for o, d in self._peers.items() if o != origin}


class _Link:
    def __init__(self, network: LocalNetwork | SimulatedNetwork, origin: str) -> None:
        self._network = network
        self._origin = origin

    def send(self, frame: bytes, to: str | None = None) -> None:
        self._network.send(self._origin, frame, to)

    def poll(self) -> None:
        self._network.poll()

    def close(self) -> None:
        self._network.leave(self._origin)


@dataclass(frozen=True)
class Impairments:
    """Impairments of a simulated network.

    Attributes:
        loss: Share of frames that are lost [1].
        latency: Minimum delay of a frame [s].
        jitter: Maximum additional delay [s]. The additional delay is uniformly distributed, so frames can overtake each
            other.
        repeats: Share of frames that are delivered twice [1].
    """

    loss: float = 0.0
    latency: float = 0.0
    jitter: float = 0.0
    repeats: float = 0.0


class SimulatedNetwork:
    """Network that delivers frames after a simulated delay, when a peer polls.

    Args:
        now: Returns the simulated time [s].
        rng: Generator of losses and delays.
        impairments: Losses and delays; may be changed at any time.
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
        """Join the network. `lost` is never called: peers must detect by themselves that another peer is gone."""
        self._peers[origin] = deliver
        return _Link(self, origin)

    def part(self, *sides: Collection[str]) -> None:
        """Partition the network into these sides; all other peers form one more side."""
        self._side = {origin: number for number, side in enumerate(sides, 1) for origin in side}

    def heal(self) -> None:
        """End the partition."""
        self._side = {}

    def leave(self, origin: str) -> None:
        """Remove a peer without notice; frames on their way to it are lost."""
        self._peers.pop(origin, None)

    def send(self, sender: str, frame: bytes, to: str | None) -> None:
        """Send a frame to one peer, or to all other peers if `to` is None."""
        for origin in [o for o in self._peers if o != sender and to in (None, o)]:
            self.sent += 1
            impairments = self.impairments
            lost, delays = self._rng.random() < impairments.loss, self._rng.random(2)
            copies = 0 if lost else 2 if self._rng.random() < impairments.repeats else 1
            for delay in delays[:copies].tolist():
                at = self._now() + impairments.latency + impairments.jitter * delay
                heapq.heappush(self._travelling, (at, self.sent, sender, origin, frame))

    def poll(self) -> None:
        """Deliver every frame that is due; frames between partitioned sides are lost."""
        while self._travelling and self._travelling[0][0] <= self._now() + 5e-7:
            _, _, sender, origin, frame = heapq.heappop(self._travelling)
            if origin in self._peers and self._side.get(sender, 0) == self._side.get(origin, 0):
                self._peers[origin](frame)
