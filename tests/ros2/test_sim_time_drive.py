"""`rocs_bt.drive` on a simulator's clock that stops or restarts, on a network in memory."""

from __future__ import annotations

import re
import threading
import time

import py_trees
import pytest

from rocs_bt import ListSink, drive
from rocs_bt.base.errors import DeviceError
from rocs_bt.event import MotionHeld
from rocs_bt.ros2 import service
from rocs_bt.ros2.messages import fields as messages
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network import clock_watch, node
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Endpoint

from .exp1 import ROBOT, write_project
from .network import Network

BOOL, CLOCK, ODOMETRY = "std_msgs/msg/Bool", "rosgraph_msgs/msg/Clock", "nav_msgs/msg/Odometry"
PATIENCE = 30.0  # [s]
STOPPED = 2.0  # [s] until the notice
AT_REST = {"pose": {"orientation": {"w": 1.0}}}
SENSORS = ("position", "orientation")
SETTINGS = '[ros2]\nuse_sim_time = true\nemergency_stop = "emergency_stop"'


class Simulator(threading.Thread):
    """Simulator of a robot at rest, on a network in memory.

    Attributes:
        time: Simulated time [s].
        jumps: Simulated times to which the time jumps next [s].
        paused: Whether the time is stopped.
        odometry: Whether the robot's odometry is published.
    """

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.network = Network(TypeStore())
        self.network.peers = [
            Endpoint("/r1/cmd_vel", "geometry_msgs/msg/TwistStamped", "/base", False, QoS.COMMAND),
            Endpoint("/r1/emergency_stop", BOOL, "/panel", True, QoS.COMMAND),
        ]
        self.time, self.paused, self.odometry = 1000.0, False, True
        self.jumps: list[float] = []
        self.over = threading.Event()

    def run(self) -> None:
        while not self.over.wait(0.01):
            self.network.time += 0.01
            if self.paused:
                continue
            self.time = self.jumps.pop() if self.jumps else self.time + 0.01
            now = messages.clock(self.time)
            self.network.send("/clock", CLOCK, **now)
            if self.odometry:
                self.network.send("/r1/odom", ODOMETRY, header={"stamp": now["clock"]}, pose=AT_REST)


class Drive(threading.Thread):
    """`rocs_bt.drive` of a mission that stays, or turns, with what it reports."""

    def __init__(self, catalog) -> None:
        super().__init__(daemon=True)
        self.catalog, self.wait, self.error = catalog, 10.0, None
        self.turns = False
        self.notices: list[str] = []
        self.sink, self.progress, self.polled = ListSink(), [], threading.Event()

    def run(self) -> None:
        stay = py_trees.behaviours.Running("stay")
        missions = {"R2": lambda mission: mission.act("SetTwist", turn=0.5) if self.turns else stay}
        options = {
            "notice": self.notices.append,
            "sinks": [self.sink],
            "progress": self.progress.append,
            "wait": self.wait,
        }
        try:
            drive("real", self.catalog, duration=900.0, missions=missions, go=self.asked, **options)
        except DeviceError as error:
            self.error = error

    def asked(self) -> bool:
        self.polled.set()
        return False

    def until(self, what) -> None:
        """Wait until a condition holds."""
        end = time.monotonic() + PATIENCE
        while not what():
            assert time.monotonic() < end, self.notices
            assert self.is_alive(), str(self.error)
            time.sleep(0.01)


@pytest.fixture
def simulator(monkeypatch):
    simulator = Simulator()
    for module in (node, service):
        monkeypatch.setattr(module, "open_transport", lambda *_: simulator.network)
    monkeypatch.setattr(clock_watch, "PATIENCE", STOPPED)
    simulator.start()
    yield simulator
    simulator.over.set()
    simulator.join()


@pytest.fixture
def run(simulator, tmp_path):
    blocks = ROBOT.replace("[ros2]", SETTINGS).split("\n[[")
    kept = [b for b in blocks[1:] if b.startswith("actuator") or any(f'name = "{name}"' in b for name in SENSORS)]
    kept.append('monitor]]\nname = "pose"\nclass = "PoseMonitor"\nsensors = ["position", "orientation"]\n')
    kept = [block for block in kept if not block.startswith("analyze")]
    catalog = write_project(tmp_path)
    (tmp_path / "robots/own/robot.toml").write_text("\n[[".join([blocks[0], *kept]))
    with (tmp_path / "scenarios/real.toml").open("a") as scenario:
        scenario.write("rules = []\nparameters = {}\n")
    run = Drive(catalog)
    yield run
    simulator.jumps.append(3000.0)  # a run that hangs ends
    simulator.paused = False
    run.join(PATIENCE)
    assert not run.is_alive()


@pytest.mark.parametrize("started", [True, False], ids=["in the run", "before the start"])
def test_a_restart_of_the_simulator_ends_the_run(simulator, run, started):
    simulator.odometry = started
    run.start()
    run.until((lambda: len(run.progress) > 5) if started else run.polled.is_set)
    simulator.jumps.append(1.0)
    run.join(PATIENCE)
    assert not run.is_alive()
    assert "the simulator was restarted" in str(run.error)


def test_a_pause_before_the_start_ends_the_wait_for_sensors(simulator, run):
    simulator.odometry, run.wait = False, 3.0
    run.start()
    run.until(run.polled.is_set)
    simulator.paused = True
    run.join(PATIENCE)
    assert not run.is_alive()
    found = re.search(r"no new time on /clock for (\d+\.\d) s", str(run.error))
    assert found, run.error
    assert float(found[1]) >= run.wait


def test_a_pause_of_the_simulator_is_a_notice_and_the_stop_topic_still_counts(simulator, run):
    run.start()
    run.until(lambda: len(run.progress) > 5)
    assert run.notices[0] == "use_sim_time: isolated = true has no effect on own/wheels."
    simulator.paused = True  # a starved thread is a pause, too, so only the last notice counts
    run.until(lambda: run.notices[-1].startswith("no new time on /clock for 2 s: the run waits for the simulator"))
    simulator.network.send("/r1/emergency_stop", BOOL, data=True)
    run.until(lambda: any(isinstance(event, MotionHeld) for event in run.sink.events))
    assert simulator.paused
    before = len(run.progress)
    simulator.paused = False
    run.until(lambda: len(run.progress) > before + 5 and run.notices[-1] == "/clock goes on: the run continues.")


def test_a_robot_that_moves_when_the_clock_stops_is_commanded_zero_and_then_drives_on(simulator, run):
    def newest():
        sent = simulator.network.published.get("/r1/cmd_vel")
        return sent[-1].twist.angular.z if sent else 0.0

    run.turns = True
    run.start()
    run.until(lambda: newest() > 0.1)
    simulator.paused = True
    run.until(lambda: newest() == 0.0)
    time.sleep(0.2)
    assert newest() == 0.0
    assert simulator.paused
    simulator.paused = False
    run.until(lambda: newest() > 0.1)
