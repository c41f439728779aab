"""Geometry of robots and objects for the header of a recording: primitives on links, and the joints between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..devices.mujoco import MujocoWorld
from ..record.file.header import BodyLink, BodyShape
from .robot_links import DRAWN_GROUPS, Matrix, RobotLinks, matrix_of

_KINDS = {2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box"}  # types of geoms in MuJoCo
_DIGITS = 4  # of lengths [m] and of quaternions


class RobotShapes:
    """Shapes of a robot, and the joints that move its links.

    Attributes:
        links: Links after the base, which is link 0; each after its parent.
        shapes: Primitives of all links.
        height: Height of the base's origin over the ground in the model [m].
        addresses: Index of the coordinate of each link's joint in MuJoCo's position vector.
    """

    def __init__(self, world: MujocoWorld, robot: str) -> None:
        tree, model = RobotLinks(world, robot), world.model
        index = {id(link): i for i, link in enumerate(tree.links)}
        self.height = round(tree.height, _DIGITS)
        joints = [(link, link.joint) for link in tree.links[1:] if link.joint is not None]
        self.addresses = [joint.address for _, joint in joints]
        self.links = tuple(
            BodyLink(
                parent=index[id(link.parent)],
                **_placed(link.origin),
                axis=_rounded(joint.axis),
                turns=joint.turns,
            )
            for link, joint in joints
        )

        def frame(body: int) -> tuple[int, Matrix]:
            link, there = tree.frame(body)
            return index[id(link)], there

        body = world.robots[robot]
        drawn = [geom for geom in body.geoms if int(model.geom_group[geom]) < DRAWN_GROUPS]
        self.shapes = tuple(_shape(model, geom, *frame(int(model.geom_bodyid[geom]))) for geom in drawn or body.hull)


def object_shapes(world: MujocoWorld, name: str) -> tuple[tuple[BodyShape, ...], float]:
    """Shapes of an object in the frame of its body, as they are now, and the height of this frame [m]."""
    model, data, found = world.model, world.data, world.objects[name]
    root = int(model.geom_bodyid[found.geoms[0]]) if found.geoms else 0

    def shapes(geoms: Sequence[int]) -> Iterator[BodyShape]:
        inverse = np.linalg.inv(matrix_of(data.xpos[root], data.xquat[root]))
        for geom in geoms:
            body = int(model.geom_bodyid[geom])
            yield _shape(model, geom, 0, inverse @ matrix_of(data.xpos[body], data.xquat[body]))

    return tuple(shapes(getattr(found, "tree", found.geoms))), round(float(data.xpos[root][2]), _DIGITS)


def _shape(model: Any, geom: int, link: int, there: Matrix) -> BodyShape:
    kind, size, centre = _KINDS.get(int(model.geom_type[geom]), "box"), model.geom_size[geom], np.zeros(3)
    if int(model.geom_type[geom]) not in _KINDS:  # such as a mesh: its bounding box
        centre, size = model.geom_aabb[geom].reshape(2, 3)
    pose = there @ matrix_of(model.geom_pos[geom], model.geom_quat[geom]) @ matrix_of(centre)
    material = int(model.geom_matid[geom])
    tint = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    return BodyShape(kind=kind, size=_rounded(size), tint=_rounded(tint, 2), link=link, **_placed(pose))


def _placed(matrix: Matrix) -> dict[str, tuple[float, ...]]:
    from ..devices.mujoco.library import mujoco

    turn = np.zeros(4)
    mujoco.mju_mat2Quat(turn, np.ascontiguousarray(matrix[:3, :3]).ravel())
    return {"position": _rounded(matrix[:3, 3]), "quaternion": _rounded(turn)}


def _rounded(values: Any, digits: int = _DIGITS) -> tuple[float, ...]:
    return tuple(round(float(value), digits) + 0.0 for value in values)
