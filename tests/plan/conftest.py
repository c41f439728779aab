"""A mind's Plan and Execute on the robot without physics: plan at 10 Hz, control at 20 Hz, a reflex at will.

Nodes for ROS 2 get a fake connection.
"""

import math

import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.expression import Environment, compile_expression
from rocs_bt.interfaces.pipeline import Priority
from rocs_bt.plan import Mission, TreePlan, mission_nodes, xml_mission
from rocs_bt.trees.xml import load_xml

from .ros_fake import Link


class Mind:
    def __init__(self, rig):
        self.rig = rig
        environment = Environment.of(rig.knowledge.signals)
        self.mission = Mission(
            "test",
            knowledge=rig.knowledge,
            pipeline=rig.pipeline,
            actions=rig.actions,
            compile_guard=lambda text: compile_expression(text, environment),
            rule_reading=lambda rule: "front = 0.21 m",
            motion_held=lambda: rig.gate.held,
        )
        self.plan = None

    def start(self, root):
        self.plan = TreePlan(root, self.mission)
        return self.plan

    def run(self, periods=1):
        for _ in range(periods):
            if self.rig.clock.count % 2 == 0 or self.plan.called:
                self.plan.run(self.rig.clock.now())
            self.rig.run()

    def until_done(self, limit=2000):
        for _ in range(limit):
            if self.plan.status != "RUNNING":
                return
            self.run()
        raise AssertionError(f"the plan has not ended after {limit} periods\n{self.plan.display()}")

    def flinch(self, action, rule="rules/Flinch"):
        """A reflex from its firing to its end, as the reflex arc does it."""
        self.rig.pipeline.hold(True)
        ticket = self.rig.pipeline.submit(action, Priority.HIGH, by=rule)
        while not ticket.state.done:
            self.run()
        self.rig.pipeline.hold(False)
        self.plan.replan(f"{rule} ended")
        return ticket


@pytest.fixture
def mind(rig):
    return Mind(rig)


@pytest.fixture
def link(mind):
    mind.mission.services = {"ros2": Link()}
    return mind.mission.services["ros2"]


@pytest.fixture
def grow(mind):
    """A tree from one line of XML, ready for its first tick."""

    def grow(line, **keys):
        nodes = mission_nodes(mind.rig.actions)
        root = load_xml(f'<root BTCPP_format="4"><BehaviorTree ID="M">{line}</BehaviorTree></root>', nodes)
        for key, value in keys.items():
            mind.mission.board[key] = value
        return TreePlan(root, mind.mission).tree

    return grow


@pytest.fixture
def served(mind, link):
    """A tree from one line of XML in the dialect of a running Nav2."""
    mind.rig.knowledge.world.place("dock", Pose2(3.0, 4.0, math.pi), kind="goal")
    mind.rig.knowledge.world.place("near", Pose2(1.0, 0.0, 0.5), kind="goal")

    def served(line, **keys):
        text = f'<root BTCPP_format="4"><BehaviorTree ID="M">{line}</BehaviorTree></root>'
        build = xml_mission(text, dialect="nav2_servers")
        mind.mission.board.update(keys)
        return TreePlan(build(mind.mission), mind.mission).tree

    return served
