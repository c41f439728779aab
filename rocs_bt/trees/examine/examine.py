"""All examinations of a tree, one after the other."""

from __future__ import annotations

from collections.abc import Iterator

from ...errors import Fault
from ..nodes import Tree
from .constant import script_faults
from .flow import flow_faults, flow_of
from .own import own_faults
from .reach import unreachable


def examine(tree: Tree) -> list[Fault]:
    """What is wrong or doubtful in a tree: keys, scripts, what nodes say themselves, children that are never ticked.

    Args:
        tree: The tree, bound.
    """
    return list(dict.fromkeys(_all(tree)))  # a subtree that is used twice has its faults once


def _all(tree: Tree) -> Iterator[Fault]:
    yield from flow_faults(tree, flow_of(tree))
    yield from own_faults(tree)
    yield from script_faults(tree)
    yield from unreachable(tree)
