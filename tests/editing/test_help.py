"""Faults, completion, descriptions and definitions of a text at an offset."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rocs_bt.base.files import unsaved
from rocs_bt.check import check_content
from rocs_bt.studio.editing import complete, define, describe, faults, vocabulary

from .conftest import MISSION

ROOT = Path(__file__).parents[2]


def completed(file: Path, text: str) -> list[str]:
    """Labels of the proposals at the sign `|` of a text."""
    at = text.index("|")
    found = complete(file, text.replace("|", "", 1), at)
    assert all(item.start <= at <= item.end for item in found)
    return [item.label for item in found]


@pytest.mark.parametrize(
    ("written", "some"),
    [
        ("<|", {"Sequence", "RetryUntilSuccessful", "GoTo", "SubTree Leg", "SubTree navigate"}),
        ("<Go|", {"GoTo"}),
        ("<GoTo |/>", {"goal", "cruise", "_skipIf", "name"}),
        ('<GoTo goal="gate" |', {"cruise"}),
        ('<GoTo goal="{|"/>', {"{place}"}),
        ('<SubTree ID="|"/>', {"Leg", "navigate", "patrol"}),
        ('<SubTree ID="Leg" |/>', {"place"}),
        ('<ComputeRoute planner="|"/>', set()),
        ("<!-- <| -->", set()),
    ],
)
def test_a_mission_is_completed(yard, written, some):
    found = completed(yard / "planners" / "missions" / "new.xml", MISSION % written)
    assert some <= set(found) or found == some
    assert len(found) == len(set(found))


@pytest.mark.parametrize(
    ("file", "old", "new", "some"),
    [
        ("scenarios/first.toml", 'mission = "patrol"', 'mission = "|"', {"patrol", "navigate"}),
        ("scenarios/first.toml", 'mission = "patrol"', 'mission = "pa|', {"patrol", "navigate"}),
        ("scenarios/first.toml", 'robot = "rover"', "|", {"robot"}),
        ("scenarios/first.toml", 'robot = "rover"', "ro|", {"robot"}),
        ("scenarios/first.toml", 'goal = "dock"', 'goal = "|"', {"gate", "dock"}),
        ("scenarios/first.toml", 'goal = "dock"', "|", {"goal", "at"}),
        ("scenarios/first.toml", '"keep_clear"]', '"|"]', {"keep_clear", "contact"}),
        ("scenarios/first.toml", 'world = "yard"', 'world = "|"', {"yard"}),
        ("scenarios/first.toml", "[[place]]", "[[|", {"place", "agent", "fact"}),
        ("rules/keep_clear.toml", 'trigger = "edge"', "|", {"trigger", "cooldown", "modes"}),
        ("rules/keep_clear.toml", 'trigger = "edge"', 'trigger = "|"', {"edge", "level"}),
        ("rules/keep_clear.toml", "min(front) <", "min(|) <", {"front", "left_gap", "goal_distance"}),
        ("rules/keep_clear.toml", 'name = "AvoidCollision"', 'name = "|"', {"AvoidCollision", "Stop"}),
        ("rules/keep_clear.toml", 'duration = "2.0 s"', "|", {"duration", "rate"}),
        ("robots/rover/robot.toml", 'kind = "skid"', 'kind = "|"', {"skid", "mecanum"}),
        ("robots/rover/robot.toml", 'driver = "lidar"', 'driver = "|"', {"lidar", "wheel_speed"}),
        ("robots/rover/robot.toml", 'kind = "skid"', "|", {"kind"}),
    ],
)
def test_toml_is_completed(yard, file, old, new, some):
    text = (yard / file).read_text("utf-8")
    assert old in text
    found = completed(yard / file, text.replace(old, new, 1))
    assert not some - set(found), found


def test_every_key_that_is_written_is_one_that_is_proposed(yard):
    """Each key of each shipped kind of file is proposed in its place, and described."""
    wrong = []
    for name in ("scenarios/dock.toml", "rules/contact.toml", "robots/jackal/robot.toml"):
        text = (ROOT / name).read_text("utf-8")
        for found in list(re.finditer(r"^(\w+) = ", text, re.MULTILINE))[::6]:
            end = text.find("\n", found.start())
            tried = text[: found.start()] + "|" + text[end:]
            if found[1] not in completed(ROOT / name, tried):
                wrong.append((name, found[1]))
    assert {key for _, key in wrong} <= {"weights", "near", "static_objects"}, (
        "parameters of classes, which the classes read themselves"
    )


def test_descriptions(yard):
    file = yard / "planners" / "missions" / "new.xml"
    text = MISSION % '<RetryUntilSuccessful num_attempts="2"><GoTo goal="gate"/></RetryUntilSuccessful>'
    node = describe(file, text, text.index("RetryUntil") + 3)
    assert (node.title, node.detail) == ("RetryUntilSuccessful", "Decorator")
    assert any("num_attempts: input int required" in row for row in node.rows)
    assert describe(file, text, text.index('goal="gate"')).detail == "input string required"
    assert describe(file, text, text.index("what to do")) is None
    scenario = (yard / "scenarios" / "first.toml").read_text("utf-8")
    key = describe(yard / "scenarios" / "first.toml", scenario, scenario.index("duration") + 1)
    assert (key.detail, key.doc) == ("a quantity [s], default 60 s", "Time limit of the episode [s].")


def test_definitions(yard):
    file, text = yard / "planners" / "missions" / "new.xml", MISSION % "<Script code=\"place := 'dock'\"/>"
    tree = define(file, text, text.index('ID="Leg" place') + 2)
    assert (tree.file, tree.line) == (file, 9)
    assert define(file, text, text.index("<GoTo") + 2).file.name == "go_to.py"
    assert define(file, text, text.index("{place}") + 2).line == 5
    scenario = (yard / "scenarios" / "first.toml").read_text("utf-8")
    for word, expected in {'"patrol"': "patrol.py", '"rover"': "robot.toml", '"keep_clear"': "keep_clear.toml"}.items():
        assert define(yard / "scenarios" / "first.toml", scenario, scenario.index(word) + 2).file.name == expected
    assert define(yard / "scenarios" / "first.toml", scenario, scenario.index('goal = "dock"') + 9).line == 12


def test_a_fault_has_its_span_and_its_hint_has_no_list_of_names(yard):
    text = MISSION % '<RetryUntilSuccessfull num_attempts="two"><GoTo goal="gate"/></RetryUntilSuccessfull>'
    (mark,) = [m for m in faults(yard / "planners" / "missions" / "new.xml", text) if m.level == "error"]
    line = text.split("\n")[mark.line - 1]
    assert line[mark.column - 1 : mark.end - 1] == "<RetryUntilSuccessfull"
    assert mark.hint.startswith("Did you mean 'RetryUntilSuccessful'?")
    assert mark.instead == "RetryUntilSuccessful"
    assert len(mark.names) > 40
    assert "PipelineSequence" not in mark.hint


def test_unsaved_texts_are_checked_together_and_files_stay_as_they_are(yard):
    mission, scenario = yard / "planners" / "missions" / "new.xml", yard / "scenarios" / "first.toml"
    before = scenario.read_bytes()
    changed = scenario.read_text("utf-8").partition("[agent.parameters]")[0].replace('"patrol"', '"new.xml"')
    changed = changed.replace('"new.xml"', f'"{mission}"')
    text = MISSION % '<RetryUntilSuccessful num_attempts="two"><GoTo goal="gate"/></RetryUntilSuccessful>'
    found = check_content([scenario], texts={scenario: changed, mission: text}).faults
    alone = check_content([mission], texts={mission: text}).faults
    (place,) = [(f.file, f.line, f.column) for f in found if "'two'" in f.message]
    assert place in [(f.file, f.line, f.column) for f in alone if "'two'" in f.message]
    assert not mission.exists()
    assert scenario.read_bytes() == before
    with unsaved({scenario: "1"}):
        pass
    assert check_content([scenario]).faults == ()


def test_a_mission_that_its_scenario_gives_wrong_parameters_is_judged_all_the_same(yard):
    mission, scenario = yard / "planners" / "missions" / "new.xml", yard / "scenarios" / "first.toml"
    changed = scenario.read_text("utf-8").replace('"patrol"', f'"{mission}"')  # it still has the parameters of patrol
    text = MISSION % '<RetryUntilSuccessful num_attempts="two"><GoTo goal="gate"/></RetryUntilSuccessful>'
    found = check_content([mission], texts={scenario: changed, mission: text}).faults
    assert [f.line for f in found if "'two'" in f.message] == [5]
    assert [f.file for f in found if "no parameter is named" in f.message] == [scenario] * 3


def test_the_vocabulary_has_standard_nodes_actions_and_trees(yard):
    found = vocabulary(yard / "planners" / "missions" / "new.xml", MISSION % "")
    assert {"Sequence", "RetryUntilSuccessful", "Script", "GoTo", "SubTree Leg"} <= found.keys()
    assert found["GoTo"].text == '<GoTo goal=""/>'
    assert [p.name for p in found["SubTree Leg"].ports] == ["place"]
    nav2 = vocabulary(yard / "planners" / "missions" / "new.xml", MISSION % "<ControllerSelector/>")
    assert "ComputePathToPose" in nav2


def test_a_tree_that_other_missions_use_gets_its_keys_from_them(yard):
    """A file of a subtree has no warnings that the mission which uses it does not have."""
    leg, whole = yard / "planners" / "missions" / "leg.xml", yard / "planners" / "missions" / "tour.xml"
    text = '<root BTCPP_format="4"><BehaviorTree ID="leg"><GoTo goal="{place}"/></BehaviorTree></root>'
    use = '<root BTCPP_format="4"><BehaviorTree ID="tour"><SubTree ID="leg" place="gate"/></BehaviorTree></root>'
    assert [f for f in check_content([leg], texts={leg: text}).faults if "no node writes it" in f.message]
    whole.write_text(use, "utf-8")
    try:
        assert not check_content([leg], texts={leg: text}).faults
    finally:
        whole.unlink()
