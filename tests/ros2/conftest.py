"""ROS 2 for the tests: a domain of their own, and robots in plain rclpy that run in .venv-ros."""

from __future__ import annotations

import fcntl
import importlib.util
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from .nodes_at_work import AtWork, Servers
from .robot_process import RobotProcess
from .simulator_process import SimulatorProcess

if importlib.util.find_spec("rclpy") is None:
    collect_ignore = ["on_rclpy"]  # `make test` runs these in .venv-ros


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project without content."""
    for folder in ("planners", "rules", "robots", "scenarios"):
        (tmp_path / folder).mkdir()
    return tmp_path


@pytest.fixture
def domain() -> Iterator[int]:
    """A ROS domain that no other test on this machine uses at the same time."""
    for number in range(100, 0, -1):
        with Path(tempfile.gettempdir(), f"rocs_bt-ros-domain-{number}").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield number
            return
    pytest.fail("a hundred tests use ROS at the same time")


@pytest.fixture
def ros_environment(domain: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, str]:
    """The environment of this process and of others, which meet on the loopback interface in that domain."""
    for name in ("PYTHONPATH", "AMENT_PREFIX_PATH", "RMW_IMPLEMENTATION", "CYCLONEDDS_URI", "ROS_NAMESPACE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")  # killed processes leave shared memory behind
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "ros"))  # logs
    return dict(os.environ)


@pytest.fixture
def counterpart(ros_environment: dict[str, str], tmp_path: Path) -> Iterator[Callable[..., RobotProcess]]:
    """Starts robots in plain rclpy: `counterpart("--stamped", "--peer", "0,0,1,1,0.3", distribution="jazzy")`."""
    with ExitStack() as stack:
        count = iter(range(100))

        def start(*options: str, distribution: str = "here") -> RobotProcess:
            log = tmp_path / f"commands-{next(count)}.jsonl"
            return stack.enter_context(closing(RobotProcess([*options], distribution, ros_environment, log)))

        yield start


@pytest.fixture
def simulator(ros_environment: dict[str, str], tmp_path: Path) -> Iterator[Callable[..., SimulatorProcess]]:
    """Starts simulators: `simulator("exp1", "--rate", "2")`."""
    with ExitStack() as stack:

        def start(*options: str) -> SimulatorProcess:
            return stack.enter_context(closing(SimulatorProcess(options, ros_environment, tmp_path)))

        yield start


@pytest.fixture
def servers(ros_environment: dict[str, str], tmp_path: Path) -> Iterator[Servers]:
    """The program of servers.py: services, an action server, and topics to talk to, in the namespace r1."""
    started = Servers(ros_environment, tmp_path)
    yield started
    started.kill()


@pytest.fixture
def at_work(ros_environment: dict[str, str]) -> Iterator[Callable[..., AtWork]]:
    """Makes trees with nodes for ROS 2: `at_work('<RosPublish .../>', "dds", key=5)`."""
    with ExitStack() as stack:
        yield lambda *of, **keys: stack.enter_context(closing(AtWork(*of, **keys)))
