"""Agents that die while they drive the robot in plain rclpy; cmd_vel has a process of its own."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import psutil

from ..deaths import SOON, TRAP, die, ten_deaths
from ..isolated import AWAKE
from .exp1 import HERE, OPTIONS, start_of, write_project
from .robot_process import RobotProcess, late_between

OWN_TIMEOUT, BRAKING = 0.3, 0.4  # [s] of the robot
HOLDS = ("--timeout", "1000")  # options of a robot that holds its last command
QUICK = ["agent killed", "agent stopped", "wheels killed", "wheels stopped"]  # deaths in `make test`
TRAPPED = f"""{TRAP}
from rocs_bt.ros2.devices.actuator_node import ActuatorNodeMaker

class TrappedMaker(ActuatorNodeMaker):
    def __call__(self, host):
        device = super().__call__(host)
        command = device.command
        device.command = lambda values: (spring(), command(values))
        return device
"""
MAIN = """
import sys
from pathlib import Path
sys.path.insert(0, str(Path.cwd()))
from trapped import TrappedMaker
from rocs_bt import drive
from rocs_bt.catalog import Catalog
from rocs_bt.ros2.devices import actuator_node
actuator_node.ActuatorNodeMaker = TrappedMaker
found = drive("real", Catalog(Path.cwd()), duration=100.0)
Path("outcome.txt").write_text(repr(found.summary.agents))
"""


@dataclass
class DrivenRobot:
    """A robot and the agent that drives it; see `deaths.Driven`.

    Attributes:
        robot: The robot.
        agent: Process of the agent.
        folder: Project and current folder of the agent, which writes its outcome there.
        awake: Whether times are without those in which the machine gave the robot no processor.
    """

    robot: RobotProcess
    agent: subprocess.Popen[bytes]
    folder: Path
    awake: bool

    @property
    def publisher(self) -> psutil.Process:
        """Process of the isolated actuator."""
        (publisher,) = psutil.Process(self.agent.pid).children(recursive=True)
        return publisher

    def wait_until_moving(self) -> None:
        begun = time.time()
        self.robot.follow(lambda lines: self._goes_on() and sum(line.moves and line.t > begun for line in lines) >= 5)

    def _goes_on(self) -> bool:
        outcome = self.folder / "outcome.txt"
        assert self.agent.poll() is None, outcome.read_text() if outcome.exists() else "the agent has ended"
        return True

    def until_zero(self, fault: float, count: int) -> float:
        """As of `deaths.Driven`, but of several zeros the robot keeps only the newest: its queue has a depth of 1."""
        self.robot.follow(lambda lines: any(line.rests and line.t > fault for line in lines))
        self.robot.until("speeds == [0.0, 0.0]")
        lines = self.robot.lines()
        commands = [line for line in lines if line.what == "command"]
        last = max(i for i, line in enumerate(commands) if line.moves)  # zero and motion may alternate under load
        begin, end = min(commands[last].t, fault), commands[last + 1].t
        return end - begin - (late_between(lines, begin, end) if self.awake else 0.0)


@contextmanager
def driven(
    counterpart: Callable[..., RobotProcess],
    folder: Path,
    transport: str,
    *options: str,
    real_time: bool = True,
    first: str = "",
) -> Iterator[DrivenRobot]:
    """A robot that EXP1's agent drives from a process of its own, which runs the code `first` at its start."""
    write_project(folder, transport=transport)
    for name, text in {"main.py": first + MAIN, "trapped.py": TRAPPED}.items():
        (folder / name).write_text(text)
    robot = counterpart(*OPTIONS, *start_of(1), *options, distribution=HERE[transport])
    agent = subprocess.Popen([sys.executable, *([] if real_time else [AWAKE]), "main.py"], cwd=folder)
    try:
        found = DrivenRobot(robot, agent, folder, awake=not real_time)
        found.wait_until_moving()
        yield found
    finally:
        agent.kill()
        agent.wait()
        robot.close()


def dies(death: str, driven: DrivenRobot) -> float:
    """Let a death happen, and check what comes after; returns the time until zero [s]."""
    publisher = driven.publisher
    took = driven.until_zero(die(death, driven), 1 if death == "agent stopped" else 3)
    if death == "agent stopped":
        driven.agent.send_signal(signal.SIGCONT)
        driven.wait_until_moving()
    elif death == "agent killed":
        publisher.wait(30.0)
    else:
        assert driven.agent.wait(30.0) == 0
        assert not psutil.pid_exists(publisher.pid)
    return took


def both_killed(driven: DrivenRobot) -> float:
    """Kill agent and publisher: the robot stops by its own time-out; returns its duration and that of braking [s]."""
    driven.publisher.kill()
    driven.agent.kill()
    lines = driven.robot.follow(lambda lines: lines[-1].what == "stopped")
    last = next(line for line in reversed(lines) if line.what == "command")
    assert driven.robot.report()["expired"] >= last.moves
    return lines[-1].t - last.t - late_between(lines, last.t, lines[-1].t)


def stops_in_time(
    counterpart: Callable[..., RobotProcess], folder: Path, transport: str, real_time: bool, death: str
) -> None:
    """One death of QUICK, or both processes killed.

    Load of the machine delays single attempts, a defect delays all three.
    """
    limit, options, case = (
        (SOON, HOLDS, partial(dies, death)) if death in QUICK else (OWN_TIMEOUT + BRAKING, (), both_killed)
    )
    took: list[float] = []
    while len(took) < 3 and min(took, default=math.inf) > limit:
        with driven(counterpart, folder / str(len(took)), transport, *options, real_time=real_time) as robot:
            took.append(case(robot))
    assert min(took) <= limit


def is_held_and_goes_on(counterpart: Callable[..., RobotProcess], folder: Path, transport: str) -> None:
    """Stop the publisher for a while: the agent's process, the second publisher, stops the robot, and the run goes on.

    However late the publisher is continued here, it is not killed.
    """
    patient = "from rocs_bt.devices.isolated import silence\nsilence.HUNG = 1e9\n"
    with driven(counterpart, folder, transport, *HOLDS, real_time=False, first=patient) as robot:
        publisher = robot.publisher
        publisher.suspend()
        robot.until_zero(time.time(), 1)
        publisher.resume()
        robot.wait_until_moving()
        assert robot.publisher == publisher


def ten_deaths_of_drives(counterpart: Callable[..., RobotProcess], folder: Path, transport: str, death: str) -> None:
    """A campaign, for `make soak`."""
    ten_deaths(death, lambda number: driven(counterpart, folder / str(number), transport, *HOLDS))
