"""robot.toml and scenario.toml: what they mean, and that every fault is told at once with its place."""

from __future__ import annotations

import math

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Twist2
from rocs_bt.base.units import LENGTH
from rocs_bt.catalog import Catalog, load_robot
from rocs_bt.control.locomotion_kinds import Differential
from rocs_bt.declare import location_of
from rocs_bt.interfaces.actuator_limits import ActuatorLimits
from rocs_bt.interfaces.safety_gate import Landing

from ..changes import edit


@pytest.fixture
def robot_file(project):
    return project / "robots" / "bot" / "robot.toml"


@pytest.fixture
def scenario_file(project):
    return project / "scenarios" / "walk.toml"


def test_a_robot_is_read_in_si_units(robot_file):
    robot = load_robot(robot_file)
    assert (robot.name, robot.body.length, robot.body.width) == ("bot", 0.4, 0.4)
    assert robot.motion == Differential(
        kind="differential", wheel_separation=0.331, max_wheel_speed=1.2, max_wheel_acceleration=1.5
    )
    sonar, position = robot.sensors
    assert sonar.arguments == {
        "sites": ("sonar0", "sonar1"),
        "half_angle": math.pi / 12,
        "rays": 5,
        "range": (0.1, 1.0),
    }
    assert (sonar.rate, sonar.noise, sonar.dimension, sonar.signal) == (20.0, 0.02, LENGTH, "sonar")
    assert (position.rate, position.noise, position.max_age) == (None, 0.0, None)
    assert robot.actuators[0].max_command_age == 0.2


def test_monitors_are_wired_by_table_or_by_class(robot_file):
    robot = load_robot(robot_file)
    by_name = {m.name: m for m in robot.monitors}
    assert by_name["range"].sensors == ("sonar",)
    assert by_name["range"].parameters == {"group": {"front": {"beams": [0, 1], "weights": [0.5, 1.0]}}}
    assert (by_name["position"].cls, by_name["position"].sensors) == ("PoseMonitor", ("position",))
    assert {s.name: s.monitor for s in robot.sensors} == {"sonar": "range", "position": "position"}


def test_the_drive_plans_with_the_actuators_limits_where_it_prefers_none(robot_file):
    edit(robot_file, 'max_wheel_speed = "1.2 m/s"\nmax_wheel_acceleration = "1.5 m/s2"\n', "")
    edit(
        robot_file,
        'wheel_radius = "9.75 cm"',
        'wheel_radius = "9.75 cm"\nmax_change = "4 m/s2"\nmax_acceleration = "3 m/s2"',
    )
    robot = load_robot(robot_file)
    assert (robot.motion.max_wheel_speed, robot.motion.max_wheel_acceleration) == (1.2, 3.0)
    assert robot.actuators[0].limits == ActuatorLimits((-1.2,), (1.2,), 4.0, together=True)


def test_a_scenario_is_read_in_si_units_but_what_classes_declare(project):
    scenario = Catalog(project).load_scenario("walk")
    assert (scenario.name, scenario.world, scenario.duration, scenario.end_on_collision) == (
        "walk",
        "room",
        20.0,
        False,
    )
    (place,), (agent,), (actor,) = scenario.places, scenario.agents, scenario.actors
    assert (place.kind, place.tolerance, place.agents) == ("goal", 0.05, ("R1",))
    assert place.pose[:2] == (0.0, -0.1)
    assert math.isnan(place.pose.yaw)
    assert (place.attributes, place.z) == ({}, None)
    assert (agent.robot, agent.mission, agent.rules, agent.success.goal) == ("bot", "go", ("calm",), "dock")
    assert agent.pose == (1.0, 2.0, math.pi)
    assert agent.jitter == (0.05, 0.0, pytest.approx(math.radians(10)))
    assert agent.parameters == {"goal": "dock", "cruise": "0.5 m/s"}
    assert (actor.script, actor.parameters) == ("random_walk", {"max_speed": "0.3 m/s"})


def test_a_place_may_have_a_height(scenario_file, project):
    edit(scenario_file, 'y = "-10 cm"', 'y = "-10 cm"\nz = "120 cm"')
    (place,) = Catalog(project).load_scenario("walk").places
    assert (place.pose[:2], place.z) == ((0.0, -0.1), 1.2)


def test_the_default_rates_are_those_of_the_conventions(project):
    rate = Catalog(project).load_scenario("walk").rate
    assert (rate.control_rate.every, rate.plan_rate.every, rate.sensor_rate(20.0).every) == (10, 4, 1)
    assert rate.sensor_rate(None).every == 1


def test_sensors_can_be_read_as_often_as_a_faster_control_needs(scenario_file, project):
    edit(scenario_file, 'plan = "5 Hz"', 'control = "50 Hz"\nsensors = "50 Hz"\nplan = "10 Hz"')
    rate = Catalog(project).load_scenario("walk").rate
    assert (rate.control_rate.every, rate.plan_rate.every, rate.sensor_rate(20.0).every) == (4, 5, 1)


def test_the_parameters_of_a_users_own_driver_stay_as_they_are_until_its_class_is_loaded(project):
    robot = project / "robots" / "bot" / "robot.toml"
    (robot.parent / "own.py").write_text("class Own:\n    pass\n")
    edit(robot, 'driver = "velocity"', 'driver = "own.py:Own"\ngain = 2.5\nport = "can0"\nratio = "3"')
    found = load_robot(robot).actuators[0]
    assert found.parameters == {
        "gain": 2.5,
        "port": "can0",
        "ratio": "3",
        "motors": ["left", "right"],
        "wheel_radius": "9.75 cm",
    }
    line = next(i for i, text in enumerate(robot.read_text().splitlines(), 1) if text == "gain = 2.5")
    assert location_of(found.parameters, "gain")[1:] == (line, 1)


LEGGED = """\
[locomotion]
kind = "legged"
lag = "0.2 s"
latency = "0.4 s"
deceleration = "0.8 m/s2"
[locomotion.vx]
max_speed = "0.5 m/s"
max_acceleration = "1 m/s2"
[locomotion.vy]
max_speed = "0.2 m/s"
max_acceleration = "0.5 m/s2"
deceleration = "0.4 m/s2"
[locomotion.wz]
max_speed = "60 deg/s"
max_acceleration = "2 rad/s2"
"""


def body_without_wheels(file, locomotion=LEGGED, actuator='max_command_age = "0.3 s"'):
    """Rewrite the bot to a body that accepts twists."""
    head, _, tail = file.read_text().partition("[locomotion]")
    rest = "[body]" + tail.partition("[body]")[2].partition("[[actuator]]")[0]
    driver = f'[[actuator]]\nname = "wheels"\ndriver = "walk.py:Walk"\n{actuator}\n'
    (file.parent / "walk.py").write_text("class Walk: ...\n")
    file.write_text(head + locomotion + rest + driver)
    return load_robot(file)


def test_a_body_that_accepts_twists_has_the_axes_with_a_table(robot_file):
    robot = body_without_wheels(robot_file)
    made = robot.locomotion
    assert (made.wheels, made.values, made.axes) == ((), ("vx", "vy", "wz"), ("vx", "vy", "wz"))
    assert made.max_speed == pytest.approx([0.5, 0.2, math.pi / 3.0])
    assert (made.response.lag, made.response.latency, made.neutral) == (0.2, 0.4, "stand")
    assert made.stop_distance(Twist2(0.4)) == 0.4 * 0.4 + 0.4 * 0.4 / 1.6
    assert made.stop_distance(Twist2(0.0, left=-0.2)) == 0.2 * 0.4 + 0.2 * 0.2 / 0.8
    (actuator,) = robot.actuators
    assert actuator.limits.high == pytest.approx((0.5, 0.2, math.pi / 3.0))
    assert (actuator.limits.together, actuator.landing) == (True, None)
    assert actuator.limits.max_change == pytest.approx((1.2, 0.6, 2.0))  # a body may brake faster than it accelerates


def test_a_flying_body_lands(robot_file):
    up = '[locomotion.vz]\nmax_speed = "0.2 m/s"\nmax_acceleration = "1 m/s2"\n'
    flying = LEGGED.replace('"legged"', '"flying"\nland_after = "9 s"') + up
    robot = body_without_wheels(robot_file, flying)
    assert robot.actuators[0].landing == Landing(9.0, (0.0, 0.0, -0.2, 0.0))
    assert robot.locomotion.neutral == "hover"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[locomotion.wz]", "[locomotion.wx]", r"needs 'wz'(.|\n)*unknown key 'wx'"),
        ('"legged"', '"flying"', r"the locomotion 'flying' needs 'vz'"),
        ('"legged"', '"twist"\nsway = "2 cm"', r"unknown key 'sway'"),
    ],
)
def test_a_wrong_body_is_told(robot_file, old, new, message):
    assert old in LEGGED
    with pytest.raises(InputError, match=message):
        body_without_wheels(robot_file, LEGGED.replace(old, new, 1))


def test_the_actuator_of_twists_declares_no_range(robot_file):
    with pytest.raises(InputError, match=r"range is not for the actuator of twists: the axes in \[locomotion\]"):
        body_without_wheels(robot_file, actuator='range = ["-1 m/s", "1 m/s"]')
