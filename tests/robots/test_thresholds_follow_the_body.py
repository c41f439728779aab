"""Thresholds of avoid_collision and contact on each shipped robot on wheels, and on variants of its body."""

import dataclasses
import inspect
import math
import tomllib

import numpy as np
import pytest

from docs.tables import wheeled
from rocs_bt.actions import ACTIONS
from rocs_bt.agent.build import thresholds
from rocs_bt.base.geometry import Twist2
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, NONE, SPEED, TIME, TURN_RATE
from rocs_bt.catalog import Catalog, is_reference
from rocs_bt.control.body_values import BODY_VALUES
from rocs_bt.declare import replaced
from rocs_bt.expression import Environment
from rocs_bt.reactive import RuleModel, load_rules

CATALOG = Catalog()
ROBOTS = wheeled()
BODIES = [e.name for e in CATALOG.list("robot") if not CATALOG.load_robot(e.name).bases]
RULES = [entry.name for entry in CATALOG.list("rules")]
GROUPS = [Signal(name, 1, (LENGTH,)) for name in ("front", "left_gap", "right_gap", "rear", "goal_distance")]
MOTION = [Signal("speed", 1, (SPEED,)), Signal("turn_rate", 1, (TURN_RATE,)), Signal("contact_time", 1, (TIME,))]


def rules_of(name, robot):
    """Rules of a file on a robot."""
    file = CATALOG.find("rules", name).path
    environment = dataclasses.replace(Environment.packed([*GROUPS, *MOTION]), robot=robot.constants)
    return load_rules(file, environment, ACTIONS, overrides=thresholds(robot, file))


def variant(name, length=1.0, width=1.0, deceleration=None, **response):
    """Robot with other factors of its size, and other values of its response."""
    robot = CATALOG.load_robot(name)
    body = replaced(robot.body, length=length * robot.body.length, width=width * robot.body.width)
    braking = {axis: a for axis, a in (deceleration or {}).items() if hasattr(robot.motion, axis)}
    axes = {axis: replaced(getattr(robot.motion, axis), deceleration=a) for axis, a in braking.items()}
    axes |= {} if deceleration is None else {"deceleration": None}
    return replaced(robot, motion=replaced(robot.motion, **response, **axes), body=body)


def test_the_robots_on_wheels_are_these():
    assert {"jackal", "pioneer_p3dx", "robotino", "rosbot_xl", "summit_xl", "turtlebot3_burger"} <= {*ROBOTS}


@pytest.mark.parametrize("name", ROBOTS)
def test_thresholds_are_ordered_and_leave_room_to_stop_and_turn(name):
    robot, found = CATALOG.load_robot(name), rules_of("avoid_collision", CATALOG.load_robot(name)).thresholds
    stop = robot.locomotion.stop_distance(Twist2(found["pace"]))
    ahead = 0.5 * (math.hypot(robot.body.length, robot.body.width) - robot.body.length)
    assert 0.0 < found["flinch_near"] < found["flinch_clear"] < found["near"] < found["clear"]
    assert found["near"] >= stop + ahead + found["flinch_near"], "no Flinch after an AvoidCollision in time"
    assert found["clear"] < 1.0, "the ranges of sonars end there"


@pytest.mark.parametrize("name", BODIES)
def test_a_later_weaker_or_longer_robot_turns_away_earlier(name):
    latency = CATALOG.load_robot(name).constants["latency"].value
    own = rules_of("avoid_collision", variant(name)).thresholds
    late = rules_of("avoid_collision", variant(name, latency=latency + 0.3)).thresholds
    assert late["near"] == pytest.approx(own["near"] + 0.3 * own["pace"], abs=1e-3)
    weak = rules_of("avoid_collision", variant(name, deceleration={"vx": 0.5, "vy": 0.5})).thresholds
    assert weak["near"] == pytest.approx(own["near"] + own["pace"] ** 2 * (1.0 - 0.5 / own["deceleration"]), abs=1e-3)
    large = rules_of("avoid_collision", variant(name, length=2.0, width=2.0)).thresholds
    assert large["near"] == pytest.approx(own["near"] + own["front_sweep"], abs=1e-3)
    if "margin" in CATALOG.load_robot(name).thresholds.get("avoid_collision", {}):
        return
    assert large["margin"] == pytest.approx(own["margin"] + own["side_sweep"], abs=1e-3)


@pytest.mark.parametrize("name", ROBOTS)
def test_contact_brakes_in_the_time_that_the_robot_needs(name):
    rng = np.random.default_rng(1)
    for _ in range(20):
        latency, deceleration, speed = rng.uniform(0.0, 0.5), rng.uniform(0.3, 5.0), rng.uniform(-1.5, 1.5)
        robot = variant(name, latency=latency, deceleration={"vx": deceleration, "vy": deceleration})
        need = 0.1 + latency + abs(speed) / deceleration
        for time, brakes in ((need - 0.01, True), (need + 0.01, False)):
            model = RuleModel(rules_of("contact", robot))
            model.react(np.array([1.0, 1.0, 1.0, 1.0, math.inf, speed, 0.0, time]), 0.0)
            assert ("contact/Brake" in model.latched) is brakes


@pytest.mark.parametrize("name", BODIES)
def test_no_robot_replaces_what_follows_from_its_braking(name):
    """What depends on latency or deceleration without the robot's own thresholds depends on them with these, too."""
    robot = CATALOG.load_robot(name)
    latency = robot.constants["latency"].value

    def moved(rules, own):
        bodies = [variant(name), variant(name, latency=latency + 0.3, deceleration={"vx": 0.4, "vy": 0.4, "vz": 0.4})]
        bodies = [body if own else replaced(body, thresholds={}) for body in bodies]
        first, second = (rules_of(rules, body).thresholds for body in bodies)
        return {key for key in first if first[key] != second[key]}

    for rules in RULES:
        if CATALOG.find("rules", rules).path.stem in robot.thresholds:
            assert moved(rules, own=True) == moved(rules, own=False) >= {"near", "clear", "stop"}


def keys_of(value):
    """Keys of tables in a value, at every depth."""
    if isinstance(value, dict):
        return {*value} | {key for each in value.values() for key in keys_of(each)}
    return {key for each in value for key in keys_of(each)} if isinstance(value, (list, tuple)) else set()


@pytest.mark.parametrize("name", [entry.name for entry in CATALOG.list("robot")])
def test_no_block_of_a_robot_declares_the_braking_again(name):
    robot, again = CATALOG.load_robot(name), {*BODY_VALUES, "reaction", "braking"}
    for block in (*robot.monitors, *robot.analyzers):
        assert not keys_of(dict(block.parameters)) & again, block.name
        if is_reference(block.cls):
            file, _, cls = block.cls.partition(":")
            taken = inspect.signature(CATALOG.load_class(robot.beside(file), cls)).parameters
            assert not taken.keys() & again, cls


@pytest.mark.parametrize("rules", RULES)
def test_no_rule_file_has_constants_of_its_own_for_the_braking(rules):
    text = CATALOG.find("rules", rules).path.read_text("utf-8")
    data = tomllib.loads(text)
    assert not {*data.get("threshold", {}), *data.get("alias", {})} & {*BODY_VALUES, "reaction", "braking"}
    assert "m/s2" not in "".join(line for line in text.splitlines() if not line.startswith("robot = "))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_vertical_motion_is_stopped_in_the_distance_that_the_robot_needs(sign):
    rng = np.random.default_rng(2)
    file = CATALOG.find("rules", "airborne").path
    names = ("front", "rear", "left_gap", "right_gap", "above", "below", "height", "goal_distance", "stop_distance")
    signals = [Signal(name, 1, (LENGTH,)) for name in (*names, "course_range")]
    signals += [Signal(name, 1, (SPEED,)) for name in ("speed", "course_speed", "lateral_speed", "climb")]
    signals += [Signal("battery", 1, (NONE,))]
    for _ in range(10):
        latency, deceleration, speed = rng.uniform(0.0, 0.5), rng.uniform(0.3, 5.0), rng.uniform(0.1, 1.0)
        robot = variant("quadrotor", latency=latency, deceleration={"vx": 3.0, "vy": 3.0, "vz": deceleration})
        environment = dataclasses.replace(Environment.packed(signals), robot=robot.constants)
        rules = load_rules(file, environment, ACTIONS, overrides=thresholds(robot, file))
        need = 0.1 + latency * speed + speed * speed / (2.0 * deceleration)
        for room, stops in ((need - 0.01, True), (need + 0.01, False)):
            values = dict.fromkeys((s.name for s in signals), 9.0)
            values |= {"climb": sign * speed, "above" if sign > 0 else "below": room, "speed": 0.0, "course_speed": 0.0}
            model = RuleModel(rules)
            model.react(np.array([values[s.name] for s in signals]), 0.0)
            assert (f"airborne/Stop{'Climb' if sign > 0 else 'Descent'}" in model.latched) is stops
