"""The pytest plugin: the fixture `run_scenario`.

def test_the_robot_arrives(run_scenario):
    result = run_scenario("first", seed=3)
    assert result.outcomes == {"R1": "success"}
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from ..simulation import RunResult


@pytest.fixture
def run_scenario(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., RunResult]:
    """Runs a scenario of the project around the test, or a shipped one, in lockstep.

    The function takes the scenario's name or path, `seed` (default 1) and `duration` [s] (default: the scenario's),
    and returns the run's result; its `recording` can be opened.
    """

    def run_scenario(scenario: str, *, seed: int = 1, duration: float | None = None) -> RunResult:
        # Imported here, as pytest loads the plugin in every session, also in those that never simulate.
        from ..catalog import Catalog
        from ..simulation import run

        catalog = Catalog.here(request.path.parent)
        out = tmp_path_factory.mktemp("run")
        return run(catalog.load_scenario(scenario), catalog, seed=seed, out=out, duration=duration, report=False)

    return run_scenario
