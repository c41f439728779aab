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
from collections.abc import Mapping, Sequence
from pathlib import Path

from ..base.errors import Fault, InputError, unknown
from ..base.signal import OPTIONAL_SIGNALS
from ..base.toml_table import Table
from ..declare import Location, fields_of, has_key, location_of
from ..expression import Environment, one_for_each_signal
from ..interfaces.action import Action
from .arguments import ExpressionReader, parameters_in, read_arguments
from .include import RuleDocument, read_documents
from .rule import InactiveRule, OnInvalid, Rule, RuleSet, tie, ties
from .rule_keys import RuleKeys
from .rule_test import read_tests
from .threshold import Override, read_thresholds, usable

MAX_RULES = 5000  # including those of included files
_Read = tuple[Rule | InactiveRule | None, RuleKeys]
"""Rule and its keys; None if the rule's guard is invalid."""


def load_rules(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    overrides: Mapping[str, Override] | None = None,
) -> RuleSet:
    """Load the rules of a file and check them against a robot.

    A rule that requires signals which the robot lacks is inactive: its expressions are not read.

    Args:
        file: Path of the file, or its root table if the file is already parsed. With a table, a fault in an expression
            has the column of its key.
        environment: Signals and constants of the robot.
        actions: Actions of the agent, keyed by name.
        overrides: Values of thresholds that the robot declares, keyed by name.

    Raises:
        InputError: All faults of the file, each with line and column.
    """
    rules, faults, _ = read_rules(file, environment, actions, overrides)
    if wrong := [f for f in faults if not f.warning]:
        raise InputError(*wrong)
    return rules


def read_rules(
    file: Path | Table,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    overrides: Mapping[str, Override] | None = None,
) -> tuple[RuleSet, list[Fault], RuleDocument]:
    """Read the valid rules of a file, its errors and warnings, and the file itself; arguments as in `load_rules`.

    Raises:
        InputError: The file itself cannot be read.
    """
    documents = read_documents(file)
    top = documents[-1].table
    label = top.file.stem
    thresholds, faults = read_thresholds(documents, environment, overrides or {}, label)
    for key, node in thresholds.items():
        environment = environment.with_alias(key, node)
    rules = list[_Read]()
    missing = (_required(documents) | OPTIONAL_SIGNALS.keys()) - environment.signals.keys()
    absent = dict[str, tuple[str, ...]]({signal: (signal,) for signal in missing})
    for document in documents:
        reader = ExpressionReader(document, environment, absent)
        _aliases(reader, document)
        _read_rules(reader, document, label, actions, rules)
        environment = reader.environment
    if not rules and not any(document.table.faults for document in documents):
        top.fault(None, "the file has no rule.", hint="Write one as [rule.Name] with when, priority and action.")
    _refuse_ties(reader, rules)
    for document in documents:
        with contextlib.suppress(InputError):  # the table keeps its faults, with warnings
            document.table.done()
        faults.extend(one_for_each_signal(document.table.faults))
    found = RuleSet(
        name=label,
        rules=tuple(rule for rule, _ in rules if isinstance(rule, Rule)),
        inactive=tuple(rule for rule, _ in rules if isinstance(rule, InactiveRule)),
        doc=documents[-1].keys.doc,
        files=tuple(document.table.file for document in documents),
        thresholds={key: float(node.value) for key, node in thresholds.items()},
        dimensions={key: node.kind.dimension for key, node in thresholds.items() if node.kind.dimension is not None},
    )
    return found, faults, documents[-1]


def _read_rules(
    reader: ExpressionReader,
    document: RuleDocument,
    label: str,
    actions: Mapping[str, type[Action]],
    rules: list[_Read],
) -> None:
    """Append the rules of one file to `rules`."""
    before = {rule.name for rule, _ in rules if rule is not None}
    for key, keys in document.keys.rule.items():
        if len(rules) >= MAX_RULES:
            reader.fault(keys, "", f"a rule file can have at most {MAX_RULES} rules, with its included files.")
            break
        if f"{label}/{key}" in before:
            fault = Fault(f"an included file already has a rule named '{key}'.", hint="Use another name.")
            reader.fault(keys, "", fault)
        rules.append((_rule(reader, keys, f"{label}/{key}", actions), keys))


def required_signals(file: Path | Table) -> set[str]:
    """Names of the signals that rules of a file or of its included files require; none if the file cannot be read."""
    try:
        return _required(read_documents(file))
    except InputError:
        return set()


def _required(documents: Sequence[RuleDocument]) -> set[str]:
    return {name for document in documents for keys in document.keys.rule.values() for name in keys.require}


def _aliases(reader: ExpressionReader, document: RuleDocument) -> None:
    table = document.keys.alias
    for key, text in table.items():
        if not isinstance(text, str):
            reader.fault(table, key, f"{key} must be a text, found {text!r}.")
        elif not usable(key, reader.environment.names):
            hint = "It must be a new word: no signal, function or unit."
            reader.fault(table, key, Fault(f"'{key}' cannot be an alias.", hint=hint))
        elif missing := reader.missing(text):
            reader.absent[key] = missing
        elif (node := reader.node(table, key, text)) is not None:
            reader.environment = reader.environment.with_alias(key, node)


def _rule(
    reader: ExpressionReader, keys: RuleKeys, name: str, actions: Mapping[str, type[Action]]
) -> Rule | InactiveRule | None:
    """Make one rule; None if its guard is invalid. Of an inactive rule, the parts without signals are checked."""
    hold, cooldown, max_hold = (
        reader.duration(keys, key, value)
        for key, value in (("for", keys.hold), ("cooldown", keys.cooldown), ("max_hold", keys.max_hold))
    )
    for key, message, hint, _ in keys.misfits():
        reader.fault(keys, key or "", Fault(message, hint=hint))
    if missing := tuple(signal for signal in keys.require if signal not in reader.environment.signals):
        if keys.action is not None:
            parameters_in(reader, keys.action, actions)
        return InactiveRule(name, missing, location_of(keys, "require"))
    when, until = reader.guard(keys, "when", keys.when), reader.guard(keys, "until", keys.until)
    arguments = {} if keys.action is None else read_arguments(reader, keys.action, actions)
    action = "" if keys.action is None else keys.action.name
    for kept in keys.keep:
        if kept not in arguments:
            reader.fault(keys, "keep", unknown("parameter of the action", kept, arguments, "The action"))
    rule = Rule(
        name=name,
        doc=keys.doc,
        tags=keys.tags,
        modes=keys.modes,
        require=keys.require,
        waits_for=keys.waits_for.strip(),
        when=when or reader.never,
        until=until,
        hold=hold,
        cooldown=cooldown,
        level=keys.trigger == "level",
        priority=keys.priority,
        on_invalid=OnInvalid(keys.on_invalid),
        max_hold=max_hold,
        action=action,
        arguments=arguments,
        keep=keys.keep,
        tests=read_tests(keys.test, keys.name, reader.environment, actions.get(action), reader.faults),
        positions=_positions(reader, keys),
    )
    return rule if when else None


def _positions(reader: ExpressionReader, keys: RuleKeys) -> dict[str, Location]:
    """Positions of the keys of a rule; of those with an expression, the position of the expression."""
    expressions = {"when": keys.when, "until": keys.until or ""}
    found = {
        each.key: reader.position(keys, each.key, expressions.get(each.key, ""))
        for each in fields_of(RuleKeys)
        if has_key(keys, each.key)
    }
    if (action := keys.action) is not None:
        written = {"name": "", **action.parameters}
        texts = {key: value if isinstance(value, str) else "" for key, value in written.items()}
        found |= {f"action.{key}": reader.position(action, key, text) for key, text in texts.items()}
    return {"": location_of(keys), **found}


def _refuse_ties(reader: ExpressionReader, rules: list[_Read]) -> None:
    """Record a fault for each tie: rules of equal priority must have equal actions or no common mode."""
    ranked = [(rule, keys) for rule, keys in rules if isinstance(rule, Rule) and has_key(keys, "priority")]
    for k, others in ties([rule for rule, _ in ranked]):
        rule, keys = ranked[k]
        fault = Fault(tie(rule, [ranked[i][0] for i in others]), hint="Give each of them its own priority.")
        reader.fault(keys, "priority", fault)
