"""Content that is well written but cannot work: refused by check and by run alike, with the place, and exit 2."""

from __future__ import annotations

import re

import pytest

SCENARIO, ROBOT = "scenarios/first.toml", "robots/rover/robot.toml"
BODY, MISSION = "robots/rover/robot.xml", "planners/missions/patrol.py"
RANGE = 'class = "RangeMonitor"\n'
GROUPS = 'monitors = ["range"]\ngroups = ["front", "rear"]'
MOTORS = 'driver = "velocity"\nmotors = ["left_motor", "right_motor"]'
ACTOR = '[[actor]]\nname = "R2"\nrobot = "rover"\nscript = "random_walk"\nx = "1.5 m"\ny = "-1 m"\n'
LAST = "    return tree\n"


def edit(project, file, old, new):
    text = (project / file).read_text()
    assert old in text
    (project / file).write_text(text.replace(old, new))


def line_of(project, file, text):
    """The 1-based line on which a text begins."""
    before, found, _ = (project / file).read_text().partition(text)
    assert found
    return before.count("\n") + 1


WRONG = [
    # Names: an agent, its devices and its places are nodes of one graph.
    (SCENARIO, '"gate"', '"sonar"', '[[place]]\nname = "sonar"', "the name 'sonar' is taken by the sensor 'sonar'"),
    (SCENARIO, '"R1"', '"sonar"', "[[agent]]", "the name 'sonar' is taken by the sensor 'sonar' of rover"),
    (SCENARIO, '"R1"', '"wheels"', "[[agent]]", "the name 'wheels' is taken by the actuator 'wheels' of rover"),
    (SCENARIO, '"R1"', '"gate"', 'name = "gate"', "another table has the name 'gate'"),
    (SCENARIO, '"R1"', '""', 'name = ""', "'' is not a valid name"),
    (SCENARIO, '"R1"', '" "', 'name = " "', "' ' is not a valid name"),
    (
        ROBOT,
        'name = "encoders"',
        'name = "wheels"',
        'name = "wheels"\ndriver = "velocity"',
        "another [[sensor]] is",
    ),
    (SCENARIO, 'y = "0 m"\n', 'y = "0 m"\ntolerence = "1 m"\n', "tolerence", "unknown key 'tolerence' in place.0"),
    (
        SCENARIO,
        'name = "gate"\n',
        'name = "tree"\nkind = "object"\ncolour = "red"\nx = "9 m"\ny = "0 m"\n[[place]]\nname = "gate"\n',
        'colour = "red"',
        "no parameter is named 'colour'",
    ),
    # Devices and blocks.
    (
        ROBOT,
        '[[analyze]]\nname = "position"',
        '[[monitor]]\nname = "again"\nclass = "WheelMonitor"\nsensors = ["encoders"]\n[[analyze]]\nname = "position"',
        '[[monitor]]\nname = "again"',
        "the monitor 'wheels' and the monitor 'again' both write the signal 'wheel_speeds'",
    ),
    (
        ROBOT,
        MOTORS,
        'driver = "velocity"\nmotors = ["left_motor"]',
        "[[actuator]]",
        "the actuator 'wheels' takes 1 values, but a 'differential' locomotion has 2. Give it one",
    ),
    (
        ROBOT,
        MOTORS,
        'driver = "velocity"\nmotors = ["left_motor", "left_motor"]',
        "[[actuator]]",
        "motors must name each element of the model once, found left_motor twice",
    ),
    (ROBOT, "beams = 16\n", "beams = 15\n", f'[[monitor]]\nname = "range"\n{RANGE}', "expects 15 values from the"),
    (
        ROBOT,
        "beams = 16\n",
        "beams = 2.5\n",
        "beams = 2.5",
        "must be a whole number, found",
    ),
    (
        ROBOT,
        'min_vanish_range = "0.7 m"',
        'min_vanish_range = "x"',
        'min_vanish_range = "x"',
        "'x' is not a quantity",
    ),
    (
        ROBOT,
        'min_vanish_range = "0.7 m"',
        "min_vanish_range = nan",
        "min_vanish_range = nan",
        "min_vanish_range needs a unit, found the bare number nan",
    ),
    (ROBOT, "beams = 16\n", "beams = 0\n", f'[[monitor]]\nname = "range"\n{RANGE}', "must be at least 1, found 0"),
    (
        ROBOT,
        'sensors = ["position", "orientation"]',
        'sensors = ["position", "orientation"]\nposition = "gps"',
        '[[monitor]]\nname = "pose"',
        "no sensor is named 'gps'. The monitor 'pose' has: orientation, position",
    ),
    (
        ROBOT,
        "beams = [1, 2, 3",
        "beams = [1, 2, 33",
        '[[monitor]]\nname = "range"',
        "group 'front' of monitor 'range'",
    ),
    (
        ROBOT,
        GROUPS,
        GROUPS.replace("front", "fron"),
        "[[analyze]]",
        "no signal is named 'fron'. Did you mean 'front'",
    ),
    (ROBOT, GROUPS, GROUPS.replace("range", "pose"), "[[analyze]]", "no signal is named 'front'. The input of"),
    (ROBOT, 'near = "0.6 m"', 'near = "6 m"', "[[analyze]]", "near must be above 0 m and below clear, found 6 m"),
    (ROBOT, 'noise = "0 m"', 'noise = "inf m"', "noise", "noise must be finite, found 'inf m'"),
    (
        ROBOT,
        'wheel_separation = "0.331 m"',
        'wheel_separation = "0 m"',
        "[locomotion]",
        "wheel_separation of a 'differential' drive must be a positive",
    ),
    (
        ROBOT,
        'max_command_age = "0.2 s"',
        'max_command_age = "10 ms"',
        "[[actuator]]",
        "the actuator 'wheels' goes to neutral 0.01 s after a command, but first sends one only every 0.05 s",
    ),
    # Files.
    (ROBOT, '"robot.xml"', '"/etc/hostname"', "model", "'/etc/hostname' is not in the robot's folder"),
    (ROBOT, '"robot.xml"', '"../../robot.xml"', "model", "'../../robot.xml' is not in the robot's folder"),
    (ROBOT, '"velocity"', '"../../own.py:Own"', 'driver = "../', "'../../own.py' is not in the robot's folder"),
    (BODY, '<mesh name="hull"', '<mesh name="hul"', '<geom name="hull"', "the model does not compile: Error: mesh"),
    # The world, and who moves in it.
    (SCENARIO, 'x = "-1.5 m"', 'x = "-2.4 m"', "[[agent]]", "R1 cannot start at x = -2."),
    (
        SCENARIO,
        "[[agent]]",
        f'{ACTOR}max_leg_duration = "inf s"\n[[agent]]',
        "[[actor]]",
        "max_leg_duration must be finite and at least",
    ),
    (SCENARIO, "[[agent]]", f'{ACTOR}margin = "-1 m"\n[[agent]]', "[[actor]]", "margin must be finite and at least"),
    (
        SCENARIO,
        '[[place]]\nname = "gate"',
        '[rate]\ncontrol = "50 Hz"\n[[place]]\nname = "gate"',
        "[rate]",
        'which is not a whole number. Use 16.6667 Hz or 25 Hz. Or set one rate for all sensors: sensors = "50 Hz"',
    ),
]
CASES = [*((("check",), *row) for row in WRONG), *((("run", "first"), *row) for row in WRONG[::6])]


@pytest.mark.parametrize(("command", "file", "old", "new", "at", "message"), CASES)
def test_what_cannot_work_is_refused_with_its_location(project, rocs_bt, command, file, old, new, at, message):
    edit(project, file, old, new)
    told = rocs_bt(*command)
    assert told.code == 2, told.text
    assert "Traceback" not in told.text
    where = rf"{re.escape(file)}:{line_of(project, file, at)}(:\d+)?: .*{re.escape(message)}"
    assert re.search(where, told.text), f"{where}\n{told.text}"
    assert not (project / "runs").exists()


@pytest.mark.parametrize("command", [("run", "first"), ("check",)], ids=lambda c: c[0])
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            LAST,
            "    return None\n",
            "build returned None, which is not a py_trees behaviour. Return the root of a py_trees",
        ),
        (
            LAST,
            '    return py_trees.composites.Sequence("none", memory=True)\n',
            "'none' has no children. Add children",
        ),
        (LAST, "    mission.knowledge.world.pursue('nowhere')\n" + LAST, "nowhere"),
        ('mission.act("GoTo"', 'mission.act("Nope"', "no action is named 'Nope'. There are: AvoidCollision"),
    ],
    ids=["none", "empty", "knowledge", "action"],
)
def test_a_mission_that_cannot_be_ticked_is_refused(project, rocs_bt, command, old, new, message):
    edit(project, MISSION, old, new)
    told = rocs_bt(*command)
    assert told.code == 2, told.text
    assert message in told.text
    assert "Traceback" not in told.text


def test_a_run_tells_the_line_of_the_mission(project, rocs_bt):
    edit(project, MISSION, 'mission.act("GoTo"', 'mission.act("Nope"')
    line = line_of(project, MISSION, "        tree.add_child(mission.act")
    assert f"patrol.py:{line}: no action is named 'Nope'." in rocs_bt("run", "first").err
    edit(project, MISSION, 'mission.act("Nope"', 'mission.act("GoTo"')


def test_a_missing_site_is_told_with_the_sites_that_its_author_made(project, rocs_bt):
    edit(project, ROBOT, '"sonar3"', '"sonarX"')
    edit(project, ROBOT, '"sonar4"', '"sonarY"')
    told = rocs_bt("run", "first")
    line = line_of(project, ROBOT, "[[sensor]]")
    assert told.code == 2
    for site in ("sonarX", "sonarY"):
        assert f"robot.toml:{line}: no site for sensor 'sonar' is named '{site}'." in told.text
    assert "sonar15" in told.text
    assert "sonar/" not in told.text


def test_a_file_that_breaks_its_checker_does_not_hide_the_others(project, rocs_bt):
    edit(project, ROBOT, RANGE, 'class = "own.py:Broken"\n')
    (project / "robots" / "rover" / "own.py").write_text(
        "from rocs_bt.errors import DeviceError\nfrom rocs_bt.monitor import RangeMonitor\n\n\n"
        "class Broken(RangeMonitor):\n    def __init__(self, *args, **kwargs):\n"
        "        raise DeviceError('no cable is plugged in')\n"
    )
    (project / "rules" / "zealous.toml").write_text('format = "reflex/2"\n')
    told = rocs_bt("check")
    assert told.code == 2
    assert re.search(r"own\.py:7: .*no cable is plugged in", told.text)
    assert re.search(r"zealous\.toml:1:1: ", told.text)


def test_a_leader_that_is_no_robot_of_the_scenario_is_told_beforehand(tmp_path, rocs_bt):
    file = tmp_path / "lonely.toml"
    file.write_text(
        'format = "scenario/2"\nbase = "exp3"\ndoc = "Nobody to follow."\n'
        '[[agent]]\nname = "R3"\n[agent.parameters]\nleader = "R9"\n'
    )
    told = rocs_bt("check", file)
    assert told.code == 0
    assert "warning: no other robot is named 'R9'." in told.text
    assert "R1, R2" in told.text
    assert "FollowRobot fails at once" in told.text


def test_a_goal_that_no_place_has_is_refused_by_check_and_run(project, rocs_bt):
    edit(project, SCENARIO, 'first = "gate"', 'first = "gaet"')
    line = line_of(project, SCENARIO, 'first = "gaet"')
    fault = rf"first\.toml:{line}:1: no place is named 'gaet'\. Did you mean"
    for command in (("run", "first", "--for", "0.5"), ("check", SCENARIO)):
        told = rocs_bt(*command)
        assert told.code == 2
        assert re.search(fault, told.text)
    assert not (project / "runs").exists()


PATROLS = {
    ".py": '''"""There, and there again."""
from rocs_bt import Mission
from rocs_bt.units import MetresPerSecond


def build(mission: Mission, *, first: str, second: str, cruise: MetresPerSecond = 0.4):
    leaves = [mission.act("GoTo", name=str(i), goal="gaet") for i in range(2)] + [mission.act("GoTo", goal="gaet")]
    return mission.node("Sequence", *leaves)
''',
    ".xml": """<root BTCPP_format="4" main_tree_to_execute="patrol"><BehaviorTree ID="patrol">
<Sequence><GoTo goal="gaet"/><GoTo goal="gaet"/></Sequence></BehaviorTree><TreeNodesModel><SubTree ID="patrol">
<input_port name="first"/><input_port name="second"/><input_port name="cruise" type="m/s"/>
</SubTree></TreeNodesModel></root>
""",
}


@pytest.mark.parametrize("suffix", PATROLS)
def test_so_is_one_that_a_mission_goes_to_twice(project, rocs_bt, suffix):
    (project / "planners/missions/patrol.py").unlink()
    (project / f"planners/missions/patrol{suffix}").write_text(PATROLS[suffix])
    told = rocs_bt("check", SCENARIO)
    assert told.code == 2, told.text
    assert "no place is named 'gaet'. Did you mean 'gate'" in told.text
    assert "warning: no place" not in told.text


@pytest.mark.parametrize("suffix", PATROLS)
def test_so_is_one_that_a_mission_looks_at_and_a_heading_that_the_robot_cannot_have(project, rocs_bt, suffix):
    (project / "planners/missions/patrol.py").unlink()
    mission = PATROLS[suffix].replace('goal="gaet"', 'goal="gate", heading="look_at gaet"')
    (project / f"planners/missions/patrol{suffix}").write_text(
        mission.replace('", h', '" h') if suffix == ".xml" else mission
    )
    told = rocs_bt("check", SCENARIO)
    assert told.code == 2, told.text
    assert "no place is named 'gaet'. Did you mean 'gate'" in told.text
    assert "warning: no place" not in told.text
    assert re.search(rf"patrol\{suffix}:\d+.* a 'differential' locomotion cannot move sideways", told.text)


@pytest.mark.parametrize(
    ("may_appear", "says"),
    [
        ('[[fact]]\nnode = "gaet"\nkind = "object"\nat = "1 s"\n', "no place is named 'gaet'"),
        ('[[fact]]\nnode = "gaet"\nkind = "object"\n', "the position of 'gaet' is not known at the start"),
        ('[share]\nkinds = ["all"]\n', "no place is named 'gaet'"),
    ],
    ids=["told later", "known without a pose", "shared"],
)
def test_a_goal_that_may_become_known_is_a_warning(project, rocs_bt, may_appear, says):
    edit(project, SCENARIO, 'first = "gate"', 'first = "gaet"')
    edit(project, SCENARIO, "[[agent]]", may_appear + "[[agent]]")
    told = rocs_bt("check", SCENARIO)
    assert told.code == 0, told.text
    assert f"warning: {says}" in told.text
    told = rocs_bt("run", "first", "--for", "0.5", "--no-report")
    assert told.code == 1, told.text
    assert f"warning: {says}" in told.text


def test_a_goal_that_the_mission_makes_itself_is_a_warning(project, rocs_bt):
    (project / MISSION).write_text(
        '"""Find a way out, then go there."""\n\nfrom py_trees.behaviour import Behaviour\n'
        "from py_trees.common import Status\nfrom py_trees.composites import Sequence\n\n\n"
        "class Find(Behaviour):\n    def __init__(self, world):\n        super().__init__('find')\n"
        "        self.world = world\n\n    def update(self):\n"
        '        self.world.place("way out", (0.0, 0.0, 0.0))\n        return Status.SUCCESS\n\n\n'
        "def build(mission):\n    find = Find(mission.knowledge.world)\n"
        '    go = mission.act("GoTo", goal="way out")\n'
        '    return Sequence("out", memory=True, children=[find, go])\n'
    )
    scenario = project / SCENARIO
    scenario.write_text(scenario.read_text().partition("[agent.parameters]")[0])
    told = rocs_bt("check", SCENARIO)
    assert told.code == 0, told.text
    assert "warning: no place is named 'way out'" in told.text


def test_a_run_without_doubts_says_nothing_of_them(project, rocs_bt):
    assert "warning" not in rocs_bt("run", "first", "--for", "0.5", "--no-report").err


@pytest.mark.parametrize(
    ("old", "new", "at", "what"),
    [
        ('y = "0 m"', 'y = "30 m"', "[[place]]", "the goal 'gate' at x = 1.5 m, y = 30 m is outside of the world"),
    ],
)
def test_what_is_outside_of_the_world_is_doubtful(project, rocs_bt, old, new, at, what):
    edit(project, SCENARIO, old, new)
    told = rocs_bt("check", SCENARIO)
    assert told.code == 0
    assert f"first.toml:{line_of(project, SCENARIO, at)}: warning: {what}" in told.text


@pytest.mark.parametrize(
    ("old", "new", "at", "what"),
    [
        ('x = "-1.5 m"', 'x = "-1500 m"', "[[agent]]", "the start of R1 at x = -1500 m, y = -0.5 m is outside of"),
        ("[[agent]]", ACTOR.replace('"1.5 m"', '"7 m"') + "[[agent]]", "[[actor]]", "the start of R2 at x = 7 m"),
    ],
)
def test_a_start_outside_of_the_world_is_refused_by_check_and_run(project, rocs_bt, old, new, at, what):
    edit(project, SCENARIO, old, new)
    for command in (("check", SCENARIO), ("run", "first")):
        told = rocs_bt(*command)
        assert told.code == 2
        assert f"first.toml:{line_of(project, SCENARIO, at)}: {what}" in told.text


@pytest.mark.parametrize("size", ["0 0 .1", None])
def test_a_world_without_an_end_has_no_outside(project, rocs_bt, size):
    floor = f'<geom name="floor" type="plane" size="{size}"/>' if size else ""
    (project / "scenarios" / "worlds" / "yard.xml").write_text(f"<mujoco><worldbody>{floor}</worldbody></mujoco>")
    edit(project, SCENARIO, 'x = "-1.5 m"', 'x = "-500 m"')
    told = rocs_bt("check", SCENARIO)
    assert told.code == 0
    assert "outside" not in told.text


def test_scripted_robots_have_their_robots_own_drivers(project, rocs_bt):
    edit(project, ROBOT, 'driver = "velocity"', 'driver = "own.py:Loud"')
    edit(project, SCENARIO, "[[agent]]", ACTOR + "[[agent]]")
    (project / "robots" / "rover" / "own.py").write_text(
        "from rocs_bt.drivers.mujoco import ACTUATORS\n\n\n"
        "class Loud(ACTUATORS['velocity']):\n"
        "    def command(self, values):\n"
        "        super().command(values)\n"
        "        with open('commanded.txt', 'a') as file:\n"
        "            file.write(self.mount.robot + '\\n')\n"
    )
    told = rocs_bt("run", "first", "--for", "0.5", "--no-report")
    assert told.code == 1, told.text
    assert set((project / "commanded.txt").read_text().split()) == {"R1", "R2"}
