"""Rule files: TOML to a RuleSet, with every fault at its place.

::

    format = "reflex/1"
    doc = "..."
    include = ["common.toml"]
    [threshold]
    close = "0.40 m"
    [alias]
    near = "min(close, stop_distance)"
    [rule.Avoid]
    when = "min(front) < near"
    priority = 50
    on_invalid = "trip"
    [rule.Avoid.action]
    name = "TurnAngle"
    angle = "60 deg * side(min(left_gap) - min(right_gap))"
    [rule.Avoid.action.on_invalid]
    angle = "60 deg"
    [[rule.Avoid.test]]
    given = { front = "0.3 m", left_gap = "1 m", right_gap = "0.5 m" }
    at = [{ t = "0 s" }]
    expect = [{ t = "0 s", fires = true, angle = "60 deg" }]
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

from ..action import Action
from ..document import Table
from ..errors import Fault, InputError, unknown
from ..expression import Environment, Node
from .arguments import Placed, read_arguments
from .include import Document, read_documents
from .rule import Argument, OnInvalid, Place, Rule, RuleSet, tie, ties
from .rule_test import read_tests
from .threshold import NAME, Override, override, read_thresholds, usable

FORMAT = "reflex/1"
MAX_PRIORITY = 1_000_000
MAX_RULES = 5000  # of a file and all that it includes
_PLACED = ("until", "for", "cooldown", "trigger", "priority", "on_invalid", "max_hold", "modes", "tags", "action")


def load_rules(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    name: str = "",
    overrides: Mapping[str, Override] | None = None,
) -> RuleSet:
    """The rules of a file, checked against what a robot has.

    Args:
        file: The file, or its table where it was read already (columns then point at keys, not into expressions).
        environment: The robot's signals.
        actions: The agent's actions by name.
        name: What the set is called; the file's name without its ending by default.
        overrides: The robot's own values of thresholds, by name.

    Raises:
        InputError: Every fault of the file at once, each with line and column.
    """
    rules, faults = read_rules(file, environment, actions, name, overrides or {})
    if wrong := [f for f in faults if not f.warning]:
        raise InputError(*wrong)
    return rules


def check_rules(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    overrides: Mapping[str, Override] | None = None,
) -> list[Fault]:
    """All that is wrong or doubtful in a rule file; takes what `load_rules` takes, and raises nothing."""
    try:
        return read_rules(file, environment, actions, "", overrides or {})[1]
    except InputError as error:
        return list(error.faults)


def read_rules(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    name: str,
    overrides: Mapping[str, Override],
) -> tuple[RuleSet, list[Fault]]:
    """As much of a file as can be read, and all that is wrong or doubtful in it; takes what `load_rules` takes.

    Raises:
        InputError: The file itself cannot be read.
    """
    documents = read_documents(file)
    top = documents[-1].table
    label = name or top.file.stem
    thresholds = dict[str, Node]()
    for document in documents:
        document.table.choice("format", [FORMAT])
        thresholds = read_thresholds(document.table, thresholds, environment.signals)
    thresholds, faults = override(thresholds, overrides, label)
    for key, node in thresholds.items():
        environment = environment.with_alias(key, node)
    doc, rules = top.text("doc", ""), list[tuple[Rule | None, Table]]()
    for document in documents:
        environment = _read_document(document, environment, label, actions, rules)
    if not rules and not any(document.table.faults for document in documents):
        top.fault(None, "the file has no rule.", hint="Write one as [rule.Name] with when, priority and action.")
    _refuse_ties(rules)
    for document in documents:
        document.table.raw("doc", "")
        with contextlib.suppress(InputError):  # the faults stay in the table, warnings too
            document.table.done()
        faults.extend(document.table.faults)
    found = RuleSet(
        name=label,
        rules=tuple(rule for rule, _ in rules if rule is not None),
        doc=doc,
        files=tuple(document.table.file for document in documents),
        thresholds={key: float(node.value) for key, node in thresholds.items()},
    )
    return found, faults


def _read_document(
    document: Document,
    environment: Environment,
    label: str,
    actions: Mapping[str, type[Action]],
    rules: list[tuple[Rule | None, Table]],
) -> Environment:
    """Add a document's rules; gives the environment with its aliases."""
    table, placed = document.table, Placed(document.table, environment, document.lines)
    _aliases(placed)
    before = {rule.name for rule, _ in rules if rule is not None}
    for key, child in table.named_tables("rule").items():
        if len(rules) >= MAX_RULES:
            child.fault(None, f"a rule file has at most {MAX_RULES} rules with those it includes.")
            break
        if f"{label}/{key}" in before:
            child.fault(None, f"a rule named '{key}' is in an included file already.", hint="Name this one otherwise.")
        rules.append((_rule(placed, child, f"{label}/{key}", actions), child))
    return placed.environment


def _aliases(placed: Placed) -> None:
    table = placed.root.table("alias")
    for key in table.keys():  # noqa: SIM118 - a Table's keys are asked for by name
        text = table.text(key)
        if not usable(key, placed.environment.names):
            table.fault(key, f"'{key}' cannot be an alias.", hint="It must be a new word, no signal, function or unit.")
        elif (node := placed.node(table, key, text)) is not None:
            placed.environment = placed.environment.with_alias(key, node)


def _rule(placed: Placed, table: Table, name: str, actions: Mapping[str, type[Action]]) -> Rule | None:
    """A rule; None where it has no guard that could be compiled."""
    short = name.rpartition("/")[2]
    if not NAME.fullmatch(short):
        table.fault(None, f"'{short}' cannot be a rule's name.", hint="Use letters, digits and '_'.")
    tags = tuple(table.texts("tags", []))
    when = placed.guard(table, "when")
    until = placed.guard(table, "until") if "until" in table else None
    on_invalid, max_hold = _on_invalid(placed, table, short, tags)
    action, arguments = "", dict[str, Argument]()
    if isinstance(table.raw("action"), dict):
        action, arguments = read_arguments(placed, table.table("action"), actions)
    elif "action" in table:
        table.fault("action", f"action must be a table, found {table.raw('action')!r}.", hint="Write [rule.X.action].")
    rule = Rule(
        name=name,
        doc=table.text("doc", ""),
        tags=tags,
        modes=_modes(table),
        when=when or placed.never,
        until=until,
        hold=placed.duration(table, "for"),
        cooldown=placed.duration(table, "cooldown"),
        level=table.choice("trigger", ["edge", "level"], "edge") == "level",
        priority=_priority(table),
        on_invalid=on_invalid,
        max_hold=max_hold,
        action=action,
        arguments=arguments,
        keep=_kept(table, arguments),
        tests=read_tests(table, short, placed.environment, actions.get(action)),
        places=_places(placed, table),
    )
    return rule if when else None


def _places(placed: Placed, table: Table) -> dict[str, Place]:
    places = {"": Place(table.file, *table.position())}
    for key in ("when", *_PLACED):
        if key in table:
            value = table.raw(key) if key in ("when", "until") else ""
            places[key] = placed.place(table, key, value if isinstance(value, str) else "")
    if isinstance(table.raw("action", None), dict):
        action = table.table("action")
        for key in action.keys():  # noqa: SIM118 - a Table's keys are asked for by name
            value = action.raw(key)
            places[f"action.{key}"] = placed.place(action, key, value if isinstance(value, str) else "")
    return places


def _priority(table: Table) -> int:
    priority = table.integer("priority")
    if abs(priority) > MAX_PRIORITY:
        table.fault("priority", f"a priority is between -{MAX_PRIORITY} and {MAX_PRIORITY}, found {priority}.")
        return 0
    return priority


def _modes(table: Table) -> tuple[str, ...]:
    modes = table.texts("modes", [])
    if "modes" in table and not modes:
        table.fault("modes", "modes lists no mode, so the rule would never live.", hint="Leave it out for all modes.")
    for mode in modes:
        if not NAME.fullmatch(mode):
            table.fault("modes", f"'{mode}' cannot be a mode.", hint="Use letters, digits and '_'.")
    return tuple(modes)


def _kept(table: Table, arguments: Mapping[str, Argument]) -> tuple[str, ...]:
    keep = table.texts("keep", [])
    for name in keep:
        if name not in arguments:
            table.adopt("keep", InputError(unknown("parameter of the action", name, arguments, "The action")))
    return tuple(keep)


def _on_invalid(placed: Placed, table: Table, name: str, tags: tuple[str, ...]) -> tuple[OnInvalid, float]:
    options = [option.value for option in OnInvalid]
    if "on_invalid" not in table and "safety" in tags:
        table.fault(
            None,
            f"{name} is tagged safety, so it must say what an invalid guard means, but has no 'on_invalid'.",
            hint='Add on_invalid = "trip" (act), "hold" (stay, for max_hold) or "clear" (do not act).',
        )
    text = table.choice("on_invalid", options, "clear")
    meaning = OnInvalid(text) if text in options else OnInvalid.CLEAR
    max_hold = placed.duration(table, "max_hold")
    if meaning is OnInvalid.HOLD and "max_hold" not in table:
        table.fault(
            "on_invalid",
            f"{name} holds while its guard is invalid, but has no 'max_hold'.",
            hint='A rule must not freeze for ever: add for example max_hold = "0.5 s"; after it the rule trips.',
        )
    if meaning is not OnInvalid.HOLD and "max_hold" in table:
        table.fault("max_hold", f"{name} has no use for max_hold, since on_invalid is '{meaning.value}'.")
    return meaning, max_hold


def _refuse_ties(rules: list[tuple[Rule | None, Table]]) -> None:
    """Two rules of one priority may only do the same, or never live at once; else it would be chance which acts."""
    ranked = [(rule, place) for rule, place in rules if rule is not None and "priority" in place]
    for k, others in ties([rule for rule, _ in ranked]):
        rule, place = ranked[k]
        place.fault("priority", tie(rule, [ranked[i][0] for i in others]), hint="Give each of them its own priority.")
