"""Reflex latency in threaded mode, from the sensor's sample to the actuator's command.

The P3DX's complete agent (its robot.toml, the shipped rules and the mission `go_to`) on mock devices in wall time,
with a recording. An obstacle comes near at random times. First a leaf of the plan keeps the CPU busy in Python, then
the plan is idle.

Run it with `python benchmarks reflex`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import math
import random
import statistics
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel
from row import Row, size

from rocs_bt.agent import AgentRuntime, Controller, ThreadedRunner
from rocs_bt.base.clock import WallClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, PlaceSpec
from rocs_bt.interfaces.device import Actuator, Reading, Sensor
from rocs_bt.knowledge import Knowledge
from rocs_bt.plan import Mission
from rocs_bt.record import Recorder, RunHeader
from rocs_bt.running import SinkThread
from rocs_bt.share.sharing import Sharing
from rocs_bt.testing.mock_agent import MockDevices, mock_agent, mock_rates

CROSSINGS = size(200, 2)
P50, P99 = 2.0, 10.0  # [ms]
PATIENCE = 60.0  # [s] timeout of a reflex
PAPER = 78.0  # [ms] the paper's C++: mean latency of its reactive route; maximum 138 ms
NEAR, FAR = 0.15, math.inf  # [m]


class Sonar(Sensor):
    """Ring of sonars with an optional obstacle in front."""

    def __init__(self, clock: WallClock) -> None:
        super().__init__("sonar")
        self.clock = clock
        self.ahead = FAR
        self.sampled: float | None = None  # time of the first near sample

    def read(self) -> Reading:
        now, ahead = self.clock.now(), self.ahead
        if ahead == NEAR and self.sampled is None:
            self.sampled = now
        return Reading(now, [2.0 if i > 8 else ahead if i in (3, 4) else 1.5 for i in range(16)])


class Wheels(Actuator):
    """Wheels that record the time of the first backward command."""

    def __init__(self, clock: WallClock) -> None:
        super().__init__("wheels", 2)
        self.clock = clock
        self.back: float | None = None
        self.backs = threading.Event()

    def command(self, values: list[float]) -> None:
        if values[0] < 0.0 and self.back is None:
            self.back = self.clock.now()
            self.backs.set()

    def neutral(self) -> None:
        pass


class Burn(Behaviour):
    """Leaf that keeps the CPU busy in Python without sleeping."""

    def __init__(self, seconds: float) -> None:
        super().__init__("Burn")
        self.seconds = seconds

    def update(self) -> Status:
        end = time.monotonic() + self.seconds
        while time.monotonic() < end:
            sum(i * i for i in range(100))
        return Status.RUNNING


Devices = Callable[[WallClock], tuple[Sonar, Wheels]]


def measure(
    burn: float,
    plan: float,
    crossings: int = CROSSINGS,
    share: Callable[[Knowledge], Sharing] | None = None,
    devices: Devices = lambda clock: (Sonar(clock), Wheels(clock)),
) -> list[float]:
    """Latencies [ms], with a leaf that is busy for `burn` [s] per tick, a plan at `plan` [Hz], optional sharing."""
    clock, catalog = WallClock(running=False), Catalog()
    sonar, wheels = devices(clock)

    def build(mission: Mission) -> Behaviour:
        drive = mission.act("GoTo", goal="far")
        return Parallel("both", ParallelPolicy.SuccessOnAll(synchronise=False), [drive, Burn(burn)])

    def prepare(mock: MockDevices) -> None:
        mock.sensors["sonar"] = sonar
        mock.actuators["wheels"].wrap(lambda device: wheels)

    rules = [catalog.find("rules", "avoid_collision").path]
    controller = Controller(build, rules=rules, places=[PlaceSpec(name="far", pose=Pose2(9.0, 0.0), agents=("R1",))])
    with tempfile.TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder) / "run.mcap", RunHeader(scenario="reflex", seed=1, mode="threaded"))
        with SinkThread(recorder) as sink:
            robot = catalog.load_robot("pioneer_p3dx")
            agent, _ = mock_agent(
                robot, controller, AgentRuntime(clock, sink), rates=mock_rates(plan=plan), prepare=prepare, share=share
            )
            clock.start()
            with ThreadedRunner(agent, clock):
                found = cross(sonar, wheels, crossings)
            agent.close()
            if agent.failure is not None:
                raise agent.failure
        recorder.close()
    return found


def cross(sonar: Sonar, wheels: Wheels, crossings: int) -> list[float]:
    """Let an obstacle come near repeatedly at random phases."""
    phase, found = random.Random(1), []
    time.sleep(0.5)
    while len(found) < crossings:
        sonar.sampled = wheels.back = None
        wheels.backs.clear()
        sonar.ahead = NEAR
        if not wheels.backs.wait(PATIENCE) or sonar.sampled is None or wheels.back is None:
            raise RuntimeError(f"crossing {len(found)} caused no reflex within {PATIENCE:g} s")
        found.append(1e3 * (wheels.back - sonar.sampled))
        sonar.ahead = FAR
        time.sleep(phase.uniform(0.15, 0.25))
    return found


def rows(what: str, found: list[float], judged: bool) -> list[Row]:
    """p50, p99 and the maximum."""
    ordered = sorted(found)
    p50, p99 = statistics.median(ordered), ordered[math.ceil(0.99 * len(ordered)) - 1]
    name = f"reflex, threaded, {what}, {len(found)} crossings"
    paper = "the paper's C++, 78 ms"
    return [
        Row(f"{name}: p50", p50, "ms", paper, p50 / PAPER, f"<= {P50:g} ms", p50 <= P50 if judged else None),
        Row(f"{name}: p99", p99, "ms", paper, p99 / PAPER, f"<= {P99:g} ms", p99 <= P99 if judged else None),
        Row(f"{name}: max", ordered[-1], "ms", "the paper's C++, 138 ms", ordered[-1] / 138.0),
    ]


def run() -> Iterator[Row]:
    """All rows."""
    yield from rows("busy leaf", measure(burn=1.9, plan=0.5), True)
    yield from rows("idle", measure(burn=0.0, plan=10.0), True)
