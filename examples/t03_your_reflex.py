# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Write reflexes of your own: one as a rule file, one as a class in Python.

The rule file is part of a project with a scenario that names it beside the shipped rules. A rule names an action and
its parameters with units; its expressions are checked against the robot's signals when the file is loaded. The class,
a ReactiveModel, integrates a value over time, which a rule cannot. Only one reflex at a time is active: the one with
the highest priority.

Output:

    mine, seed 7, 12.3 s simulated
    R2 success; 3.16 m, 0 collisions, 6 reflexes, 5 resumed actions
     0.15 s  respect/Hesitate fired: min(front) = 0.601 m, speed = 0.2 m/s
     1.05 s  avoid_collision/AvoidCollision fired: min(front) = 0.396 m, min(near, to_goal) = 0.4 m, speed = 0.485 m/s
     4.15 s  respect/Hesitate fired: min(front) = 0.445 m, speed = 0.232 m/s
     4.25 s  avoid_collision/AvoidCollision fired: min(front) = 0.392 m, min(near, to_goal) = 0.4 m, speed = 0.148 m/s
     7.75 s  respect/Hesitate fired: min(front) = 0.638 m, speed = 0.412 m/s
    11.15 s  respect/Hesitate fired: min(front) = 0.632 m, speed = 0.449 m/s
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from py_trees.behaviour import Behaviour

import rocs_bt
from rocs_bt.event import ListSink, RuleChanged
from rocs_bt.reactive import Reflex

RULES = """
format = "reflex/1"
doc = "Keep a respectful distance."

[rule.Hesitate]
doc = "Stop for a moment before driving toward an obstacle."
when = "min(front) < 0.70 m and speed > 0.05 m/s"
for = "0.1 s"
cooldown = "2 s"
trigger = "edge"
priority = 40
on_invalid = "clear"

[rule.Hesitate.action]
name = "SetWheelSpeed"
speeds = ["0 m/s", "0 m/s"]
duration = "0.3 s"
"""


class Dizzy(rocs_bt.ReactiveModel):
    """Rest after every two full turns: integrates the turn rate, which a rule cannot."""

    def __init__(self, knowledge: rocs_bt.Knowledge) -> None:
        self.turn_rate = knowledge.signals.slice_of("turn_rate").start
        self.turned = 0.0  # [rad]
        self.last = 0.0  # [s]
        self.until = 0.0  # [s]

    def react(self, x: np.ndarray, t: float) -> Sequence[Reflex]:
        """Integrate the absolute turn rate; after two full turns, request the action Stop for one second."""
        rate, passed, self.last = float(x[self.turn_rate]), t - self.last, t
        if np.isfinite(rate):
            self.turned += abs(rate) * passed
        if self.turned > 4.0 * np.pi:
            self.turned, self.until = 0.0, t + 1.0
        if t >= self.until:
            return []
        reading = f"{self.until - t:.2f} s of rest left"
        return [Reflex("dizzy/Rest", priority=95, action="Stop", level=True, reading=reading)]


def build(mission: rocs_bt.Mission) -> Behaviour:
    """Build a mission with one leaf, GoTo, and add the reactive model Dizzy to the agent."""
    mission.knowledge.reactive_models.append(Dizzy(mission.knowledge))
    return mission.act("GoTo", goal="goal", cruise="0.5 m/s")


with tempfile.TemporaryDirectory() as folder:
    project = Path(folder)
    (project / "rules").mkdir()
    (project / "scenarios").mkdir()
    (project / "rules" / "respect.toml").write_text(RULES)
    exp1 = rocs_bt.Catalog().find("scenario", "exp1").path.read_text()
    exp1 = exp1.replace('rules = ["avoid_collision"]', 'rules = ["avoid_collision", "respect"]')
    (project / "scenarios" / "mine.toml").write_text(exp1)

    sink = ListSink()
    result = rocs_bt.run("mine", rocs_bt.Catalog(project), seed=7, missions={"R2": build}, sinks=[sink])

print(result)
for event in sink.events:
    if isinstance(event, RuleChanged) and event.phase == "fired":
        print(f"{event.t:5.2f} s  {event.rule} {event.phase}: {event.reading}")
