"""Substitution: other nodes in the place of some, without touching the file (BehaviorTree.CPP 4.10, t15)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ...errors import Fault, InputError, unknown
from ...nesting import check_nesting
from ...trees.nodes import BUILTIN, Node, Registry
from .letters import Letters, Scripted
from .match import Filters, identity, replace, wild

if TYPE_CHECKING:
    from ...trees import Behaviour

Rule: TypeAlias = "Letters | str | Mapping[str, Any]"
"""What stands in: letters; the name of another node class; or the configuration of a `TestNode`."""


def substitute(root: Behaviour, rules: Mapping[str, Rule], nodes: Registry = BUILTIN) -> Behaviour:
    """Put stand-ins into a tree that is not bound yet.

        substitute(root, {"dock/*": Letters("RRS"), "GoTo": "AlwaysSuccess", "shout": {"return_status": "FAILURE"}})

    A filter is a node's name, or its path; or the name of its class, or of its action; or a pattern with `*` and `?`
    over paths, which are those of BehaviorTree.CPP: `subtree/name`. The first that fits counts, in this order, and
    among patterns in the order given. Letters that are given to a pattern are for leaves that need a robot alone:
    neither for nodes with children, nor for built-in ones. What stands in keeps the conditions of the original.

    Args:
        root: The tree's root.
        rules: What stands in, by filter.
        nodes: The node classes that rules may name.

    Returns:
        The root, which may be another one now.

    Raises:
        InputError: A filter means no node, or a rule names no class; every such filter is told.
    """
    filters, out = Filters(root, rules), root
    filters.refuse_unused()
    careful = [text for text, rule in rules.items() if isinstance(rule, Letters) and wild(text)]
    todo = [root]
    while todo:
        node = todo.pop()
        skip = careful if node.children or identity(node) in BUILTIN else ()
        found = filters.match(node, skip)
        if found is None:
            todo += node.children
            continue
        new = _stand_in(node, rules[found], nodes)
        new.origin = getattr(node, "origin", None)
        replace(node.parent, node, new)
        todo += new.children
        out = new if node is root else out
    return out


def read_rules(source: Path | str) -> dict[str, Rule]:
    """Rules from BehaviorTree.CPP's JSON form.

        {"TestNodeConfigs": {"Slow": {"async_delay": 2000}}, "SubstitutionRules": {"dock/*": "Slow"}}

    Args:
        source: A file, or the text.

    Raises:
        InputError: It is no such document.
    """
    file = source if isinstance(source, Path) else None
    try:
        text = source.read_text("utf-8") if isinstance(source, Path) else source
        check_nesting(text)
        document = json.loads(text)
    except (OSError, ValueError) as error:
        raise InputError(Fault(f"these rules cannot be read: {error}.", file)) from error
    if not isinstance(document, dict) or not isinstance(document.get("SubstitutionRules"), dict):
        hint = 'Write {"TestNodeConfigs": {...}, "SubstitutionRules": {"filter": "name"}}.'
        raise InputError(Fault("these rules have no SubstitutionRules.", file, hint=hint))
    configs, rules = document.get("TestNodeConfigs", {}), document["SubstitutionRules"]
    if not isinstance(configs, dict) or not all(isinstance(config, dict) for config in configs.values()):
        raise InputError(Fault('TestNodeConfigs must be {"name": {...}}.', file))
    if odd := [name for name in rules.values() if not isinstance(name, str)]:
        raise InputError(Fault(f"a substitution rule must name a node or a configuration, found {odd[0]!r:.40}.", file))
    return {filter: configs.get(name, name) for filter, name in rules.items()}


def _stand_in(node: Behaviour, rule: Rule, nodes: Registry) -> Node:
    if isinstance(rule, Letters):
        return Scripted(node.name, rule, node)
    conditions = {n: s.text for n, s in node.conditions.items()} if isinstance(node, Node) else {}
    if isinstance(rule, str):
        if rule not in nodes:
            raise InputError(unknown("node", rule, nodes))
        given = {n: v for n, v in getattr(node, "given", {}).items() if n in nodes[rule].ports}
        children = node.children if nodes[rule].min_children else []
        for child in children:
            child.parent = None  # or it would not go with another parent
        return nodes.make(rule, node.name, children, {**given, **conditions})
    texts = {n: str(v) if not isinstance(v, str) else v for n, v in rule.items()}
    return nodes.make("TestNode", node.name, (), {**texts, **conditions})
