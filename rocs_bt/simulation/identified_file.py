"""`identified.toml` (identified/1): measured parameters of a robot's motion, beside its robot.toml."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from ..base.files import is_file
from ..base.toml_table import Table, read_toml
from ..base.toml_text import as_toml
from ..base.units import (
    ACCELERATION,
    ANGLE,
    ANGULAR_ACCELERATION,
    LENGTH,
    SPEED,
    TIME,
    TURN_RATE,
    Bounds,
)
from ..catalog import IDENTIFIED, RobotSpec, content_hash, is_reference, make_entry
from ..control.locomotion import AXES
from ..declare import InFile, Scope, SetByPrograms, Value, data_of, fields_of, read_root, replaced

V = TypeVar("V", bound=Value)

_LEAST = Bounds(0.0)
_BRAKING = Bounds(1e-6)


class AxisFigures(Value):
    """Measured motion along one axis of a body twist.

    Attributes:
        max_speed: Steady speed at the limit of the commands [m/s, rad/s].
        lag: Total delay and lag behind a ramp command at the maximum acceleration [s].
        latency: Delay of the braking model: distance = v * latency + v^2 / (2 deceleration) [s]; None if the model does
            not fit the measured distances.
        deceleration: Deceleration of the braking model [m/s2, rad/s2]; None if the model does not fit.
        stop_distance: Distance to a stop from `max_speed`, by the braking model [m, rad]; if the model does not fit,
            the longest measured distance, scaled to `max_speed`.
    """

    max_speed: Annotated[float, SPEED, _LEAST]
    lag: Annotated[float, TIME]
    latency: Annotated[float, TIME, _LEAST] | None = None
    deceleration: Annotated[float, ACCELERATION, _BRAKING] | None = None
    stop_distance: Annotated[float, LENGTH, _LEAST]

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Note the fault of a braking model with one of its two numbers."""
        if ("latency" in table) != ("deceleration" in table):
            lack = "deceleration" if "latency" in table else "latency"
            table.fault(None, f"{table.label} has no '{lack}'.", f"Add a line '{lack} = ...'.")


class TurnFigures(AxisFigures):
    """Measured motion about the vertical; attributes as those of other axes, with angles."""

    max_speed: Annotated[float, TURN_RATE, _LEAST]
    deceleration: Annotated[float, ANGULAR_ACCELERATION, _BRAKING] | None = None
    stop_distance: Annotated[float, ANGLE, _LEAST]


class WheelFigures(Value):
    """Measured parameters of a drive that turns by the speed difference of two sides.

    Attributes:
        effective_wheel_separation: Effective wheel separation, from true wheel linear speeds [m].
        icr_offset: Distance ahead of the base at which the robot does not skid sideways in a forward curve [m]. The
            distance is smaller at lower speed, smaller still when turning in place, and nearly 0 in reverse.
    """

    effective_wheel_separation: Annotated[float, LENGTH, _LEAST]
    icr_offset: Annotated[float, LENGTH]


class IdentifiedFile(Value):
    """Content of an identified.toml.

    Attributes:
        file: The file.
        format: Format of the file.
        model: `model_hash` of the robot that was measured.
        vx, vy, vz, wz: Figures of each axis; None for one that was not measured.
        wheels: Figures of the wheels; None for other locomotions.
    """

    file: Annotated[Path, SetByPrograms()] = Path()
    format: Annotated[Literal["identified/1"], InFile()] = "identified/1"
    model: str
    vx: AxisFigures | None = None
    vy: AxisFigures | None = None
    vz: AxisFigures | None = None
    wz: TurnFigures | None = None
    wheels: WheelFigures | None = None

    @property
    def axes(self) -> dict[str, AxisFigures]:
        """Figures by axis, such as `vx`."""
        return {axis: found for axis in AXES if (found := getattr(self, axis)) is not None}


def identified_path(robot: RobotSpec) -> Path | None:
    """The identified.toml of a robot: its own, else that of its nearest base; None if there is none."""
    folders = [file.parent for file in (robot.file, *robot.bases)]
    return next((path for folder in folders if is_file(path := folder / IDENTIFIED)), None)


def read_identified(file: Path, text: str | None = None) -> IdentifiedFile:
    """Read an identified.toml.

    Raises:
        InputError: The file has faults; contains all of them, each with its line.
    """
    return replaced(read_root(IdentifiedFile, read_toml(file, text)), file=file)


def identified_text(robot: RobotSpec, axes: Mapping[str, AxisFigures], wheels: WheelFigures | None) -> str:
    """Text of the identified.toml of a robot."""
    figures: dict[str, Any] = {
        axis: _rounded(TurnFigures if axis == "wz" else AxisFigures, of) for axis, of in axes.items()
    }
    measured = None if wheels is None else _rounded(WheelFigures, wheels)
    file = IdentifiedFile(model=model_hash(robot), wheels=measured, **figures)
    text = "# Measured by `rocs-bt identify`. `rocs-bt check` compares robot.toml with it.\n"
    return text + as_toml(data_of(file), levels=1)


def _rounded(cls: type[V], of: Any) -> V:
    """The values of a class with four digits; those that may be near 0 with four decimals."""
    values = {each.name: getattr(of, each.name) for each in fields_of(cls)}
    near_0 = ("lag", "latency", "icr_offset")
    return cls(**{n: v and (round(v, 4) if n in near_0 else float(f"{v:.4g}")) for n, v in values.items()})


def model_hash(robot: RobotSpec) -> str:
    """SHA-256 over all that the measured motion depends on: the model's files, and driver of the motion actuator."""
    motion = robot.mover
    entries = [] if robot.model is None else [make_entry(robot.model, "world", "file")]
    if is_reference(motion.driver):
        entries.append(make_entry(robot.beside(motion.driver.partition(":")[0]), "node", "file"))
    change = motion.limits.max_change
    # Those of each axis come from [locomotion], which is compared.
    driver = [motion.driver, motion.arguments, None if isinstance(change, tuple) else change]
    text = json.dumps([content_hash(entries), driver], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()
