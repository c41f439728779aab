"""robot.toml and scenario.toml: what they mean, and that every fault is told at once with its place."""

from __future__ import annotations

import math

import pytest

from rocs_bt.catalog import Catalog, load_robot, robot_locomotion
from rocs_bt.control.locomotion import Response
from rocs_bt.errors import InputError
from rocs_bt.geometry import Twist2
from rocs_bt.safety import Landing, Limits
from rocs_bt.units import LENGTH


def edit(path, old, new):
    text = path.read_text()
    assert old in text, old
    path.write_text(text.replace(old, new))
    return path


@pytest.fixture
def robot_file(project):
    return project / "robots" / "bot" / "robot.toml"


@pytest.fixture
def scenario_file(project):
    return project / "scenarios" / "walk.toml"


def test_a_robot_is_read_in_si_units(robot_file):
    robot = load_robot(robot_file)
    assert (robot.name, robot.length, robot.width) == ("bot", 0.4, 0.4)
    assert robot.locomotion.parameters == {
        "wheel_separation": 0.331,
        "max_wheel_speed": 1.2,
        "max_wheel_acceleration": 1.5,
        "response": Response(),
    }
    sonar, position = robot.sensors
    assert sonar.parameters == {
        "sites": ["sonar0", "sonar1"],
        "half_angle": math.pi / 12,
        "rays": 5,
        "range": [0.1, 1.0],
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


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('format = "robot/3"', 'format = "robot/9"', r":1:1: invalid value 'robot/9' for 'format'"),
        ('model = "robot.xml"', 'model = "rbot.xml"', r":3:1: there is no model file 'rbot\.xml'"),
        ('"33.1 cm"', '"33.1 parsec"', r":7:1: 'parsec' is not a unit"),
        ('length = "0.4 m"', 'length = "0.4 s"', r":12:1: length must be in m, found '0\.4 s'"),
        ('width = "40 cm"', "width = 0.4", r":13:1: width needs a unit"),
        ('noise = "2 cm"', 'noise = "2 deg"', r":23:1: noise must be in m"),
        ('noise = "2 cm"', 'noise = "-2 cm"', r":23:1: noise must be at least 0"),
        ('unit = "m"\nmonitor = "range"', 'unit = "mm3x"\nmonitor = "range"', r":23:1: "),
        ('name = "position"', 'name = "sonar"', r":28:1: another \[\[sensor\]\] is named 'sonar'"),
        ('monitor = "PoseMonitor"', 'monitor = "own.py:Own"', r"own\.py: cannot read the file"),
        (
            'monitors = ["range", "position"]',
            'monitors = ["rnge"]',
            r":43:1: no monitor .* 'rnge'. Did you mean 'range'",
        ),
        ('name = "wheels"', 'name = "weels"', r"no actuator of this robot is named 'wheels'. Did you mean 'weels'"),
        ("rays = 5", "rays = 5.5", r":20:1: rays must be a whole number, found 5.5"),
        ('half_angle = "15 deg"', 'half_angle = "15 m"', r":19:1: half_angle must be in rad, found '15 m'"),
        ('half_angle = "15 deg"', 'half_angel = "15 deg"', r":19:1: unknown key .* Did you mean 'half_angle'"),
        ('sites = ["sonar0", "sonar1"]', "", r":15:1: the driver 'range_cone' needs 'sites'"),
        ('driver = "velocity"', 'driver = "velocty"', r"no driver is named 'velocty'. Did you mean 'velocity'"),
        (
            'kind = "differential"',
            'kind = "diferential"',
            r":6:1: invalid value 'diferential' for 'kind'. Did you mean 'differential'",
        ),
        (
            'range = ["-1.2 m/s", "1.2 m/s"]\n',
            "",
            r"the actuator 'wheels' has no limits\. Write .* range = \[\"-1 m/s\"",
        ),
        (
            '["-1.2 m/s", "1.2 m/s"]',
            '["-1 m/s", "1 m/s"]',
            r":8:1: max_wheel_speed is 1.2 m/s, but the actuator allows 1",
        ),
        ('["-1.2 m/s", "1.2 m/s"]', '["1 m/s", "1.2 m/s"]', r"the range of wheel speeds must contain 0 m/s"),
        ('["-1.2 m/s", "1.2 m/s"]', '["-1 m/s", "inf m/s"]', r"from a finite number to a larger one, found -1 to inf"),
        ('["-1.2 m/s", "1.2 m/s"]', '["-1.2 rad/s", "1.2 m/s"]', r"range must be in m/s, found '-1.2 rad/s'"),
        (
            '["-1.2 m/s", "1.2 m/s"]',
            '"1.2 m/s"',
            r"range must be a pair \[minimum, maximum\], found '1.2 m/s'",
        ),
        ('["-1.2 m/s", "1.2 m/s"]', "[[], []]", r"range must be a pair \[minimum, maximum\]"),
        ('wheel_radius = "9.75 cm"', 'wheel_radius = "1 cm"\nmax_change = "1 m/s2"', r"but the actuator allows 1 m/s2"),
        ('wheel_radius = "9.75 cm"', 'wheel_radius = "1 cm"\nmax_acceleration = "1 m/s2"', r"actuator allows 1 m/s2"),
        ('wheel_radius = "9.75 cm"', 'wheel_radius = "1 cm"\nmax_change = "1 m/s"', r"max_change must be in m/s2"),
        ('max_wheel_acceleration = "1.5 m/s2"', "", r"neither \[locomotion\] nor its actuator limits"),
        (
            'wheel_radius = "9.75 cm"',
            'wheel_radius = "1 cm"\nunit = "rad"',
            r"unit of the wheels must be m/s, found 'rad'",
        ),
        (
            'class = "PassRange"',
            'class = "PasRange"',
            r"no analyze class is named 'PasRange'. Did you mean 'PassRange'",
        ),
        ("[locomotion]", "[locomotion]\nactuator = 7", r":6:1: actuator must be a text, found 7"),
        ("[body]", '[locomotion.vy]\ndeceleration = "1 m/s2"\n[body]', r"unknown key 'deceleration' in locomotion.vy"),
        (
            'wheel_radius = "9.75 cm"',
            'wheel_radius = "1 cm"\nmax_acceleration = "2 m/s2"\n[locomotion.vx]\ndeceleration = "50 m/s2"',
            r"deceleration is 50 m/s2, but the actuator allows 2",
        ),
        ('monitor = "range"', "", r"sensor\.0 has no 'monitor'"),
        ('class = "RangeMonitor"', 'class = "RangeMonitor"\nsensors = ["sonr"]', r"no sensor .* 'sonr'. Did you mean"),
    ],
)
def test_a_wrong_robot_is_told_with_its_place(robot_file, old, new, message):
    edit(robot_file, old, new)
    with pytest.raises(InputError, match=message):
        load_robot(robot_file)


def test_the_drive_plans_with_the_actuators_limits_where_it_prefers_none(robot_file):
    edit(robot_file, 'max_wheel_speed = "1.2 m/s"\nmax_wheel_acceleration = "1.5 m/s2"\n', "")
    edit(
        robot_file,
        'wheel_radius = "9.75 cm"',
        'wheel_radius = "9.75 cm"\nmax_change = "4 m/s2"\nmax_acceleration = "3 m/s2"',
    )
    robot = load_robot(robot_file)
    assert robot.locomotion.parameters == {
        "wheel_separation": 0.331,
        "max_wheel_speed": 1.2,
        "max_wheel_acceleration": 3.0,
        "response": Response(),
    }
    assert robot.actuators[0].limits == Limits((-1.2,), (1.2,), 4.0, together=True)


def test_a_monitor_that_counts_on_harder_braking_than_the_actuator_allows_is_a_fault(robot_file):
    edit(robot_file, 'wheel_radius = "9.75 cm"', 'wheel_radius = "9.75 cm"\nmax_acceleration = "3 m/s2"')
    edit(robot_file, 'class = "RangeMonitor"', 'class = "RangeMonitor"\ndeceleration = "3.1 m/s2"')
    with pytest.raises(InputError, match=r"deceleration is 3.1 m/s2, but the actuator allows 3 m/s2"):
        load_robot(robot_file)


def test_all_faults_of_a_robot_are_told_at_once(robot_file):
    edit(robot_file, '"0.4 m"', '"0.4 s"')
    edit(robot_file, '"20 Hz"', '"20 m"')
    edit(robot_file, 'monitors = ["range", "position"]', 'monitors = ["rnge"]')
    with pytest.raises(InputError) as caught:
        load_robot(robot_file)
    assert sorted(f.line for f in caught.value.faults) == [12, 22, 43]


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
    assert (agent.robot, agent.mission, agent.rules, agent.success) == ("bot", "go", ("calm",), "dock")
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


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('world = "room"', 'world = "romo"', r":3:1: no world is named 'romo'. Did you mean 'room'\?"),
        ('robot = "bot"\nmission', 'robot = "bto"\nmission', r":18:1: no robot is named 'bto'. Did you mean 'bot'\?"),
        ('mission = "go"', 'mission = "goo"', r":19:1: no mission is named 'goo'. Did you mean 'go'\?"),
        ('rules = ["calm"]', 'rules = ["clam"]', r":20:1: no rule file is named 'clam'. Did you mean 'calm'\?"),
        ('goal = "dock" }', 'goal = "duck" }', r":25:1: no goal is named 'duck'. Did you mean 'dock'\?"),
        ('x = "1 m"', 'x = "1 s"', r":21:1: x must be in m, found '1 s'"),
        ('yaw = "180 deg"', 'yaw = "inf deg"', r":23:1: yaw must be between"),
        ('duration = "20 s"', 'duration = "20 m"', r":4:1: duration must be in s"),
        ('plan = "5 Hz"', 'plan = "7 Hz"', r":7:1: the plan rate of 7 Hz is .* Use 6\.66667 Hz or 10 Hz"),
        ('plan = "5 Hz"', 'control = "0 Hz"', r":7:1: control must be between 0\.1 and"),
        ('plan = "5 Hz"', 'physics = "0 s"', r":7:1: physics must be between 1e-05 and"),
        ('plan = "5 Hz"', 'physics = "3 ms"', r"the control rate of 20 Hz is 16\.67 steps of 0\.003 s"),
        ('plan = "5 Hz"', 'control = "30 Hz"', r"the control rate of 30 Hz is 6\.667 steps"),
        ('plan = "5 Hz"', 'control = "50 Hz"', r":6: the rate of sensor 'bot/sonar' of 20 Hz is 2\.5 steps"),
        ('name = "R2"', 'name = "R1"', r":31:1: another table has the name 'R1'"),
        ('name = "R2"', 'name = "R/2"', r":31:1: 'R/2' is not a valid body name"),
        ('agents = ["R1"]', 'agents = ["R9"]', r":14:1: no agent is named 'R9'"),
        (
            'duration = "20 s"',
            'durashun = "20 s"',
            r":4:1: unknown key 'durashun' in the file. Did you mean 'duration'",
        ),
    ],
)
def test_a_wrong_scenario_is_told_with_its_place(scenario_file, project, old, new, message):
    edit(scenario_file, old, new)
    with pytest.raises(InputError, match=message):
        Catalog(project).load_scenario("walk")


def test_a_misspelt_key_of_success_is_no_goal_without_a_name(scenario_file, project):
    edit(scenario_file, 'goal = "dock" }', 'gaol = "dock" }')
    with pytest.raises(InputError) as caught:
        Catalog(project).load_scenario("walk")
    found = [fault.message for fault in caught.value.faults]
    assert found == ["agent.0.success has no 'goal'.", "unknown key 'gaol' in agent.0.success."]


def test_a_robot_that_is_wrong_is_told_with_its_own_file(robot_file, project):
    edit(robot_file, '"0.4 m"', '"0.4 s"')
    with pytest.raises(InputError, match=r"robot\.toml:12:1: length must be in m"):
        Catalog(project).load_scenario("walk")


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
    assert found.positions["gain"] == (line, 1)


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
    made = robot_locomotion(robot.locomotion)
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
    assert robot_locomotion(robot.locomotion).neutral == "hover"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('max_speed = "0.2 m/s"\n', "", r"has no 'max_speed'"),
        ('max_speed = "0.2 m/s"', 'max_speed = "0.2 rad/s"', r"max_speed must be in m/s"),
        ('max_speed = "60 deg/s"', 'max_speed = "1 m/s"', r"max_speed must be in rad/s"),
        ("[locomotion.wz]", "[locomotion.wx]", r"unknown key 'wx'.*Did you mean 'w?[vw]?z'|needs the axis 'wz'"),
        ('"legged"', '"flying"', r"a 'flying' locomotion needs the axis 'vz'"),
        ('"legged"', '"legged"\nland_after = "2 s"', r"unknown key 'land_after'"),
        ('"legged"', '"twist"\nsway = "2 cm"', r"unknown key 'sway'"),
        ('"legged"', '"legged"\nsway = "0.3 m"', r"sway must be"),
        ('lag = "0.2 s"', 'lag = "0.2 m"', r"lag must be in s"),
        ('"legged"', '"legged"\nmax_wheel_speed = "1 m/s"', r"unknown key 'max_wheel_speed'"),
    ],
)
def test_a_wrong_body_is_told(robot_file, old, new, message):
    assert old in LEGGED
    with pytest.raises(InputError, match=message):
        body_without_wheels(robot_file, LEGGED.replace(old, new, 1))


def test_the_actuator_of_twists_declares_no_range(robot_file):
    with pytest.raises(InputError, match=r"range is not for the actuator of twists: the axes in \[locomotion\]"):
        body_without_wheels(robot_file, actuator='range = ["-1 m/s", "1 m/s"]')
