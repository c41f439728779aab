"""Checks of a mission before the first tick."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from numbers import Real
from typing import Any, cast

from py_trees.behaviour import Behaviour
from py_trees.decorators import Timeout
from py_trees.timers import Timer

from ..base.errors import Fault, InputError
from ..base.nesting import descendants
from ..base.units import SPEED, TURN_RATE, Dimension
from ..interfaces.action import parameters_of
from ..knowledge import Knowledge
from ..trees.examine import Flow, examine, flow_of, initial_value
from ..trees.nodes import Direction, Node, Port, SubTree, Tree
from ..trees.nodes.tree import fault_at
from .act import Act
from .action_node import ActionNode
from .context import CheckOptions, MissionContext
from .mission import Mission, named_place, unknown_goal, unknown_leader
from .parameters import mission_parameters
from .plan import Plan
from .tree import TreePlan, shape_faults

THIS_ROBOT = CheckOptions().robot

_LIMITS: dict[Dimension, tuple[str, str]] = {SPEED: ("speed_limit", "m/s"), TURN_RATE: ("turn_limit", "rad/s")}


def mission_faults(
    tree: Tree, knowledge: Knowledge, later: Collection[str] | None = None, *, robot: str = THIS_ROBOT
) -> list[Fault]:
    """Errors and warnings of a mission's tree: those of any tree, and actions that the robot cannot execute.

    Args:
        tree: Tree of the mission.
        knowledge: Knowledge of the robot, with its limits and places.
        later: Names of nodes that may become known during the run; None if any node may.
        robot: Robot in messages; empty if it is an arbitrary one, the limits of which do not count.
    """
    flow = flow_of(tree)
    return list(dict.fromkeys((*examine(tree), *infeasible_actions(tree, flow, knowledge, later, robot=robot))))


def infeasible_actions(
    tree: Tree, flow: Flow, knowledge: Knowledge, later: Collection[str] | None = None, *, robot: str = THIS_ROBOT
) -> Iterator[Fault]:
    """Faults of actions that exceed the robot's limits, and of goals that are not known; as `mission_faults`.

    `flow` has the uses of the blackboard keys: a goal in a key that a node changes is not checked.
    """
    if robot:
        yield from _beyond_limits(tree, flow, knowledge, robot)
    yield from dict.fromkeys(_unknown_goals(tree, flow, knowledge, later))


def _beyond_limits(tree: Tree, flow: Flow, knowledge: Knowledge, robot: str) -> Iterator[Fault]:
    limits = knowledge.graph.attributes(knowledge.agent)
    for node in tree.nodes:
        if not isinstance(node, Act):
            continue
        for name, (value, dimension) in _values(node, flow).items():
            attribute, unit = _LIMITS.get(dimension, ("", "")) if dimension else ("", "")
            limit = limits.get(attribute, math.inf)
            if isinstance(value, Real) and isinstance(limit, Real) and abs(float(value)) > float(limit) * (1 + 1e-9):
                message = f"{name} is {float(value):g} {unit}; the limit of {robot} is {float(limit):.3g} {unit}."
                yield fault_at(node, message, attribute=name)
            wrong = unknown_leader(knowledge.world, node.tag, str(value)) if name == "leader" else None
            if wrong is not None and isinstance(node, ActionNode):
                yield fault_at(node, wrong.message, wrong.hint, attribute=name)


def _unknown_goals(tree: Tree, flow: Flow, knowledge: Knowledge, later: Collection[str] | None) -> Iterator[Fault]:
    """Faults of the goals of actions and the poses of Nav2 nodes: unknown places, and texts that are no poses."""
    added = {
        value
        for node in tree.nodes
        if isinstance(node, Node) and not isinstance(node, (Act, SubTree))
        for name, value in node.given.items()
        if isinstance(value, str) and not (name in node.ports and node.ports[name].names_places)
    }  # names of places that a node such as PlaceGoal may add
    parameters: set[str] = set()  # one fault per parameter, even if several nodes read it
    for node, port in _pose_ports(tree):
        text = _initial(node, port, flow)
        if text is not None and isinstance(node, ActionNode):
            text = named_place(port.name, text) or None
        if text is None or text in parameters or text in added:
            continue
        owner = node.runtime.owner
        passed = owner.passed if isinstance(owner, MissionContext) and node.key(port.name) is not None else {}
        if text in passed:
            parameters.add(text)
        for fault in _pose_faults(node, port, text, knowledge, later):
            if text in passed:
                yield replace(fault, message=f"'{node.name}': {fault.message}").at(*passed[text])
            else:
                at = fault_at(node, fault.message, fault.hint, attribute=port.name)
                yield replace(at, warning=fault.warning)


def _pose_ports(tree: Tree) -> Iterator[tuple[Node, Port]]:
    for node in tree.nodes:
        for port in node.ports.values() if isinstance(node, Node) else ():
            goal = isinstance(node, ActionNode) and port.name in ("goal", "heading") and port.kind is str
            if goal or port.names_places:
                yield cast("Node", node), port


def _initial(node: Node, port: Port, flow: Flow) -> str | None:
    """Text that a port reads in the first tick; None if there is no text, or if a node may change it before."""
    value = initial_value(node, port, flow)
    return value if isinstance(value, str) and value else None


def _pose_faults(
    node: Node, port: Port, text: str, knowledge: Knowledge, later: Collection[str] | None
) -> Iterator[Fault]:
    try:
        found = port.value(text)
    except InputError as error:
        if node.key(port.name) is not None:  # a faulty literal was reported when the node was made
            yield from (replace(fault, column=0) for fault in error.faults)
        return
    for pose in found if isinstance(found, list) else [found]:
        if isinstance(pose, str) and (fault := unknown_goal(knowledge.world, node.tag, pose, later)) is not None:
            yield fault


def _values(node: Act, flow: Flow) -> dict[str, tuple[Any, Dimension | None]]:
    """Values of the parameters of a leaf's action that are known before the first tick, with their dimensions."""
    if not isinstance(node, ActionNode):
        try:
            action = node.make()
        except InputError:  # reported when the node was made
            return {}
        declared = parameters_of(type(action))
        return {n: (v, declared[n].dimension) for n, v in action.parameters.items() if n in declared}
    found = {}
    for name in node.given:
        port = node.ports[name]
        value = initial_value(node, port, flow) if port.direction is Direction.INPUT else None
        if value is not None:
            try:
                found[name] = (port.value(value) if isinstance(value, str) else value, port.dimension)
            except InputError:  # reported otherwise
                continue
    return found


def checked_plan(build: Callable[..., Any], mission: Mission, parameters: Mapping[str, Any]) -> Plan | None:
    """Build and check the plan of a mission with `check_options`; its faults are then in `mission.faults`.

    Args:
        build: `build` function of the mission.
        mission: Argument of the function. Its check ends with this function, so that the plan can run.
        parameters: Parameters of the mission, in SI units.

    Returns:
        The plan; None if there are errors.
    """
    try:
        plan = _plan(build, mission, parameters)
    except InputError as error:
        mission.faults += error.faults
        return None
    except Exception as error:  # noqa: BLE001 - user code may raise anything; it is reported as a fault of the mission
        mission.faults.append(Fault(f"build raised {type(error).__name__}: {error}."))
        return None
    mission.check_options = None
    return plan


def _plan(build: Callable[..., Any], mission: Mission, parameters: Mapping[str, Any]) -> Plan | None:
    missing = [n for n, p in mission_parameters(build).items() if p.required and n not in parameters]
    if missing:
        hint = "Set them in the scenario, or give defaults."
        raise InputError(Fault(f"the mission needs {', '.join(missing)}.", hint=hint))
    root = build(mission, **parameters)
    if isinstance(root, Plan):
        return None if _has_errors(mission) else root
    if faults := shape_faults(root):
        raise InputError(*faults)
    options = mission.check_options or CheckOptions()
    tree = Tree(root, board=mission.board, clock=mission.clock, owner=mission, faults=mission.faults)
    mission.faults += _tree_faults(root, mission)
    mission.faults += mission_faults(tree, mission.knowledge, options.later, robot=options.robot)
    return None if _has_errors(mission) else TreePlan(root, mission, tree)


def _has_errors(mission: Mission) -> bool:
    return any(not fault.warning for fault in mission.faults)


def _tree_faults(root: Behaviour, mission: Mission) -> list[Fault]:
    nodes, faults = list(descendants(root)), []
    for node in nodes:
        if isinstance(node, (Timer, Timeout)):
            hint = "Use mission.wait, so that runs repeat."
            faults.append(Fault(f"'{node.name}' reads the wall clock.", hint=hint, warning=True))
        if node.blackboards:
            hint = "Store values in mission.knowledge."
            message = f"'{node.name}' uses py_trees' Blackboard, which all agents of a process share."
            faults.append(Fault(message, hint=hint, warning=True))
    for leaf in mission.leaves:
        if leaf not in nodes:
            faults.append(fault_at(leaf, "this leaf was created but is not in the tree."))
    return faults
