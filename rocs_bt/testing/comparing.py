"""Comparisons of planners as tests: marks, options, the fixture `comparison`, and a result of its own: inconclusive.

@pytest.mark.planners("hybrid", "tree")
@pytest.mark.scenarios("barn_like[0:100]", seeds=3)
def test_the_hybrid_is_better(comparison):
    comparison.assert_better("hybrid", "tree", metric="success")
    comparison.assert_rate("hybrid", "collision", upper=0.02)

Episodes are played once, and kept: tests of the same planners share them, and so does the next session.
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
    "scenarios(*names, seeds=1, parameters={}): where: scenarios, `family[0:100]`, or scenes such as `barn_like-17`",
)
_WAIT = 24.0 * 3600.0  # [s] for another process that plays the same episodes


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("rocs_bt")
    told = "whether a comparison that cannot be told apart fails the run (default) or lets it pass"
    group.addoption("--inconclusive", choices=("fail", "pass"), default="fail", help=told)
    group.addoption("--compare-store", metavar="DIR", help="where episodes are kept (default: runs/compare)")
    group.addoption("--compare-workers", type=int, metavar="N", help="processes that play (default: one for each core)")
    told = "play only the first N scenes of each family"
    group.addoption("--compare-scenarios", type=int, metavar="N", help=told)


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marks."""
    for mark in _MARKS:
        config.addinivalue_line("markers", mark)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Make what was inconclusive a result of its own."""
    report = yield
    if call.excinfo is not None and type(call.excinfo.value).__name__ == "Inconclusive":
        from .claims import Inconclusive

        if isinstance(call.excinfo.value, Inconclusive):
            report.longrepr = str(call.excinfo.value)
            report.__dict__["inconclusive"] = True  # travels with it from worker processes
            report.outcome = "failed" if item.config.getoption("--inconclusive") == "fail" else "passed"
    return report


def pytest_report_teststatus(report: pytest.TestReport) -> tuple[str, str, tuple[str, dict[str, bool]]] | None:
    """Its word on the terminal."""
    if getattr(report, "inconclusive", False):
        return "inconclusive", "?", ("INCONCLUSIVE", {"yellow": True})
    return None


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Tell what was inconclusive, and what it means for the run."""
    reports = terminalreporter.stats.get("inconclusive", [])
    if not reports:
        return
    terminalreporter.section("inconclusive", yellow=True)
    for report in reports:
        terminalreporter.write_line(f"{report.nodeid}\n{report.longrepr}\n")
    fails = config.getoption("--inconclusive") == "fail"
    told = "so the run fails; --inconclusive=pass lets it pass" if fails else "which lets the run pass"
    terminalreporter.write_line(f"{len(reports)} inconclusive: neither borne out nor refuted, {told}.")


class Sweeps:
    """The sweeps of a session: each is played once, whoever asks for it.

    Args:
        config: The session's options.
    """

    def __init__(self, config: pytest.Config) -> None:
        self._workers: int | None = config.getoption("--compare-workers")
        self._most: int | None = config.getoption("--compare-scenarios")
        given = config.getoption("--compare-store")
        self._folder = Path(given) if given else config.rootpath / "runs" / "compare"
        self._found: dict[tuple[Any, ...], tuple[EpisodeRecord, ...]] = {}

    def places(self, names: Sequence[str], parameters: dict[str, Any], catalog: Catalog) -> tuple[SceneRef, ...]:
        """The scenes that a mark names.

        Raises:
            InputError: There is no such scenario or family.
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
        self, planners: tuple[str, ...], places: tuple[SceneRef, ...], seeds: int, catalog: Catalog, require: str = ""
    ) -> tuple[EpisodeRecord, ...]:
        """The episodes, played now where the store does not have them."""
        from ..compare import Store, SweepOptions, sweep

        key = (planners, places, seeds, catalog.project, require)
        if key not in self._found:
            with Store(self._folder) as store, _alone(self._folder):
                done = sweep(
                    planners,
                    places,
                    range(1, seeds + 1),
                    catalog=catalog,
                    store=store,
                    options=SweepOptions(workers=self._workers, require=require),
                )
                self._found[key] = tuple(done.records())
        return self._found[key]


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """While another process of the session plays, wait: what both need is then there."""
    with closing(sqlite3.connect(folder / "lock.sqlite", timeout=_WAIT, isolation_level=None)) as lock:
        lock.execute("begin exclusive")
        yield


@pytest.fixture(scope="session")
def _sweeps(pytestconfig: pytest.Config) -> Sweeps:
    return Sweeps(pytestconfig)


@pytest.fixture
def comparison(request: pytest.FixtureRequest, _sweeps: Sweeps) -> Claims:
    """The episodes of the planners and scenarios with which the test is marked; see `rocs_bt.testing.claims.Claims`.

    Planners and scenarios are those of the project around the test, and ours.
    """
    from ..catalog import Catalog
    from ..compare import Comparison
    from .claims import Claims

    planners, scenarios = (request.node.get_closest_marker(name) for name in ("planners", "scenarios"))
    if planners is None or scenarios is None or not planners.args or not scenarios.args:
        raise pytest.UsageError(
            f"{request.node.nodeid} uses `comparison`, so it needs both marks: "
            '@pytest.mark.planners("tree") and @pytest.mark.scenarios("exp1", seeds=20).'
        )
    catalog = Catalog.here(request.path.parent)
    seeds = int(scenarios.kwargs.get("seeds", 1))
    places = _sweeps.places(scenarios.args, scenarios.kwargs.get("parameters", {}), catalog)
    compared: Comparison = Comparison(_sweeps.records(planners.args, places, seeds, catalog))

    def check(planner: str, requirement: str) -> Sequence[EpisodeRecord]:
        compared.of(planner)
        return _sweeps.records((planner,), places, seeds, catalog, requirement)

    return Claims(compared, check)
