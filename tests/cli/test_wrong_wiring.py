"""Content that is well written but cannot work: refused by check and by run alike, with the place, and exit 2."""

from __future__ import annotations

import re

import pytest

from ..changes import edit

SCENARIO, ROBOT = "scenarios/first.toml", "robots/rover/robot.toml"
BODY, MISSION = "robots/rover/robot.xml", "planners/missions/patrol.py"
RANGE = 'class = "RangeMonitor"\n'
ACTOR = '[[actor]]\nname = "R2"\nrobot = "rover"\nscript = "random_walk"\nx = "1.5 m"\ny = "-1 m"\n'


def test_a_file_that_breaks_its_checker_does_not_hide_the_others(project, rocs_bt):
    edit(project / ROBOT, RANGE, 'class = "own.py:Broken"\n')
    (project / "robots" / "rover" / "own.py").write_text(
        "from rocs_bt.base.errors import DeviceError\nfrom rocs_bt.monitor import RangeMonitor\n\n\n"
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


PATROLS = {
    ".py": '''"""There, and there again."""
from rocs_bt import Mission
from rocs_bt.base.units import MetresPerSecond


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
    edit(project / SCENARIO, 'first = "gate"', 'first = "gaet"')
    edit(project / SCENARIO, "[[agent]]", may_appear + "[[agent]]")
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


@pytest.mark.parametrize("size", ["0 0 .1", None])
def test_a_world_without_an_end_has_no_outside(project, rocs_bt, size):
    floor = f'<geom name="floor" type="plane" size="{size}"/>' if size else ""
    (project / "scenarios" / "worlds" / "yard.xml").write_text(f"<mujoco><worldbody>{floor}</worldbody></mujoco>")
    edit(project / SCENARIO, 'x = "-1.5 m"', 'x = "-500 m"')
    told = rocs_bt("check", SCENARIO)
    assert told.code == 0
    assert "outside" not in told.text


def test_scripted_robots_have_their_robots_own_drivers(project, rocs_bt):
    edit(project / ROBOT, 'driver = "velocity"', 'driver = "own.py:Loud"')
    edit(project / SCENARIO, "[[agent]]", ACTOR + "[[agent]]")
    (project / "robots" / "rover" / "own.py").write_text(
        "from rocs_bt.devices.simulated import Velocity\n\n\n"
        "class Loud(Velocity):\n"
        "    def command(self, values):\n"
        "        super().command(values)\n"
        "        with open('commanded.txt', 'a') as file:\n"
        "            file.write(self.robot + '\\n')\n"
    )
    told = rocs_bt("run", "first", "--for", "0.5", "--no-report")
    assert told.code == 1, told.text
    assert set((project / "commanded.txt").read_text().split()) == {"R1", "R2"}
