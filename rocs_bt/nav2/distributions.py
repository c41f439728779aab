"""Differences between Nav2's nodes in the distributions of ROS 2; the nodes of the other modules are Lyrical's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from ..trees.nodes import Input, Node
from ..trees.nodes.control.navigation import RoundRobin
from .costs import INSCRIBED, LETHAL, IsPathValid
from .motion import FollowPath
from .paths import TruncatePathLocal


def _variant(node: type[Node], **members: Any) -> type[Node]:
    return type(node.__name__, (node,), {"__doc__": node.__doc__, "__module__": __name__, **members})


def _bad(self: Any, cost: int, round_: bool) -> bool:
    return cost == LETHAL or (round_ and cost == INSCRIBED)


_ROUND: Final = _variant(RoundRobin, wrap_around=Input(bool, True, "whether the first child follows the last"))
_NEAREST_ONLY: Final = _variant(TruncatePathLocal, whole_rest=False)
_INVALID: Final = _variant(FollowPath, empty_code=103)
_UNKNOWN_IS_FREE: Final = _variant(IsPathValid, bad=_bad)

CHANGED: Final[Mapping[str, Sequence[type[Node]]]] = {
    "humble": (_ROUND, _NEAREST_ONLY, _variant(FollowPath, empty_code=0), _UNKNOWN_IS_FREE),
    "jazzy": (_ROUND, _NEAREST_ONLY, _INVALID, _UNKNOWN_IS_FREE),
    "kilted": (_ROUND, _NEAREST_ONLY, _INVALID),
}
"""Nodes that differ from the newest ones, by distribution."""
