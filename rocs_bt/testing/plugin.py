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

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import pytest

from .rule_files import pytest_collect_file as pytest_collect_file  # a hook that pytest finds by name

if TYPE_CHECKING:
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
