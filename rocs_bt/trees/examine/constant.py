"""Scripts: conditions that always hold or never do, and what can never be computed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import Fault, InputError
from ..board import Board, from_string
from ..nodes import Node, Tree
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
from .flow import scripts_of
from .place import fault_at

CONDITIONS = ("_failureIf", "_successIf", "_skipIf", "_while", "if")


def constant(script: Script) -> bool | None:
    """What a condition always is; None where it depends on a key, or cannot be computed."""
    if script.reads() or script.writes() or not script.statements:
        return None
    try:
        return compile_condition(script, Board())()
    except InputError:
        return None


def script_faults(tree: Tree) -> Iterator[Fault]:
    """Conditions that depend on nothing, and expressions that fail whenever they are computed."""
    for node in tree.nodes:
        if not isinstance(node, Node):
            continue
        for attribute, script in scripts_of(node):
            yield from _failing(node, attribute, script)
            yield from _misfits(node, attribute, script, tree.boards[node])
            asked = attribute in CONDITIONS or node.tag == "ScriptCondition"
            if asked and (value := constant(script)) is not None:
                message = f"the condition '{script.text}' is always {str(value).lower()}."
                yield fault_at(node, message, "Name a key, or leave it out.", attribute=attribute)


def _failing(node: Node, attribute: str, script: Script) -> Iterator[Fault]:
    todo: list[Expression] = list(script.statements)
    while todo:
        expression = todo.pop()
        inside = list(walk(expression))
        if any(isinstance(e, (Name, Assignment)) for e in inside):
            todo += parts(expression)
            continue
        failing = [e for e in inside if _error(script, e)] if _error(script, expression) else []
        for inner in failing[-1:]:  # the last is the innermost: an operand that fails makes all around it fail
            for fault in _error(script, inner):
                message = f"this script cannot run: {fault.message}"
                yield fault_at(node, message, fault.hint, attribute=attribute, column=inner.at, warning=False)


def _error(script: Script, expression: Expression) -> tuple[Fault, ...]:
    """Why an expression without names cannot be computed; empty if it can."""
    try:
        compile_script(Script(script.text, (expression,)), Board())()
    except InputError as error:
        return error.faults
    return ()


def _misfits(node: Node, attribute: str, script: Script, board: Board) -> Iterator[Fault]:
    """Texts that are assigned to keys that a port has made numbers."""
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
            message = f"the key '{a.target.name}' is a number by its port: {error.faults[0].message}"
            yield fault_at(node, message, attribute=attribute, column=a.at, warning=False)
