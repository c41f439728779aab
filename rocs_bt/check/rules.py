"""Check of rule files for every robot that uses them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from ..actions import ACTIONS, action_table
from ..agent.build import thresholds
from ..base.errors import Fault, InputError, unknown
from ..base.signal import OPTIONAL_SIGNALS
from ..base.words import inactive_rule, listed
from ..catalog import Catalog, Entry, RobotSpec
from ..expression import Environment, is_absent
from ..interfaces.action import Action
from ..knowledge import Knowledge
from ..plan import mission_actions
from ..reactive import InactiveRule, RuleSet, add_test_files, load_rules, required_signals, rule_misfits
from ..reactive.analysis import Examined, examine_rules
from .stub_agent import stub_agent


def check_rule_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check a rule file for the robots of the scenarios that use it, or else for any robot."""
    users, inactive = _users(entry, catalog), dict[tuple[str, InactiveRule], None]()
    for name, mission, dialect in users or [(name, "", "") for name in _any_robot(entry, catalog)]:
        try:
            robot = catalog.load_robot(name)
            if robot.code and not catalog.code:
                continue
            knowledge = _knowledge(robot, catalog)
            build = catalog.load_mission(mission, dialect) if mission and catalog.code else None
        except InputError:
            continue  # reported by the check of the robot, or of the mission
        environment = Environment.of(knowledge.signals, robot.constants)
        actions = action_table(*mission_actions(build)) if build else ACTIONS
        rules, faults = examined(entry.path, robot, environment, actions, catalog)
        yield from faults
        if rules is not None:
            yield from add_test_files(rules, environment, actions)[1]
            yield from inactive_faults(rules, name, catalog)
            inactive |= dict.fromkeys((name, rule) for rule in rules.inactive)
            if mission:  # otherwise no scenario combines this robot with these rules
                yield from rule_misfits(rules.rules, actions, knowledge)
    for sentence, rule in inactive_rules([*inactive]):
        yield Fault(sentence, warning=True, note=True).at(*rule.position)


def examined(
    file: Path, robot: RobotSpec, environment: Environment, actions: Mapping[str, type[Action]], catalog: Catalog
) -> Examined:
    """Rules of a file for a robot and the faults of the file, which a `CachingCatalog` finds only once."""
    key = "examined", file, robot.file, tuple(actions.values())
    return catalog.cached(key, lambda: examine_rules(file, environment, actions, thresholds(robot, file)))


def inactive_faults(rules: RuleSet, robot: str, catalog: Catalog) -> Iterable[Fault]:
    """Faults of rules that are inactive on a robot.

    A required signal that no robot has is an error; a file of which all rules are inactive gives a warning.
    """
    unknown_names = {name: rule for rule in rules.inactive for name in rule.missing if name not in OPTIONAL_SIGNALS}
    known = _signals(catalog) if unknown_names else set()
    for name, rule in unknown_names.items():
        if name not in known:
            fault = unknown("signal", name, known | {*OPTIONAL_SIGNALS})
            yield replace(fault, message=f"no robot has a signal '{name}'.").at(*rule.position)
    if rules.inactive and not rules.rules:
        missing = sorted({name for rule in rules.inactive for name in rule.missing})
        message = f"all rules of '{rules.name}' are inactive: robot '{robot}' has no signal {listed(missing)}."
        hint = "Use another rule file, or add a sensor and a monitor for the signal to the robot."
        yield Fault(message, rules.files[-1], hint=hint, warning=True)


def inactive_rules(found: Sequence[tuple[str, InactiveRule]]) -> list[tuple[str, InactiveRule]]:
    """Sentences about inactive rules, one for all robots that lack the same signals.

    Args:
        found: Pairs of robot's name and inactive rule.

    Returns:
        Pairs of sentence and rule.
    """
    robots: dict[InactiveRule, list[str]] = {}
    for robot, rule in found:
        robots.setdefault(rule, []).append(robot)
    return [(inactive_rule(rule.name, names, rule.missing), rule) for rule, names in robots.items()]


def _knowledge(robot: RobotSpec, catalog: Catalog) -> Knowledge:
    """Knowledge of an agent of a robot, which is only read."""
    return catalog.cached(("knowledge", robot.file), lambda: stub_agent(robot, catalog.load_class).knowledge)


def _signals(catalog: Catalog) -> set[str]:
    """Names of the signals of all robots."""
    return {name for robot in catalog.list("robot") for name in _environment(robot.name, catalog).signals}


def _environment(robot: str, catalog: Catalog) -> Environment:
    """Signals of a robot; none if it is invalid, or has code that may not run."""
    with suppress(InputError):
        spec = catalog.load_robot(robot)
        if catalog.code or not spec.code:
            return Environment.of(_knowledge(spec, catalog).signals)
    return Environment.packed(())


def fitted_rules(entry: Entry, catalog: Catalog, robot: str | None = None) -> list[tuple[str, RuleSet]]:
    """Load a rule file with its tests for each robot that uses it.

    The tests of a file state what its own thresholds do. So only a robot that is named overrides them.

    Args:
        entry: Entry of the rule file.
        catalog: Catalog of robots and scenarios.
        robot: Name of the only robot for which to load the file, with the thresholds of the robot; by default all
            robots that use it in scenarios, with the thresholds of the file.

    Returns:
        Pairs of robot's name and rules.

    Raises:
        InputError: The file or its test file has faults, or does not fit a robot.
    """
    found = []
    users = dict.fromkeys(name for name, _, _ in _users(entry, catalog))
    for name in [robot] if robot is not None else users or _any_robot(entry, catalog):
        spec = catalog.load_robot(name)
        signals = _knowledge(spec, catalog).signals
        environment = Environment.of(signals, {} if robot is None else spec.constants)
        own = {} if robot is None else thresholds(spec, entry.path)
        rules = load_rules(entry.path, environment, ACTIONS, overrides=own)
        rules, faults = add_test_files(rules, environment, ACTIONS)
        if faults:
            raise InputError(*faults)
        found.append((name, rules))
    return found


def _any_robot(entry: Entry, catalog: Catalog) -> list[str]:
    """First robot for which a file loads that no scenario uses, at best with all signals that its rules require."""
    required = required_signals(entry.path)
    robots = [robot.name for robot in catalog.list("robot")]
    environments = {robot: _environment(robot, catalog) for robot in robots}
    robots.sort(key=lambda robot: not required <= environments[robot].signals.keys())
    for robot in robots:
        try:
            load_rules(entry.path, environments[robot], ACTIONS)
        except InputError as error:
            if any(map(is_absent, error.faults)):
                continue  # the robot does not fit; otherwise the file is wrong
        return [robot]
    return robots[:1]


def _users(entry: Entry, catalog: Catalog) -> list[tuple[str, str, str]]:
    """Robots that use a rule file in a scenario, each with its mission and the dialect of the mission."""
    used: dict[tuple[str, str, str], None] = {}
    for scenario in catalog.list("scenario"):
        try:
            agents = catalog.read_scenario(scenario.name).agents
        except InputError:
            continue  # reported by the check of the scenario
        used.update(dict.fromkeys((a.robot, a.mission, a.nodes) for a in agents if entry.name in a.rules))
    return list(used)
