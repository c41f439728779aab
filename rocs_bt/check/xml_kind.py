"""What an XML file outside of a project's folders is, by its root element."""

from __future__ import annotations

import re
from pathlib import Path

from ..errors import Fault, InputError

_LEADING = re.compile(r"<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>\[]*(?:\[.*?\]\s*)?>", re.DOTALL)
_ROOT = re.compile(r"<([A-Za-z_][\w.:\-]*)")
_TREES = re.compile(r"BTCPP_format|main_tree_to_execute|<(?:BehaviorTree|TreeNodesModel|TreeNodeModel|include)\b")
_READ = 1_000_000
"""How much of a file is looked at [bytes]."""

_CHECKABLE = "Behaviour trees (<root BTCPP_format=...>) and MJCF models (<mujoco>) can be checked."
_OTHER = {
    "robot": "a URDF model. MuJoCo's compile tool turns it into MJCF.",
    "sdf": "an SDF model of Gazebo.",
    "launch": "a ROS launch file.",
    "package": "a ROS package manifest.",
    "svg": "a picture.",
}


def xml_kind(file: Path) -> str:
    """The kind of content that an XML file holds: `mission` for behaviour trees, `world` for MJCF.

    Raises:
        InputError: The file holds neither, or cannot be read.
    """
    try:
        with file.open("rb") as opened:
            text = opened.read(_READ).decode("utf-8", errors="replace")
    except OSError as error:
        raise InputError(Fault(f"cannot read the file: {error.strerror}.", file)) from error
    found = _ROOT.search(_LEADING.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text))
    if found is None:
        raise InputError(Fault("the file holds no XML element.", file, 1, hint=_CHECKABLE))
    root = found[1]
    if root == "mujoco":
        return "world"
    if root == "BehaviorTree" or (root == "root" and _TREES.search(text)):
        return "mission"
    what = "neither trees nor models of nodes" if root == "root" else _OTHER.get(root, "nothing that is known here.")
    message = f"the file begins with <{root}>, which is {what}" if root != "root" else f"its <root> holds {what}."
    line, column = text.count("\n", 0, found.start()) + 1, found.start() - text.rfind("\n", 0, found.start())
    raise InputError(Fault(message, file, line, column, hint=_CHECKABLE))
