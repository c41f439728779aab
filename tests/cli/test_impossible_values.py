"""Values that no robot can act on: refused with their place before anything runs, harmless where they come later."""

from __future__ import annotations

import json
import re

from rocs_bt.event import ActuatorCommanded, TicketChanged
from rocs_bt.record import Recording

from ..changes import edit

SCENARIO, RULES, ROBOT = "scenarios/first.toml", "rules/keep_clear.toml", "robots/rover/robot.toml"
MISSION = "planners/missions/patrol.py"


def test_a_reflex_that_comes_out_impossible_stands_still_and_is_no_defect(project, rocs_bt):
    """The nearer, the shorter: less than nothing as soon as the rule fires."""
    edit(project / RULES, "min(front) < min(0.40 m, max(goal_distance - 0.07 m, 0.05 m))", "min(front) < 1.5 m")
    edit(project / RULES, "min(front) > 0.50 m", "min(front) > 1.6 m")
    edit(project / RULES, 'duration = "2.0 s"', 'duration = "1 s * (min(front) - 2 m) / 1 m"')
    edit(project / SCENARIO, 'duration = "60 s"', 'duration = "12 s"')
    told = rocs_bt("run", "first", "--no-report")
    assert told.code == 1
    agent = json.loads((project / "runs" / "first-1" / "summary.json").read_text())["agents"]["R1"]
    assert agent["outcome"] in ("stuck", "timeout")
    assert agent["collisions"] == 0
    events = list(Recording.open(project / "runs" / "first-1").events())
    reflexes = [e for e in events if isinstance(e, TicketChanged) and e.priority == "HIGH" and e.state == "FAILED"]
    assert len(reflexes) > 20  # it fires again and again, and each time the robot is told to stand
    pattern = r"CANNOT: duration of AvoidCollision must be positive, found -\d\.\d+ s\."
    assert all(re.fullmatch(pattern, e.reason) for e in reflexes)
    first = reflexes[0].t
    driven = [e.values for e in events if isinstance(e, ActuatorCommanded) and e.t > first]
    assert not [values for values in driven if any(values)]


def test_a_speed_that_is_hardly_one_is_no_defect(project, rocs_bt):
    edit(project / SCENARIO, 'cruise = "0.4 m/s"', 'cruise = "1e-9 m/s"')
    told = rocs_bt("run", "first", "--for", "1", "--no-report")  # a warning of numpy would be an error here
    assert told.code == 1
    assert "error" not in told.out
    assert "Warning" not in told.text
