"""Rule files: TOML to a RuleSet, with every fault at its place.

::

    format = "reflex/1"
    doc = "..."
    [alias]
    near = "min(0.40 m, stop_distance)"
    [rule.Avoid]
    when = "min(front) < near"
    priority = 50
    on_invalid = "trip"
    [rule.Avoid.action]
    name = "TurnAngle"
    angle = "60 deg * side(min(left_gap) - min(right_gap))"
    [rule.Avoid.action.on_invalid]
    angle = "60 deg"
"""

from __future__ import annotations

import contextlib
import keyword
import re
from collections.abc import Mapping
from pathlib import Path

from ..action import Action
from ..document import Table, read_toml
from ..errors import Fault, InputError
from ..expression import FUNCTIONS, Environment
from ..units import TIME, unit_names
from .arguments import read_arguments
from .placed import Placed
from .rule import Argument, OnInvalid, Rule, RuleSet

FORMAT = "reflex/1"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def load_rules(
    file: Path | Table, environment: Environment, actions: Mapping[str, type[Action]], name: str = ""
) -> RuleSet:
    """The rules of a file, checked against what a robot has.

    Args:
        file: The file, or its table where it was read already (columns then point at keys, not into expressions).
        environment: The robot's signals.
        actions: The agent's actions by name.
        name: What the set is called; the file's name without its ending by default.

    Raises:
        InputError: Every fault of the file at once, each with line and column.
    """
    rules, faults = _load(file, environment, actions, name)
    if wrong := [f for f in faults if not f.warning]:
        raise InputError(*wrong)
    return rules


def check_rules(file: Path | Table, environment: Environment, actions: Mapping[str, type[Action]]) -> list[Fault]:
    """All that is wrong or doubtful in a rule file; takes what `load_rules` takes, and raises nothing."""
    try:
        return _load(file, environment, actions, "")[1]
    except InputError as error:
        return list(error.faults)


def _load(
    file: Path | Table, environment: Environment, actions: Mapping[str, type[Action]], name: str
) -> tuple[RuleSet, list[Fault]]:
    table = file if isinstance(file, Table) else read_toml(file)
    placed = Placed(table, environment, _lines(file))
    table.choice("format", [FORMAT])
    doc = table.text("doc", "")
    _aliases(placed)
    label = name or table.file.stem
    rules = [_rule(placed, child, f"{label}/{key}", actions) for key, child in table.named_tables("rule").items()]
    if not rules and not table.faults:
        table.fault(None, "the file has no rule.", hint="Write one as [rule.Name] with when, priority and action.")
    _refuse_ties(table, rules)
    with contextlib.suppress(InputError):  # the faults stay in the table, warnings too
        table.done()
    return RuleSet(label, tuple(rule for rule, _ in rules if rule is not None), doc), table.faults


def _lines(file: Path | Table) -> list[str]:
    path = file.file if isinstance(file, Table) else file
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return []


def _aliases(placed: Placed) -> None:
    table = placed.root.table("alias")
    names = table.keys()
    for key in names:
        text = table.text(key)
        taken = {*FUNCTIONS, *unit_names(), *keyword.kwlist, "inf", *placed.environment.names}
        if not _NAME.fullmatch(key) or key in taken:
            table.fault(key, f"'{key}' cannot be an alias.", hint="It must be a new word, no signal, function or unit.")
        elif (node := placed.node(table, key, text)) is not None:
            placed.environment = placed.environment.with_alias(key, node)


def _rule(placed: Placed, table: Table, name: str, actions: Mapping[str, type[Action]]) -> tuple[Rule | None, Table]:
    """A rule and its table; None in its place where it has no guard that could be compiled."""
    short = name.rpartition("/")[2]
    if not _NAME.fullmatch(short):
        table.fault(None, f"'{short}' cannot be a rule's name.", hint="Use letters, digits and '_'.")
    tags = tuple(table.texts("tags", []))
    when = placed.guard(table, "when")
    until = placed.guard(table, "until") if "until" in table else None
    on_invalid, max_hold = _on_invalid(table, short, tags)
    action, arguments = "", dict[str, Argument]()
    if isinstance(table.raw("action"), dict):
        action, arguments = read_arguments(placed, table.table("action"), actions)
    elif "action" in table:
        table.fault("action", f"action must be a table, found {table.raw('action')!r}.", hint="Write [rule.X.action].")
    rule = Rule(
        name=name,
        doc=table.text("doc", ""),
        tags=tags,
        when=when or placed.never,
        until=until,
        hold=table.quantity("for", TIME, 0.0, low=0.0),
        cooldown=table.quantity("cooldown", TIME, 0.0, low=0.0),
        level=table.choice("trigger", ["edge", "level"], "edge") == "level",
        priority=table.integer("priority"),
        on_invalid=on_invalid,
        max_hold=max_hold,
        action=action,
        arguments=arguments,
    )
    return (rule if when else None), table


def _on_invalid(table: Table, name: str, tags: tuple[str, ...]) -> tuple[OnInvalid, float]:
    options = [option.value for option in OnInvalid]
    if "on_invalid" not in table and "safety" in tags:
        table.fault(
            None,
            f"{name} is tagged safety, so it must say what an invalid guard means, but has no 'on_invalid'.",
            hint='Add on_invalid = "trip" (act), "hold" (stay, for max_hold) or "clear" (do not act).',
        )
    text = table.choice("on_invalid", options, "clear")
    meaning = OnInvalid(text) if text in options else OnInvalid.CLEAR
    max_hold = table.quantity("max_hold", TIME, 0.0, low=0.0)
    if meaning is OnInvalid.HOLD and "max_hold" not in table:
        table.fault(
            "on_invalid",
            f"{name} holds while its guard is invalid, but has no 'max_hold'.",
            hint='A rule must not freeze for ever: add for example max_hold = "0.5 s"; after it the rule trips.',
        )
    if meaning is not OnInvalid.HOLD and "max_hold" in table:
        table.fault("max_hold", f"{name} has no use for max_hold, since on_invalid is '{meaning.value}'.")
    return meaning, max_hold


def _refuse_ties(table: Table, rules: list[tuple[Rule | None, Table]]) -> None:
    """Two rules of one priority may only do the same; else it would be chance which of them acts."""
    seen: dict[int, Rule] = {}
    for rule, place in rules:
        if rule is None or "priority" not in place:
            continue
        first = seen.setdefault(rule.priority, rule)
        if (first.action, first.arguments) != (rule.action, rule.arguments):
            names = [r.name.rpartition("/")[2] for r in (first, rule)]
            place.fault(
                "priority",
                f"{names[0]} and {names[1]} have the same priority {rule.priority} but different actions.",
                hint="Give one of them the higher priority.",
            )
