"""The node classes that every document may name."""

from __future__ import annotations

from typing import Final

from .action import always, board, script, sleep, stand_in
from .control import branch, fallback, navigation, parallel, sequence, switch, try_catch
from .decorator import again, loop, mapping, once, precondition, timing, updated
from .registry import Registry, nodes_of
from .subtree import SubTree

_MODULES = (
    always,
    board,
    script,
    sleep,
    stand_in,
    branch,
    fallback,
    navigation,
    parallel,
    sequence,
    switch,
    try_catch,
    again,
    loop,
    mapping,
    once,
    precondition,
    timing,
    updated,
)

BUILTIN: Final = Registry([*(node for module in _MODULES for node in nodes_of(module)), SubTree])
"""BehaviorTree.CPP 4.10's own nodes, and the control nodes of Nav2."""
