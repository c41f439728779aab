"""Composition of a world: compiles an arena and its robots to one MuJoCo model."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...base.clock import Clock, SimulatedClock
from ...base.errors import Fault, InputError, UnknownName, located_at, unknown
from ...base.files import is_file
from ..body_variant import AS_MODELLED, BodyVariant
from ..simulated.device import SimulatedSensor
from .elements import add_elements
from .mjcf import examine_model
from .terrain import GroundPiece, add_ground
from .world import MujocoWorld

_LENGTHS = ("pos", "ipos", "size", "fromto")  # of the elements of a model
_DENSITY = 1000.0  # [kg/m3] density of free objects in the compiler, before their masses are set


@dataclass(frozen=True)
class SensorMount:
    """Declaration of a robot's sensor, which may add elements to the model before it is compiled.

    Attributes:
        name: Name of the sensor in robot.toml.
        sensor: The sensor with its keys.
        file, line: Location of the sensor's table in robot.toml, for messages.
        running: Function that returns a context manager around code of a user's class, which converts its exceptions.
    """

    name: str
    sensor: SimulatedSensor
    file: Path | None = None
    line: int = 0
    running: Callable[[], AbstractContextManager[None]] = nullcontext


@dataclass(frozen=True)
class RobotInstance:
    """Robot in a world.

    Attributes:
        name: Name of the robot, which is the prefix of its elements, as in `R2/hull`.
        model: MJCF file of the robot; its root body must be named `base` and have a free joint.
        sensors: Sensors of the robot; none for a robot without an agent.
        variant: Differences of the body from its model.
    """

    name: str
    model: Path
    sensors: Sequence[SensorMount] = ()
    variant: BodyVariant = AS_MODELLED


@dataclass(frozen=True)
class FreeObject:
    """Mocap body of an arena that becomes a free body.

    Attributes:
        name: Name of the body.
        mass: Mass [kg], shared by the colliding geoms of the body and its children in proportion to their volumes.
        file, line: Location of the object's table in a scenario, for messages.
    """

    name: str
    mass: float
    file: Path | None = None
    line: int = 0


def compose_world(
    arena: Path,
    robots: Sequence[RobotInstance],
    *,
    step: float = 0.005,
    clock: Clock | None = None,
    within: Sequence[Path] = (),
) -> MujocoWorld:
    """Compile a world. Its robots are at the origin until they are placed (`MujocoWorld.place`).

    Args:
        arena: MJCF file of the arena.
        robots: Robots of the world.
        step: Physics step [s].
        clock: Clock of the world; by default a simulated clock, which the world advances.
        within: Folders with files that a model may reference, in addition to those in the model's own folder.

    Raises:
        InputError: A file is missing or is not valid MJCF, or a model lacks an element that a driver needs.
    """
    model = compile_model(arena, robots, step=step, within=within)
    return MujocoWorld(model, [r.name for r in robots], clock or SimulatedClock(step))


def compile_model(
    arena: Path,
    robots: Sequence[RobotInstance],
    *,
    step: float = 0.005,
    within: Sequence[Path] = (),
    text: str | None = None,
    ground: Sequence[GroundPiece] = (),
    free: Sequence[FreeObject] = (),
) -> Any:
    """Compile the MjModel of an arena and its robots. Several worlds can use it, one after the other.

    The solver options were chosen by measurement: the discrete integrator is accurate with all steps up to 20 ms, and
    with elliptic cones and ellipsoid wheels the drives follow their kinematics with an error of 0.2 %. All robots have
    the same options. Only `jacobian="sparse"` is taken from a robot's model: it is faster for many joints.

    Args:
        arena: MJCF file of the arena.
        robots: Robots of the world.
        step: Physics step [s].
        within: Folders with files that a model may reference, in addition to those in the model's own folder.
        text: MJCF text of a generated arena; `arena` is then only its name in faults.
        ground: Ground that is not level, added to the floor.
        free: Mocap bodies of the arena that become free bodies.

    Raises:
        InputError: A file is missing or is not valid MJCF, a model lacks an element that a driver needs, or the mass of
            a free object cannot be set.
    """
    from .library import mujoco

    sparse = int(mujoco.mjtJacobian.mjJAC_SPARSE)
    spec = read_model(arena, within, text)
    with _compiling(arena, "the scenario's ground cannot be added to the world"):
        add_ground(spec, ground)
    for each in free:
        with located_at(each.file, each.line):
            _set_free(spec, each.name)
    for robot in robots:
        model = read_model(robot.model, within)
        jacobian = sparse if sparse in (model.option.jacobian, spec.option.jacobian) else spec.option.jacobian
        _check_base(model, robot.model)
        for sensor in robot.sensors:
            with located_at(sensor.file or robot.model, sensor.line), _compiling(robot.model), sensor.running():
                add_elements(model, sensor.name, sensor.sensor)
        _vary(model, robot.variant)
        _take_options(spec, model)
        spec.option.jacobian = model.option.jacobian = jacobian
        spec.attach(model, prefix=f"{robot.name}/", frame=spec.worldbody.add_frame())
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    # Sensors are computed when they are read, not at each step.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
    with _compiling(arena):
        compiled = spec.compile()
    _set_masses(compiled, free)
    return compiled


def read_model(file: Path, within: Sequence[Path] = (), text: str | None = None) -> Any:
    """Read the MjSpec of an MJCF file.

    The model may reference files in its own folder and in those of `within`.

    Raises:
        InputError: The file cannot be read, is not valid MJCF, references a file in another folder, or exceeds a limit;
            with the line.
    """
    from .library import mujoco

    if text is not None:
        with _compiling(file, "not a valid MJCF model"):
            return mujoco.MjSpec.from_string(text)
    if not is_file(file):
        raise InputError(Fault("there is no such model file.", file))
    examine_model(file, within)
    with _compiling(file, "not a valid MJCF model"):
        return mujoco.MjSpec.from_file(str(file))


@contextmanager
def _compiling(file: Path, what: str = "the model does not compile") -> Iterator[None]:
    """Context that converts errors of MuJoCo to faults of a file, with the line that MuJoCo reports."""
    try:
        yield
    except (ValueError, RuntimeError, MemoryError) as error:
        found = re.search(r"[Ll]ine(?: number)?[ =]+(\d+)(?:, column[ =]+(\d+))?", str(error))
        line, column = (int(found[1]), int(found[2] or 0)) if found else (0, 0)
        raise InputError(Fault(f"{what}: {_one_line(error)}.", file, line, column)) from error


def _set_free(spec: Any, name: str) -> None:
    """Make a mocap body of an arena a free body; only its colliding geoms, all of one density, have a mass."""
    known = [body.name for body in spec.worldbody.bodies if body.mocap and body.name]
    if name not in known:
        raise UnknownName(unknown("mocap body", name, known, "The world"))
    body = spec.body(name)
    if any(each.explicitinertial for each in (body, *body.find_all("body"))):
        raise InputError(
            Fault(
                f"the world's body '{name}' has an <inertial>, and a free object has the mass of its script.",
                hint="Remove the <inertial>.",
            )
        )
    geoms = body.find_all("geom")
    if not any(geom.contype or geom.conaffinity for geom in geoms):
        raise InputError(
            Fault(
                f"the world's body '{name}' has no geom that collides, so a free object would fall through the floor.",
                hint='Add a geom without contype="0" conaffinity="0" to it.',
            )
        )
    body.mocap = False
    body.add_freejoint()
    for geom in geoms:
        geom.mass = math.nan if geom.contype or geom.conaffinity else 0.0  # NaN: density times volume
        geom.density = _DENSITY


def _set_masses(model: Any, free: Sequence[FreeObject]) -> None:
    """Scale masses and inertias of free objects in a compiled model."""
    from .library import mujoco

    for each in free:
        root = model.body(each.name).id
        bodies = model.body_rootid == root
        factor = each.mass / float(model.body_mass[bodies].sum())
        model.body_mass[bodies] *= factor
        model.body_inertia[bodies] *= factor
    if free:
        mujoco.mj_setConst(model, mujoco.MjData(model))  # quantities that depend on masses


def _vary(model: Any, variant: BodyVariant) -> None:
    """Change lengths and friction of a robot's model, with the elements of its sensors."""
    if variant.size != 1.0:
        for element in (*model.bodies, *model.geoms, *model.sites, *model.joints, *model.cameras):
            for lengths in _LENGTHS:
                if hasattr(element, lengths):
                    getattr(element, lengths)[:] *= variant.size
        for mesh in model.meshes:
            mesh.scale[:] *= variant.size
    if variant.friction is not None:
        for geom in model.geoms:
            if (geom.contype or geom.conaffinity) and geom.condim > 1:  # others, such as casters, have no friction
                geom.friction[0] = variant.friction
                geom.priority = max(geom.priority, 1)  # over the friction of the floor


def _check_base(model: Any, file: Path) -> None:
    base = model.body("base")
    if base is None or base.parent != model.worldbody:
        names = ", ".join(b.name for b in model.worldbody.bodies if b.name) or "none"
        raise InputError(
            Fault(f"a robot's root body must be named 'base', found {names}.", file, hint='Write <body name="base">.')
        )
    if not any(int(j.type) == 0 for j in base.joints):
        raise InputError(Fault("the body 'base' has no free joint.", file, hint="Add a <freejoint/> to it."))


def _take_options(spec: Any, model: Any) -> None:
    """Copy the world's <option> to a robot's model, because MuJoCo warns about every difference."""
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
