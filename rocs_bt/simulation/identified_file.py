"""`identified.toml` (identified/1): measured parameters of a robot's motion, beside its robot.toml."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..base.files import is_file
from ..base.toml_table import Table, read_toml
from ..base.toml_text import as_toml
from ..base.units import ANGLE, LENGTH, TIME, Dimension
from ..catalog import IDENTIFIED, RobotSpec, content_hash, is_reference, make_entry
from ..control.locomotion import AXES

FORMAT = "identified/1"


@dataclass(frozen=True)
class AxisFigures:
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

    max_speed: float
    lag: float
    latency: float | None
    deceleration: float | None
    stop_distance: float


@dataclass(frozen=True)
class WheelFigures:
    """Measured parameters of a drive that turns by the speed difference of two sides.

    Attributes:
        effective_wheel_separation: Effective wheel separation, from true wheel linear speeds [m].
        icr_offset: Distance ahead of the base at which the robot does not skid sideways in a forward curve [m]. The
            distance is smaller at lower speed, smaller still when turning in place, and nearly 0 in reverse.
    """

    effective_wheel_separation: float
    icr_offset: float


@dataclass(frozen=True)
class IdentifiedFile:
    """Content of an identified.toml.

    Attributes:
        file: The file.
        model: `model_hash` of the robot that was measured.
        axes: Figures by axis, such as `vx`.
        wheels: Figures of the wheels; None for other locomotions.
    """

    file: Path
    model: str
    axes: Mapping[str, AxisFigures]
    wheels: WheelFigures | None


def identified_path(robot: RobotSpec) -> Path | None:
    """The identified.toml of a robot: its own, else that of its nearest base; None if there is none."""
    folders = [file.parent for file in (robot.file, *robot.bases)]
    return next((path for folder in folders if is_file(path := folder / IDENTIFIED)), None)


def read_identified(file: Path, text: str | None = None) -> IdentifiedFile:
    """Read an identified.toml.

    Raises:
        InputError: The file has faults; contains all of them, each with its line.
    """
    root = read_toml(file, text)
    root.choice("format", (FORMAT,))
    model = root.text("model")
    axes = {axis: _read_axis(root.table(axis), _unit(axis)) for axis in AXES if axis in root}
    wheels = None
    if "wheels" in root:
        table = root.table("wheels")
        separation = table.quantity("effective_wheel_separation", LENGTH, low=0.0)
        wheels = WheelFigures(separation, table.quantity("icr_offset", LENGTH, low=-math.inf))
    root.done()
    return IdentifiedFile(file, model, axes, wheels)


def _read_axis(table: Table, unit: Dimension) -> AxisFigures:
    fits = "latency" in table or "deceleration" in table
    return AxisFigures(
        max_speed=table.quantity("max_speed", unit / TIME, low=0.0),
        lag=table.quantity("lag", TIME),
        latency=table.quantity("latency", TIME, low=0.0) if fits else None,
        deceleration=table.quantity("deceleration", unit / TIME / TIME, low=1e-6) if fits else None,
        stop_distance=table.quantity("stop_distance", unit, low=0.0),
    )


def identified_text(robot: RobotSpec, axes: Mapping[str, AxisFigures], wheels: WheelFigures | None) -> str:
    """Text of the identified.toml of a robot."""
    text = "# Measured by `rocs-bt identify`. `rocs-bt check` compares robot.toml with it.\n"
    text += as_toml({"format": FORMAT, "model": model_hash(robot)})
    for axis, of in axes.items():
        unit = str(_unit(axis))
        figures = {"max_speed": f"{of.max_speed:.4g} {unit}/s", "lag": f"{round(of.lag, 4):g} s"}
        if of.latency is not None:
            figures |= {"latency": f"{round(of.latency, 4):g} s", "deceleration": f"{of.deceleration:.4g} {unit}/s2"}
        figures["stop_distance"] = f"{of.stop_distance:.4g} {unit}"
        text += f"\n[{axis}]\n{as_toml(figures)}"
    if wheels is not None:
        separation, offset = wheels.effective_wheel_separation, round(wheels.icr_offset, 4)
        figures = {"effective_wheel_separation": f"{separation:.4g} m", "icr_offset": f"{offset:g} m"}
        text += f"\n[wheels]\n{as_toml(figures)}"
    return text


def model_hash(robot: RobotSpec) -> str:
    """SHA-256 over all that the measured motion depends on: the model's files, and driver of the motion actuator."""
    motion = next(a for a in robot.actuators if a.name == robot.locomotion.actuator)
    entries = [] if robot.model is None else [make_entry(robot.model, "world", "file")]
    if is_reference(motion.driver):
        entries.append(make_entry(robot.beside(motion.driver.partition(":")[0]), "node", "file"))
    change = motion.limits.max_change
    # Those of each axis come from [locomotion], which is compared.
    driver = [motion.driver, motion.parameters, None if isinstance(change, tuple) else change]
    text = json.dumps([content_hash(entries), driver], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def _unit(axis: str) -> Dimension:
    """Dimension of a distance along an axis."""
    return ANGLE if axis == "wz" else LENGTH
