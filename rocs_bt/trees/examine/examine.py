"""Static checks of a tree: blackboard keys, scripts, the nodes' own checks, nodes that never run or never end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees import composites
from py_trees.behaviour import Behaviour

from ...base.errors import Fault, InputError
from ..board import Board
from ..nodes import BUILTIN, Direction, Instant, Node, Port, SubTree, Tree
from ..nodes.guard import PRE
from ..nodes.tree import fault_at
from ..script import (
    Assignment,
    Expression,
    Literal,
    Name,
    Script,
    compile_condition,
    compile_script,
    parts,
    walk,
)
from ..value import from_string
from .flow import Flow, flow_faults, flow_of, scripts_of


def node_faults(tree: Tree) -> Iterator[Fault]:
    """Faults that nodes find in themselves (`Node.bound_faults`), located in the document; errors prevent a run."""
    for node in tree.nodes:
        if isinstance(node, Node):
            for attribute, fault in _bound_faults(node):
                column = fault.column - 1 if fault.column and fault.file is None else None
                yield fault_at(
                    node, fault.message, fault.hint, attribute=attribute, column=column, warning=fault.warning
                )


def _bound_faults(node: Node) -> Iterator[tuple[str, Fault]]:
    """Attributes and faults from a node's own check; if it raises, such as for a port without a value, that error."""
    try:
        yield from node.bound_faults()
    except InputError as error:
        yield from (("", fault) for fault in error.faults)


CONDITIONS = (*PRE, "if")


def constant(script: Script) -> bool | None:
    """Value of a condition that is constant; None if the condition uses a key or cannot be computed."""
    if script.reads() or script.writes() or not script.statements:
        return None
    try:
        return compile_condition(script, Board())()
    except InputError:
        return None


def script_faults(tree: Tree) -> Iterator[Fault]:
    """Faults of scripts: constant conditions, expressions that always fail, assignments of a wrong type."""
    for node in tree.nodes:
        if not isinstance(node, Node):
            continue
        for attribute, script in scripts_of(node):
            yield from _failing_parts(node, attribute, script)
            yield from _type_faults(node, attribute, script, tree.boards[node])
            is_condition = attribute in CONDITIONS or node.tag == "ScriptCondition"
            if is_condition and (value := constant(script)) is not None:
                message = f"the condition '{script.text}' is always {str(value).lower()}."
                yield fault_at(node, message, "Use a key in it, or remove it.", attribute=attribute)


def _failing_parts(node: Node, attribute: str, script: Script) -> Iterator[Fault]:
    todo: list[Expression] = list(script.statements)
    while todo:
        expression = todo.pop()
        inside = list(walk(expression))
        if any(isinstance(e, (Name, Assignment)) for e in inside):
            todo += parts(expression)
            continue
        failing = [e for e in inside if _error(script, e)] if _error(script, expression) else []
        for inner in failing[-1:]:  # the last is the innermost: a failing operand makes all enclosing expressions fail
            for fault in _error(script, inner):
                message = f"this script always fails: {fault.message}"
                yield fault_at(node, message, fault.hint, attribute=attribute, column=inner.at, warning=False)


def _error(script: Script, expression: Expression) -> tuple[Fault, ...]:
    """Faults that prevent the evaluation of an expression without names; empty if it can be evaluated."""
    try:
        compile_script(Script(script.text, (expression,)), Board())()
    except InputError as error:
        return error.faults
    return ()


def _type_faults(node: Node, attribute: str, script: Script, board: Board) -> Iterator[Fault]:
    """Faults of assignments of a text that is no number to a key that a port declares as a number."""
    for a in script.writes():
        if a.target.name.count("@") > 1 or not isinstance(a.value, Literal) or not isinstance(a.value.value, str):
            continue
        entry = board.entry(a.target.name)
        kind: Any = None if entry is None else entry.kind
        if kind not in (int, float, bool):
            continue
        try:
            from_string(a.value.value, kind, board.enums)
        except InputError as error:
            message = f"the key '{a.target.name}' is a number, as declared by a port: {error.faults[0].message}"
            yield fault_at(node, message, attribute=attribute, column=a.at, warning=False)


Outcomes = frozenset[str]
ALL = frozenset("SFRK")
"""All outcomes: S for SUCCESS, F for FAILURE, R for RUNNING, K for SKIPPED."""

_SEQUENCES = ("Sequence", "AsyncSequence", "SequenceWithMemory", "ReactiveSequence")
_FALLBACKS = ("Fallback", "AsyncFallback", "ReactiveFallback")
_LEAVES = {"AlwaysSuccess": "S", "AlwaysFailure": "F", "Script": "S", "Sleep": "SR", "SetBlackboard": "SF"}
_MAPPINGS = {
    "Inverter": {"S": "F", "F": "S"},
    "ForceSuccess": {"F": "S"},
    "ForceFailure": {"S": "F"},
    "KeepRunningUntilFailure": {"S": "R", "K": "R"},
}
_WORDS = {"S": "succeeds", "F": "fails", "R": "runs", "K": "is skipped"}


def unreachable(tree: Tree) -> Iterator[Fault]:
    """Warnings about nodes that are never ticked, whatever the outcomes of the other nodes are."""
    known: dict[Any, Outcomes] = {}
    found: list[Fault] = []
    for node in reversed(tree.nodes):  # children before their parents
        known[node.id] = _guarded(node, _outcomes_of(node, known, found))
    yield from reversed(found)


def _outcomes_of(node: Behaviour, known: dict[Any, Outcomes], found: list[Fault]) -> Outcomes:
    tag = node.tag if isinstance(node, Node) else ""
    if isinstance(node, Node) and BUILTIN.get(tag) is not type(node):
        return ALL  # a user's class, or a stub that only has the name and may have fewer children
    below = [known[child.id] for child in node.children]
    if tag in _SEQUENCES or (not tag and isinstance(node, composites.Sequence)):
        return _in_order(node, below, "S", found)
    if tag in _FALLBACKS or (not tag and isinstance(node, composites.Selector)):
        return _in_order(node, below, "F", found)
    if tag in _MAPPINGS:
        return frozenset(_MAPPINGS[tag].get(outcome, outcome) for outcome in below[0])
    if tag in ("IfThenElse", "WhileDoElse"):
        return _branches(node, below, found)
    if tag in _LEAVES:
        return frozenset(_LEAVES[tag])
    if tag == "ScriptCondition" and isinstance(node, Node):
        values = [constant(script) for attribute, script in scripts_of(node) if attribute == "code"]
        return frozenset("SF" if not values or values[0] is None else "S" if values[0] else "F")
    if tag in ("Repeat", "RetryUntilSuccessful") and isinstance(node, Node):
        return _counted(node, below[0])
    return below[0] if isinstance(node, SubTree) else ALL


def _in_order(node: Behaviour, below: list[Outcomes], passes: str, found: list[Fault]) -> Outcomes:
    """Possible outcomes of a Sequence (`passes` is S) or a Fallback (F)."""
    outcomes, reached = set[str](), True
    for child, its in zip(node.children, below, strict=True):
        if not reached:
            message = f"is never ticked: a node before it in '{node.name}' never {_WORDS[passes]}."
            found.append(fault_at(child, message, "Change the order, or remove it."))
            break
        outcomes |= its - {passes, "K"}
        reached = bool(its & {passes, "K"})
    if reached:
        outcomes |= {passes} if any(its != {"K"} for its in below) else set()
        outcomes |= {"K"} if all("K" in its for its in below) else set()
    yields = isinstance(node, Node) and (node.tag.startswith("Async") or node.tag == "SequenceWithMemory")
    return frozenset(outcomes | {"R"} if yields else outcomes)


def _branches(node: Behaviour, below: list[Outcomes], found: list[Fault]) -> Outcomes:
    condition, outcomes = below[0], set("R") | (below[0] & {"K"})
    for child, its, needs in zip(node.children[1:], below[1:], "SF", strict=False):
        if needs in condition:
            outcomes |= its
        else:
            name = node.children[0].name
            message = f"is never ticked: the condition '{name}' never {_WORDS[needs]}."
            found.append(fault_at(child, message, "Change the condition, or remove the branch."))
    return frozenset(outcomes | ({"F"} if len(below) == 2 and "F" in condition else set()))


def _counted(node: Node, below: Outcomes) -> Outcomes:
    """Possible outcomes of Repeat and RetryUntilSuccessful; with the limit -1, not the outcome that they count."""
    counted, port = ("S", "num_cycles") if node.tag == "Repeat" else ("F", "num_attempts")
    never = {counted} if str(node.given.get(port)).strip() == "-1" else set()
    return (below | {"R", counted}) - never


def _guarded(node: Behaviour, own: Outcomes) -> Outcomes:
    """Possible outcomes of a node: those of its own tick, and those that its pre-conditions can decide."""
    if not isinstance(node, Node) or not node.conditions:
        return own
    added = {"_failureIf": "F", "_successIf": "S", "_skipIf": "K", "_while": "K"}
    return own | {added[name] for name in node.conditions if name in added}


def examine(tree: Tree) -> list[Fault]:
    """Errors and warnings of a tree: keys, values, scripts, the nodes' own checks, nodes that are never ticked."""
    return list(dict.fromkeys(_all(tree)))  # a subtree that is used twice has the same faults twice


def _all(tree: Tree) -> Iterator[Fault]:
    flow = flow_of(tree)
    yield from flow_faults(tree, flow)
    yield from value_faults(tree, flow)
    yield from node_faults(tree)
    yield from script_faults(tree)
    yield from unreachable(tree)
    yield from restart_faults(tree)


def initial_value(node: Node, port: Port, flow: Flow) -> Any:
    """Value that a port reads in the first tick; None if there is none, or if a node may change it before."""
    key = node.key(port.name)
    if key is None:
        return node.given.get(port.name)
    if any(use.changes for use in flow.of(node.board, key)):
        return None
    entry = node.board.entry(key)
    return None if entry is None else entry.value


def value_faults(tree: Tree, flow: Flow) -> Iterator[Fault]:
    """Errors of values that no node changes and that a port cannot take, if possible at the SubTree that gives them.

    A literal of the node itself is an error before, when the node is made.
    """
    givers = {tree.boards[node.decorated]: node for node in tree.nodes if isinstance(node, SubTree)}
    reported = set[tuple[Board, str]]()
    for node, port in _inputs(tree):
        key = node.key(port.name)
        # An empty text is no value: checks give it to parameters that they do not know.
        if (
            key is None
            or initial_value(node, port, flow) in (None, "")
            or (place := node.board.resolve(key)) in reported
        ):
            continue
        try:
            node.read(port.name)
        except InputError as error:
            reported.add(place)
            giver, name = givers.get(place[0]), place[1]
            at, attribute = (giver, name) if giver and name in giver.remaps else (node, port.name)
            for f in error.faults:
                yield fault_at(at, f.message, f.hint, attribute=attribute, warning=False)


def _inputs(tree: Tree) -> Iterator[tuple[Node, Port]]:
    for node in tree.nodes:
        if isinstance(node, Node) and not isinstance(node, SubTree):
            yield from ((node, port) for port in node.ports.values() if port.direction is Direction.INPUT)


_INSTANT_SUCCESS = ("AlwaysSuccess", "Script")
_DECORATORS = ("Inverter", "ForceSuccess", "ForceFailure", "Repeat", "RetryUntilSuccessful", "Timeout", "SubTree")
_TICK_FIRST = (*_DECORATORS, "Fallback", "ReactiveFallback", "AsyncFallback")
_RESTARTED = ("Sequence", "ReactiveSequence", "AsyncSequence")


def restart_faults(tree: Tree) -> Iterator[Fault]:
    """Warnings about ReactiveSequence and ReactiveFallback with a child, not the last one, that begins as RUNNING.

    A reactive node ticks its children from the first one in each tick. When such a child has ended and a later child is
    RUNNING, the next tick starts the first one again, which halts the later one: it is restarted for ever.
    """
    for node in tree.nodes:
        if not isinstance(node, Node) or node.tag not in ("ReactiveSequence", "ReactiveFallback"):
            continue
        for index, child in enumerate(node.children[:-1]):
            later = next((other for other in node.children[index + 1 :] if _may_run(other)), None)
            if later is not None and _begins_running(child):
                hint = "Use a Sequence; or put before the last child only conditions and nodes that end at once."
                message = f"is RUNNING at the start of each run, and so restarts '{later.name}' for ever."
                yield fault_at(child, f"{message[:-1]}: '{node.name}' ticks both again in each tick.", hint)
                break


def _begins_running(node: Behaviour) -> bool:
    """Whether the first tick of each run of a node returns RUNNING, as far as the classes of its nodes tell."""
    while isinstance(node, Node) and not any(name in node.conditions for name in PRE):
        if node.begins_running():
            return True
        if node.tag in _RESTARTED:
            following = (c for c in node.children if getattr(c, "tag", "") not in _INSTANT_SUCCESS)
            first = next(following, None)
        else:
            first = node.children[0] if node.tag in _TICK_FIRST else None
        if first is None:
            return False
        node = first
    return False


def _may_run(node: Behaviour) -> bool:
    """Whether a node may be RUNNING after a tick: it contains a leaf that is not known to end at once."""
    leaves = (each for each in node.iterate() if not each.children)
    return any(not isinstance(leaf, Instant) and getattr(leaf, "kind", "") != "Condition" for leaf in leaves)
