"""A robot's signals and actions, and rule files about them, for the tests of what examines rules."""

from typing import Annotated

from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED, TURN_RATE, MetresPerSecond, PositiveSeconds, Radians
from rocs_bt.expression import Environment
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.reactive import load_rules
from rocs_bt.reactive.analysis import analyse_fit, examine_rules

INF = float("inf")
ENVIRONMENT = Environment.packed(
    [
        Signal("front", 4, (LENGTH,), bounds=(0.0, INF), max_age=0.15),
        Signal("rear", 2, (LENGTH,), bounds=(0.0, INF), max_age=0.15),
        Signal("goal_distance", 1, (LENGTH,), bounds=(0.0, INF), max_age=0.15),
        Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.5), max_age=0.15),
        Signal("turn_rate", 1, (TURN_RATE,), bounds=(-2.0, 2.0), max_age=0.01),
        Signal("tags", 1, bounds=(0.0, 8.0), max_age=0.15),
    ]
)


class Turn(AtomicAction):
    """Turns."""

    angle: Radians = 1.0
    rate: Annotated[float, TURN_RATE] = 1.0
    patience: PositiveSeconds = 1.0
    speeds: Annotated[list[float], SPEED] = (0.0, 0.0)

    def act(self, body):
        return Progress.SUCCEEDED


class Go(AtomicAction):
    """Goes."""

    speed: MetresPerSecond = 0.5

    def act(self, body):
        return Progress.SUCCEEDED


ACTIONS = {"Turn": Turn, "Go": Go}


def file_of(*rules, head=""):
    """A rule file: each rule is its lines, the action's as `action: ...`; the name stands in the first line."""
    text = f'format = "reflex/1"\n{head}'
    for name, *lines in rules:
        own = [line for line in lines if not line.startswith("action: ")]
        does = [line.removeprefix("action: ") for line in lines if line.startswith("action: ")]
        if not any(line.startswith("priority") for line in own):
            own.append("priority = 5")
        if not any(line.startswith("name") for line in does):
            does.insert(0, 'name = "Turn"')
        text += "\n".join([f"[rule.{name}]", *own, f"[rule.{name}.action]", *does, ""])
    return text


def faults_of(tmp_path, text, period=None, modes=None):
    file = tmp_path / "rules.toml"
    file.write_text(text, encoding="utf-8")
    if period is not None:
        return analyse_fit(load_rules(file, ENVIRONMENT, ACTIONS).rules, ENVIRONMENT, period, modes)
    return examine_rules(file, ENVIRONMENT, ACTIONS).faults


def at(fault):
    return f"{fault.line}:{fault.column}"


A = "A"
NEAR, FAR = 'when = "min(front) < 0.4 m"', 'until = "min(front) > 0.5 m"'
