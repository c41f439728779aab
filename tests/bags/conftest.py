"""Recorded runs and their bags, for all tests of this folder."""

from pathlib import Path
from typing import NamedTuple

import pytest
from rosbags.highlevel import AnyReader

from rocs_bt import run as simulate
from rocs_bt.cli.main import call
from rocs_bt.record import Recording
from rocs_bt.ros2.bags.export import export_rosbag


@pytest.fixture(scope="session")
def record(tmp_path_factory):
    """Function that runs a scenario, once for all tests, and returns its recording."""
    runs = {}

    def run(scenario, duration=None):
        if (scenario, duration) not in runs:
            out = tmp_path_factory.mktemp(scenario)
            simulate(scenario, out=out, duration=duration, report=False)
            runs[scenario, duration] = Recording.open(out)
        return runs[scenario, duration]

    return run


@pytest.fixture(scope="session")
def exp1(record):
    return record("exp1")


@pytest.fixture(scope="session")
def exp1_bag(exp1, tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags") / "exp1"
    export_rosbag(exp1, folder)
    return folder


@pytest.fixture(scope="session")
def read_export(record, tmp_path_factory):
    """Function that exports a run once for all tests, and returns the messages of the bag by topic."""
    bags = {}

    def messages(scenario, duration=None):
        if (scenario, duration) not in bags:
            folder = tmp_path_factory.mktemp("bags") / scenario
            export_rosbag(record(scenario, duration), folder)
            bags[scenario, duration] = read(folder)
        return bags[scenario, duration]

    return messages


@pytest.fixture
def export(tmp_path):
    """Function that exports a recording and returns the folder of the bag."""

    def made(recording, name="bag", **options):
        export_rosbag(recording, tmp_path / name, **options)
        return tmp_path / name

    return made


class Told(NamedTuple):
    """Exit code, stdout and stderr of a command."""

    code: int
    out: str
    err: str


@pytest.fixture
def rocs_bt(capsys):
    """Function that runs `rocs-bt` with these arguments."""

    def run(*arguments):
        capsys.readouterr()
        return Told(call([str(a) for a in arguments]), *capsys.readouterr())

    return run


def read(bag: Path) -> dict[str, list[tuple[int, object]]]:
    """Messages of a bag by topic, as rosbags reads them: log time [ns] and message."""
    found: dict[str, list[tuple[int, object]]] = {}
    with AnyReader([bag]) as reader:
        for connection, time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append((time, message))
    return found
