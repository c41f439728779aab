"""The robot of counterpart.py as a process."""

from __future__ import annotations

import importlib.util
import json
import select
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENTS = {"jazzy": ROOT / ".venv-ros", "kilted": ROOT / ".venv-ros-kilted"}
BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"  # set with LD_LIBRARY_PATH in each process with wheels of ROS 2
PATIENCE = 60.0  # [s] far longer than a line of the robot may take


def ros_python(distribution: str) -> Path:
    """Python with a distribution of ROS 2; skips the test where there is none. "here" is this process's own."""
    if distribution == "here" and importlib.util.find_spec("rclpy") is not None:
        return Path(sys.executable)
    folder = ENVIRONMENTS["jazzy" if distribution == "here" else distribution]
    if (reason := folder / "unavailable").exists():
        pytest.skip(reason.read_text().strip())
    if not (folder / ".set-up").exists():
        pytest.skip(f"no {folder.name}: `make test` makes .venv-ros, `make soak` also .venv-ros-kilted")
    return folder / "bin" / "python"


class Line(NamedTuple):
    """Line of the robot's log.

    Attributes:
        t: Time at which the robot received or noted it [s since 1970].
        what: `command`, `stopped`, `fault` or `late`.
        sent: Time at which a command was published [s since 1970]; how late the robot was [s].
        header: Stamp of a command's header [s since 1970].
        v: Speed that is commanded [m/s].
        w: Turn rate that is commanded [rad/s].
    """

    t: float
    what: str
    sent: float = 0.0
    header: float | None = None
    v: float = 0.0
    w: float = 0.0

    @property
    def moves(self) -> bool:
        """Whether it is a command that moves the robot."""
        return self.what == "command" and bool(self.v or self.w)

    @property
    def rests(self) -> bool:
        """Whether it is a command of zero."""
        return self.what == "command" and not (self.v or self.w)


def late_between(lines: list[Line], begin: float, end: float) -> float:
    """Time for which the machine gave the robot no processor [s]."""
    late = [(line.t - line.sent, line.t) for line in lines if line.what == "late"]
    return sum(max(min(until, end) - max(since, begin), 0.0) for since, until in late)


class RobotProcess:
    """A robot that runs.

    Args:
        options: Options of counterpart.py.
        distribution: "jazzy", "kilted" or "here".
        environment: Environment of the process.
        log: File in which the robot writes its commands.

    Attributes:
        process: The process.
        ended: Its last report; empty while it runs.
    """

    def __init__(self, options: list[str], distribution: str, environment: dict[str, str], log: Path) -> None:
        python, self.log, self.ended = ros_python(distribution), log, {}
        if BOOTSTRAPPED in environment:
            environment = {k: v for k, v in environment.items() if k not in (BOOTSTRAPPED, "LD_LIBRARY_PATH")}
        command = [python, Path(__file__).with_name("counterpart.py"), "--log", log, *options]
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen([*map(str, command)], env=environment, **pipes)
        assert self.read()["ready"]

    def read(self) -> dict[str, Any]:
        """The next line that the robot prints."""
        assert self.process.stdout is not None
        assert select.select([self.process.stdout], [], [], PATIENCE)[0], "the robot prints nothing"
        line = self.process.stdout.readline()
        assert line, f"the robot's process ended with {self.process.wait()}"
        return json.loads(line)

    def tell(self, line: str) -> None:
        """Make a fault happen, or press or release the emergency stop; see counterpart.py."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def report(self) -> dict[str, Any]:
        """The robot's state now."""
        self.tell("report")
        return self.read()

    def until(self, wanted: str) -> dict[str, Any]:
        """Wait until an expression of the report holds, as `commands > 3`."""
        end = time.monotonic() + PATIENCE
        while not eval(wanted, dict(report := self.report())):
            assert time.monotonic() < end, f"{wanted} never holds: {report}"
            time.sleep(0.02)
        return report

    def lines(self) -> list[Line]:
        """The log so far."""
        return [Line(*json.loads(line)) for line in self.log.read_text().splitlines(keepends=True) if line[-1] == "\n"]

    def follow(self, wanted: Callable[[list[Line]], bool]) -> list[Line]:
        """Wait until a condition of the log holds; the log."""
        end = time.monotonic() + PATIENCE
        while not wanted(lines := self.lines()):
            assert time.monotonic() < end, f"it never came; the last lines: {lines[-5:]}"
            time.sleep(0.02)
        return lines

    def end(self) -> dict[str, Any]:
        """Ask the robot to end, and return its last report."""
        if not self.ended:
            self.process.terminate()
            self.ended = self.read()
            self.process.wait(PATIENCE)
        return self.ended

    def close(self) -> None:
        """End the process, however it fares."""
        self.process.terminate()
        try:
            self.process.communicate(timeout=5.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.communicate()
