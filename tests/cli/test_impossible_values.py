"""Values that no robot can act on: refused with their place before anything runs, harmless where they come later."""

from __future__ import annotations

import json
import re

import pytest

from rocs_bt.event import ActuatorCommanded, TicketChanged
from rocs_bt.record import Recording

SCENARIO, RULES, ROBOT = "scenarios/first.toml", "rules/keep_clear.toml", "robots/rover/robot.toml"
MISSION = "planners/missions/patrol.py"


def edit(project, file, old, new):
    """Put one text for another; the 1-based line where it stands."""
    before, found, after = (project / file).read_text().partition(old)
    assert found
    (project / file).write_text(before + new + after)
    return before.count("\n") + 1


@pytest.mark.parametrize("command", [("run", "first"), ("check",)], ids=lambda c: c[0])
@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        (SCENARIO, 'cruise = "0.4 m/s"', f'cruise = "{cruise}"', message)
        for cruise, message in (
            ("-0.5 m/s", "cruise must be positive and finite, found -0.5 m/s."),
            ("0 m/s", "cruise must be positive and finite, found 0 m/s."),
            ("inf m/s", "cruise must be positive and finite, found inf m/s."),
        )
    ]
    + [
        (RULES, 'duration = "2.0 s"', 'duration = "-1.5 s"', "duration of AvoidCollision must be positive and finite"),
        (RULES, 'duration = "2.0 s"', 'rate = "-2.5 rad/s"', "rate of AvoidCollision must be positive and finite"),
        (RULES, 'speed = "0 m/s"', 'speed = "inf m/s"', "speed of AvoidCollision must be finite, found inf m/s."),
        (ROBOT, "rays = 5", "rays = 100000000", "rays must be 1 to 1000 for each beam, found 100000000."),
    ],
)
def test_they_are_refused_by_check_and_run_alike(project, rocs_bt, command, file, old, new, message):
    line = edit(project, file, old, new)
    told = rocs_bt(*command)
    assert told.code == 2, told.text
    place = rf"{re.escape(file)}:\d+" if file == ROBOT else rf"{re.escape(file)}:{line}"
    assert re.search(rf"{place}(:\d+)?: .*{re.escape(message)}", told.text), told.text
    assert "Traceback" not in told.text
    assert not (project / "runs").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cruise=cruise", 'cruise="-0.5 m/s"', "cruise of GoTo must be positive and finite, found -0.5 m/s."),
        ("mission.wait(rest)", "mission.wait(-rest)", "wait must be 0 or more and finite, found -1 s."),
    ],
)
def test_a_mission_is_told_the_line_where_it_asks_for_one(project, rocs_bt, old, new, message):
    line = edit(project, MISSION, old, new)
    told = rocs_bt("run", "first")
    assert told.code == 2
    assert f"patrol.py:{line}: {message}" in told.text
    assert message in rocs_bt("check").out


def test_a_reflex_that_comes_out_impossible_stands_still_and_is_no_defect(project, rocs_bt):
    """The nearer, the shorter: less than nothing as soon as the rule fires."""
    edit(project, RULES, "min(front) < min(0.40 m, max(goal_distance - 0.07 m, 0.05 m))", "min(front) < 1.5 m")
    edit(project, RULES, "min(front) > 0.50 m", "min(front) > 1.6 m")
    edit(project, RULES, 'duration = "2.0 s"', 'duration = "1 s * (min(front) - 2 m) / 1 m"')
    edit(project, SCENARIO, 'duration = "60 s"', 'duration = "12 s"')
    told = rocs_bt("run", "first", "--no-report")
    assert told.code == 1
    agent = json.loads((project / "runs" / "first-1" / "summary.json").read_text())["agents"]["R1"]
    assert agent["outcome"] in ("stuck", "timeout")
    assert agent["collisions"] == 0
    events = list(Recording.open(project / "runs" / "first-1").events())
    reflexes = [e for e in events if isinstance(e, TicketChanged) and e.priority == "HIGH" and e.state == "FAILED"]
    assert len(reflexes) > 20  # it fires again and again, and each time the robot is told to stand
    pattern = r"CANNOT: duration of AvoidCollision must be positive and finite, found -\d\.\d+ s\."
    assert all(re.fullmatch(pattern, e.reason) for e in reflexes)
    first = reflexes[0].t
    driven = [e.values for e in events if isinstance(e, ActuatorCommanded) and e.t > first]
    assert not [values for values in driven if any(values)]


def test_a_speed_that_is_hardly_one_is_no_defect(project, rocs_bt):
    edit(project, SCENARIO, 'cruise = "0.4 m/s"', 'cruise = "1e-9 m/s"')
    told = rocs_bt("run", "first", "--for", "1", "--no-report")  # a warning of numpy would be an error here
    assert told.code == 1
    assert "error" not in told.out
    assert "Warning" not in told.text
