"""Links and joints of a simulated robot, as a tree of frames for ROS 2."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.geometry import Pose3
from ..devices.mujoco import Motors, MujocoWorld
from ..devices.mujoco.body import collides, find_bodies

Matrix = npt.NDArray[np.float64]
"""Pose as a homogeneous matrix, shape (4, 4)."""

DRAWN_GROUPS = 3  # groups of geoms that MuJoCo draws by default: 0, 1 and 2
_HINGE, _SLIDE = 3, 2  # types of joints in MuJoCo
_SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX = 2, 3, 4, 5, 6  # types of geoms


@dataclass(frozen=True)
class Shape:
    """Primitive of a link.

    Attributes:
        kind: `box`, `cylinder` or `sphere`.
        size: Edge lengths x, y, z of a box; radius and length of a cylinder; radius of a sphere [m].
        pose: Pose in the frame of the link.
        color: Red, green, blue and opacity, each 0 to 1.
    """

    kind: str
    size: tuple[float, ...]
    pose: Pose3
    color: tuple[float, ...]


@dataclass(frozen=True)
class Joint:
    """Actuated joint of a link with its parent.

    Attributes:
        name: Name in the robot's model, as in joint_states.
        turns: Whether it turns about its axis; else it slides along it.
        axis: Unit vector in the frame of the link.
        limits: Minimum and maximum angle [rad] or displacement [m]; None without limits.
        address: Index of its coordinate in MuJoCo's position vector.
    """

    name: str
    turns: bool
    axis: tuple[float, ...]
    limits: tuple[float, float] | None
    address: int


@dataclass
class Link:
    """Rigid part of a robot: its base, or a body on an actuated joint, with the passive bodies on it.

    Attributes:
        name: Name of the link, without a namespace.
        parent: Parent link; None for the base.
        origin: Pose in the frame of the parent with the joint at 0.
        joint: Joint with the parent; None for the base.
        visual: Shapes that are drawn.
        collision: Shapes that collide.
    """

    name: str
    parent: Link | None
    origin: Matrix
    joint: Joint | None
    visual: list[Shape] = field(default_factory=list)
    collision: list[Shape] = field(default_factory=list)

    @property
    def rest(self) -> Pose3:
        """Pose in the frame of the parent with the joint at 0."""
        return pose_of(self.origin)

    def pose(self, positions: Sequence[float]) -> Pose3:
        """Pose in the frame of the parent."""
        if self.joint is None:
            return self.rest
        return pose_of(self.origin @ _moved(self.joint, positions[self.joint.address]))


class RobotLinks:
    """Tree of a robot's links. Frames of links are at their joints, as URDF requires.

    A passive body, such as the roller of a wheel, belongs to the link that carries it, in the pose of the model. Its
    motion is not shown. Meshes are shown as their bounding boxes.

    Attributes:
        links: Links, each after its parent; the base comes first.
        height: Height of the base's origin over the ground in the model [m].
    """

    def __init__(self, world: MujocoWorld, robot: str) -> None:
        self._world, self._model, self._prefix = world, world.model, f"{robot}/"
        body = find_bodies(world.model, [robot])[robot]
        self.height = body.height
        base = Link("base_link", None, np.eye(4), None)
        self.links = [base]
        self._of: dict[int, tuple[Link, Matrix]] = {body.root: (base, np.eye(4))}  # link of a body, and its pose there
        children = range(body.root + 1, world.model.nbody)
        for child in (b for b in children if int(world.model.body_rootid[b]) == body.root):
            self._add(child)
        for geom in body.geoms:
            self._shape(geom, geom in body.hull)

    def site(self, site: str) -> tuple[str, Pose3]:
        """Name of the link that carries a site of the robot's model, and the pose of the site on it."""
        found = self._model.site(f"{self._prefix}{site}")
        link, there = self._of[int(self._model.site_bodyid[found.id])]
        return link.name, pose_of(there @ matrix_of(found.pos, found.quat))

    def joints(self, motors: Motors) -> list[str]:
        """Names of the joints of motors, without the robot's prefix."""
        named = (str(self._model.joint(int(self._model.dof_jntid[dof])).name) for dof in motors.joints)
        return [name.removeprefix(self._prefix) for name in named]

    def frame(self, body: int) -> tuple[Link, Matrix]:
        """Link that carries a body of the model, by its ID, and the pose of the body on it."""
        return self._of[body]

    def poses(self) -> tuple[float, list[tuple[str, str, Pose3]]]:
        """Time of the present state [s], and parent, name and pose of each link on a joint."""
        with self._world.lock:
            stamp, positions = self._world.stamp, self._world.data.qpos.tolist()
        found = [(link.parent.name, link.name, link.pose(positions)) for link in self.links if link.parent is not None]
        return stamp, found

    def _add(self, body: int) -> None:
        model = self._model
        link, there = self._of[int(model.body_parentid[body])]
        there = there @ matrix_of(model.body_pos[body], model.body_quat[body])
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        for joint in (j for j in range(first, first + count) if self._actuated(j)):
            anchor = matrix_of(model.jnt_pos[joint])  # from the body's frame to that of the joint
            how = self._joint(joint)
            origin = there @ anchor @ _moved(how, -float(model.qpos0[how.address]))  # the model is at qpos0
            link = Link(f"{how.name.removesuffix('_joint')}_link", link, origin, how)
            self.links.append(link)
            there = matrix_of(-model.jnt_pos[joint])
        self._of[body] = link, there

    def _actuated(self, joint: int) -> bool:
        model = self._model
        driven = model.actuator_trnid[model.actuator_trntype == 0, 0]  # 0: the transmission of a joint
        return int(model.jnt_type[joint]) in (_HINGE, _SLIDE) and joint in driven

    def _joint(self, joint: int) -> Joint:
        model = self._model
        low, high = model.jnt_range[joint].tolist()
        return Joint(
            model.joint(joint).name.removeprefix(self._prefix) or f"joint_{joint}",
            int(model.jnt_type[joint]) == _HINGE,
            tuple(model.jnt_axis[joint].tolist()),
            (low, high) if model.jnt_limited[joint] else None,
            int(model.jnt_qposadr[joint]),
        )

    def _shape(self, geom: int, hull: bool) -> None:
        model = self._model
        link, there = self._of[int(model.geom_bodyid[geom])]
        kind, size, centre = _primitive(model, geom)
        pose = pose_of(there @ matrix_of(model.geom_pos[geom], model.geom_quat[geom]) @ matrix_of(centre))
        material = int(model.geom_matid[geom])
        color = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
        shape = Shape(kind, size, pose, tuple(round(float(c), 4) for c in color))
        if int(model.geom_group[geom]) < DRAWN_GROUPS:
            link.visual.append(shape)
        if hull or collides(model, geom):
            link.collision.append(shape)


def _primitive(model: Any, geom: int) -> tuple[str, tuple[float, ...], Sequence[float]]:
    """Kind and size of the primitive that bounds a geom, and its centre in the frame of the geom."""
    kind, (a, b, c), origin = int(model.geom_type[geom]), model.geom_size[geom].tolist(), (0.0, 0.0, 0.0)
    if kind == _SPHERE:
        return "sphere", (a,), origin
    if kind == _CYLINDER:
        return "cylinder", (a, 2.0 * b), origin
    if kind == _CAPSULE:
        return "cylinder", (a, 2.0 * (a + b)), origin
    if kind == _ELLIPSOID and a == b:
        return "cylinder", (a, 2.0 * c), origin
    if kind in (_BOX, _ELLIPSOID):
        return "box", (2.0 * a, 2.0 * b, 2.0 * c), origin
    centre, half = model.geom_aabb[geom].reshape(2, 3).tolist()
    return "box", tuple(2.0 * each for each in half), centre


def _moved(joint: Joint, value: float) -> Matrix:
    """Pose of a link in the frame of its joint at a value [rad or m]."""
    axis = np.array(joint.axis)
    if not joint.turns:
        return matrix_of(axis * value)
    return matrix_of((0.0, 0.0, 0.0), (math.cos(value / 2.0), *(axis * math.sin(value / 2.0))))


def matrix_of(position: Any, quaternion: Any = (1.0, 0.0, 0.0, 0.0)) -> Matrix:
    """Homogeneous matrix of a position [m] and a quaternion (w, x, y, z)."""
    from ..devices.mujoco.library import mujoco

    turn, found = np.zeros(9), np.eye(4)
    mujoco.mju_quat2Mat(turn, np.asarray(quaternion, np.float64))
    found[:3, :3], found[:3, 3] = turn.reshape(3, 3), position
    return found


def pose_of(matrix: Matrix) -> Pose3:
    """Pose of a homogeneous matrix."""
    (r00, r01, _), (r10, r11, _), (r20, r21, r22) = matrix[:3, :3].tolist()
    x, y, z = matrix[:3, 3].tolist()
    level = math.hypot(r00, r10)
    pitch = math.atan2(-r20, level)
    if level < 1e-9:  # upright: roll and yaw are about the same axis
        return Pose3(x, y, z, 0.0, pitch, math.atan2(-r01, r11))
    return Pose3(x, y, z, math.atan2(r21, r22), pitch, math.atan2(r10, r00))
