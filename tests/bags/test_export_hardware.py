"""Export of a run on hardware: names and frames are those of the robot, and a replay has the signals of the run."""

import threading
import time

import numpy as np
import py_trees
import pytest

from rocs_bt import drive
from rocs_bt.base.geometry import Pose3
from rocs_bt.catalog import Catalog
from rocs_bt.record import Recording
from rocs_bt.record.fold.arrays import signal_table
from rocs_bt.ros2.devices.parameters import TWIST_STAMPED
from rocs_bt.ros2.messages.message_types import MESSAGES, ODOMETRY, SCAN, TRANSFORMS, Channel, pose_values
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network import node
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Endpoint

from ..ros2.network import Network
from .conftest import read
from .robots import cart
from .test_export import frames

BEACON = """
[[sensor]]
name = "beacon"
driver = "ros2"
monitor = "all"
signal = "read"
topic = "/tf"
type = "tf2_msgs/msg/TFMessage"
[[monitor]]
name = "all"
class = "all.py:All"
sensors = ["beacon"]
"""
ALL = """
from rocs_bt import Monitor, Signal


class All(Monitor):
    def signals(self):
        return [Signal("read")]

    def expects(self):
        return {}

    def interpret(self, readings):
        return {"read": [float(len(readings))]}
"""


SCAN_CHANNEL = Channel("laser", first=-np.pi, step=np.pi / 180.0, limits=(0.1, 8.0))


def messages_at(k):
    """Type, values and channel of the k-th message of each topic."""
    x, poses = 0.01 * k, Channel("map", "base_link")
    pose, twist = pose_values(Pose3(x, 2.0 * x, 0.1, 0.01, 0.02, 0.3)), [0.2, 0.0, 0.0, 0.1 + x]
    ranges = 1.0 + x + 0.01 * np.arange(360)
    ranges[17], ranges[200] = np.inf, np.nan
    return {
        "/r1/scan": (SCAN, {"ranges": ranges}, SCAN_CHANNEL),
        "/r1/odom": (ODOMETRY, {**pose, "twist": twist}, poses),
        "/tf": (TRANSFORMS, pose, poses),
    }


class Live(Network):
    """Network in memory whose clock runs."""

    def now(self):
        return time.time()


class Robot(threading.Thread):
    """Robot on a network in memory that publishes each topic at 20 Hz."""

    def __init__(self):
        super().__init__(daemon=True)
        self.network, self.over = Live(TypeStore()), threading.Event()
        self.network.peers = [Endpoint("/r1/cmd_vel", TWIST_STAMPED, "/base", False, QoS.COMMAND)]

    def run(self):
        k = 0
        while not self.over.wait(0.05):
            k += 1
            for topic, (kind, values, channel) in messages_at(k).items():
                self.network.send(topic, kind, **MESSAGES[kind].make(1.0 + 0.05 * k, values, channel))


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """Project with the robot `cart` and the scenario `real`."""
    folder = tmp_path_factory.mktemp("hardware")
    cart(folder, ros2='namespace = "r1"', more=BEACON)
    (folder / "robots/cart/all.py").write_text(ALL)
    (folder / "scenarios").mkdir()
    agent = '[[agent]]\nname = "R2"\nrobot = "cart"\n'
    text = f'format = "scenario/2"\nbase = "exp1"\n{agent}rules = ["wall"]\nparameters = {{}}\n'
    (folder / "scenarios/real.toml").write_text(text)
    return folder


@pytest.fixture(scope="module")
def driven(project):
    """Recording of a run on hardware."""
    with pytest.MonkeyPatch.context() as patch:
        thread = Robot()
        patch.setattr(node, "open_transport", lambda *_: thread.network)
        thread.start()
        missions = {"R2": lambda mission: py_trees.behaviours.Running("stay")}
        drive("real", Catalog(project), duration=2.0, missions=missions, out=project / "run")
        thread.over.set()
    return Recording.open(project / "run")


def test_scan_frames_and_names(project, driven, export):
    """Names are those of the robot, and the agent's estimates do not mix with its measurements."""
    topics = read(export(driven, catalog=Catalog(project)))
    assert {"/r1/cmd_vel", "/r1/signals/front", "/r1/mission"} <= set(topics)
    scan = topics["/r1/scan"][-1][1]
    assert (scan.header.frame_id, len(scan.ranges)) == ("r1/lidar", 90)
    assert scan.angle_min == pytest.approx(np.radians(-135.0))
    assert scan.angle_max == pytest.approx(np.radians(135.0))
    assert (scan.range_min, scan.range_max) == (0.0, np.inf)
    parents = frames(topics)
    assert parents["r1/lidar"] == {"r1/base_link"}
    assert parents["base_link"] == {"map"}  # of the robot's own transforms


def test_a_replay_of_the_export_has_the_signals_of_the_run(project, driven, export, rocs_bt, monkeypatch):
    bag = export(driven, catalog=Catalog(project))
    monkeypatch.chdir(project)
    told = rocs_bt("replay", "--bag", bag, "--robot", "cart", "--rules", "wall", "--out", "again")
    assert told.code == 0, told.err
    first, again = signal_table(driven, "R2"), signal_table(Recording.open("again"), "cart")
    for name in ("front", "pose", "speed"):
        expected, values = (np.array(each[name].tolist()).reshape(len(each), -1) for each in (first, again))
        known = [np.isclose(expected, row, atol=1e-6, equal_nan=True).all(axis=1).any() for row in values]
        assert len(known) > 10
        assert np.mean(known) > 0.8, name  # a message may have arrived between the reads of two sensors
