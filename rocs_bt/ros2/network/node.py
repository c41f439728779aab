"""RosNode: connection of one robot to ROS 2, which its sensors and actuators share."""

from __future__ import annotations

import math
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from ...base.clock import Clock
from ...base.errors import DeviceError
from ..messages.fields import seconds_of
from ..settings import Ros2Settings
from .connect import open_transport
from .matching import OwnEndpoint
from .qos import QoS
from .sim_clock import SimTimeClock
from .transport import Endpoint, Reader, Transport, Writer

LOOK_AGAIN = 0.5
"""Time after which the publishers of silent topics are looked up again [s]."""

REST = 20.0
"""Pause after a look per duration of the look, so that looks use at most a twentieth of the time."""

MAX_AHEAD = 0.5
"""Time by which a stamp may at most be in the future before the message counts as faulty [s]."""


class RosNode:
    """Connection of one robot to ROS 2.

    Args:
        settings: The `[ros2]` table.
        clock: Clock of the run, for the stamps of readings.
        transport: Opened transport; None to open one by the settings.
        name: Name of the node, if the transport is opened here.

    Attributes:
        transport: Participant of the network.
        types: Message types.
        opened: Identifiers of the publishers that were opened here.

    Raises:
        InputError: A package is not installed; the hint says which.
        DeviceError: The network cannot be joined.
    """

    def __init__(
        self,
        settings: Ros2Settings,
        clock: Clock,
        transport: Transport | None = None,
        name: str = "rocs_bt",
    ) -> None:
        self.settings = settings
        self.transport = open_transport(settings, name) if transport is None else transport
        self.types = self.transport.types
        self.opened: set[bytes] = set()
        self._clock = clock
        self._faults: dict[str, Counter[str]] = {}
        self._lock = threading.Lock()  # protects the rest
        self._silent: dict[OwnEndpoint, Callable[[OwnEndpoint, Sequence[Endpoint]], str]] = {}
        self._reasons: dict[OwnEndpoint, str] = {}
        self._watched: dict[str, Sequence[Endpoint] | None] = {}  # publishers by topic; None before the first look
        self._asked, self._closed = threading.Event(), threading.Event()
        self._lookout = threading.Thread(target=self._look_out, name="ros2 lookout", daemon=True)

    @property
    def faults(self) -> Mapping[str, Mapping[str, int]]:
        """Number of faulty messages, by topic and kind of fault."""
        with self._lock:
            return {topic: dict(counter) for topic, counter in self._faults.items()}

    def reader(self, topic: str, type: str, qos: QoS) -> Reader:
        """Open a subscription of a topic with a full or relative name; see `Transport`."""
        self.begin_lookout()
        return self.transport.reader(self.settings.topic(topic), type, qos)

    def writer(self, topic: str, type: str, qos: QoS) -> Writer:
        """Open a publisher of a topic with a full or relative name; see `Transport`."""
        writer = self.transport.writer(self.settings.topic(topic), type, qos)
        self.opened.add(writer.gid)
        return writer

    def now(self) -> float:
        """Present time on the network's clock: simulated time, or seconds since 1970."""
        return self._clock.ros_time() if isinstance(self._clock, SimTimeClock) else self.transport.now()

    def received(self) -> float:
        """Time on the clock of the run of a message that has just arrived [s]."""
        return self._clock.now()

    def stamp(self, published: float, max_ahead: float = MAX_AHEAD) -> tuple[float, float]:
        """Convert a moment on the network's clock to the clock of the run.

        Args:
            published: Moment on the network's clock; see `now` [s].
            max_ahead: Time by which the moment may be in the future [s].

        Returns:
            Time on the clock of the run, at most the present [s]; and time by which the moment is in the future [s].

        Raises:
            DeviceError: The moment is further in the future, or no moment at all.
        """
        age = self.now() - published
        if not -max_ahead <= age < math.inf:
            raise of_the_future(-age) if age < 0.0 else DeviceError(f"its stamp, {published:.3f} s, is no time")
        return self._clock.now() - max(age, 0.0), max(-age, 0.0)

    def fault(self, topic: str, kind: str, error: DeviceError) -> DeviceError:
        """Count a faulty message; returns the error with topic and count, to be raised."""
        with self._lock:
            count = self._faults.setdefault(topic, Counter())
            count[kind] += 1
            total = count.total()
        again = f" ({total} faulty messages so far)" if total > 1 else ""
        return DeviceError(f"{topic}: {error}{again}")

    def why_silent(self, own: OwnEndpoint) -> str:
        """Reason why a subscription has received nothing, as far as the discovered publishers tell.

        This never waits and starts nothing, because a control period calls it: a thread of the node looks the
        publishers up, and the reason is that of its last look.
        """
        return self._last_look(own, self.silence, f"nothing was received on '{own.topic}' ({own.type}) yet")

    def why_unmatched(self, own: OwnEndpoint) -> str:
        """Reason why no discovered endpoint matches, empty if one does or there is none; it never waits either."""
        return self._last_look(own, OwnEndpoint.mismatch, "")

    def _last_look(self, own: OwnEndpoint, why: Callable[[OwnEndpoint, Sequence[Endpoint]], str], first: str) -> str:
        with self._lock:
            self._silent[own] = why
            reason = self._reasons.get(own, first)
        self._asked.set()
        return reason

    def watch(self, topic: str) -> None:
        """Begin to look for the publishers of a topic with a full name, before the run."""
        self.begin_lookout()
        with self._lock:
            self._watched.setdefault(topic, None)

    def publishers_now(self, topic: str) -> Sequence[Endpoint] | None:
        """Publishers of a watched topic in the last look; None before the first. It never waits, as `why_silent`."""
        self._asked.set()
        with self._lock:
            return self._watched[topic]

    def begin_lookout(self) -> None:
        """Start the thread that looks endpoints up, before the run."""
        if self._lookout.ident is None:  # not in a control period, which would wait for the thread
            self._lookout.start()

    def _look_out(self) -> None:
        """Thread function, for the life of the node: look up the publishers of silent topics."""
        while not self._closed.is_set():
            self._asked.wait()
            self._asked.clear()
            begun = time.monotonic()
            with suppress(Exception):  # the network may be closing; the next look tells
                self._look()
            self._closed.wait(max(LOOK_AGAIN, REST * (time.monotonic() - begun)))

    def _look(self) -> None:
        with self._lock:
            silent, watched = dict(self._silent), list(self._watched)
            self._silent.clear()
        if not (silent or watched) or self._closed.is_set():
            return
        endpoints = self.transport.endpoints()
        reasons = {own: why(own, endpoints) for own, why in silent.items()}
        found = {topic: [e for e in endpoints if e.publishes and e.topic == topic] for topic in watched}
        with self._lock:
            self._reasons |= reasons
            self._watched |= found

    def silence(self, own: OwnEndpoint, endpoints: Sequence[Endpoint]) -> str:
        """Reason why a subscription has received nothing, by discovered endpoints."""
        wanted = f"'{own.topic}' ({own.type})"
        if found := own.found(endpoints):
            return own.mismatch(endpoints) or f"{wanted}: {found[0].owner} has published nothing yet"
        same = sorted({e.topic for e in endpoints if e.publishes and e.type == own.type})
        if same:
            return f"nothing is published on {wanted}; topics of this type: {', '.join(same[:8])}"
        where = f"the ROS domain {self.settings.domain_id} ({self.settings.network})"
        return f"nothing is published on {wanted}; no topic of this type was discovered in {where}"

    def counterparts(self, own: OwnEndpoint) -> tuple[int, str]:
        """Number of discovered endpoints that match; and for 0 the reason, as far as known."""
        endpoints = self.transport.endpoints()
        count = sum(map(own.matches, own.found(endpoints)))
        none = f"no node subscribes to '{own.topic}'" if own.publishes else f"nothing is published on '{own.topic}'"
        return count, "" if count else own.mismatch(endpoints) or f"{none} ({own.type})"

    def close(self) -> None:
        """Close all endpoints, and leave the network."""
        self._closed.set()
        self._asked.set()
        if self._lookout.ident is not None:
            self._lookout.join(2.0)
        self.transport.close()


def of_the_future(ahead: float) -> DeviceError:
    """Error of a message with a stamp in the future [s]."""
    return DeviceError(f"its stamp is {ahead:.2f} s in the future: synchronise the clocks of both computers")


def header_stamp(message: Any) -> float:
    """Stamp in the header of a message [s since 1970].

    Raises:
        DeviceError: The message has no header, or its stamp is 0.
    """
    header = getattr(message, "header", None)
    if header is None:
        raise DeviceError('it has no header: write stamp = "source"')
    if not (stamp := seconds_of(header.stamp)):
        raise DeviceError("the stamp of its header is 0")
    return stamp
