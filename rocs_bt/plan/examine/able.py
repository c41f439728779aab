"""Actions that the robot cannot do: faster than it is, or to where nobody knows of."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import replace
from numbers import Real
from typing import Any

from ...action import parameters_of
from ...errors import Fault, InputError, unknown
from ...knowledge import Knowledge
from ...units import SPEED, TURN_RATE, Dimension
from ..act import Act
from ..action_node import ActionNode
from ..nodes import Tree
from ..unseen import unseen_goal
from .place import fault_at

_LIMITS: dict[Dimension, tuple[str, str]] = {SPEED: ("speed_limit", "m/s"), TURN_RATE: ("turn_limit", "rad/s")}


def unable(tree: Tree, knowledge: Knowledge, later: Collection[str] | None = None) -> Iterator[Fault]:
    """What the leaves that have actions done ask too much of the robot."""
    limits = knowledge.graph.attributes(knowledge.agent)
    for node in tree.nodes:
        if not isinstance(node, Act):
            continue
        for name, (value, dimension) in _values(node).items():
            attribute, unit = _LIMITS.get(dimension, ("", "")) if dimension else ("", "")
            limit = limits.get(attribute, math.inf)
            if isinstance(value, Real) and isinstance(limit, Real) and abs(float(value)) > float(limit) * (1 + 1e-9):
                message = f"{name} is {float(value):g} {unit}, and this robot does {float(limit):.3g} {unit} at most."
                yield fault_at(node, message, attribute=name)
            if name == "goal" and isinstance(node, ActionNode):
                fault = unseen_goal(knowledge.world, node.tag, str(value), later)
                if fault is not None:
                    yield replace(fault_at(node, fault.message, fault.hint, attribute="goal"), warning=fault.warning)
            if name == "leader" and isinstance(node, ActionNode):
                yield from _absent(node, str(value), knowledge)


def _values(node: Act) -> dict[str, tuple[Any, Dimension | None]]:
    """The parameters of a leaf's action that are known before it is ticked, and their dimensions."""
    if not isinstance(node, ActionNode):
        try:
            action = node.make()
        except InputError:  # told where it was made
            return {}
        declared = parameters_of(type(action))
        return {n: (v, declared[n].dimension) for n, v in action.parameters.items() if n in declared}
    found = {}
    for name, given in node.given.items():
        port = node.ports[name]
        if node.key(name) is None:
            try:
                found[name] = (port.value(given) if isinstance(given, str) else given, port.dimension)
            except InputError:  # told where it was made
                continue
    return found


def _absent(node: ActionNode, leader: str, knowledge: Knowledge) -> Iterator[Fault]:
    known = knowledge.world.peers()
    if known and leader not in known:
        found = unknown("other robot", leader, known, "The world")
        yield fault_at(node, found.message, f"{found.hint} {node.tag} fails at once.", attribute="leader")
