"""Agents that are killed or stopped while they drive the robot in plain rclpy; cmd_vel has a process of its own."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import psutil

from ..isolated import AWAKE
from .exp1 import HERE, OPTIONS, start_of, write_project
from .robot_process import RobotProcess, late_between

PERIOD, MAX_AGE = 0.05, 0.2  # [s] of control; max_command_age
SOON = MAX_AGE + 2 * PERIOD  # also without the publisher
OWN_TIMEOUT, BRAKING = 0.3, 0.4  # [s] of the robot
MOMENTS = 9.0  # [s] EXP1 takes 14 s
MAIN = """
from pathlib import Path
from rocs_bt import drive
from rocs_bt.catalog import Catalog
found = drive("real", Catalog(Path({project!r})), duration=100.0)
Path({project!r}, "outcome.txt").write_text(repr(found.summary.agents))
"""


@dataclass
class DrivenRobot:
    """A robot and the agent that drives it.

    Attributes:
        robot: The robot.
        main: Process of the agent.
        publisher: Process of the isolated actuator.
        folder: Project of the agent, which writes its outcome there.
    """

    robot: RobotProcess
    main: subprocess.Popen[bytes]
    publisher: psutil.Process
    folder: Path

    def drive(self, duration: float) -> None:
        """Wait until the robot is commanded to move, and then for a time [s]."""
        begun = time.time()
        self.robot.follow(lambda lines: self._goes_on() and sum(line.moves and line.t > begun for line in lines) >= 5)
        time.sleep(duration)

    def _goes_on(self) -> bool:
        outcome = self.folder / "outcome.txt"
        assert not outcome.exists(), outcome.read_text()
        return True

    def stopped(self, since: float) -> tuple[float, float]:
        """Wait for the robot's standstill, by commands of zero.

        A machine under load may delay the agent before, so that zero and motion alternate: what counts is the last
        command that moves the robot.

        Args:
            since: Time of the fault [s since 1970].

        Returns:
            Time from the last moving command, or from the fault if that came earlier, to the first of zero, by the
            publisher's stamps [s]; and that without the time in which the machine gave the robot no processor [s].
        """
        self.robot.follow(lambda lines: any(line.rests and line.t > since for line in lines))
        self.robot.until("speeds == [0.0, 0.0]")
        lines = self.robot.lines()
        commands = [line for line in lines if line.what == "command"]
        last = max(i for i, line in enumerate(commands) if line.moves)
        before, first = commands[last : last + 2]
        took = first.sent - min(before.sent, since)
        return took, took - late_between(lines, min(before.t, since), first.t)


@contextmanager
def driven(
    counterpart: Callable[..., RobotProcess], folder: Path, transport: str, real_time: bool
) -> Iterator[DrivenRobot]:
    """A robot that EXP1's agent drives from a process of its own."""
    write_project(folder, transport=transport)
    (folder / "main.py").write_text(MAIN.format(project=str(folder)))
    robot = counterpart(*OPTIONS, *start_of(1), distribution=HERE[transport])
    main = subprocess.Popen([sys.executable, *([] if real_time else [AWAKE]), "main.py"], cwd=folder)
    try:
        robot.follow(lambda lines: any(line.moves for line in lines))
        (publisher,) = psutil.Process(main.pid).children(recursive=True)
        yield DrivenRobot(robot, main, publisher, folder)
    finally:
        main.kill()
        main.wait()
        robot.close()


def killed(driven: DrivenRobot) -> tuple[float, float]:
    """Kill -9 of the agent: the publisher sends zero, and ends."""
    at = time.time()
    driven.main.kill()
    took = driven.stopped(at)
    assert driven.publisher.wait(30.0) is not False
    return took


def paused(driven: DrivenRobot) -> tuple[float, float]:
    """SIGSTOP of the agent: the publisher sends zero; after SIGCONT the robot drives on."""
    at = time.time()
    driven.main.send_signal(signal.SIGSTOP)
    took = driven.stopped(at)
    driven.main.send_signal(signal.SIGCONT)
    return took


def both_killed(driven: DrivenRobot) -> tuple[float, float]:
    """Kill -9 of agent and publisher: the robot stops by its own time-out."""
    driven.publisher.kill()
    driven.main.kill()
    lines = driven.robot.follow(lambda lines: lines[-1].what == "stopped")
    last = next(line for line in reversed(lines) if line.what == "command")
    assert driven.robot.report()["expired"] >= last.moves
    took = lines[-1].t - last.t
    return took, took - late_between(lines, last.t, lines[-1].t)


def publisher_killed(driven: DrivenRobot) -> tuple[float, float]:
    """Kill -9 of the publisher: the agent sends zero, three times, and ends its run."""
    return _without_publisher(driven, signal.SIGKILL)


def publisher_stopped(driven: DrivenRobot) -> tuple[float, float]:
    """SIGSTOP of the publisher: the agent kills it, sends zero, three times, and ends its run."""
    return _without_publisher(driven, signal.SIGSTOP)


def _without_publisher(driven: DrivenRobot, number: int) -> tuple[float, float]:
    at = time.time()
    driven.publisher.send_signal(number)
    took = driven.stopped(at)
    driven.robot.follow(lambda lines: sum(line.rests and line.t > at for line in lines) >= 3)
    assert driven.main.wait(30.0) == 0
    assert not psutil.pid_exists(driven.publisher.pid)
    return took


def shortest(attempt: Callable[[int], float], limit: float) -> float:
    """Shortest time of up to three attempts [s]; the first one within the limit is the last attempt.

    Load of the machine delays single attempts, a defect delays all.
    """
    took = [attempt(0)]
    while len(took) < 3 and min(took) > limit:
        took.append(attempt(len(took)))
    return min(took)


def moments(seed: int, count: int) -> list[float]:
    """Random moments of a run [s]."""
    chance = random.Random(seed)
    return [chance.uniform(0.0, MOMENTS) for _ in range(count)]


def report(what: str, took: list[tuple[float, float]], limit: float) -> None:
    """Print the times of a campaign, and check them."""
    raw, awake = zip(*took, strict=True)
    print(f"{what}, {len(took)} times: zero after {min(raw):.3f} to {max(raw):.3f} s, awake at most {max(awake):.3f} s")
    assert max(awake) <= limit
