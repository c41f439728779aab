"""The pytest plugin: the fixtures `run_scenario` and `play`, the option `--tree-coverage`, the tests in rule files.

def test_the_robot_arrives(run_scenario):
    result = run_scenario("first", seed=3)
    assert result.outcomes == {"R1": "success"}

def test_it_gives_up_when_the_dock_is_taken(play):
    trace = play("patrol", leaves={"GoTo": "RS", "Dock": "F"})
    assert trace.outcome == "FAILURE"

`rocs_bt.testing.comparing` brings the fixture `comparison`, with marks and options of its own.
`pytest rules/` runs the `[[rule.NAME.test]]` tables of a project's rule files, as `rocs-bt rules test` does.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import pytest

from .rule_files import pytest_collect_file as pytest_collect_file  # a hook: pytest looks for its name here

if TYPE_CHECKING:
    from ..simulation import RunResult
    from .missions import Trace, TreeCoverage

pytest_plugins = ("rocs_bt.testing.comparing",)

COVERAGE: pytest.StashKey[TreeCoverage] = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare `--tree-coverage`."""
    group = parser.getgroup("rocs_bt")
    told = "tell which leaves of missions the fixture `play` ticked, and what each node came to"
    group.addoption("--tree-coverage", action="store_true", help=told)


def pytest_configure(config: pytest.Config) -> None:
    """Begin to count where it is wanted."""
    if config.getoption("--tree-coverage"):
        from .missions import TreeCoverage

        config.stash[COVERAGE] = TreeCoverage()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Tell what was counted."""
    coverage = config.stash.get(COVERAGE, None)
    if coverage is not None:
        terminalreporter.section("tree coverage")
        terminalreporter.write_line(coverage.table())


@pytest.fixture
def play(request: pytest.FixtureRequest) -> Callable[..., Trace]:
    """Ticks a mission to its end without a robot; see `rocs_bt.testing.missions.play`.

    Missions are those of the project around the test, and ours. With `--tree-coverage` what it comes to is counted.
    """
    from ..catalog import Catalog
    from .missions import play

    catalog = Catalog.here(request.path.parent)
    return partial(play, catalog=catalog, coverage=request.config.stash.get(COVERAGE, None))


@pytest.fixture
def run_scenario(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., RunResult]:
    """Runs a scenario of the project around the test, or a shipped one, in lockstep.

    The function takes the scenario's name or path, `seed` (default 1) and `duration` [s] (default: the scenario's),
    and returns the run's result; its `recording` can be opened.
    """

    def run_scenario(scenario: str, *, seed: int = 1, duration: float | None = None) -> RunResult:
        # Imported here, as pytest loads the plugin in every session, also in those that never simulate.
        from .._run import run
        from ..catalog import Catalog

        catalog = Catalog.here(request.path.parent)
        out = tmp_path_factory.mktemp("run")
        return run(catalog.load_scenario(scenario), catalog, seed=seed, out=out, duration=duration, report=False)

    return run_scenario
