"""Checking a mission without running it: everything that can be told before the first tick."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.decorators import Timeout
from py_trees.timers import Timer

from ..action import Action
from ..clock import Clock
from ..errors import Fault, InputError
from ..event import NullSink
from ..expression import Expression
from ..knowledge import Knowledge
from ..pipeline import Pipeline
from ..trees.examine.place import fault_at
from ..trees.nodes import Tree, descendants
from .able import mission_faults
from .mission import Mission
from .parameters import mission_parameters
from .plan import Plan
from .shape import shape_faults


def check_mission(
    build: Callable[..., Any],
    *,
    actions: Mapping[str, type[Action]],
    knowledge: Knowledge,
    clock: Clock,
    parameters: Mapping[str, Any] | None = None,
    compile_guard: Callable[[str], Expression] | None = None,
    fit: bool = True,
    later: Collection[str] | None = None,
) -> list[Fault]:
    """All faults of a mission; empty when it is fine. Those marked `warning` do not keep it from running.

    Args:
        build: The mission's.
        actions: The action table.
        knowledge: What the robot knows at the start; goals are looked for when it knows any place.
        clock: Time.
        parameters: The mission's parameters, in SI units.
        compile_guard: Compiles expressions over the robot's signals.
        fit: Whether the robot is the one that the mission is for, and not just any.
        later: Nodes that may become known during the run; None where any may.
    """
    try:
        declared = mission_parameters(build)
    except InputError as error:
        return list(error.faults)
    missing = [n for n, p in declared.items() if p.required and n not in (parameters or {})]
    if missing:
        return [Fault(f"the mission needs {', '.join(missing)}.", hint="Give them in the scenario, or defaults.")]
    sink = NullSink()
    mission = Mission(
        "check",
        knowledge=knowledge,
        pipeline=Pipeline(clock, sink),
        actions=actions,
        clock=clock,
        sink=sink,
        compile_guard=compile_guard,
        survey=True,
        fit=fit,
        passed=[value for value in (parameters or {}).values() if isinstance(value, str)],
        later=later,
    )
    try:
        root = build(mission, **(parameters or {}))
    except InputError as error:
        return [*mission.faults, *error.faults]
    except Exception as error:  # noqa: BLE001 - a mission is a person's code: whatever it raises is a fault of it
        return [*mission.faults, Fault(f"build raised {type(error).__name__}: {error}.")]
    if isinstance(root, Plan):
        return mission.faults
    if faults := shape_faults(root):
        return [*mission.faults, *faults]
    misfits: list[Fault] = []
    try:
        tree = Tree(root, board=mission.board, clock=clock, owner=mission, faults=misfits)
    except InputError as error:
        return [*mission.faults, *error.faults]
    return [*mission.faults, *misfits, *_tree_doubts(root, mission), *mission_faults(tree, knowledge, later)]


def _tree_doubts(root: Behaviour, mission: Mission) -> list[Fault]:
    nodes, faults = list(descendants(root)), []
    for node in nodes:
        if isinstance(node, (Timer, Timeout)):
            hint = "Use mission.wait, or runs will not repeat."
            faults.append(Fault(f"'{node.name}' reads the wall clock.", hint=hint, warning=True))
        if node.blackboards:
            hint = "Keep what is known in mission.knowledge."
            message = f"'{node.name}' uses py_trees' Blackboard, which all agents of a process share."
            faults.append(Fault(message, hint=hint, warning=True))
    for leaf in mission.leaves:
        if leaf not in nodes:
            faults.append(fault_at(leaf, "this leaf was made but is not in the tree."))
    return faults
