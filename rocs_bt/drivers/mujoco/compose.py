"""Composing a world: one arena and its robots become one compiled model."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...clock import Clock, SimulatedClock
from ...errors import Fault, InputError, located_at
from ..parameters import driver_class
from .mjcf import examine_model
from .sensor import MujocoSensor
from .sensors import SENSORS
from .world import MujocoWorld


@dataclass(frozen=True)
class SensorMount:
    """A sensor that a robot carries, before the model is compiled.

    Attributes:
        name: What robot.toml calls it.
        driver: Its driver's name, or a class of a user's own.
        parameters: What the driver takes, in SI units.
        file, line: Where it is written, for messages.
        running: Context in which a user's own class is run.
    """

    name: str
    driver: str | type[MujocoSensor]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    file: Path | None = None
    line: int = 0
    running: Callable[[], AbstractContextManager[None]] = nullcontext


@dataclass(frozen=True)
class Placed:
    """A robot to put into the world.

    Attributes:
        name: The prefix of its elements, as in `R2/hull`.
        model: Its MJCF; the root body is named `base` and moves freely.
        sensors: What it carries; a robot without a mind carries nothing.
    """

    name: str
    model: Path
    sensors: Sequence[SensorMount] = ()


def compose_world(
    arena: Path,
    robots: Sequence[Placed],
    *,
    step: float = 0.005,
    clock: Clock | None = None,
    within: Sequence[Path] = (),
) -> MujocoWorld:
    """The compiled world, its robots standing at the origin until they are placed.

    Args:
        arena: The world's MJCF.
        robots: Who is in it.
        step: Physics step [s].
        clock: Time; a simulated one of this step by default, which the world moves on.
        within: Folders that a model may name files of, besides its own.

    Raises:
        InputError: A file is missing or is no MJCF, or a robot lacks what its drivers need.
    """
    model = compile_model(arena, robots, step=step, within=within)
    return MujocoWorld(model, [r.name for r in robots], clock or SimulatedClock(step))


def compile_model(
    arena: Path, robots: Sequence[Placed], *, step: float = 0.005, within: Sequence[Path] = (), text: str | None = None
) -> Any:
    """The compiled MjModel of an arena and its robots; worlds may share it, one after the other.

    The options were chosen by measurement: the discrete integrator is right at every step up to 20 ms, elliptic
    cones and ellipsoid wheels give drives that follow their kinematics to 0.2 %.

    Args:
        arena: The world's MJCF.
        robots: Who is in it.
        step: Physics step [s].
        within: Folders that a model may name files of, besides its own.
        text: The world's MJCF where a program made it; `arena` then only names it in faults.

    Raises:
        InputError: A file is missing or is no MJCF, or a robot lacks what its drivers need.
    """
    import mujoco

    spec = read_model(arena, within, text)
    for robot in robots:
        model = read_model(robot.model, within)
        _check_base(model, robot.model)
        for sensor in robot.sensors:
            with located_at(sensor.file or robot.model, sensor.line), _compiling(robot.model), sensor.running():
                driver_class(SENSORS, sensor.driver, "sensor", "mujoco").prepare(model, sensor.name, sensor.parameters)
        _take_options(spec, model)
        spec.attach(model, prefix=f"{robot.name}/", frame=spec.worldbody.add_frame())
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    # Sensors are computed when somebody reads them, not at each step.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
    with _compiling(arena):
        return spec.compile()


def read_model(file: Path, within: Sequence[Path] = (), text: str | None = None) -> Any:
    """The MjSpec of an MJCF file.

    Args:
        file: The file.
        within: Folders that it may name files of, besides its own.
        text: Its text where a program made it.

    Raises:
        InputError: The file cannot be read, is no MJCF, names a file of another folder, or asks for too much; with the
            line.
    """
    import mujoco

    if text is not None:
        with _compiling(file, "not a valid MJCF model"):
            return mujoco.MjSpec.from_string(text)
    if not file.is_file():
        raise InputError(Fault("there is no such model file.", file))
    examine_model(file, within)
    with _compiling(file, "not a valid MJCF model"):
        return mujoco.MjSpec.from_file(str(file))


@contextmanager
def _compiling(file: Path, what: str = "the model does not compile") -> Iterator[None]:
    """What MuJoCo refuses in here is a fault of this file, at the line that it tells."""
    try:
        yield
    except (ValueError, RuntimeError, MemoryError) as error:
        found = re.search(r"[Ll]ine(?: number)?[ =]+(\d+)(?:, column[ =]+(\d+))?", str(error))
        line, column = (int(found[1]), int(found[2] or 0)) if found else (0, 0)
        raise InputError(Fault(f"{what}: {_one_line(error)}.", file, line, column)) from error


def _check_base(model: Any, file: Path) -> None:
    base = model.body("base")
    if base is None or base.parent != model.worldbody:
        names = ", ".join(b.name for b in model.worldbody.bodies if b.name) or "none"
        raise InputError(
            Fault(f"a robot's root body must be named 'base', found {names}.", file, hint='Write <body name="base">.')
        )
    if not any(int(j.type) == 0 for j in base.joints):
        raise InputError(Fault("the body 'base' cannot move.", file, hint="Add a <freejoint/> to it."))


def _take_options(spec: Any, model: Any) -> None:
    """Give a robot the world's <option>: the world's holds, and MuJoCo warns about every difference."""
    for name in dir(spec.option):
        if name.startswith("_"):
            continue
        value = getattr(spec.option, name)
        if isinstance(value, (int, float)):
            setattr(model.option, name, value)
        else:
            getattr(model.option, name)[:] = value


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()).rstrip(".")
