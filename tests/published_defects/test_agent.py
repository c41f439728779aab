"""What the published C++ code does wrong in its reflexes, wiring, log and threads, and a whole agent does not.

Each agent here is that of the shipped EXP1, with its robot, rules and devices.
"""

import itertools
import json
import math
import threading

import numpy as np
import pytest

import rocs_bt
from rocs_bt.actions import action_table
from rocs_bt.agent import ThreadedRunner
from rocs_bt.base.clock import SimulatedClock, WallClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.catalog import Catalog
from rocs_bt.event import ActuatorCommanded, AtomicStarted, BodyMoved, ListSink, RuleChanged
from rocs_bt.expression import Environment, compile_expression
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.knowledge import Knowledge
from rocs_bt.reactive import RuleModel, load_rules
from rocs_bt.record import Recording
from rocs_bt.running.simulated_stage import simulated_agents
from rocs_bt.simulation import OUTCOMES, build_world

CATALOG = Catalog()
RANGES = {"front": 6, "rear": 6, "left_gap": 4, "right_gap": 4}


@pytest.fixture
def exp1():
    return CATALOG.load_scenario("exp1")


@pytest.fixture
def make_mind(exp1):
    """R2's mind on its stage, and what it tells."""

    def make(clock=None, build=None):
        sink = ListSink()
        stage = build_world(exp1, CATALOG, 1, sink, clock=clock)
        (agent,) = simulated_agents(exp1, stage, CATALOG, sink, {} if build is None else {"R2": build})
        return agent, stage, sink

    return make


@pytest.fixture
def wanted():
    """What the shipped rules want, given ranges; no echo where none is given."""
    signals = Knowledge("R2", SimulatedClock(0.05), ListSink()).signals
    for name, size in RANGES.items():
        signals.declare(Signal(name, size, (LENGTH,), (0.0, math.inf)))
    signals.declare(Signal("goal_distance", 1, (LENGTH,), (0.0, math.inf)))
    signals.declare(Signal("speed", 1, (SPEED,), (-1.0, 1.0)))
    signals.freeze()
    file = CATALOG.find("rules", "avoid_collision").path
    rules = load_rules(file, Environment.of(signals), action_table())

    def ask(**ranges):
        for name, size in RANGES.items():
            signals.write(name, ranges.get(name, [math.inf] * size), 0.0)
        signals.write("goal_distance", [2.0], 0.0)
        signals.write("speed", [0.3], 0.0)
        return {r.rule.split("/")[-1]: r for r in RuleModel(rules).react(signals.snapshot(0.0), 0.0) if r.latched}

    return ask


class TestReflex:
    @pytest.mark.parametrize(("near", "there", "proportional"), [((3, 4), -0.3, 1.41), ((2, 3, 4, 5), -2.1, 1.32)])
    def test_its_reaction_is_in_proportion_to_the_distance(self, near, there, proportional):
        """There: the clamp is written the wrong way round, so that all between 0.1 and 0.3 m counts as full."""
        signals = Knowledge("R2", SimulatedClock(0.05), ListSink()).signals
        signals.declare(Signal("sonar", 8, (LENGTH,), (0.0, math.inf)))
        signals.freeze()
        seen = "clip((0.30 m - clip(sonar[{i}], 0 m, 1 m)) / 0.20 m, 0, 1)"
        weights = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6]  # the published ones, for the left wheel
        terms = [f"{w} * {seen.format(i=i)}" for i, w in enumerate(weights)]
        speed = compile_expression("1.5 - (" + " + ".join(terms) + ")", Environment.of(signals))
        signals.write("sonar", [0.29 if i in near else math.inf for i in range(8)], 0.0)
        assert speed(signals.snapshot(0.0), 0.0) == pytest.approx(proportional, abs=0.01)
        assert speed(signals.snapshot(0.0), 0.0) > there + 1.0

    def test_straight_ahead_it_turns_all_the_same(self, wanted):
        """There: the same on both sides gives both wheels the same speed, straight backwards and to again."""
        reflex = wanted(front=[math.inf, 0.35, 0.3, 0.3, 0.35, math.inf])["AvoidCollision"]
        assert abs(reflex.parameters["turn"]) == pytest.approx(math.radians(60.0))

    def test_it_drives_no_faster_than_the_plan(self, exp1, wanted):
        """There: the reflex drives forward at one and a half times the planned speed."""
        cruise = 0.5
        assert exp1.agents[0].parameters["cruise"] == f"{cruise} m/s"
        seen = [
            wanted(front=[0.3] * 6),
            wanted(front=[0.15] * 6),
            wanted(rear=[0.15] * 6),
            wanted(left_gap=[0.12, 1.0, 1.0, 1.0]),
        ]
        speeds = [r.parameters["speed"] for rules in seen for r in rules.values() if "speed" in r.parameters]
        assert len(speeds) >= 4
        assert max(map(abs, speeds)) < cruise

    def test_before_anything_was_measured_it_stands(self, make_mind):
        """There: a reflex that runs before the first sonar was published reads memory that is not there."""
        agent, stage, sink = make_mind()
        for count in range(8):
            stage.clock.advance(10)
            agent.react(stage.clock.now())  # not one monitor has run
            agent.execute.run(stage.clock.now())
            assert count < 3 or agent.arc.active == "avoid_collision/Blind"
        assert not any(v for e in sink.events if isinstance(e, ActuatorCommanded) for v in e.values)
        fired = next(e for e in sink.events if isinstance(e, RuleChanged) and e.phase == "fired")
        assert "invalid" in fired.reading

    def test_when_it_ends_the_wheels_stand_until_the_plan_acts_which_is_soon(self):
        """There: after a reflex the wheels keep its speed for two cycles or more of Execute."""
        sink = ListSink()
        rocs_bt.run("exp1", CATALOG, sinks=[sink])
        commands = [e for e in sink.events if isinstance(e, ActuatorCommanded)]
        pairs = list(itertools.pairwise(commands))
        assert sum(b.route == "deliberative" != a.route for a, b in pairs) >= 2
        for before, after in pairs:
            if before.route == "reactive":  # the reflex goes on, the plan has the wheels, or they stand
                assert after.route in ("reactive", "deliberative") or not any(after.values)
                assert after.t - before.t == pytest.approx(0.05)
            elif before.route == "idle" and after.route != "idle":  # two idle ones: neutral at the run's end
                assert after.t - before.t < 0.11  # the tree ticks at 10 Hz


class TestAction:
    def test_it_acts_on_what_was_measured_in_this_period(self, make_mind):
        """There: a command crosses the queue two or three times, on a pose that is one whole chain old."""
        ages = []

        class Look(AtomicAction):
            def act(self, body):
                ages.append(body.clock.now() - body.knowledge.signals.stamp("pose"))
                body.motion.command([0.0, 0.0])
                return Progress.RUNNING

        agent, stage, _ = make_mind()
        for count in range(10):
            agent.step(count)
            if count == 2:
                agent.pipeline.clear("test")
                agent.pipeline.submit(Look(), rocs_bt.Priority.HIGH, "test")
            stage.world.advance(10)
        assert ages
        assert max(ages) == 0.0

    def test_height_is_no_part_of_the_way(self, make_mind):
        """There: the distance to a goal counts z too, so that a robot 0.36 m up is never within 0.1 m."""
        agent, stage, _ = make_mind()
        agent.knowledge.world.pursue("goal")
        body = stage.world
        body.place("R2", Pose2(0.05, 0.0, 0.0))
        agent.step(0)
        assert body.pose3("R2").z != 0.0
        assert agent.knowledge.signals.value("goal_distance", stage.clock.now()) == pytest.approx(0.05, abs=1e-6)


class TestOneOfEach:
    def test_all_blocks_share_one_knowledge(self, make_mind):
        """There: a robot has two, one of which shadows the other, and Execute holds the wrong one."""
        seen = []

        class Look(AtomicAction):
            def act(self, body):
                seen.append(body.knowledge)
                return Progress.SUCCEEDED

        agent, stage, _ = make_mind()
        agent.pipeline.submit(Look(), rocs_bt.Priority.HIGH, "test")
        agent.execute.run(stage.clock.now())
        seen += [m.knowledge for m in agent.monitors] + [a.knowledge for a in agent.analyzes] + [agent.plan.knowledge]
        knowledge = agent.knowledge
        seen += [view.knowledge for view in (knowledge.world, knowledge.robot, knowledge.strategy)]
        assert len(seen) == 1 + 3 + 3 + 1 + 3
        assert all(k is knowledge for k in seen)

    def test_execute_and_plan_share_one_pipeline(self, make_mind):
        agent, _, _ = make_mind()
        assert agent.plan.pipeline is agent.execute.pipeline is agent.pipeline

    def test_models_have_the_name_that_they_were_given(self, make_mind):
        """There: constructors move a name into itself, so that it is always empty."""
        agent, _, _ = make_mind()
        knowledge = agent.knowledge
        assert [v.name for v in (knowledge.robot, knowledge.world, knowledge.strategy)] == ["R2", "R2", "R2"]
        assert [m.name for m in agent.monitors] == ["range", "pose", "wheels"]

    def test_a_monitor_interprets(self, make_mind):
        """There: Monitor's interpret returns what it was given."""
        agent, stage, _ = make_mind()
        agent.step(0)
        now, signals = stage.clock.now(), agent.knowledge.signals
        sonar, front = signals.read("sonar", now), signals.read("front", now)
        assert np.array_equal(front, sonar[1:7] / np.array([0.6, 0.85, 1.0, 1.0, 0.85, 0.6]))


class TestLog:
    @pytest.fixture
    def folder(self, tmp_path):
        rocs_bt.run("exp1", CATALOG, out=tmp_path, report=False)
        return tmp_path

    def test_everything_is_stamped_in_every_period_whether_something_is_queued_or_not(self, folder):
        """There: X, Y, T, Action, where T is the yaw; no time, and no line while the queue is empty."""
        events = list(Recording.open(folder).events())
        told = [e.t for e in events if isinstance(e, BodyMoved) and e.body == "R2"]
        assert told == pytest.approx([0.05 * k for k in range(len(told))])
        assert all(math.isfinite(e.t) for e in events)
        assert [e.t for e in events] == sorted(e.t for e in events)

    def test_the_action_told_is_the_one_that_acts(self, folder):
        """There: it is the one that is queued."""
        events = list(Recording.open(folder).events())
        begun = {e.action for e in events if isinstance(e, AtomicStarted)}
        assert {"SetWheelSpeed", "TurnAngle"} <= begun
        assert not begun & {"GoTo", "AvoidCollision"}  # those are what was asked for

    def test_collisions_and_success_are_told(self, folder):
        """There: one run, no outcome, no collision count."""
        agent = json.loads((folder / "summary.json").read_text())["agents"]["R2"]
        assert agent["outcome"] in OUTCOMES
        assert agent["collisions"] == 0
        assert agent["min_clearance"] > 0.0


@pytest.mark.usefixtures("awake")
class TestThreads:
    def test_all_threads_end_with_the_run(self, make_mind):
        """There: stop flags are plain bools, threads are never deleted, and bases join when the derived is gone."""
        before = set(threading.enumerate())
        clock = WallClock()
        agent, stage, _ = make_mind(clock)
        assert stage.clock is clock
        with ThreadedRunner(agent, clock):
            names = {t.name for t in set(threading.enumerate()) - before}
            blocks = {f"monitor {m.name}" for m in agent.monitors} | {f"analyze {a.name}" for a in agent.analyzes}
            assert {f"R2/{b}" for b in (*blocks, "plan", "execute")} <= names  # a thread each (paper, 5.2)
        assert agent.failure is None
        assert set(threading.enumerate()) <= before

    def test_starting_and_stopping_again_and_again_harms_nobody(self, make_mind):
        """There: the program crashes now and then when it ends."""
        for _ in range(5):
            clock = WallClock()
            agent, _, _ = make_mind(clock)
            with ThreadedRunner(agent, clock):
                pass
            agent.stop()
            assert agent.failure is None
