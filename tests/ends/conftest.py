"""Runs and drives in processes of their own that a test ends: by signals, a full disk, kill -9."""

from __future__ import annotations

import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from rocs_bt.cli.main import call

from ..direct_project import drive_straight
from ..udp_robot import UdpRobot, write_project

LONG = """format = "scenario/2"
base = "rounds"
duration = "3600 s"
[[agent]]
name = "R2"
[agent.parameters]
rounds = 1000
"""
BEGUN = 150_000
"""Size of a recording from which on the robot certainly drives [B]."""

REPORTED = ("-m", "rocs_bt", "drive", "real")
DRIVE = (*REPORTED, "--no-report")

CREEP = """
import py_trees
from rocs_bt.base.units import MetresPerSecond


class Worm(py_trees.behaviour.Behaviour):
    ticks = 0

    def update(self):
        self.ticks += 1
        if {raises} and self.ticks > 10:
            raise ValueError("a worm")
        return py_trees.common.Status.RUNNING


def build(mission):
    both = py_trees.composites.Parallel("both", py_trees.common.ParallelPolicy.SuccessOnAll())
    both.add_children([mission.act("SetWheelSpeed", speeds=[0.1, 0.1]), Worm("worm")])
    return both
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new project with the scenario `long`, which drives for an hour; the current folder."""
    assert call(["new", str(tmp_path / "yard")]) == 0
    drive_straight(tmp_path / "yard")
    monkeypatch.chdir(tmp_path / "yard")
    (tmp_path / "yard/scenarios/long.toml").write_text(LONG)
    return tmp_path / "yard"


class Process(subprocess.Popen[str]):
    """A command in a process of its own."""

    def __init__(self, *command: str, file_size: int | None = None) -> None:
        def prepare() -> None:
            if file_size is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))

        super().__init__(
            [sys.executable, *command],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=prepare,
        )

    def wait_for(self, file: Path, size: int = BEGUN) -> None:
        """Wait until a file has grown to a size [B]; fails if the process ends before."""
        while not (file.exists() and file.stat().st_size >= size):
            with suppress(subprocess.TimeoutExpired):
                self.wait(0.01)
                raise AssertionError(f"the process has ended: {self.communicate()}")

    def notice(self) -> str:
        """The notice after a first signal, which begins with an empty line; what was printed before it is skipped."""
        assert self.stderr is not None
        while self.stderr.readline() != "\n":
            assert self.poll() is None
        return self.stderr.readline()

    def end(self, seconds: float = 60.0) -> tuple[int, str, str]:
        """Exit code, stdout and stderr; fails if the process does not end in time [s]."""
        out, err = self.communicate(timeout=seconds)
        return self.returncode, out, err


@pytest.fixture
def start(project: Path) -> Iterator[Callable[..., Process]]:
    """Starts commands in the project, and kills what is left of them."""
    running: list[Process] = []

    def start(*command: str, **limits: int) -> Process:
        running.append(Process(*command, **limits))
        return running[-1]

    yield start
    for process in running:
        process.kill()
        process.communicate()


@pytest.fixture
def robot() -> Iterator[UdpRobot]:
    with UdpRobot() as robot:
        yield robot


@pytest.fixture
def creep(tmp_path, monkeypatch, robot) -> Callable[..., Path]:
    """A project whose robot creeps ahead for ever, or until a leaf of its mission raises an exception."""
    monkeypatch.chdir(tmp_path)

    def write(*, isolated: bool, raises: bool = False, driver: Callable[[str], str] = lambda text: text) -> Path:
        write_project(tmp_path, robot.port, isolated=isolated, scenario='mission = "creep"\n')
        missions = tmp_path / "planners/missions"
        missions.mkdir(parents=True)
        (missions / "creep.py").write_text(CREEP.format(raises=raises))
        code = tmp_path / "robots/udp_p3dx/udp.py"
        code.write_text(driver(code.read_text()))
        return tmp_path

    return write


@contextmanager
def driving(*arguments: str, command: tuple[str, ...] = DRIVE) -> Iterator[Process]:
    """The command in its process, which is killed afterwards."""
    with Process(*command, *arguments) as process:
        try:
            yield process
        finally:
            process.kill()
