"""Elements that sensors need in the model of a robot: sites, and rangefinders for conical beams."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ...base.errors import Fault, InputError, unknown
from ..simulated.device import SimulatedSensor
from .body import z_axis
from .device import MujocoSensor


def add_elements(model: Any, name: str, sensor: SimulatedSensor) -> None:
    """Add the elements of a sensor to the MjSpec of its robot.

    Raises:
        InputError: The model lacks a site that the sensor needs, or nothing would call its `prepare`.
    """
    # Sites that other sensors have added contain a slash in their names; the author's sites do not.
    known = [s.name for s in model.sites if s.name and "/" not in s.name]
    if missing := [site for site in sensor.mounted_at() if site not in known]:
        raise InputError(*(unknown(f"site for sensor '{name}'", site, known, "The model") for site in missing))
    if angles := sensor.beam_angles():
        _add_rangefinders(model, name, sensor.mounted_at(), angles)
    cls = type(sensor)
    if isinstance(sensor, MujocoSensor):
        sensor.prepare(model, name)
    elif callable(getattr(cls, "prepare", None)):
        message = f"'{cls.__name__}' has a method 'prepare' and does not extend MujocoSensor, so nothing calls it."
        hint = f"Write class {cls.__name__}(MujocoSensor, {', '.join(base.__name__ for base in cls.__bases__)})."
        raise InputError(Fault(message, hint=hint))


def _add_rangefinders(model: Any, name: str, sites: Sequence[str], angles: Sequence[tuple[float, float]]) -> None:
    """Add a rangefinder for each ray of each beam: MuJoCo computes them together."""
    from .library import mujoco

    compiled = model.copy().compile()  # resolves every form of orientation in the file
    for site in sites:
        found = compiled.site(site)
        body = model.body(compiled.body(int(compiled.site_bodyid[found.id])).name)
        axis = z_axis(found.quat)
        for ray, (left, up) in enumerate(angles):
            quat = np.zeros(4)
            mujoco.mju_quatZ2Vec(quat, _ray(axis, left, up))
            label = f"{name}/{site}/{ray}"
            body.add_site(name=label, pos=found.pos, quat=quat, size=[0.001] * 3, group=5)
            model.add_sensor(
                name=label,
                type=mujoco.mjtSensor.mjSENS_RANGEFINDER,
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=label,
                intprm=[1, 0, 0],  # distance only
            )


def _ray(axis: Sequence[float], left: float, up: float) -> npt.NDArray[np.float64]:
    """Direction of a ray at angles to the left and up from the axis of its beam, shape (3,)."""
    c, s = math.cos(left), math.sin(left)
    x, y, z = axis
    if math.hypot(x, y) > 1e-6:
        turned = np.array([c * x - s * y, s * x + c * y, z])
        across = np.array([-turned[1], turned[0], 0.0]) / math.hypot(x, y)
    else:  # a vertical beam: its rays spread along the y and x axes of the body
        turned, across = np.array([0.0, s, c * z]), np.array([0.0, c, -s * z])
    return math.cos(up) * turned + math.sin(up) * np.cross(turned, across)
