"""Clock of a robot in a simulator: follows the topic `/clock` (use_sim_time)."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

from ...base.clock import WallClock
from ...base.errors import DeviceError
from ..messages.fields import seconds_of
from .qos import QoS
from .transport import Reader, Transport

_TYPE = "rosgraph_msgs/msg/Clock"
_QOS = QoS("best_effort", "volatile", 10)  # matches every publisher
_LOOK = 0.002  # [s] wall time between two looks for messages
_WINDOW = 0.5  # [s] wall time over which the speed is measured
_GAP = 0.25  # [s] wall time between messages after which the clock counts as stopped in between
_LEAST, _MOST = 0.001, 0.02  # [s] minimum and maximum wall time of one sleep
_BACK = 0.5  # [s] jump back after which the simulator counts as restarted


class SimTimeClock(WallClock):
    """Simulated time since the call of `start` [s].

    Between two messages the time is extrapolated by the measured speed, by at most the time between messages. The clock
    therefore stops when `/clock` stops, as in a paused simulator. It never goes back. Thread-safe; each request for the
    time polls for messages.

    Raises:
        DeviceError: The network refuses the subscription.
    """

    def __init__(self, transport: Transport) -> None:
        self._types = transport.types
        self._reader: Reader = transport.reader("/clock", _TYPE, _QOS)
        self._lock = threading.Lock()
        self._looked = -math.inf  # [s] wall time of the last look for messages
        self._message = math.nan  # [s] newest simulated time received
        self._received = -math.inf  # [s] wall time at which it was received
        self._interval = 0.0  # [s] simulated time between messages
        self._speed = 1.0  # simulated per wall time
        self._base = (math.nan, 0.0)  # simulated and wall time [s] at the begin of the speed's window
        self._shown = -math.inf  # [s] latest simulated time that was returned
        self._zero = math.nan  # [s] simulated time of the start
        self._fault = ""
        super().__init__(running=False)

    def wait_for_message(self, patience: float, ended: Callable[[], str] = lambda: "") -> None:
        """Wait until the simulator publishes its time, or a signal ends the run.

        Args:
            patience: Maximum wall time [s].
            ended: Returns the reason of a signal that ends the run, or an empty text.

        Raises:
            DeviceError: There was no message.
        """
        until = time.monotonic() + patience
        while math.isnan(self.ros_time()) and not ended():
            if time.monotonic() > until:
                hint = "Start the simulator, such as 'rocs-bt sim SCENARIO --ros2', or remove use_sim_time."
                raise DeviceError(f"no message on /clock within {patience:g} s. {hint}")
            time.sleep(0.01)

    def check(self) -> None:
        """Check that one simulator publishes the time, and was not restarted.

        Raises:
            DeviceError: Its time jumped back.
        """
        if self._fault:
            raise DeviceError(self._fault)

    @property
    def stopped_for(self) -> float:
        """Wall time since the simulator's time last advanced [s]."""
        self.ros_time()  # polls for messages
        return time.monotonic() - self._received

    @property
    def interval(self) -> float:
        """Wall time between the last two messages, by the measured speed [s]."""
        return self.wall_time(self._interval)

    def start(self) -> None:
        self._zero = self.ros_time()

    def now(self) -> float:
        return 0.0 if math.isnan(self._zero) else self.ros_time() - self._zero

    def at(self, stamp: float) -> float:
        """Time on this clock of a stamp in a message's header [s]; NaN before the first message of the simulator."""
        return self.now() + stamp - self.ros_time()

    def wall_time(self, duration: float) -> float:
        return max(duration / self._speed, _LEAST) if duration > 0.0 else 0.0

    def wait_until(self, deadline: float, stop: threading.Event, patience: float = math.inf) -> bool:
        until = time.monotonic() + patience
        while (remaining := deadline - self.now()) > 0.0 and (left := until - time.monotonic()) > 0.0:
            if stop.wait(min(self.wall_time(remaining), _MOST, left)):
                return False
        return not stop.is_set()

    def ros_time(self) -> float:
        """Present simulated time [s]; NaN before the first message."""
        with self._lock:
            wall = time.monotonic()
            if wall - self._looked >= _LOOK:
                self._looked = wall
                self._receive(wall)
            if math.isnan(self._message):
                return math.nan
            ahead = min(self._speed * (wall - self._received), self._interval)
            self._shown = max(self._shown, self._message + ahead)
            return self._shown

    def _receive(self, wall: float) -> None:
        """Take the messages that have arrived."""
        for sample in self._reader.take_all():
            try:
                now = seconds_of(self._types.deserialize(sample.data, _TYPE).clock)
            except DeviceError:
                continue
            if now < self._message - _BACK:
                jump = f"/clock jumped back from {self._message:.3f} s to {now:.3f} s"
                why = "the simulator was restarted, or a second one runs in this ROS domain."
                self._fault = self._fault or f"{jump}: {why}"
                return
            if now > self._message:
                self._interval = now - self._message
            if not now <= self._message:  # also the first one
                if wall - self._received > _GAP:
                    self._base = now, wall
                self._message, self._received = now, wall
        since, at = self._base
        if self._received - at >= _WINDOW:
            self._speed = max((self._message - since) / (self._received - at), 1e-3)
            self._base = self._message, self._received
