from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, KnowledgeError
from rocs_bt.base.geometry import Pose2, Pose3, Twist2
from rocs_bt.base.units import TEMPERATURE
from rocs_bt.event import KnowledgeChanged, ListSink
from rocs_bt.knowledge import SCHEMA, Attribute, Knowledge, NodeKind, RobotModel, StrategyModel, WorldModel


def test_the_robot_is_a_node_of_its_own_knowledge(knowledge: Knowledge) -> None:
    assert knowledge.graph.kind("R2") == "robot"
    assert knowledge.robot.name == knowledge.agent == "R2"
    assert knowledge.revision == knowledge.graph.revision == 1


def test_a_knowledge_needs_a_name(clock: SimulatedClock, sink: ListSink) -> None:
    with pytest.raises(KnowledgeError, match="needs the name of its agent"):
        Knowledge("", clock, sink)


def test_two_agents_in_one_process_share_nothing(clock: SimulatedClock, sink: ListSink) -> None:
    first, second = Knowledge("R1", clock, sink), Knowledge("R2", clock, sink)
    first.world.place("home", Pose2(0.0, 0.0), "goal")
    assert not second.graph.has("home")
    assert not second.graph.has("R1")


def test_the_world_holds_what_is_placed_in_it(knowledge: Knowledge) -> None:
    world = knowledge.world
    world.place("home", Pose2(0.0, 0.0), "goal", tolerance=0.2)
    world.place("box", Pose2(1.0, 2.0, 0.5), "object", radius=0.3)
    world.place("corner", Pose2(2.0, 2.0))
    world.place("R1", Pose2(-1.0, 0.0), "peer")
    world.place("box", Pose2(1.5, 2.0, 0.5), "object")
    assert (world.goals(), world.objects(), world.places(), world.peers()) == (["home"], ["box"], ["corner"], ["R1"])
    assert world.pose_of("box") == Pose2(1.5, 2.0, 0.5)
    assert knowledge.graph.attributes("box")["radius"] == 0.3


def test_a_pose_that_is_not_known_is_none(knowledge: Knowledge) -> None:
    knowledge.graph.add("felt", "object", distance=0.4)
    assert knowledge.world.pose_of("felt") is None
    assert knowledge.world.pose_of("nobody") is None
    assert knowledge.world.pose_of("R2") is None
    knowledge.signals.write("pose", [1.0, 2.0, 3.0], 0.0)
    assert knowledge.world.pose_of("R2") == Pose2(1.0, 2.0, 3.0)


def test_a_pose_has_an_optional_height(knowledge: Knowledge) -> None:
    world, graph = knowledge.world, knowledge.graph
    world.place("shelf", Pose3(1.0, 2.0, 1.5, yaw=0.5))
    world.place("floor", Pose2(0.0, 0.0))
    assert (world.pose_of("shelf"), world.z_of("shelf"), graph.get("shelf", "z")) == (Pose2(1.0, 2.0, 0.5), 1.5, 1.5)
    assert world.z_of("floor") is world.z_of("nobody") is world.z_of("R2") is None
    world.place("shelf", Pose2(2.0, 2.0))
    assert world.z_of("shelf") == 1.5  # a pose in the plane keeps the height
    world.place("floor", Pose3(0.0, 0.0, 0.2))
    assert knowledge.ask("place where z > 1 m give z").values == ((1.5,),)
    assert knowledge.ask("place order by z give pose.x, z").values == ((0.0, 0.2), (2.0, 1.5))
    with pytest.raises(InputError, match=r"a pose has no 'z', which is an attribute of the node; write place\.z\."):
        knowledge.ask("place where place.pose.z > 1 m")


def test_a_thing_cannot_become_another_kind(knowledge: Knowledge) -> None:
    knowledge.world.place("home", Pose2(0.0, 0.0), "goal")
    with pytest.raises(KnowledgeError, match="cannot place 'home' as object: it exists, of kind goal"):
        knowledge.world.place("home", Pose2(1.0, 1.0), "object")
    with pytest.raises(KnowledgeError, match="'sensor x' has no attribute 'pose'"):
        knowledge.world.place("x", Pose2(1.0, 1.0), "sensor")


def test_the_robot_pursues_one_goal_or_none(knowledge: Knowledge) -> None:
    world = knowledge.world
    for name in ("home", "away"):
        world.place(name, Pose2(3.0, 4.0), "goal")
    assert world.pursued() is None
    world.pursue(None)
    world.pursue("home")
    world.pursue("away")
    assert world.pursued() == "away"
    assert knowledge.graph.related("R2", "pursues") == ["away"]
    world.pursue(None)
    assert world.pursued() is None
    with pytest.raises(KnowledgeError, match="no node named 'hme'"):
        world.pursue("hme")


def test_the_distance_of_the_goal(knowledge: Knowledge) -> None:
    world = knowledge.world
    world.place("away", Pose2(3.0, 4.0), "goal")
    assert world.goal_distance() == math.inf
    world.pursue("away")
    assert math.isnan(world.goal_distance())
    knowledge.signals.write("pose", [0.0, 0.0, 1.0], 0.0)
    assert world.goal_distance(0.1) == 5.0
    assert math.isnan(world.goal_distance(1.0))


def test_the_robots_state_is_read_from_its_signals_now(knowledge: Knowledge, clock: SimulatedClock) -> None:
    robot = knowledge.robot
    assert np.isnan(robot.pose()).all()
    knowledge.signals.update({"pose": [1.0, 2.0, 0.5], "wheel_speeds": [0.1, 0.3], "speed": 0.2}, 0.0)
    assert robot.pose() == Pose2(1.0, 2.0, 0.5)
    assert robot.wheel_speeds().tolist() == [0.1, 0.3]
    assert robot.speed() == 0.2
    clock.advance(4)
    assert np.isnan(robot.pose()).all()
    assert math.isnan(robot.speed())
    assert robot.pose(0.1) == Pose2(1.0, 2.0, 0.5)


def test_the_robots_parts_and_limits_stand_in_the_graph(knowledge: Knowledge) -> None:
    graph, robot = knowledge.graph, knowledge.robot
    graph.add("sonar", "sensor", signal="front")
    graph.add("wheels", "actuator", size=2)
    graph.relate("R2", "has_sensor", "sonar")
    graph.relate("R2", "has_actuator", "wheels")
    graph.set("R2", speed_limit=0.7, turn_limit=2.0, radius=0.25)
    assert (robot.sensors(), robot.actuators()) == (["sonar"], ["wheels"])
    assert robot.limits == {"speed_limit": 0.7, "turn_limit": 2.0}


def test_a_state_that_no_sensor_tells_is_nan(clock: SimulatedClock, sink: ListSink) -> None:
    robot = Knowledge("R2", clock, sink).robot
    robot.locomotion = Tracks()
    assert np.isnan([*robot.pose(), *robot.wheel_speeds(), robot.speed(), robot.turn_rate()]).all()
    assert robot.wheel_speeds().shape == (2,)


class Tracks:
    wheels = ("left", "right")

    def command(self, twist: Twist2) -> np.ndarray:
        return np.array([twist.forward - twist.turn, twist.forward + twist.turn])

    def twist(self, wheels: np.ndarray) -> Twist2:
        return Twist2(float(wheels.mean()), float(wheels[1] - wheels[0]) / 2.0)


def test_kinematics_both_ways_are_the_drives(knowledge: Knowledge) -> None:
    with pytest.raises(KnowledgeError, match="'R2' has no locomotion"):
        knowledge.robot.inverse(Twist2(1.0))
    knowledge.robot.locomotion = Tracks()
    assert knowledge.robot.inverse(Twist2(1.0, 0.5)).tolist() == [0.5, 1.5]
    assert knowledge.robot.forward(np.array([0.5, 1.5])) == Twist2(1.0, 0.5)


def test_strategies_and_what_they_fall_back_to(knowledge: Knowledge) -> None:
    strategy = knowledge.strategy
    strategy.add("stand", mission="stop")
    strategy.add("defend", falls_back_to="stand")
    strategy.add("attack", falls_back_to="defend")
    assert strategy.names() == ["stand", "defend", "attack"]
    assert strategy.fallbacks("attack") == ["defend", "stand"]
    assert strategy.used() is None
    strategy.use("attack")
    strategy.use("defend")
    assert strategy.used() == "defend"
    knowledge.graph.relate("stand", "falls_back_to", "attack")
    assert strategy.fallbacks("attack") == ["defend", "stand"]
    with pytest.raises(KnowledgeError, match="no node named 'stnd'"):
        strategy.add("retreat", falls_back_to="stnd")
    assert not knowledge.graph.has("retreat")


class WarmWorld(WorldModel):
    @property
    def temperature(self) -> float | None:
        return self.graph.get("air", "temperature")


class BatteryRobot(RobotModel):
    def is_slow(self) -> bool:
        return self.speed() < 0.1


class Team(StrategyModel):
    def attackers(self) -> list[str]:
        return [n for n in self.names() if n.startswith("attack")]


def test_each_model_can_be_a_users_own(clock: SimulatedClock, sink: ListSink) -> None:
    schema = SCHEMA.extended([NodeKind("air", {"temperature": Attribute(float, (TEMPERATURE,), low=0.0)})])
    knowledge = Knowledge("R2", clock, sink, schema, world=WarmWorld, robot=BatteryRobot, strategy=Team)
    knowledge.graph.add("air", "air", temperature=293.0)
    knowledge.strategy.add("attack left")
    assert isinstance(knowledge.world, WarmWorld)
    assert isinstance(knowledge.robot, BatteryRobot)
    assert isinstance(knowledge.strategy, Team)
    assert knowledge.world.temperature == 293.0
    assert knowledge.strategy.attackers() == ["attack left"]


def test_views_have_no_store_of_their_own(knowledge: Knowledge) -> None:
    changes: list[KnowledgeChanged] = []
    knowledge.graph.subscribe(changes.append, node="home")
    knowledge.world.place("home", Pose2(0.0, 0.0), "goal")
    knowledge.graph.set("home", pose=Pose2(1.0, 0.0))
    assert knowledge.world.pose_of("home") == Pose2(1.0, 0.0)
    knowledge.graph.remove("home")
    assert knowledge.world.goals() == []
    assert [c.what for c in changes] == ["node added", "attribute", "attribute", "node removed"]


def test_networkx_is_imported_only_when_a_knowledge_is_made() -> None:
    code = (
        "import sys; from rocs_bt.knowledge import Knowledge; before = 'networkx' in sys.modules;"
        "from rocs_bt.base.clock import SimulatedClock; from rocs_bt.event import NullSink;"
        "Knowledge('R2', SimulatedClock(0.05), NullSink());"
        "sys.exit(0 if (before, 'networkx' in sys.modules) == (False, True) else 1)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
