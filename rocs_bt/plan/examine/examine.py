"""All examinations of a tree, one after the other."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from ...errors import Fault
from ...knowledge import Knowledge
from ..nodes import Tree
from .able import unable
from .constant import script_faults
from .flow import flow_faults, flow_of
from .own import own_faults
from .reach import unreachable


def examine(tree: Tree, knowledge: Knowledge | None = None, later: Collection[str] | None = None) -> list[Fault]:
    """What is wrong or doubtful in a tree: keys, scripts, children that are never ticked, actions out of reach.

    Args:
        tree: The tree, bound.
        knowledge: The robot's, which its limits and its places are taken from; None without a robot.
        later: Nodes that may become known during the run; None where any may.
    """
    return list(dict.fromkeys(_all(tree, knowledge, later)))  # a subtree that is used twice has its faults once


def _all(tree: Tree, knowledge: Knowledge | None, later: Collection[str] | None) -> Iterator[Fault]:
    flow = flow_of(tree)
    yield from flow_faults(tree, flow)
    yield from own_faults(tree)
    yield from script_faults(tree)
    yield from unreachable(tree)
    if knowledge is not None:
        yield from unable(tree, flow, knowledge, later)
