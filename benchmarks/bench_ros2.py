"""Reflex latency over ROS 2 (DDS without ROS): from the sample in the agent to the command at the robot.

The agent and the plan are those of `bench_reflex`. The robot is another process, which publishes scans of 720 beams at
20 Hz and receives twists. The sample is the moment at which the agent takes the near scan. The agent polls its topics
once per control period (20 Hz), so from the publication on there is up to a period more: this is the last row.

Run it with `python benchmarks ros2`.
"""

from __future__ import annotations

import math
import platform
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import ros2_peer
from bench_reflex import FAR, NEAR, Sonar, Wheels, measure
from row import Row, size

from rocs_bt.base.clock import WallClock
from rocs_bt.base.errors import DeviceError
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.interfaces.device import Reading
from rocs_bt.ros2.devices.actuator_node import ActuatorNode
from rocs_bt.ros2.devices.parameters import TWIST, Ros2ActuatorParameters, Ros2SensorParameters
from rocs_bt.ros2.devices.sensor_node import SensorNode
from rocs_bt.ros2.messages.message_types import SCAN
from rocs_bt.ros2.network.node import RosNode
from rocs_bt.ros2.settings import Ros2Settings

CROSSINGS = size(200, 2)
P50, P99 = 5.0, 20.0  # [ms]
WHEELS = make_locomotion("differential", wheel_separation=0.331, max_wheel_speed=1.2, max_wheel_acceleration=1.0)


class Robot:
    """The robot's process.

    Attributes:
        delays: Times from the publication of the near scan to the command [ms].
    """

    def __init__(self, clock: WallClock, wheels: RosWheels) -> None:
        self.delays: list[float] = []
        self._clock = clock
        self._wheels = wheels
        command = [sys.executable, str(Path(ros2_peer.__file__))]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def tell(self, word: str) -> None:
        """Move the obstacle: `near` or `far`."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{word}\n")
        self._process.stdin.flush()

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()
        self._thread.join()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            published, arrived = map(float, line.split())
            self.delays.append(1e3 * (arrived - published))
            self._wheels.back = self._clock.now() - (time.time() - arrived)
            self._wheels.backs.set()


class RosSonar(Sonar):
    """Sixteen sectors of the scans."""

    robot: Robot

    def __init__(self, clock: WallClock, node: RosNode) -> None:
        self._far = FAR
        super().__init__(clock)
        keys = Ros2SensorParameters(type=SCAN, topic="scan", rays=ros2_peer.RAYS, span=ros2_peer.SPAN)
        self._sensor = SensorNode("sonar", node, keys)

    @property
    def ahead(self) -> float:
        """Distance of the obstacle [m]."""
        return self._far

    @ahead.setter
    def ahead(self, distance: float) -> None:
        if distance != self._far:
            self._far = distance
            self.robot.tell("near" if distance == NEAR else "far")

    def read(self) -> Reading:
        began = self.clock.now()
        reading = self._sensor.read()
        if min(reading.values) < 2.0 * NEAR and self._far == NEAR and self.sampled is None:
            self.sampled = began
        return reading


class RosWheels(Wheels):
    """Wheels that publish the twist; the robot's process notes the first backward command."""

    def __init__(self, clock: WallClock, node: RosNode) -> None:
        super().__init__(clock)
        self._actuator = ActuatorNode("wheels", node, Ros2ActuatorParameters(topic="cmd_vel", type=TWIST), WHEELS)

    def command(self, values: Sequence[float]) -> None:
        self._actuator.command(values)

    def neutral(self) -> None:
        self._actuator.neutral()


def over_ros(burn: float, plan: float) -> tuple[list[float], list[float]]:
    """Latencies [ms] from the sample, and from the publication; see `bench_reflex.measure`."""
    opened: list[RosNode | Robot] = []

    def devices(clock: WallClock) -> tuple[Sonar, Wheels]:
        node = RosNode(Ros2Settings(transport="dds"), clock)
        wheels, sonar = RosWheels(clock, node), RosSonar(clock, node)
        sonar.robot = Robot(clock, wheels)
        opened.extend([sonar.robot, node])
        end = time.monotonic() + 30.0
        while time.monotonic() < end:  # until the scans arrive
            try:
                sonar.read()
                break
            except DeviceError:
                time.sleep(0.05)
        return sonar, wheels

    try:
        found = measure(burn, plan, CROSSINGS, devices=devices)
        robot = opened[0]
        return found, robot.delays if isinstance(robot, Robot) else []
    finally:
        for each in opened:
            each.close()


def processor() -> str:
    """Name of the CPU."""
    lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines() if sys.platform == "linux" else []
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def run() -> Iterator[Row]:
    """All rows."""
    for what, burn, plan, judged in (("idle", 0.0, 10.0, True), ("busy leaf", 1.9, 0.5, False)):
        plain = measure(burn, plan, CROSSINGS)
        found, published = over_ros(burn, plan)
        title = f"reflex over ROS 2, {what}, {processor()}, {len(found)} crossings"
        for name, part, budget in (("p50", 0.5, P50), ("p99", 0.99, P99)):
            value, base = quantile(found, part), quantile(plain, part)
            judge = (f"<= {budget:g} ms", value <= budget) if judged else ("", None)
            yield Row(f"{title}: {name}", value, "ms", "the same without ROS", value / base, *judge)
        yield Row(f"the same from the publication on, {what}: p50", quantile(published, 0.5), "ms")


def quantile(values: Sequence[float], part: float) -> float:
    """Value below which a part of the values lies."""
    return sorted(values)[math.ceil(part * len(values)) - 1]
