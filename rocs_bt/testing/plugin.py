"""Pytest plugin: the fixtures `run_scenario` and `play`, the option `--tree-coverage`, the tests in rule files.

    def test_the_robot_arrives(run_scenario):
        result = run_scenario("first", seed=3)
        assert result.outcomes == {"R1": "success"}

    def test_it_gives_up_when_the_dock_is_taken(play):
        trace = play("patrol", leaves={"GoTo": "RS", "Dock": "F"})
        assert trace.outcome == "FAILURE"

`rocs_bt.testing.comparing` provides the fixture `comparison`, with its own marks and options.
`pytest rules/` runs the `[[rule.NAME.test]]` tables of a project's rule files, as `rocs-bt rules test` does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from ..base.files import is_file

if TYPE_CHECKING:
    from ..reactive import RuleTestResult
    from ..running import RunResult
    from .missions import Trace, TreeCoverage


pytest_plugins = ("rocs_bt.testing.comparing",)

COVERAGE: pytest.StashKey[TreeCoverage] = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Register `--tree-coverage`."""
    group = parser.getgroup("rocs_bt")
    text = "report the leaves ticked by the fixture `play`, and the outcomes of each node"
    group.addoption("--tree-coverage", action="store_true", help=text)


def pytest_configure(config: pytest.Config) -> None:
    """Start counting node outcomes if `--tree-coverage` is set."""
    if config.getoption("--tree-coverage"):
        from .missions import TreeCoverage

        config.stash[COVERAGE] = TreeCoverage()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print the coverage table at the end of the session."""
    coverage = config.stash.get(COVERAGE, None)
    if coverage is not None:
        terminalreporter.section("tree coverage")
        terminalreporter.write_line(coverage.table())


@pytest.fixture
def play(request: pytest.FixtureRequest) -> Callable[..., Trace]:
    """Fixture that ticks a mission to its end without a robot; see `rocs_bt.testing.missions.play`.

    Missions are found in the project around the test and in the shipped content. `--tree-coverage` counts the outcomes
    of their nodes.
    """
    from ..catalog import Catalog
    from .missions import play

    catalog = Catalog.here(request.path.parent)
    return partial(play, catalog=catalog, coverage=request.config.stash.get(COVERAGE, None))


@pytest.fixture
def run_scenario(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., RunResult]:
    """Fixture that runs a scenario of the project around the test, or a shipped one, in lockstep.

    The function takes the scenario's name or path, `seed` (default 1) and `duration` [s] (default: the scenario's),
    and returns the run's result, with a `recording` that can be opened.
    """

    def run_scenario(scenario: str, *, seed: int = 1, duration: float | None = None) -> RunResult:
        # Imported here because pytest loads the plugin in every session, even without simulation.
        from .._run import run
        from ..catalog import Catalog

        catalog = Catalog.here(request.path.parent)
        out = tmp_path_factory.mktemp("run")
        return run(catalog.load_scenario(scenario), catalog, seed=seed, out=out, duration=duration, report=False)

    return run_scenario


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> RuleFileTests | None:
    """Return a collector for a project's rule file or a file in its `rules/tests`; None for any other file."""
    from ..reactive import tested_file

    if file_path.suffix != ".toml" or tested_file(file_path).parent.name != "rules":
        return None
    collected: RuleFileTests = RuleFileTests.from_parent(parent, path=file_path)
    return collected


class RuleFileTests(pytest.File):
    """Collector of the tests in one file; each test runs once for each robot that uses the rules."""

    def collect(self) -> Iterator[RuleFileTest]:
        """Run all tests now, which takes no longer than collecting them; an invalid file is a collection error."""
        from ..base.errors import InputError
        from ..catalog import Catalog, make_entry
        from ..check import fitted_rules
        from ..reactive import run_tests, tested_file

        rule_file = tested_file(self.path)
        if not is_file(rule_file):
            raise self.CollectError(f"{self.path}: the rule file {rule_file} does not exist.")
        apart = rule_file.parent / "tests"
        try:
            fitted = fitted_rules(make_entry(rule_file, "rules", "file"), Catalog.here(rule_file.parent))
        except InputError as error:
            raise self.CollectError(str(error)) from error
        for robot, rules in fitted:
            for result in run_tests(rules):
                file = result.position.file
                if (file is not None and file.parent == apart) != (self.path.parent == apart):
                    continue
                name = f"{result.rule.rpartition('/')[2]}: {result.test} [{robot}]"
                yield RuleFileTest.from_parent(self, name=name, result=result)


class RuleFileTest(pytest.Item):
    """One test of a rule file for one robot, with its result."""

    def __init__(self, *, result: RuleTestResult, **of: Any) -> None:
        super().__init__(**of)
        self.result = result

    def runtest(self) -> None:
        """Fail if the rule test failed."""
        if not self.result.passed:
            position = self.result.position
            pytest.fail(f"{position.file}:{position.line}:{position.column}: {self.result.message}", pytrace=False)

    def reportinfo(self) -> tuple[Path, int, str]:
        """File, line and name of the test."""
        return self.path, max(self.result.position.line - 1, 0), self.name
