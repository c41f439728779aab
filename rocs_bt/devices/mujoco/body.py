"""Elements of a compiled MuJoCo model: robots, mocap bodies, labels and outlines of geoms."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ...base.geometry import Pose2, yaw_of
from ...record.file.header import Outline, Point

FLOOR = "floor"
GROUND = f"{FLOOR}/"
"""Prefix of the names of geoms that a scenario adds to the floor."""

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


@dataclass(frozen=True)
class RobotElements:
    """Indices of a robot's elements in a compiled model, and sizes of the robot.

    Attributes:
        name: Name of the robot.
        root: ID of the base body.
        q: Index of the free joint in qpos: x, y, z, quaternion.
        v: Index of the free joint in qvel: velocity (world frame), turn rates (body frame).
        geoms: IDs of all geoms of the robot.
        hull: IDs of the geoms of the hull: the geom named `hull`, or else all colliding geoms of the base.
        reach: Maximum distance of a point of the hull from the origin of the base [m].
        height: Height of the base's origin over the floor in the model [m].
    """

    name: str
    root: int
    q: int
    v: int
    geoms: tuple[int, ...]
    hull: tuple[int, ...]
    reach: float
    height: float


@dataclass(frozen=True)
class MocapBody:
    """Named mocap body: an object that a script can move."""

    name: str
    slot: int  # index among MuJoCo's mocap bodies
    geoms: tuple[int, ...]


@dataclass(frozen=True)
class FreeBody:
    """Named body with a free joint that is no robot: an object that robots can push."""

    name: str
    q: int  # index of the free joint in qpos: x, y, z, quaternion
    v: int  # index of the free joint in qvel
    geoms: tuple[int, ...]
    tree: tuple[int, ...]  # geoms of the body and of its children


def find_objects(model: Any, robots: Mapping[str, RobotElements]) -> dict[str, MocapBody | FreeBody]:
    """Named mocap bodies and free bodies of a model that are no robots, by name."""
    found: dict[str, MocapBody | FreeBody] = {}
    roots = {body.root for body in robots.values()}
    for body in range(model.nbody):
        slot, name, joint = int(model.body_mocapid[body]), model.body(body).name, int(model.body_jntadr[body])
        first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
        geoms = tuple(range(first, first + count))
        if name and slot >= 0:
            found[name] = MocapBody(name, slot, geoms)
        elif name and body not in roots and joint >= 0 and int(model.jnt_type[joint]) == 0:  # 0: a free joint
            tree = tuple(g for g in range(model.ngeom) if int(model.body_rootid[model.geom_bodyid[g]]) == body)
            found[name] = FreeBody(name, int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint]), geoms, tree)
    return found


def find_bodies(model: Any, robots: Sequence[str]) -> dict[str, RobotElements]:
    """Indices of the robots' elements in a model, by name of the robot."""
    return {name: _find(model, name) for name in robots}


def geom_labels(model: Any, robots: Mapping[str, RobotElements]) -> list[str]:
    """Label of each geom, for messages: the name of its robot, `floor`, or the name of the geom or its body."""
    owners = {body.root: name for name, body in robots.items()}
    names = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        name = model.geom(geom).name or model.body(body).name
        if int(model.body_rootid[body]) in owners:
            names.append(owners[int(model.body_rootid[body])])
        elif body == 0 and (int(model.geom_type[geom]) == 0 or name.startswith(FLOOR)):  # 0: a plane
            names.append(FLOOR)
        else:
            names.append(name if name != "world" else f"geom {geom}")
    return names


def collides(model: Any, geom: int) -> bool:
    """Whether a geom can collide with other geoms."""
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


def outlines(model: Any, robots: Mapping[str, RobotElements]) -> tuple[Outline, ...]:
    """Outlines, seen from above, of all static geoms that can collide, without the floor."""
    names, found = geom_labels(model, robots), []
    for geom in range(model.ngeom):
        if int(model.geom_bodyid[geom]) != 0 or names[geom] == FLOOR or not collides(model, geom):
            continue
        x, y, z = model.geom_pos[geom].tolist()
        half = model.geom_aabb[geom][3:].tolist()
        if int(model.geom_type[geom]) == 5:  # a cylinder
            found.append(Outline.circle(names[geom], (x, y), half[0], z + half[2]))
        else:
            pose = Pose2(x, y, yaw_of(*model.geom_quat[geom].tolist()))
            found.append(Outline.box(names[geom], pose, (2.0 * half[0], 2.0 * half[1]), z + half[2]))
    return tuple(found)


def bounds(model: Any) -> tuple[float, float, float, float]:
    """Minimum x, minimum y, maximum x, maximum y of the static geoms [m]; infinite for a plane without a size.

    Ground that a scenario adds does not count.
    """
    from .library import mujoco

    corners = []
    for geom in range(model.ngeom):
        if int(model.geom_bodyid[geom]) != 0 or not collides(model, geom) or model.geom(geom).name.startswith(GROUND):
            continue
        if int(model.geom_type[geom]) == 0:  # a plane; size 0 means infinite
            x, y = (half or np.inf for half in model.geom_size[geom][:2].tolist())
            corners.append(np.array([(-x, -y, 0.0), (x, y, 0.0)]) + model.geom_pos[geom])
        else:
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
            corners.append(box_points(model, geom) @ turn.reshape(3, 3).T + model.geom_pos[geom])
    if not corners:
        return -np.inf, -np.inf, np.inf, np.inf
    points = np.concatenate(corners)[:, :2]
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    return float(left), float(low), float(right), float(high)


def hull_outline(model: Any, geoms: Sequence[int]) -> tuple[Point, ...]:
    """Convex outline of geoms of one body, seen from above: corners, body frame [m], anticlockwise."""
    from .library import mujoco

    corners: list[tuple[float, float]] = []
    for geom in geoms:
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        if int(model.geom_dataid[geom]) >= 0:
            points = mesh_points(model, geom)
        else:
            points = _ring_points(model, geom) if int(model.geom_type[geom]) == 5 else box_points(model, geom)
        placed = points @ turn.reshape(3, 3).T + model.geom_pos[geom]
        corners += [(round(x, 6), round(y, 6)) for x, y in placed[:, :2].tolist()]
    return tuple(_convex(corners))


def _find(model: Any, name: str) -> RobotElements:
    root = model.body(f"{name}/base").id
    joint = int(model.body_jntadr[root])
    geoms = tuple(g for g in range(model.ngeom) if int(model.body_rootid[model.geom_bodyid[g]]) == root)
    named = tuple(g for g in geoms if model.geom(g).name == f"{name}/hull")
    own = tuple(g for g in geoms if int(model.geom_bodyid[g]) == root and collides(model, g))
    q, v = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    hull = named or own
    reach = max((float(np.linalg.norm(model.geom_pos[g]) + model.geom_rbound[g]) for g in hull), default=0.0)
    return RobotElements(name, root, q, v, geoms, hull, reach, float(model.qpos0[q + 2]))


def mesh_points(model: Any, geom: int) -> Any:
    """Vertices of a geom's mesh, frame of the geom [m], shape (n, 3)."""
    mesh = int(model.geom_dataid[geom])
    start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    return model.mesh_vert[start : start + count]


def _ring_points(model: Any, geom: int) -> Any:
    """Points on the circumference of a cylinder [m]."""
    angles, radius = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False), float(model.geom_size[geom][0])
    return radius * np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)


def box_points(model: Any, geom: int) -> Any:
    """Corners of a geom's bounding box, frame of the geom [m], shape (8, 3)."""
    centre, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return centre + signs * half


def _convex(points: Sequence[Point]) -> list[Point]:
    """Convex hull of points, anticlockwise (Andrew's monotone chain)."""

    def chain(ordered: Sequence[Point]) -> list[Point]:
        kept: list[Point] = []
        for x, y in ordered:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2], kept[-1]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    ordered = sorted(set(points))
    return chain(ordered) + chain(ordered[::-1])


@dataclass(frozen=True)
class Controls:
    """Actuators in a robot's model, for `set_controls` of the world.

    Attributes:
        robot: Name of the robot.
        names: Names of the actuators, without the robot's prefix.
        ids: Indices of the actuators in MuJoCo's control vector, shape (n,).
        low: Minimum of each control value, in MuJoCo's unit of the actuator, shape (n,); -inf without a limit.
        high: Maximum of each control value, shape (n,); +inf without a limit.
        angles: Indices of the actuators' joints in MuJoCo's position vector, shape (n,); -1 without a joint.
        joints: Indices of the actuators' joints in MuJoCo's velocity vector, shape (n,); -1 without a joint.
    """

    robot: str
    names: tuple[str, ...]
    ids: Indices
    low: Array
    high: Array
    angles: Indices
    joints: Indices


@dataclass
class Motors:
    """Motors of one actuator of a robot, with their commands.

    Attributes:
        ids: Indices of the motors in MuJoCo's control vector.
        joints: Indices of the motors' joints in MuJoCo's velocity vector.
        angles: Indices of the motors' joints in MuJoCo's position vector.
        target: Commanded speeds of the motors [rad/s].
        change: Maximum change of a motor's speed per physics step [rad/s].
        settled: Whether the setpoints of all motors have reached the commanded speeds.
        delay: Delay of a command [physics steps].
        coming: Delayed commands, each with the step at which it takes effect.
        radius: Radius of the wheels [m].
    """

    ids: list[int]
    joints: list[int]
    angles: list[int]
    target: list[float]
    change: float = math.inf
    settled: bool = True
    delay: int = 0
    coming: deque[tuple[int, Sequence[float]]] = field(default_factory=deque)
    radius: float = 1.0


def z_axis(quat: Any) -> list[float]:
    """Direction of the z axis of a quaternion."""
    from .library import mujoco

    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quat)
    axis: list[float] = matrix.reshape(3, 3)[:, 2].tolist()
    return axis
