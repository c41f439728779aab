"""Notices of nodes that do not match the topics of simulated robots."""

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Endpoint
from rocs_bt.ros2.sim.simulation import LOOK_AGAIN, NetworkWatch

from .test_sim_robot import AGENT, SCENARIO, Wire

TWIST, STAMPED, SCAN = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped", "sensor_msgs/msg/LaserScan"
COMMANDS, SCANS = ("/cmd_vel", STAMPED, QoS("best_effort")), ("/scan", SCAN, QoS("reliable", depth=5))


def watched(*others):
    now, said, wire = [0.0], [], Wire()
    wire.others = others
    watch = NetworkWatch(wire, [SCANS], [COMMANDS], said.append, lambda: now[0])
    for _ in range(3):
        now[0] += LOOK_AGAIN
        watch.look()
    return said


@pytest.mark.parametrize(
    ("other", "notice"),
    [
        (
            Endpoint("/cmd_vel", TWIST, "/teleop", True, QoS()),
            f"/cmd_vel: the node '/teleop' publishes {TWIST}, and the type here is {STAMPED}. Write --cmd-vel Twist.",
        ),
        (
            Endpoint("/cmd_vel", SCAN, "", True, QoS()),
            f"/cmd_vel: a node publishes {SCAN}, and the type here is {STAMPED}.",
        ),
        (
            Endpoint("/scan", TWIST, "/slam", False, QoS()),
            f"/scan: the node '/slam' subscribes to {TWIST}, and the type here is {SCAN}.",
        ),
        (
            Endpoint("/scan", SCAN, "/slam", False, QoS.LATCHED),
            "/scan: the quality of service of the node '/slam' does not match in durability "
            "(offered volatile, requested transient_local). Let it request reliable, volatile.",
        ),
    ],
)
def test_a_node_that_does_not_match_is_named_once(other, notice):
    assert watched(other) == [notice]


@pytest.mark.parametrize(
    "other",
    [
        Endpoint("/cmd_vel", STAMPED, "/teleop", True, QoS.SENSOR),
        Endpoint("/cmd_vel", TWIST, "/plot", False, QoS()),
        Endpoint("/scan", SCAN, "/slam", False, QoS()),
        Endpoint("/scan", SCAN, "/slam", False, QoS.SENSOR),
        Endpoint("/other", TWIST, "/other", True, QoS()),
    ],
)
def test_nodes_that_match_or_do_not_matter(other):
    assert watched(other) == []


def test_a_scenario_without_missions_is_only_for_the_simulator(tmp_path):
    (tmp_path / "scenarios").mkdir()
    agent = AGENT.format(name="R1", robot="jackal", x=0.0, y=0.0, yaw=0.0).replace('mission = "go_to"', "")
    (tmp_path / "scenarios/bare.toml").write_text(SCENARIO.format(world="arena_box") + agent)
    catalog = Catalog.here(tmp_path)
    assert catalog.load_scenario("bare", missions=False).agents[0].mission == ""
    with pytest.raises(InputError, match="mission"):
        catalog.load_scenario("bare")
