"""Reader of rule files: converts TOML to a RuleSet and reports every fault with its position.

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
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..base.errors import Fault, InputError, unknown
from ..base.signal import OPTIONAL_SIGNALS
from ..base.toml_table import Table
from ..expression import Environment, one_for_each_signal
from ..interfaces.action import Action
from .arguments import ExpressionReader, read_action, read_arguments
from .include import Document, read_documents
from .rule import Argument, InactiveRule, OnInvalid, Position, Rule, RuleSet, tie, ties
from .rule_test import read_tests
from .threshold import NAME, Override, read_thresholds, usable

FORMAT = "reflex/1"
MAX_PRIORITY = 1_000_000
MAX_RULES = 5000  # including those of included files
_KEYS = (
    *("until", "for", "cooldown", "trigger", "priority", "on_invalid", "max_hold", "modes", "tags", "require"),
    "waits_for",
    "action",
)
_Read = tuple[Rule | InactiveRule | None, Table]
"""Rule and its table; None if the rule's guard is invalid."""


def load_rules(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    name: str = "",
    overrides: Mapping[str, Override] | None = None,
) -> RuleSet:
    """Load the rules of a file and check them against a robot.

    A rule that requires signals which the robot lacks is inactive: its expressions are not read.

    Args:
        file: Path of the file, or its root table if the file is already parsed. With a table, a fault in an expression
            has the column of its key.
        environment: Signals and constants of the robot.
        actions: Actions of the agent, keyed by name.
        name: Name of the rule set; by default the name of the file without suffix.
        overrides: Values of thresholds that the robot declares, keyed by name.

    Raises:
        InputError: All faults of the file, each with line and column.
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
    """Errors and warnings of a rule file. Arguments as in `load_rules`. Faults are returned, never raised."""
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
    """Read the valid rules of a file, and the file's errors and warnings; arguments as in `load_rules`.

    Raises:
        InputError: The file itself cannot be read.
    """
    documents = read_documents(file)
    top = documents[-1].table
    label = name or top.file.stem
    for document in documents:
        document.table.choice("format", [FORMAT])
    thresholds, faults = read_thresholds(documents, environment, overrides, label)
    for key, node in thresholds.items():
        environment = environment.with_alias(key, node)
    doc, rules = top.text("doc", ""), list[_Read]()
    required = {signal for document in documents for signal in _names(document.table.data)}
    missing = (required | OPTIONAL_SIGNALS.keys()) - environment.signals.keys()
    absent = dict[str, tuple[str, ...]]({signal: (signal,) for signal in missing})
    for document in documents:
        environment = _read_document(document, environment, label, actions, rules, absent)
    if not rules and not any(document.table.faults for document in documents):
        top.fault(None, "the file has no rule.", hint="Write one as [rule.Name] with when, priority and action.")
    _refuse_ties(rules)
    for document in documents:
        document.table.raw("doc", "")
        with contextlib.suppress(InputError):  # the table keeps its faults, with warnings
            document.table.done()
        faults.extend(one_for_each_signal(document.table.faults))
    found = RuleSet(
        name=label,
        rules=tuple(rule for rule, _ in rules if isinstance(rule, Rule)),
        inactive=tuple(rule for rule, _ in rules if isinstance(rule, InactiveRule)),
        doc=doc,
        files=tuple(document.table.file for document in documents),
        thresholds={key: float(node.value) for key, node in thresholds.items()},
        dimensions={key: node.kind.dimension for key, node in thresholds.items() if node.kind.dimension is not None},
    )
    return found, faults


def _read_document(
    document: Document,
    environment: Environment,
    label: str,
    actions: Mapping[str, type[Action]],
    rules: list[_Read],
    absent: dict[str, tuple[str, ...]],
) -> Environment:
    """Append the rules of one file to `rules`; return the environment with the aliases of the file."""
    table, reader = document.table, ExpressionReader(document.table, environment, document.lines, absent)
    _aliases(reader)
    before = {rule.name for rule, _ in rules if rule is not None}
    for key, child in table.named_tables("rule").items():
        if len(rules) >= MAX_RULES:
            child.fault(None, f"a rule file can have at most {MAX_RULES} rules, with its included files.")
            break
        if f"{label}/{key}" in before:
            child.fault(None, f"an included file already has a rule named '{key}'.", hint="Use another name.")
        rules.append((_rule(reader, child, f"{label}/{key}", actions), child))
    return reader.environment


def required_signals(file: Path | Table) -> set[str]:
    """Names of the signals that rules of a file or of its included files require; none if the file cannot be read."""
    try:
        documents = read_documents(file)
    except InputError:
        return set()
    return {name for document in documents for name in _names(document.table.data)}


def _names(data: Mapping[str, Any]) -> Iterator[str]:
    rules = data.get("rule")
    for rule in rules.values() if isinstance(rules, dict) else ():
        require = rule.get("require") if isinstance(rule, dict) else ()
        yield from (name for name in require if isinstance(name, str)) if isinstance(require, list) else ()


def _aliases(reader: ExpressionReader) -> None:
    table = reader.root.table("alias")
    for key in table.keys():  # noqa: SIM118 - a Table is no mapping and cannot be iterated
        text = table.text(key)
        if not usable(key, reader.environment.names):
            table.fault(key, f"'{key}' cannot be an alias.", hint="It must be a new word: no signal, function or unit.")
        elif missing := reader.missing(text):
            reader.absent[key] = missing
        elif (node := reader.node(table, key, text)) is not None:
            reader.environment = reader.environment.with_alias(key, node)


def _rule(
    reader: ExpressionReader, table: Table, name: str, actions: Mapping[str, type[Action]]
) -> Rule | InactiveRule | None:
    """Read one rule; None if its guard is invalid."""
    short = name.rpartition("/")[2]
    if not NAME.fullmatch(short):
        table.fault(None, f"'{short}' cannot be a rule's name.", hint="Use letters, digits and '_'.")
    require = _required(table)
    if missing := tuple(signal for signal in require if signal not in reader.environment.signals):
        _read_inactive(reader, table, short, actions)
        return InactiveRule(name, missing, reader.position(table, "require"))
    tags = tuple(table.texts("tags", []))
    when = reader.guard(table, "when")
    until = reader.guard(table, "until") if "until" in table else None
    on_invalid, max_hold = _on_invalid(reader, table, short, tags)
    action, arguments = "", dict[str, Argument]()
    if isinstance(table.raw("action"), dict):
        action, arguments = read_arguments(reader, table.table("action"), actions)
    elif "action" in table:
        table.fault("action", f"action must be a table, found {table.raw('action')!r}.", hint="Write [rule.X.action].")
    rule = Rule(
        name=name,
        doc=table.text("doc", ""),
        tags=tags,
        modes=_modes(table),
        require=require,
        waits_for=_waits_for(table),
        when=when or reader.never,
        until=until,
        hold=reader.duration(table, "for"),
        cooldown=reader.duration(table, "cooldown"),
        level=table.choice("trigger", ["edge", "level"], "edge") == "level",
        priority=_priority(table),
        on_invalid=on_invalid,
        max_hold=max_hold,
        action=action,
        arguments=arguments,
        keep=_kept(table, arguments),
        tests=read_tests(table, short, reader.environment, actions.get(action)),
        positions=_positions(reader, table),
    )
    return rule if when else None


def _required(table: Table) -> tuple[str, ...]:
    require = table.texts("require", [])
    for name in require:
        if not NAME.fullmatch(name):
            table.fault("require", f"'{name}' cannot be the name of a signal.", hint="Use letters, digits and '_'.")
    return tuple(require)


def _read_inactive(reader: ExpressionReader, table: Table, name: str, actions: Mapping[str, type[Action]]) -> None:
    """Check the parts of an inactive rule that do not depend on signals."""
    for key in ("when", "until", "keep", "test"):
        table.raw(key, *([] if key == "when" else [None]))
    table.text("doc", "")
    table.choice("trigger", ["edge", "level"], "edge")
    for key in ("for", "cooldown"):
        reader.duration(table, key)
    _priority(table)
    _modes(table)
    _waits_for(table)
    _on_invalid(reader, table, name, tuple(table.texts("tags", [])))
    if isinstance(table.raw("action"), dict):
        read_action(table.table("action"), actions)


def _positions(reader: ExpressionReader, table: Table) -> dict[str, Position]:
    positions = {"": Position(table.file, *table.position())}
    for key in ("when", *_KEYS):
        if key in table:
            value = table.raw(key) if key in ("when", "until") else ""
            positions[key] = reader.position(table, key, value if isinstance(value, str) else "")
    if isinstance(table.raw("action", None), dict):
        action = table.table("action")
        for key in action.keys():  # noqa: SIM118 - a Table is no mapping and cannot be iterated
            value = action.raw(key)
            positions[f"action.{key}"] = reader.position(action, key, value if isinstance(value, str) else "")
    return positions


def _priority(table: Table) -> int:
    priority = table.integer("priority")
    if abs(priority) > MAX_PRIORITY:
        table.fault("priority", f"priority must be between -{MAX_PRIORITY} and {MAX_PRIORITY}, found {priority}.")
        return 0
    return priority


def _modes(table: Table) -> tuple[str, ...]:
    modes = table.texts("modes", [])
    if "modes" in table and not modes:
        table.fault("modes", "modes is empty, so the rule would never be active.", hint="Omit it for all modes.")
    for mode in modes:
        if not NAME.fullmatch(mode):
            table.fault("modes", f"'{mode}' cannot be the name of a mode.", hint="Use letters, digits and '_'.")
    return tuple(modes)


def _waits_for(table: Table) -> str:
    text = table.text("waits_for", "").strip()
    if "waits_for" in table and not text:
        table.fault("waits_for", "waits_for is empty.", hint='Name what releases the rule, such as "a person".')
    return text


def _kept(table: Table, arguments: Mapping[str, Argument]) -> tuple[str, ...]:
    keep = table.texts("keep", [])
    for name in keep:
        if name not in arguments:
            table.adopt("keep", InputError(unknown("parameter of the action", name, arguments, "The action")))
    return tuple(keep)


def _on_invalid(reader: ExpressionReader, table: Table, name: str, tags: tuple[str, ...]) -> tuple[OnInvalid, float]:
    options = [option.value for option in OnInvalid]
    if "on_invalid" not in table and "safety" in tags:
        table.fault(
            None,
            f"{name} has the tag safety, so it must declare 'on_invalid', its behaviour with an invalid guard.",
            hint='Add on_invalid = "trip" (act), "hold" (keep the latch for max_hold) or "clear" (do not act).',
        )
    text = table.choice("on_invalid", options, "clear")
    meaning = OnInvalid(text) if text in options else OnInvalid.CLEAR
    max_hold = reader.duration(table, "max_hold")
    if meaning is OnInvalid.HOLD and "max_hold" not in table:
        table.fault(
            "on_invalid",
            f"{name} holds while its guard is invalid, but has no 'max_hold'.",
            hint='A rule must not hold for ever: add for example max_hold = "0.5 s", after which the rule trips.',
        )
    if meaning is not OnInvalid.HOLD and "max_hold" in table:
        table.fault("max_hold", f"max_hold of {name} has no effect, because on_invalid is '{meaning.value}'.")
    return meaning, max_hold


def _refuse_ties(rules: list[_Read]) -> None:
    """Record a fault for each tie: rules of equal priority must have equal actions or no common mode."""
    ranked = [(rule, table) for rule, table in rules if isinstance(rule, Rule) and "priority" in table]
    for k, others in ties([rule for rule, _ in ranked]):
        rule, table = ranked[k]
        table.fault("priority", tie(rule, [ranked[i][0] for i in others]), hint="Give each of them its own priority.")
