"""MJCF files: that they compile, and that a robot's devices find their sites and motors in them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ..catalog import ActuatorSpec, Catalog, Entry, RobotSpec, SensorSpec, is_reference
from ..errors import Fault, InputError


def check_world(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """That a world compiles."""
    from ..drivers.mujoco import compose_world

    compose_world(entry.path, [])
    return ()


def check_model(robot: RobotSpec) -> Iterable[Fault]:
    """That a robot's model compiles and has what its devices name; a user's own drivers are left out."""
    from ..drivers.mujoco import Placed, SensorMount, compose_world, make_actuator, make_sensor

    if robot.model is None:
        return
    sensors = [
        SensorMount(s.name, s.driver, s.parameters, robot.file, s.line)
        for s in robot.sensors
        if not is_reference(s.driver)
    ]
    try:
        # The model stands in itself, as any world will do to compile it.
        world = compose_world(robot.model, [Placed("R1", robot.model, sensors)])
    except InputError as error:
        yield from error.at(robot.model).faults
        return
    devices: list[SensorSpec | ActuatorSpec] = [*robot.sensors, *robot.actuators]
    for device in devices:
        if is_reference(device.driver):
            continue
        make: Callable[..., object] = make_sensor if isinstance(device, SensorSpec) else make_actuator
        try:
            make(world, "R1", device.name, device.driver, device.parameters)
        except InputError as error:
            yield from error.at(robot.file, device.line).faults
