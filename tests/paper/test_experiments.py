"""Which of many runs is drawn."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import pytest

from benchmarks.paper.experiments import _plain, numbers_of, typical
from rocs_bt.record import AgentResult, Following, Summary


def summary(agents: dict[str, AgentResult], seed: int = 1) -> Summary:
    return Summary(scenario="exp1", seed=seed, mode="lockstep", sim_time=60.0, agents=agents)


def result(outcome: str, switches: int, **more: Any) -> AgentResult:
    return AgentResult(robot="r", mission="m", rules=(), outcome=outcome, route_switches=switches, **more)


def run(seed: int, *agents: tuple[str, int]) -> Summary:
    """A summary: outcome and switches of each agent."""
    return summary({f"R{i}": result(*agent) for i, agent in enumerate(agents)}, seed)


GOOD, BAD = "success", "collision"


@pytest.mark.parametrize(
    ("runs", "seed", "among"),
    [
        ([run(1, (GOOD, 9)), run(2, (GOOD, 2)), run(3, (GOOD, 4)), run(4, (BAD, 4)), run(5, (GOOD, 0))], 3, "(3)"),
        (
            [run(1, (GOOD, 4)), run(2, (GOOD, 4))],
            1,
            "of the runs that succeed with both routes active in each robot (2)",
        ),
        ([run(1, (GOOD, 0), (GOOD, 0)), run(2, (GOOD, 3), (GOOD, 0))], 2, "that succeed with a reflex (1)"),
        ([run(1, (GOOD, 9), (GOOD, 0)), run(2, (GOOD, 1), (GOOD, 1))], 2, "with both routes active in each robot (1)"),
        ([run(1, (BAD, 7)), run(2, (BAD, 3))], 2, "of the runs of this experiment (2)"),
    ],
)
def test_the_run_with_the_median_number_of_switches_is_drawn(runs, seed, among):
    found, words = typical(runs)
    assert found.seed == seed
    assert among in words


def test_an_end_that_nobody_knows_is_null_for_a_script():
    def follower(error: float | None) -> Summary:
        following = Following(
            leader="R2",
            periods=1,
            mean_distance=1.0,
            distance_error=error,
            in_band=1.0,
            too_far=0.0,
            least_distance=1.0,
            least_driving=None,
            safe=True,
        )
        times = {"time_reactive": 1.0, "time_deliberative": 3.0}
        return summary({"R3": result(GOOD, 2, collisions=0, struck=1, following=following, **times)})

    found = numbers_of([follower(0.25), follower(None)], "R3")
    told = json.loads(json.dumps(_plain(asdict(found)), allow_nan=False))
    assert told["distance_error"] == {"value": 0.25, "low": None, "high": None, "of": 1}
    assert told["struck"]["value"] == 1.0
