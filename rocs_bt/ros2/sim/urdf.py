"""Description of a simulated robot in the Unified Robot Description Format (URDF)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree as xml

from ...base.geometry import Pose3
from ...simulation.robot_links import Joint, Link, Shape

_UNLIMITED = "1000"  # effort and velocity, which URDF requires beside the limits of a joint

_SIZES: Mapping[str, Callable[[Sequence[str]], dict[str, str]]] = {
    "box": lambda size: {"size": " ".join(size)},
    "cylinder": lambda size: {"radius": size[0], "length": size[1]},
    "sphere": lambda size: {"radius": size[0]},
}


def urdf(
    robot: str, links: Sequence[Link], frame: Callable[[str], str], fixed: Iterable[tuple[str, str, Pose3]]
) -> str:
    """URDF of a robot.

    Args:
        robot: Name of the robot.
        links: Its links, each after its parent.
        frame: Function from the name of a link to the name of its frame, which is the link's name in the URDF.
        fixed: Frames on fixed joints, such as those of sensors: frame of the parent, own frame, and pose in the parent.
    """
    root = xml.Element("robot", name=robot)
    for link in links:
        element = xml.SubElement(root, "link", name=frame(link.name))
        for kind, shapes in (("visual", link.visual), ("collision", link.collision)):
            for shape in shapes:
                _shape(xml.SubElement(element, kind), shape)
        if link.parent is not None and link.joint is not None:
            ends = frame(link.parent.name), frame(link.name)
            _joint(root, link.joint, *ends, link.rest)
    known = {frame(link.name) for link in links}
    for parent, child, pose in fixed:
        for name in dict.fromkeys((parent, child)):
            if name not in known:
                known.add(name)
                xml.SubElement(root, "link", name=name)
        _connect(root, f"{child}_joint", "fixed", parent, child, pose)
    xml.indent(root)
    return xml.tostring(root, encoding="unicode", xml_declaration=True)


def _shape(element: xml.Element, shape: Shape) -> None:
    xml.SubElement(element, "origin", _origin(shape.pose))
    size = _SIZES[shape.kind](list(map(_number, shape.size)))
    xml.SubElement(xml.SubElement(element, "geometry"), shape.kind, size)
    if element.tag == "visual":
        rgba = " ".join(map(_number, shape.color))
        material = xml.SubElement(element, "material", name=f"rgba {rgba}")
        xml.SubElement(material, "color", rgba=rgba)


def _joint(root: xml.Element, joint: Joint, parent: str, child: str, origin: Pose3) -> None:
    kind = "prismatic" if not joint.turns else "revolute" if joint.limits else "continuous"
    element = _connect(root, joint.name, kind, parent, child, origin)
    xml.SubElement(element, "axis", xyz=" ".join(map(_number, joint.axis)))
    if kind != "continuous":
        low, high = joint.limits or (-1000.0, 1000.0)
        bounds = {"lower": _number(low), "upper": _number(high), "effort": _UNLIMITED, "velocity": _UNLIMITED}
        xml.SubElement(element, "limit", bounds)


def _connect(root: xml.Element, name: str, kind: str, parent: str, child: str, origin: Pose3) -> Any:
    element = xml.SubElement(root, "joint", name=name, type=kind)
    xml.SubElement(element, "origin", _origin(origin))
    xml.SubElement(element, "parent", link=parent)
    xml.SubElement(element, "child", link=child)
    return element


def _origin(pose: Pose3) -> dict[str, str]:
    x, y, z, *turns = map(_number, pose)
    return {"xyz": f"{x} {y} {z}", "rpy": " ".join(turns)}


def _number(value: float) -> str:
    return f"{value:.9g}"
