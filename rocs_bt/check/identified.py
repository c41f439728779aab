"""Comparison of a robot's `[locomotion]` with its measured motion; no driver runs, and nothing is simulated.

A value is reported where it differs from the measured one by more than 10 % in a harmful direction. Lower limits and
longer stopping distances than the measured ones are margins.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ..base.errors import Fault
from ..base.geometry import Twist3
from ..catalog import Catalog, RateSpec, RobotSpec
from ..control.locomotion import Locomotion
from ..declare import Location, location_of
from ..running.hardware_devices import on_hardware
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


@dataclass(frozen=True)
class Difference:
    """Harmful difference between `[locomotion]` and the measured motion.

    Attributes:
        message: Difference, and the harm that it does.
        keys: Keys of `[locomotion]` at which it is reported, the first that the file has.
        values: Values by key, such as `lag` or `vx.max_speed`, that end the difference, in SI units; empty if only
            another model does.
        hint: Further advice.
    """

    message: str
    keys: tuple[str, ...]
    values: Mapping[str, float]
    hint: str = ""


def identified_faults(robot: RobotSpec, catalog: Catalog) -> Iterator[Fault]:
    """Compare a robot with its identified.toml; yields warnings at lines of robot.toml, and nothing without the file.

    The file of a base is compared only if the robot moves like its base: with the same model and motion actuator.

    Raises:
        InputError: identified.toml has faults.
    """
    if (file := identified_path(robot)) is None:
        return
    measured = read_identified(file)
    if measured.model != model_hash(robot):
        if file.parent != robot.file.parent:
            yield from _not_identified(robot, catalog)
            return
        message = f"{file.name} was measured with another model or actuator; [locomotion] is not compared with it."
        yield _warning(location_of(robot, "model"), message, f"Run: rocs-bt identify {robot.name}")
        return
    for difference in differences(robot, measured):
        written = " and ".join(f'{key} = "{text}"' for key, text in as_quantities(difference.values).items())
        hint = f"Write {written}, or run: rocs-bt identify {robot.name} --write." if written else ""
        hint = f"{difference.hint} {hint}".strip()
        yield _warning(robot.position(*difference.keys), difference.message, hint)


def differences(robot: RobotSpec, measured: IdentifiedFile) -> Iterator[Difference]:
    """Compare `[locomotion]` of a robot with the measured motion of its model."""
    locomotion = robot.locomotion
    axes = {axis: figures for axis, figures in measured.axes.items() if axis in locomotion.axes}
    yield from _geometry(robot, locomotion, measured)
    for axis, figures in axes.items():
        yield from _speed(locomotion, axis, figures)
        yield from _grip(locomotion, axis, figures)
    yield from _lag(locomotion, axes)
    for axis, figures in axes.items():
        if axis != "wz":
            yield from _stopping(robot, locomotion, axis, figures)


def corrections(robot: RobotSpec, measured: IdentifiedFile) -> dict[str, float]:
    """Values of `[locomotion]` by key, in SI units, that end all differences: of several for a key the safest."""
    found = dict[str, float]()
    for difference in differences(robot, measured):
        for key, value in difference.values.items():
            safest = max if key == "latency" else min
            found[key] = safest(value, found.get(key, value))
    return found


def as_quantities(values: Mapping[str, float]) -> dict[str, str]:
    """Texts with units of values of `[locomotion]`, by key."""
    units = {"delay": "s", "lag": "s", "latency": "s", "deceleration": "m/s2", "max_wheel_acceleration": "m/s2"}
    units |= {"max_speed": "m/s", "max_wheel_speed": "m/s", "wz.max_speed": "rad/s"}
    return {
        key: f"{float(f'{value:.3g}'):g} {units.get(key) or units.get(key.rpartition('.')[2], 'm')}"
        for key, value in values.items()
    }


def _not_identified(robot: RobotSpec, catalog: Catalog) -> Iterator[Fault]:
    """Warn of a simulated robot that changes the model or the motion actuator of its base without measured values."""
    if on_hardware(catalog, robot):  # the drivers differ, and the real robot may still move like the model
        return
    message = (
        f"'{robot.name}' is not identified: its model or motion actuator differs from that of its base "
        f"'{robot.bases[0].parent.name}', so the measured motion does not apply. It may stop late and cut corners."
    )
    yield _warning(location_of(robot, "base"), message, f"Run: rocs-bt identify {robot.name} --write.")


def _geometry(robot: RobotSpec, locomotion: Locomotion, measured: IdentifiedFile) -> Iterator[Difference]:
    """Compare the size that relates turns to wheel speeds, and the ICR offset."""
    sizes = {name: v for name in _WIDTHS if (v := getattr(robot.motion, name, None)) is not None}
    if not sizes or not {"vx", "wz"} <= measured.axes.keys():
        return
    declared = sum(sizes.values())
    if measured.wheels is None:
        found = declared * measured.axes["vx"].max_speed / measured.axes["wz"].max_speed / locomotion.arm
    else:
        found = measured.wheels.effective_wheel_separation
    if abs(declared / found - 1.0) > TOLERANCE:
        message = (
            f"{' + '.join(sizes)} is {declared:.4g} m, but {found:.4g} m was measured: the robot turns "
            f"{declared / found:.2f} times as fast as commanded."
        )
        values = {name: size * found / declared for name, size in sizes.items()}
        yield Difference(message, tuple(sizes), values)
    if measured.wheels is None:
        return
    offset = measured.wheels.icr_offset
    if abs(locomotion.icr_offset - offset) > ICR_TOLERANCE:
        message = (
            f"icr_offset is {locomotion.icr_offset:.3g} m, but {offset:.3g} m was measured: the robot drifts sideways "
            "in curves."
        )
        slips = hasattr(robot.motion, "icr_offset")
        hint = "" if slips else "Move the model's base to the axle of the wheels."
        yield Difference(message, ("icr_offset",), {"icr_offset": offset} if slips else {}, hint)


def _speed(locomotion: Locomotion, axis: str, measured: AxisFigures) -> Iterator[Difference]:
    """Report a speed limit that the robot does not reach; `_geometry` compares the turn rates of wheels."""
    declared, unit = locomotion.axis_limits(axis).max_speed, "rad/s" if axis == "wz" else "m/s"
    if declared <= measured.max_speed * (1.0 + TOLERANCE) or (axis == "wz" and locomotion.wheeled):
        return
    key, limit = f"{axis}.max_speed", declared
    if locomotion.wheeled:
        key, limit = "max_wheel_speed", float(locomotion.max_speed.min())
    message = (
        f"{key} allows {declared:.3g} {unit} along {axis}, but the robot reached {measured.max_speed:.3g} {unit}: it "
        "cannot follow its plans."
    )
    values = {key: limit * measured.max_speed / declared}
    yield Difference(message, (key,), values, "Lower it, or correct the model or the actuator.")


def _grip(locomotion: Locomotion, axis: str, measured: AxisFigures) -> Iterator[Difference]:
    """Report an acceleration of wheels at which the robot cannot brake: the wheels would slip."""
    declared = locomotion.axis_limits(axis).max_acceleration
    if not locomotion.wheeled or axis == "wz" or measured.deceleration is None:
        return
    if declared > measured.deceleration * (1.0 + TOLERANCE):
        message = (
            f"max_wheel_acceleration allows {declared:.3g} m/s2 along {axis}, but the robot brakes at "
            f"{measured.deceleration:.3g} m/s2: it cannot follow its plans."
        )
        limit = float(locomotion.max_acceleration.min()) * measured.deceleration / declared
        yield Difference(message, ("max_wheel_acceleration",), {"max_wheel_acceleration": limit})


def _lag(locomotion: Locomotion, axes: dict[str, AxisFigures]) -> Iterator[Difference]:
    """Compare the lag with that of the axis with the largest difference, and with the best for all axes."""
    declared = locomotion.response.late
    plane = {axis: figures for axis, figures in axes.items() if axis in ("vx", "vy")}
    far = {axis: abs(of.lag - declared) for axis, of in plane.items()}
    far = {axis: error for axis, error in far.items() if error * plane[axis].max_speed > DISTANCE_TOLERANCE}
    if not far:
        return
    axis = max(far, key=far.__getitem__)
    lag, speeds = plane[axis].lag, sum(of.max_speed for of in plane.values())
    best = max(sum(of.lag * of.max_speed for of in plane.values()) / speeds, 0.0)  # the least error of position
    if far[axis] - abs(best - lag) <= max(LAG_TOLERANCE, TOLERANCE * lag):
        return
    message = (
        f"delay + lag is {declared:.3g} s, but {lag:.3g} s was measured along {axis}: path following cuts corners or "
        "weaves."
    )
    delay, latency = locomotion.response.delay, plane["vx"].latency
    if locomotion.wheeled and latency is not None:
        delay = latency  # wheels begin to brake after the dead time; legs end a step first
    delay = min(delay, best)
    yield Difference(message, ("lag", "delay"), {"delay": delay, "lag": best - delay})


def _stopping(robot: RobotSpec, locomotion: Locomotion, axis: str, measured: AxisFigures) -> Iterator[Difference]:
    """Report a `stop_distance` that is too short at the maximum speed or half of it.

    Where the braking model does not fit, only the stop distance from the maximum speed is compared.
    """
    period, response = _reading_period(robot), locomotion.response
    top = min(measured.max_speed, locomotion.axis_limits(axis).max_speed)
    braking = response.deceleration.get(axis, locomotion.axis_limits(axis).max_acceleration)
    if measured.latency is None or measured.deceleration is None:
        latency, deceleration, speeds = period, 0.5 * measured.max_speed**2 / max(measured.stop_distance, 1e-6), [top]
        hint = f"Measured: {measured.stop_distance:.3g} m after the command, which comes up to {period:.3g} s late."
    else:
        latency, deceleration, speeds = period + measured.latency, measured.deceleration, [top, 0.5 * top]
        hint = (
            f"Measured: latency {latency:.3g} s ({period:.3g} s from reading to reading, {measured.latency:.3g} s of "
            f"delay), deceleration {deceleration:.3g} m/s2."
        )
    each = response.deceleration  # the table's own one is that of all three axes
    shared = len(each) == 3 and len(set(each.values())) == 1 if each else locomotion.axes == ("vx", "wz")
    for speed in speeds:
        needed = speed * latency + speed**2 / (2.0 * deceleration)
        twist = {"vx": Twist3(speed), "vy": Twist3(0.0, speed), "vz": Twist3(0.0, 0.0, speed)}[axis]
        declared = locomotion.stop_distance(twist)
        if declared < needed - max(TOLERANCE * needed, DISTANCE_TOLERANCE):
            message = (
                f"by latency and deceleration, the robot stops from {speed:.3g} m/s along {axis} within "
                f"{declared:.3g} m, but it needs {needed:.3g} m: it brakes too late."
            )
            late, values = response.latency < latency * (1.0 - TOLERANCE), dict[str, float]()
            if response.latency < latency:
                values["latency"] = latency
            if braking > deceleration:
                values["deceleration" if shared else f"{axis}.deceleration"] = deceleration
            yield Difference(message, ("latency",) if late else (f"{axis}.deceleration", "deceleration"), values, hint)
            return


def _reading_period(robot: RobotSpec) -> float:
    """Longest time between two readings of the robot's motion [s]."""
    names = {name for monitor in robot.monitors if monitor.cls == "WheelMonitor" for name in monitor.sensors}
    rates = [sensor.rate for sensor in robot.sensors if sensor.name in names and sensor.rate is not None]
    return 1.0 / min(rates, default=RateSpec().control)


def _warning(place: Location, message: str, hint: str) -> Fault:
    return Fault(message, *place, hint, warning=True)
