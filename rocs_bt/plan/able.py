"""Actions that the robot cannot do: faster than it is, or to where nobody knows of."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import replace
from numbers import Real
from typing import Any, cast

from ..action import parameters_of
from ..errors import Fault, InputError, unknown
from ..knowledge import Knowledge
from ..trees.examine import Flow, examine, flow_of
from ..trees.examine.place import fault_at
from ..trees.nodes import Node, Port, SubTree, Tree
from ..units import SPEED, TURN_RATE, Dimension
from .act import Act
from .action_node import ActionNode
from .context import MissionContext
from .nav2.poses import PoseInput, PosesInput
from .unseen import unseen_goal

_LIMITS: dict[Dimension, tuple[str, str]] = {SPEED: ("speed_limit", "m/s"), TURN_RATE: ("turn_limit", "rad/s")}


def mission_faults(tree: Tree, knowledge: Knowledge, later: Collection[str] | None = None) -> list[Fault]:
    """What is wrong or doubtful in a mission's tree: as of any tree, and actions that the robot cannot do.

    Args:
        tree: The tree, bound.
        knowledge: The robot's, with its limits and places.
        later: Nodes that may become known during the run; None where any may.
    """
    flow = flow_of(tree)
    return list(dict.fromkeys((*examine(tree), *unable(tree, flow, knowledge, later))))


def unable(tree: Tree, flow: Flow, knowledge: Knowledge, later: Collection[str] | None = None) -> Iterator[Fault]:
    """Actions beyond the robot's limits, and goals that no place has.

    Args:
        tree: The tree, bound.
        flow: Uses of its keys; a key that a node changes is not examined.
        knowledge: The robot's knowledge at the start.
        later: Nodes that may become known during the run; None where any may.
    """
    yield from _beyond_limits(tree, knowledge)
    yield from dict.fromkeys(_unseen(tree, flow, knowledge, later))


def _beyond_limits(tree: Tree, knowledge: Knowledge) -> Iterator[Fault]:
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
            if name == "leader" and isinstance(node, ActionNode):
                yield from _absent(node, str(value), knowledge)


def _unseen(tree: Tree, flow: Flow, knowledge: Knowledge, later: Collection[str] | None) -> Iterator[Fault]:
    """Goals of actions and poses of Nav2's nodes that name no known place, or are no poses."""
    added = {
        value
        for node in tree.nodes
        if isinstance(node, Node) and not isinstance(node, (Act, SubTree))
        for name, value in node.given.items()
        if isinstance(value, str) and not isinstance(node.ports.get(name), (PoseInput, PosesInput))
    }  # names that a node such as PlaceGoal may add
    parameters: set[str] = set()  # one fault for each parameter, however many nodes read it
    for node, port in _pose_ports(tree):
        text = _initial(node, port, flow)
        if text is None or text in parameters or text in added:
            continue
        owner = node.runtime.owner
        passed = node.key(port.name) is not None and isinstance(owner, MissionContext) and text in owner.passed
        if passed:
            parameters.add(text)
        for fault in _pose_faults(node, port, text, knowledge, later):
            if passed:  # a fault without a place gets that of the parameters
                yield replace(fault, message=f"'{node.name}': {fault.message}")
            else:
                at = fault_at(node, fault.message, fault.hint, attribute=port.name)
                yield replace(at, warning=fault.warning)


def _pose_ports(tree: Tree) -> Iterator[tuple[Node, Port[Any]]]:
    for node in tree.nodes:
        for port in node.ports.values() if isinstance(node, Node) else ():
            goal = isinstance(node, ActionNode) and port.name == "goal" and port.kind is str
            if goal or isinstance(port, (PoseInput, PosesInput)):
                yield cast("Node", node), port


def _initial(node: Node, port: Port[Any], flow: Flow) -> str | None:
    """The text that a port reads in the first tick; None for none, or where a node may write another one before."""
    key = node.key(port.name)
    if key is None:
        value = node.given.get(port.name)
    elif any(use.changes for use in flow.of(node.board, key)):
        return None
    else:
        entry = node.board.entry(key)
        value = None if entry is None else entry.value
    return value if isinstance(value, str) and value else None


def _pose_faults(
    node: Node, port: Port[Any], text: str, knowledge: Knowledge, later: Collection[str] | None
) -> Iterator[Fault]:
    try:
        found = port.value(text)
    except InputError as error:
        if node.key(port.name) is not None:  # a literal was reported where the node was made
            yield from (replace(fault, column=0) for fault in error.faults)
        return
    for pose in found if isinstance(found, list) else [found]:
        if isinstance(pose, str) and (fault := unseen_goal(knowledge.world, node.tag, pose, later)) is not None:
            yield fault


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
