"""Comparison of a robot's `[locomotion]` with its identified.toml; no driver runs, and nothing is simulated.

A warning is given where a declared value differs from the measured one by more than 10 % in a harmful direction. Lower
limits and longer stopping distances than the measured ones are margins, which need no warning.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..catalog import Catalog, RateSpec, RobotSpec, robot_locomotion
from ..control.locomotion import Locomotion
from ..errors import Fault
from ..geometry import Twist3
from ..simulation import on_hardware
from ..simulation.identified_file import AxisFigures, IdentifiedFile, identified_path, model_hash, read_identified

TOLERANCE = 0.1
"""Relative difference above which a value is reported."""

LAG_TOLERANCE = 0.02
"""Difference of the lag that is never reported [s]: less than half a control period."""

DISTANCE_TOLERANCE = 0.02
"""Difference of a distance that is never reported [m]: about the noise of a position and a range."""

ICR_TOLERANCE = 0.05
"""Difference of the ICR offset above which it is reported [m]."""

_WIDTHS = ("wheel_separation", "effective_wheel_separation", "half_length", "half_width", "base_radius")
"""Parameters of wheels, the sum of which is proportional to the wheel speeds of a turn."""


def identified_faults(robot: RobotSpec, catalog: Catalog) -> Iterator[Fault]:
    """Compare a robot with its identified.toml; yields warnings at lines of robot.toml, and nothing without the file.

    The file of a base is compared only if the robot moves like its base: with the same model and motion actuator.

    Raises:
        InputError: identified.toml has faults.
    """
    if (file := identified_path(robot)) is None:
        return
    measured, locomotion = read_identified(file), robot_locomotion(robot.locomotion)
    if measured.model != model_hash(robot):
        if file.parent != robot.file.parent:
            yield from _not_identified(robot, catalog)
            return
        message = f"{file.name} was measured with another model or actuator; [locomotion] is not compared with it."
        yield _warning(robot, message, f"Run: rocs-bt identify {robot.name}", "model")
        return
    axes = {axis: figures for axis, figures in measured.axes.items() if axis in locomotion.axes}
    yield from _geometry(robot, locomotion, measured)
    for axis, figures in axes.items():
        yield from _speed(robot, locomotion, axis, figures)
    yield from _lag(robot, locomotion, axes)
    for axis, figures in axes.items():
        if axis != "wz":
            yield from _stopping(robot, locomotion, axis, figures)


def _not_identified(robot: RobotSpec, catalog: Catalog) -> Iterator[Fault]:
    """Warn of a simulated robot that changes the model or the motion actuator of its base without measured values."""
    if on_hardware(catalog, robot):  # the drivers differ, and the real robot may still move like the model
        return
    message = (
        f"'{robot.name}' is not identified: its model or motion actuator differs from that of its base "
        f"'{robot.bases[0].parent.name}', so the measured motion does not apply. It may stop late and cut corners."
    )
    yield _warning(robot, message, f"Run: rocs-bt identify {robot.name}. Then follow what check says.", "base")


def _geometry(robot: RobotSpec, locomotion: Locomotion, measured: IdentifiedFile) -> Iterator[Fault]:
    """Compare the size that relates turns to wheel speeds, and the ICR offset."""
    names = [name for name in _WIDTHS if name in robot.locomotion.parameters]
    if not names or not {"vx", "wz"} <= measured.axes.keys():
        return
    declared = sum(robot.locomotion.parameters[name] for name in names)
    if measured.wheels is None:
        found = declared * measured.axes["vx"].max_speed / measured.axes["wz"].max_speed / locomotion.arm
    else:
        found = measured.wheels.effective_wheel_separation
    if abs(declared / found - 1.0) > TOLERANCE:
        size = " + ".join(names)
        message = (
            f"{size} is {declared:.4g} m, but {found:.4g} m was measured: the robot turns {declared / found:.2f} times "
            "as fast as commanded."
        )
        yield _warning(robot, message, f"Write the measured value for {size}.", "locomotion", *names)
    if measured.wheels is None:
        return
    offset = measured.wheels.icr_offset
    if abs(locomotion.icr_offset - offset) > ICR_TOLERANCE:
        message = (
            f"icr_offset is {locomotion.icr_offset:.3g} m, but {offset:.3g} m was measured: the robot drifts sideways "
            "in curves."
        )
        skid = locomotion.kind == "skid"
        hint = f'Write icr_offset = "{offset:.3g} m".' if skid else "Move the model's base to the axle of the wheels."
        yield _warning(robot, message, hint, "locomotion", "icr_offset")


def _speed(robot: RobotSpec, locomotion: Locomotion, axis: str, measured: AxisFigures) -> Iterator[Fault]:
    """Report a speed limit that the robot does not reach; `_geometry` compares the turn rates of wheels."""
    declared, unit = locomotion.axis_limits(axis).max_speed, "rad/s" if axis == "wz" else "m/s"
    if declared <= measured.max_speed * (1.0 + TOLERANCE) or (axis == "wz" and locomotion.wheeled):
        return
    key = "max_wheel_speed" if locomotion.wheeled else f"{axis}.max_speed"
    message = (
        f"{key} allows {declared:.3g} {unit} along {axis}, but the robot reached {measured.max_speed:.3g} {unit}: it "
        "cannot follow its plans."
    )
    yield _warning(robot, message, f"Lower {key}, or correct the model or the actuator.", "locomotion", key)


def _lag(robot: RobotSpec, locomotion: Locomotion, axes: dict[str, AxisFigures]) -> Iterator[Fault]:
    """Compare the lag with that of the axis with the largest difference."""
    declared = locomotion.response.late
    lags = {
        axis: figures.lag
        for axis, figures in axes.items()
        if axis in ("vx", "vy") and abs(figures.lag - declared) * figures.max_speed > DISTANCE_TOLERANCE
    }
    axis = max(lags, key=lambda name: abs(lags[name] - declared), default="")
    if not axis or abs(declared - lags[axis]) <= max(LAG_TOLERANCE, TOLERANCE * lags[axis]):
        return
    message = (
        f"delay + lag is {declared:.3g} s, but {lags[axis]:.3g} s was measured along {axis}: path following cuts "
        "corners or weaves."
    )
    hint = f"Write delay and lag with the sum {lags[axis]:.3g} s."
    yield _warning(robot, message, hint, "locomotion", "lag", "delay")


def _stopping(robot: RobotSpec, locomotion: Locomotion, axis: str, measured: AxisFigures) -> Iterator[Fault]:
    """Report a `stop_distance` that is too short at the maximum speed or half of it.

    Where the braking model does not fit, only the stop distance from the maximum speed is compared.
    """
    period = _reading_period(robot)
    top = min(measured.max_speed, locomotion.axis_limits(axis).max_speed)
    distances = {top: measured.stop_distance + top * period}
    hint = f"Measured: {measured.stop_distance:.3g} m after the command, which comes up to {period:.3g} s late."
    late = False
    if measured.latency is not None and measured.deceleration is not None:
        latency = period + measured.latency
        distances = {v: v * latency + v**2 / (2.0 * measured.deceleration) for v in (top, 0.5 * top)}
        late = locomotion.response.latency < latency * (1.0 - TOLERANCE)
        hint = (
            f"Measured: latency {latency:.3g} s ({period:.3g} s from reading to reading, {measured.latency:.3g} s of "
            f"delay), deceleration {measured.deceleration:.3g} m/s2."
        )
    for speed, needed in distances.items():
        twist = {"vx": Twist3(speed), "vy": Twist3(0.0, speed), "vz": Twist3(0.0, 0.0, speed)}[axis]
        declared = locomotion.stop_distance(twist)
        if declared < needed - max(TOLERANCE * needed, DISTANCE_TOLERANCE):
            keys = ("latency",) if late else (f"{axis}.deceleration", "deceleration")
            message = (
                f"by latency and deceleration, the robot stops from {speed:.3g} m/s along {axis} within "
                f"{declared:.3g} m, but it needs {needed:.3g} m: it brakes too late."
            )
            yield _warning(robot, message, hint, "locomotion", *keys)
            return


def _reading_period(robot: RobotSpec) -> float:
    """Longest time between two readings of the robot's motion [s]."""
    names = {name for monitor in robot.monitors if monitor.cls == "WheelMonitor" for name in monitor.sensors}
    rates = [sensor.rate for sensor in robot.sensors if sensor.name in names and sensor.rate is not None]
    return 1.0 / min(rates, default=RateSpec().control)


def _warning(robot: RobotSpec, message: str, hint: str, table: str, *keys: str) -> Fault:
    line, column = robot.position(table, *keys)
    return Fault(message, robot.file, line, column, hint, warning=True)
