"""Types and lengths of actions' parameters, by `check` and before a run: at the line of the mission or rule file."""

import pytest

MISSION = '''"""Drives."""

from rocs_bt import Mission
from rocs_bt.units import PositiveMetresPerSecond


def build(mission: Mission, *, first: str, second: str, cruise: PositiveMetresPerSecond = 0.4):
    return {leaf}
'''

RULES = """format = "reflex/1"
doc = "One rule."

[rule.Fast]
priority = 1
when = "min(front) < 0.3 m"
on_invalid = "trip"
action = {{ name = "SetWheelSpeed", speeds = {speeds}, on_invalid = {{ speeds = ["0 m/s", "0 m/s"] }} }}
"""

XML = """<root BTCPP_format="4" main_tree_to_execute="patrol">
  <BehaviorTree ID="patrol">
    <SetWheelSpeed speeds="{speeds}"/>
  </BehaviorTree>
</root>
"""

LEAVES = {
    'mission.act("SetWheelSpeed", speeds=["0.6 m/s"])': "the drive takes 2 wheel speeds (left, right), found 1",
    'mission.act("SetWheelSpeed", speeds=["0.6 m", "0.6 m"])': "speeds of SetWheelSpeed must be in m/s",
    'mission.act("SetWheelSpeed", speeds=[0.6, "fast"])': "'fast' is not a quantity",
    'mission.act("SetWheelSpeed", speeds=[0.6, None])': "must be a list in which each is a number, found [0.6, None]",
    'mission.act("SetWheelSpeed", speeds=0.6)': "speeds of SetWheelSpeed must be a list, found 0.6",
    'mission.act("SetWheelSpeed", speeds=(0.1, 0.2, 0.3))': "the drive takes 2 wheel speeds (left, right), found 3",
    'mission.act("GoTo", goal=3)': "goal of GoTo must be a text, found 3",
    'mission.act("GoTo", goal=first, cruise=True)': "cruise of GoTo must be a number, found True",
    'mission.act("Dock", goal=first, attempts=1.5)': "attempts of Dock must be a whole number, found 1.5",
    'mission.act("FollowPath", points=[(0.0, 1.0), 2.0])': "points of FollowPath must be a list in which each",
    'mission.act("GoTo", gaol=first)': "no parameter of GoTo is named 'gaol'",
    'mission.wait("-1 s")': "wait must be 0 or more",
    'mission.when("min(frnt) > 1 m")': "frnt",
    'mission.node("SetWheelSpeed", speeds="0.6 m/s")': "the drive takes 2 wheel speeds (left, right), found 1",
}


@pytest.mark.parametrize("leaf", LEAVES)
def test_a_python_mission_is_checked_at_its_line(leaf, project, rocs_bt):
    file = project / "planners/missions/patrol.py"
    file.write_text(MISSION.format(leaf=leaf))
    line = next(i for i, each in enumerate(file.read_text().splitlines(), 1) if "return" in each)
    checked = rocs_bt("check", "scenarios/first.toml")
    assert checked.code == 2
    found = [each for each in checked.text.splitlines() if LEAVES[leaf] in each]
    assert found
    assert found[0].startswith(f"{file}:{line}: ")
    run = rocs_bt("run", "first")
    assert run.code == 2
    assert [each for each in run.err.splitlines() if LEAVES[leaf] in each and each.startswith(f"{file}:{line}: ")]


@pytest.mark.parametrize("leaf", ['mission.act("SetWheelSpeed", speeds=["0.2 m/s", 0.2], duration="1 s")'])
def test_quantities_in_lists_become_numbers(leaf, project, rocs_bt):
    file = project / "planners/missions/patrol.py"
    file.write_text(MISSION.format(leaf=leaf))
    run = rocs_bt("run", "first", "--no-report")
    assert run.code == 1
    assert "0.2 m from" not in run.err
    assert "moved 0.2" in run.out


@pytest.mark.parametrize(
    ("speeds", "words"),
    [
        ('["0.2 m/s"]', "speeds of SetWheelSpeed: the drive takes 2 wheel speeds (left, right), found 1"),
        ('["0.2 m/s", "min(front) / 1 s", "0.1 m/s"]', "the drive takes 2 wheel speeds (left, right), found 3"),
        ('"0.2 m/s"', "'speeds' must be a list of numbers"),
    ],
)
def test_a_rule_file_is_checked_for_the_robots_that_use_it(speeds, words, project, rocs_bt):
    file = project / "rules/keep_clear.toml"
    file.write_text(RULES.format(speeds=speeds))
    for path in ("rules/keep_clear.toml", "scenarios/first.toml"):
        checked = rocs_bt("check", path)
        assert checked.code == 2
        assert [each for each in checked.text.splitlines() if words in each and each.startswith(f"{file}:8:")]
    run = rocs_bt("run", "first")
    assert run.code == 2
    assert [each for each in run.err.splitlines() if words in each and each.startswith(f"{file}:8:")]


def test_an_xml_mission_is_checked_too(project, rocs_bt):
    (project / "planners/missions/patrol.py").unlink()
    file = project / "planners/missions/patrol.xml"
    file.write_text(XML.format(speeds="0.2 m/s"))
    scenario = project / "scenarios/first.toml"
    scenario.write_text(scenario.read_text().partition("[agent.parameters]")[0])
    words = "the drive takes 2 wheel speeds (left, right), found 1"
    for command in (("check", "scenarios/first.toml"), ("run", "first")):
        told = rocs_bt(*command)
        assert told.code == 2
        assert [each for each in told.text.splitlines() if words in each and each.startswith(f"{file}:3:20: ")]


OWN = '''"""Drives."""

from dataclasses import dataclass

from rocs_bt import AtomicAction, Mission, Progress
from rocs_bt.units import MetresPerSecond


@dataclass(kw_only=True, eq=False)
class Creep(AtomicAction):
    """Creeps."""

    @classmethod
    def misfits(cls, parameters, *more):
        return parameters["missing"]

    def act(self, body) -> Progress:
        return Progress.SUCCEEDED


def build(mission: Mission, *, first: str, second: str, cruise: MetresPerSecond = 0.4):
    return mission.act("Creep")
'''


def test_what_misfits_of_an_own_action_raises_is_a_fault_at_the_line(project, rocs_bt):
    file = project / "planners/missions/patrol.py"
    file.write_text(OWN)
    checked = rocs_bt("check", "scenarios/first.toml")
    assert checked.code == 2
    assert f"{file}:22: misfits of Creep: it raised KeyError: 'missing'." in checked.text
