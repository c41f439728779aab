"""Check of rule files for every robot that uses them."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

from ..actions import ACTIONS
from ..agent.build import thresholds
from ..catalog import Catalog, Entry
from ..errors import Fault, InputError
from ..expression import Environment
from ..reactive import RuleSet, add_test_files, load_rules, rule_misfits
from ..reactive.analysis import examine_rules
from .stub_agent import stub_agent


def check_rule_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check a rule file for the robots of the scenarios that use it, or else for any robot."""
    users = _users(entry, catalog)
    for name in users or _any_robot(catalog):
        try:
            robot = catalog.load_robot(name)
            if robot.code and not catalog.code:
                continue
            agent = stub_agent(robot, catalog.load_class)
        except InputError:
            continue  # reported by the check of the robot
        own, environment = thresholds(robot, entry.path), Environment.of(agent.knowledge.signals)
        yield from examine_rules(entry.path, environment, ACTIONS, own)
        with suppress(InputError):  # reported by examine_rules
            rules = load_rules(entry.path, environment, ACTIONS, overrides=own)
            yield from add_test_files(rules, environment, ACTIONS)[1]
            if name in users:  # otherwise no scenario combines this robot with these rules
                yield from rule_misfits(rules.rules, ACTIONS, agent.knowledge)


def fitted_rules(entry: Entry, catalog: Catalog, robot: str | None = None) -> list[tuple[str, RuleSet]]:
    """Load a rule file with its tests for each robot that uses it.

    Args:
        entry: Entry of the rule file.
        catalog: Catalog of robots and scenarios.
        robot: Name of the only robot for which to load the file; by default all robots that use it in scenarios.

    Returns:
        Pairs of robot's name and rules.

    Raises:
        InputError: The file or its test file has faults, or does not fit a robot.
    """
    found = []
    for name in [robot] if robot is not None else _users(entry, catalog) or _any_robot(catalog):
        spec = catalog.load_robot(name)
        environment = Environment.of(stub_agent(spec, catalog.load_class).knowledge.signals)
        rules = load_rules(entry.path, environment, ACTIONS, overrides=thresholds(spec, entry.path))
        rules, faults = add_test_files(rules, environment, ACTIONS)
        if faults:
            raise InputError(*faults)
        found.append((name, rules))
    return found


def _any_robot(catalog: Catalog) -> list[str]:
    """First robot of the catalog, for a rule file that no scenario uses."""
    return [entry.name for entry in catalog.list("robot")][:1]


def _users(entry: Entry, catalog: Catalog) -> list[str]:
    """Names of the robots that use a rule file in a scenario."""
    used: dict[str, None] = {}
    for scenario in catalog.list("scenario"):
        try:
            agents = catalog.read_scenario(scenario.name).agents
        except InputError:
            continue  # reported by the check of the scenario
        used.update(dict.fromkeys(a.robot for a in agents if entry.name in a.rules))
    return list(used)
