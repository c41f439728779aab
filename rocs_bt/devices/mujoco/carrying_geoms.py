"""Geoms of a robot that may touch the ground: by default those that carry the robot in the pose of its model."""

from __future__ import annotations

from typing import Any

import numpy as np

from .body import RobotElements, box_points, collides, mesh_points

_CLEARANCE = 0.01  # [m] height above the robot's lowest point up to which a geom counts as carrying the robot


def carrying_geoms(model: Any, data: Any, body: RobotElements) -> frozenset[int]:
    """IDs of the geoms that carry a robot in a state, with all geoms of the same wheels and legs.

    A geom carries the robot if its lowest point is within 1 cm of the robot's lowest point. A part that moves against
    the base, such as a wheel with rollers or a leg, counts as a whole. Of the base, only single geoms count, such as
    skids and casters. The geom `hull` never counts: it touches the ground in the pose of a model that floats or flies.
    """
    lowest = {geom: _lowest(model, data, geom) for geom in body.geoms if collides(model, geom)}
    limit = min(lowest.values(), default=0.0) + _CLEARANCE
    limbs = {geom: _limb(model, body.root, int(model.geom_bodyid[geom])) for geom in lowest}
    hull = f"{body.name}/hull"
    carrying = [geom for geom, z in lowest.items() if z <= limit and model.geom(geom).name != hull]
    moving = {limbs[geom] for geom in carrying} - {body.root}
    return frozenset([*carrying, *(geom for geom, limb in limbs.items() if limb in moving)])


def _limb(model: Any, root: int, body: int) -> int:
    """First body of the wheel or leg that a body belongs to; the root if the body is fixed to the base."""
    limb = int(model.body_weldid[body])
    while limb != root and (parent := int(model.body_weldid[model.body_parentid[limb]])) != root:
        limb = parent
    return limb


def _lowest(model: Any, data: Any, geom: int) -> float:
    """Height of the lowest point of a geom [m]."""
    from .library import mujoco

    down, (a, b, c) = -data.geom_xmat[geom].reshape(3, 3)[2], model.geom_size[geom].tolist()
    kinds, kind = mujoco.mjtGeom, int(model.geom_type[geom])
    if kind == int(kinds.mjGEOM_SPHERE):
        reach = a
    elif kind == int(kinds.mjGEOM_CAPSULE):
        reach = a + b * abs(down[2])
    elif kind == int(kinds.mjGEOM_CYLINDER):
        reach = a * float(np.hypot(down[0], down[1])) + b * abs(down[2])
    elif kind == int(kinds.mjGEOM_ELLIPSOID):
        reach = float(np.linalg.norm(down * (a, b, c)))
    else:
        points = mesh_points(model, geom) if int(model.geom_dataid[geom]) >= 0 else box_points(model, geom)
        reach = float((points @ down).max())
    return float(data.geom_xpos[geom, 2] - reach)
