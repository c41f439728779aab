"""The node classes that every document may name."""

from __future__ import annotations

from typing import Final

from . import actions, decorators
from .control import branch, navigation, ordered, parallel
from .registry import Registry, nodes_of
from .subtree import SubTree

_MODULES = (actions, branch, navigation, ordered, parallel, decorators)

BUILTIN: Final = Registry([*(node for module in _MODULES for node in nodes_of(module)), SubTree])
"""BehaviorTree.CPP 4.10's own nodes, and the control nodes of Nav2."""
