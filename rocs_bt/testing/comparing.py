"""Comparisons of planners as tests: marks, options, the fixture `comparison`, and the result "inconclusive".

@pytest.mark.planners("hybrid", "tree")
@pytest.mark.scenarios("barn_like[0:100]", seeds=3)
def test_the_hybrid_is_better(comparison):
    comparison.assert_better("hybrid", "tree", metric="success")
    comparison.assert_rate("hybrid", "collision", upper=0.02)

Episodes are stored after their first run, and shared by all tests of the same planners and by later sessions.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from ..catalog import Catalog
    from ..compare import Comparison
    from ..compare.episode import SceneRef
    from ..compare.record import EpisodeRecord
    from .claims import Claims

_RANGE = re.compile(r"(?P<family>\w+)\[(?P<first>\d+):(?P<end>\d+)\]")
_MARKS = (
    "planners(*names): the planners that the fixture `comparison` compares",
    "scenarios(*names, seeds=1, parameters={}): scenarios, `family[0:100]`, or scenes such as `barn_like-17`",
)
_WAIT = 24.0 * 3600.0  # [s] timeout while another process plays the same episodes


def pytest_addoption(parser: pytest.Parser) -> None:
    """Register the command-line options of comparisons."""
    group = parser.getgroup("rocs_bt")
    text = "whether inconclusive comparisons fail (default) or pass"
    group.addoption("--inconclusive", choices=("fail", "pass"), default="fail", help=text)
    group.addoption("--compare-store", metavar="DIR", help="folder of stored episodes (default: runs/compare)")
    group.addoption("--compare-jobs", type=int, metavar="N", help="worker processes (default: one per core)")
    text = "play only the first N scenes of each family"
    group.addoption("--compare-scenes", type=int, metavar="N", help=text)


def pytest_configure(config: pytest.Config) -> None:
    """Register the pytest marks of comparisons."""
    for mark in _MARKS:
        config.addinivalue_line("markers", mark)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Report a test with an inconclusive claim as "inconclusive", which is neither passed nor failed."""
    report = yield
    if call.excinfo is not None and type(call.excinfo.value).__name__ == "Inconclusive":
        from .claims import Inconclusive

        if isinstance(call.excinfo.value, Inconclusive):
            report.longrepr = str(call.excinfo.value)
            report.__dict__["inconclusive"] = True  # serialised with the report in worker processes
            report.outcome = "failed" if item.config.getoption("--inconclusive") == "fail" else "passed"
    return report


def pytest_report_teststatus(report: pytest.TestReport) -> tuple[str, str, tuple[str, dict[str, bool]]] | None:
    """Status of an inconclusive test for pytest's terminal output; None for any other test."""
    if getattr(report, "inconclusive", False):
        return "inconclusive", "?", ("INCONCLUSIVE", {"yellow": True})
    return None


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print the inconclusive claims, and whether they make the test session fail."""
    reports = terminalreporter.stats.get("inconclusive", [])
    if not reports:
        return
    terminalreporter.section("inconclusive", yellow=True)
    for report in reports:
        terminalreporter.write_line(f"{report.nodeid}\n{report.longrepr}\n")
    fails = config.getoption("--inconclusive") == "fail"
    effect = "so the run fails; --inconclusive=pass lets it pass" if fails else "and the run passes"
    terminalreporter.write_line(f"{len(reports)} inconclusive: neither confirmed nor refuted, {effect}.")


class Sweeps:
    """Sweeps (planners × scenes × seeds) of a test session; each is played once, for all tests that need it."""

    def __init__(self, config: pytest.Config) -> None:
        self._jobs: int | None = config.getoption("--compare-jobs")
        self._most: int | None = config.getoption("--compare-scenes")
        given = config.getoption("--compare-store")
        self._folder = Path(given) if given else config.rootpath / "runs" / "compare"
        self._found: dict[tuple[Any, ...], tuple[EpisodeRecord, ...]] = {}

    def scenes(self, names: Sequence[str], parameters: dict[str, Any], catalog: Catalog) -> tuple[SceneRef, ...]:
        """Return the scenes that a pytest mark `scenarios` names, at most `--compare-scenes` of each range.

        Raises:
            InputError: A scenario or family does not exist.
        """
        from ..compare import scenes_of
        from ..compare.replay import scene_by_name

        found: list[SceneRef] = []
        for name in names:
            if (ranged := _RANGE.fullmatch(name)) is None:
                found.append(scene_by_name(name, catalog))
                continue
            catalog.find("family", ranged["family"])
            first, end = int(ranged["first"]), int(ranged["end"])
            end = end if self._most is None else min(end, first + self._most)
            found += scenes_of(ranged["family"], range(first, end), parameters)
        return tuple(found)

    def records(
        self, planners: tuple[str, ...], scenes: tuple[SceneRef, ...], seeds: int, catalog: Catalog, require: str = ""
    ) -> tuple[EpisodeRecord, ...]:
        """Return the episodes of a sweep; those that the store does not have are played now."""
        from ..compare import EpisodeStore, SweepOptions, sweep

        key = (planners, scenes, seeds, catalog.project, require)
        if key not in self._found:
            with EpisodeStore(self._folder) as store, _exclusive(self._folder):
                done = sweep(
                    planners,
                    scenes,
                    range(1, seeds + 1),
                    catalog=catalog,
                    store=store,
                    options=SweepOptions(workers=self._jobs, require=require),
                )
                self._found[key] = tuple(done.records())
        return self._found[key]


@contextmanager
def _exclusive(folder: Path) -> Iterator[None]:
    """Hold a lock so that only one test process plays episodes; other processes then find the results in the store."""
    with closing(sqlite3.connect(folder / "lock.sqlite", timeout=_WAIT, isolation_level=None)) as lock:
        lock.execute("begin exclusive")
        yield


@pytest.fixture(scope="session")
def _sweeps(pytestconfig: pytest.Config) -> Sweeps:
    return Sweeps(pytestconfig)


@pytest.fixture
def comparison(request: pytest.FixtureRequest, _sweeps: Sweeps) -> Claims:
    """Fixture with the episodes of the planners and scenarios in a test's marks; see `rocs_bt.testing.claims.Claims`.

    Planners and scenarios are found in the project around the test and in the shipped content.
    """
    from ..catalog import Catalog
    from ..compare import Comparison
    from .claims import Claims

    planners, scenarios = (request.node.get_closest_marker(name) for name in ("planners", "scenarios"))
    if planners is None or scenarios is None or not planners.args or not scenarios.args:
        raise pytest.UsageError(
            f"{request.node.nodeid} uses `comparison` and so needs both marks: "
            '@pytest.mark.planners("tree") and @pytest.mark.scenarios("exp1", seeds=20).'
        )
    catalog = Catalog.here(request.path.parent)
    seeds = int(scenarios.kwargs.get("seeds", 1))
    scenes = _sweeps.scenes(scenarios.args, scenarios.kwargs.get("parameters", {}), catalog)
    compared: Comparison = Comparison(_sweeps.records(planners.args, scenes, seeds, catalog))

    def check(planner: str, requirement: str) -> Sequence[EpisodeRecord]:
        compared.of(planner)
        return _sweeps.records((planner,), scenes, seeds, catalog, requirement)

    return Claims(compared, check)
