"""Settings of two scenarios side by side, as texts made from all fields of their specifications."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import ActorSpec, AgentSpec
from rocs_bt.declare import Value, values_of

OMITTED = ("name", "file", "doc", "bases", "format", "perturbations")
"""Fields that are no settings of a file: documentation, names, and what a comparison perturbs."""

UNITS = {
    **dict.fromkeys(("control", "plan", "rate", "sensors"), "Hz"),
    **dict.fromkeys(
        ("after", "at", "duration", "forget_after", "jitter", "latency", "lost_after", "physics", "until"), "s"
    ),
    **dict.fromkeys(("grain", "height", "height_tolerance", "length", "shortest_path", "tolerance", "width", "z"), "m"),
    "force": "N",
    "spread": "rad",
}
"""Units of numeric fields."""

Formatter = Callable[[Any], str]
"""Formats a single value."""

_UNSET = {"latency": "measured", "goal": "the mission's status"}  # meaning of None in these fields
_NOTHING: tuple[Any, ...] = (None, "", (), {})  # values of fields that are not set


@dataclass(frozen=True)
class Setting:
    """Setting in two scenarios.

    Attributes:
        what: Name of the setting.
        first: Value in the first scenario, as text; empty if not set.
        second: Value in the second scenario, as text; empty if not set.
    """

    what: str
    first: str
    second: str

    @property
    def same(self) -> bool:
        """Whether both values are equal."""
        return self.first == self.second


def settings(first: Any, second: Any) -> tuple[Setting, ...]:
    """Settings of two specifications, field by field.

    Values are rounded. If rounding would hide a difference, they are shown with all digits or by `repr`. Attributes of
    places are shown as in the file.

    Args:
        first: A scenario, agent or actor; None if there is none.
        second: Its counterpart; None if there is none.
    """
    texts = [[{} if spec is None else _rows(spec, show) for spec in (first, second)] for show in (_plain, _exact, repr)]
    found = []
    for what in dict.fromkeys([*texts[0][0], *texts[0][1]]):
        shown = [Setting(what, *(side.get(what, "") for side in sides)) for sides in texts]
        found.append(next((setting for setting in shown if not setting.same), shown[0]))
    return tuple(found)


def _rows(spec: Any, show: Formatter) -> dict[str, str]:
    rows: dict[str, str] = {}
    robot = isinstance(spec, (AgentSpec, ActorSpec))
    for name in (name for name in values_of(spec) if name not in OMITTED):
        value = _UNSET.get(name) if getattr(spec, name) is None else getattr(spec, name)
        what = "start" if robot and name == "pose" else name.replace("_", " ")
        if value in _NOTHING:
            continue
        if name == "tables":
            rows |= {f"{table}'s {row}": text for table, of in value.items() for row, text in _rows(of, show).items()}
        elif robot and name == "parameters":
            rows |= _parameters(spec, show)
        elif isinstance(value, Value):
            rows |= {f"{what}'s {row}": text for row, text in _rows(value, show).items()}
        elif isinstance(value, tuple) and isinstance(value[0], Value):
            rows |= _each(what, value, show)
        else:
            rows[what] = _text(value, show, UNITS.get(name, ""))
    return rows


def _parameters(robot: AgentSpec | ActorSpec, show: Formatter) -> dict[str, str]:
    """Parameters of a mission or of a script, as in the file."""
    owner = "mission" if isinstance(robot, AgentSpec) else "script"
    return {f"{owner}'s {name}": _text(value, show) for name, value in robot.parameters.items()}


def _each(what: str, specs: Sequence[Any], show: Formatter) -> dict[str, str]:
    """Settings of a field with several places, facts or requirements, one for each; of robots only their names."""
    if isinstance(specs[0], (AgentSpec, ActorSpec)):
        return {what: _text([robot.name for robot in specs], show)}
    rows: dict[str, str] = {}
    for spec in specs:
        values = "; ".join(f"{row}: {text}" for row, text in _rows(spec, show).items())
        called = f"{what.removesuffix('s')} {next(iter(values_of(spec).values()))}"
        nth = sum(row == called or row.startswith(f"{called} #") for row in rows) + 1  # a node may have several facts
        rows[called if nth == 1 else f"{called} #{nth}"] = values
    return rows


def _text(value: Any, show: Formatter, unit: str = "") -> str:
    if isinstance(value, Pose2):
        x, y, yaw = (show(round(number, 3) if show is _plain else number) for number in value)
        return f"{x} m, {y} m" + ("" if math.isnan(value.yaw) else f", {yaw} rad")
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
