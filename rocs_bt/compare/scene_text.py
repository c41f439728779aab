"""The text of a scene's scenario: ordinary TOML, as a person would write it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping

from ..geometry import Pose2
from .family import AGENT, Driver
from .thing import Point

Table = Mapping[str, object]


def metres(value: float) -> str:
    """A length [m] with its unit, to a tenth of a millimetre."""
    return f"{round(value, 4):g} m"


def degrees(value: float) -> str:
    """An angle [rad] in degrees, with its unit."""
    return f"{round(math.degrees(value), 4):g} deg"


def seconds(value: float) -> str:
    """A time [s] with its unit."""
    return f"{round(value, 4):g} s"


def as_speed(value: float) -> str:
    """A speed [m/s] with its unit."""
    return f"{round(value, 4):g} m/s"


def as_toml(root: Table, tables: Iterable[tuple[str, Table]] = ()) -> str:
    """A TOML document: the root's keys, then one `[[name]]` for each table; None is left out."""
    lines = [f"{key} = {_value(value)}" for key, value in root.items() if value is not None]
    for name, table in tables:
        lines += ["", f"[[{name}]]"]
        lines += [f"{key} = {_value(value)}" for key, value in table.items() if value is not None]
    return "\n".join([*lines, ""])


def goal_scenario(
    driver: Driver,
    name: str,
    doc: str,
    start: Pose2,
    goal: Point,
    *,
    tolerance: float,
    duration: float,
    tables: Iterable[tuple[str, Table]] = (),
    places: Iterable[Table] = (),
    parameters: Table | None = None,
    success: Table | None = None,
    end_on_collision: bool = True,
) -> str:
    """A scenario in which the agent under test must come to one place.

    Args:
        driver: Whose robot, mission and rules it has; a family is one.
        name: Of the scene, and so of its world.
        doc: One sentence for people.
        start: Where the agent stands; the seed moves it by 5 cm and 5 deg.
        goal: Where it must come to [m].
        tolerance: How near [m].
        duration: How long it has [s].
        tables: More tables, such as movers, each with its name.
        places: More places.
        parameters: Of the mission; the goal's name by default.
        success: When the agent succeeds; by default at the goal.
        end_on_collision: Whether a collision ends the episode.
    """
    root = {
        "format": "scenario/1",
        "doc": doc,
        "world": name,
        "duration": seconds(duration),
        "end_on_collision": end_on_collision,
    }
    target = {
        "name": "goal",
        "kind": "goal",
        "x": metres(goal[0]),
        "y": metres(goal[1]),
        "tolerance": metres(tolerance),
    }
    agent = {
        "name": AGENT,
        "robot": driver.robot,
        "mission": driver.mission,
        "rules": [driver.rules] if driver.rules else [],
        "x": metres(start.x),
        "y": metres(start.y),
        "yaw": degrees(start.yaw),
        "jitter": {"x": "0.05 m", "y": "0.05 m", "yaw": "5 deg"},
        "success": success or {"goal": "goal"},
        "parameters": {"goal": "goal"} if parameters is None else parameters,
    }
    own = [("place", target), *(("place", place) for place in places), ("agent", agent)]
    return as_toml(root, [*own, *tables])


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        inner = ", ".join(f"{key} = {_value(v)}" for key, v in value.items() if v is not None)
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value)  # of texts, numbers and flags TOML's form is JSON's
