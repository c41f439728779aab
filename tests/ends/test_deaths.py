"""Campaign: processes of a drive die, stop or hang at random moments; the robot over UDP holds its last command."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from ..deaths import DEATHS, TRAP, ten_deaths
from ..udp_robot import UdpRobot
from .conftest import Process, driving

COMMAND = "    def command(self, values):\n"


@dataclass
class Driven:
    """The robot, and the agent that drives it; see `deaths.Driven`."""

    robot: UdpRobot
    agent: Process
    folder: Path

    def wait_until_moving(self) -> None:
        self.robot.wait_until_moving()

    def until_zero(self, fault: float, count: int) -> float:
        self.robot.wait_until_neutral(count)
        with self.robot.arrived:
            lines = [(at, any(speeds)) for at, (_, speeds) in zip(self.robot.times, self.robot.received, strict=True)]
        last = max(i for i, (_, moves) in enumerate(lines) if moves)
        return lines[last + 1][0] - min(lines[last][0], fault)


def trapped(text: str) -> str:
    """The driver, with a trap at the begin of its command."""
    head, rest = text.split("\nclass ", 1)
    return f"{head}{TRAP}\n\nclass {rest.replace(COMMAND, COMMAND + '        spring()' + chr(10))}"


@pytest.mark.soak
@pytest.mark.parametrize("death", DEATHS)
def test_ten_deaths(creep, robot, death):
    folder = creep(isolated=True, driver=trapped)

    @contextmanager
    def drive(_: int) -> Iterator[Driven]:
        with driving() as process:
            yield Driven(robot, process, folder)

    ten_deaths(death, drive)
