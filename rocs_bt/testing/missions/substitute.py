"""Substitution of nodes by stubs, without a change of the file (BehaviorTree.CPP 4.10, t15)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ...base.errors import Fault, InputError, unknown
from ...base.files import read_text
from ...base.nesting import check_nesting
from ...trees.nodes import BUILTIN, Node, Registry
from .match import Filters, identity, replace, wild
from .scripted import Scripted, ScriptedOutcomes

if TYPE_CHECKING:
    from ...trees import Behaviour

Rule: TypeAlias = "ScriptedOutcomes | str | Mapping[str, Any]"
"""Replacement of a node: scripted outcomes; the name of another node class; or the configuration of a `TestNode`."""


def substitute(root: Behaviour, rules: Mapping[str, Rule], nodes: Registry = BUILTIN) -> Behaviour:
    """Replace nodes of an unbound tree by stubs.

        substitute(root, {"dock/*": ScriptedOutcomes("RRS"), "GoTo": "AlwaysSuccess", "shout": {"async_delay": 100}})

    A filter is a node's name or path, the name of its class or action, or a pattern with the wildcards `*` and `?` for
    paths. Paths have BehaviorTree.CPP's form `subtree/name`. If several filters match a node, a name or path takes
    precedence over a class or action, and this over a pattern; of several patterns, the first one given is used. A
    pattern with scripted outcomes matches only leaves that need a robot, not nodes with children or built-in nodes. A
    stub keeps the conditions of the node that it replaces.

    Args:
        root: Root of the tree.
        rules: Replacement of the nodes that match each filter.
        nodes: Node classes that a rule may name as a replacement.

    Returns:
        The root, which may have been replaced.

    Raises:
        InputError: A filter matches no node, or a rule names an unknown class; the error lists all unmatched filters.
    """
    filters, out = Filters(root, rules), root
    filters.refuse_unused()
    leaves_only = [text for text, rule in rules.items() if isinstance(rule, ScriptedOutcomes) and wild(text)]
    todo = [root]
    while todo:
        node = todo.pop()
        skip = leaves_only if node.children or identity(node) in BUILTIN else ()
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
    """Read replacement rules in BehaviorTree.CPP's JSON form.

        {"TestNodeConfigs": {"Slow": {"async_delay": 2000}}, "SubstitutionRules": {"dock/*": "Slow"}}

    Args:
        source: A file, or the text.

    Raises:
        InputError: The document is invalid.
    """
    file = source if isinstance(source, Path) else None
    try:
        text = read_text(source) if isinstance(source, Path) else source
        check_nesting(text)
        document = json.loads(text)
    except ValueError as error:
        raise InputError(Fault(f"cannot read the substitution rules: {error}.", file)) from error
    if not isinstance(document, dict) or not isinstance(document.get("SubstitutionRules"), dict):
        hint = 'Write {"TestNodeConfigs": {...}, "SubstitutionRules": {"filter": "name"}}.'
        raise InputError(Fault("the document has no SubstitutionRules.", file, hint=hint))
    configs, rules = document.get("TestNodeConfigs", {}), document["SubstitutionRules"]
    if not isinstance(configs, dict) or not all(isinstance(config, dict) for config in configs.values()):
        raise InputError(Fault('TestNodeConfigs must be {"name": {...}}.', file))
    if odd := [name for name in rules.values() if not isinstance(name, str)]:
        raise InputError(Fault(f"a substitution rule must name a node or a configuration, found {odd[0]!r:.40}.", file))
    return {filter: configs.get(name, name) for filter, name in rules.items()}


def _stand_in(node: Behaviour, rule: Rule, nodes: Registry) -> Node:
    if isinstance(rule, ScriptedOutcomes):
        return Scripted(node.name, rule, node)
    conditions = {n: s.text for n, s in node.conditions.items()} if isinstance(node, Node) else {}
    if isinstance(rule, str):
        if rule not in nodes:
            raise InputError(unknown("node", rule, nodes))
        given = {n: v for n, v in getattr(node, "given", {}).items() if n in nodes[rule].ports}
        children = node.children if nodes[rule].min_children else []
        for child in children:
            child.parent = None  # else the new parent would refuse it
        return nodes.make(rule, node.name, children, {**given, **conditions})
    texts = {n: str(v) if not isinstance(v, str) else v for n, v in rule.items()}
    return nodes.make("TestNode", node.name, (), {**texts, **conditions})
