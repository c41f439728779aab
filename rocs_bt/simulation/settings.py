"""What scenarios say, beside each other and as texts: every field of their specs, so that none can be forgotten."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from ..catalog import AgentSpec, FactSpec, MoverSpec
from ..document import Table
from ..drivers import parameters_of_driver
from ..geometry import Pose2
from .mover import MOVERS
from .scripted_objects import SCRIPTED_OBJECTS

OMITTED = ("name", "file", "doc", "bases", "line", "parameters_line", "place")
"""Fields that are no settings: words for people, and where things stand in which file. Names are told by the rows."""

UNITS = {
    **dict.fromkeys(("control", "plan", "rate", "sensors"), "Hz"),
    **dict.fromkeys(("after", "at", "duration", "forget_after", "jitter", "latency", "lost_after", "physics"), "s"),
    **dict.fromkeys(("shortest", "tolerance"), "m"),
}
"""What fields are in whose values are numbers."""

Show = Callable[[Any], str]
"""How a single value is told."""

_UNSET = {"latency": "measured", "success": "the mission's word"}  # what it means where these are None
_NOTHING: tuple[Any, ...] = (None, "", (), {})  # said of a field that is not set


@dataclass(frozen=True)
class Setting:
    """What one scenario says of something, beside what the other says; empty where it says nothing."""

    what: str
    first: str
    second: str

    @property
    def same(self) -> bool:
        """Whether both say the same."""
        return self.first == self.second


def settings(first: Any, second: Any) -> tuple[Setting, ...]:
    """What two specs say, field by field: rounded, but with all digits or as values where that would hide a difference.

    Attributes of places are in SI units and have none behind them.

    Args:
        first: A scenario, agent or mover; None where there is none.
        second: The one that takes its part.
    """
    told = [[{} if spec is None else _rows(spec, show) for spec in (first, second)] for show in (_plain, _exact, repr)]
    found = []
    for what in dict.fromkeys([*told[0][0], *told[0][1]]):
        shown = [Setting(what, *(side.get(what, "") for side in sides)) for sides in told]
        found.append(next((setting for setting in shown if not setting.same), shown[0]))
    return tuple(found)


def _rows(spec: Any, show: Show) -> dict[str, str]:
    rows: dict[str, str] = {}
    robot = isinstance(spec, (AgentSpec, MoverSpec))
    for name in (field.name for field in fields(spec) if field.name not in OMITTED):
        value = _UNSET.get(name) if getattr(spec, name) is None else getattr(spec, name)
        what = "start" if robot and name == "pose" else name.replace("_", " ")
        if value in _NOTHING:
            continue
        if robot and name == "parameters":
            rows |= _parameters(spec, show)
        elif is_dataclass(value):
            rows |= {f"{what}'s {row}": text for row, text in _rows(value, show).items()}
        elif isinstance(value, tuple) and is_dataclass(value[0]):
            rows |= _things(what, value, show)
        else:
            rows[what] = _text(value, show, UNITS.get(name, ""))
    return rows


def _parameters(robot: AgentSpec | MoverSpec, show: Show) -> dict[str, str]:
    """A mission's are as the file has them; a script's in SI units, which the script declares."""
    if isinstance(robot, AgentSpec):
        return {f"mission's {name}": _text(value, show) for name, value in robot.parameters.items()}
    script = MOVERS.get(robot.script) or SCRIPTED_OBJECTS.get(robot.script)
    declared = parameters_of_driver(script.Parameters) if script else {}
    units = {name: str(of.dimension) for name, of in declared.items() if of.dimension and str(of.dimension) != "1"}
    return {f"script's {name}": _text(value, show, units.get(name, "")) for name, value in robot.parameters.items()}


def _things(what: str, things: Sequence[Any], show: Show) -> dict[str, str]:
    """A row for each place, fact and requirement; of robots only who they are, since they have tables of their own."""
    if isinstance(things[0], (AgentSpec, MoverSpec)):
        return {what: _text([robot.name for robot in things], show)}
    rows: dict[str, str] = {}
    for thing in things:
        said = "; ".join(f"{row}: {text}" for row, text in _rows(thing, show).items())
        called = f"{what.removesuffix('s')} {getattr(thing, fields(thing)[0].name)}"
        nth = sum(row == called or row.startswith(f"{called} #") for row in rows) + 1  # a node may have several facts
        rows[called if nth == 1 else f"{called} #{nth}"] = said
    return rows


def _text(value: Any, show: Show, unit: str = "") -> str:
    if isinstance(value, Pose2):
        x, y, yaw = (show(round(number, 3) if show is _plain else number) for number in value)
        return f"{x} m, {y} m" + ("" if math.isnan(value.yaw) else f", {yaw} rad")
    if isinstance(value, Table):  # of a fact
        return _text({key: told for key, told in value.data.items() if key not in FactSpec.KEYS}, show)
    if isinstance(value, Mapping):
        parts = [f"{key} {_text(value[key], show, unit)}" for key in sorted(value)]
    elif isinstance(value, (list, tuple)):
        parts = [_text(each, show, unit) for each in value]
    else:
        return f"{show(value)} {unit}" if unit and not isinstance(value, (str, bool)) else show(value)
    return f"[{', '.join(parts)}]" if show is repr else ", ".join(parts)


def _plain(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else _exact(value)


def _exact(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
