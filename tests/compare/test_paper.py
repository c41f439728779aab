"""Which of many runs is drawn."""

from __future__ import annotations

import json
from dataclasses import asdict

import pytest

from rocs_bt.compare.paper import _plain, numbers_of, typical


def run(seed: int, *agents: tuple[str, int]) -> dict:
    """A summary: outcome and switches of each agent."""
    told = {f"R{i}": {"outcome": outcome, "route_switches": n} for i, (outcome, n) in enumerate(agents)}
    return {"seed": seed, "agents": told}


GOOD, BAD = "success", "collision"


@pytest.mark.parametrize(
    ("runs", "seed", "among"),
    [
        ([run(1, (GOOD, 9)), run(2, (GOOD, 2)), run(3, (GOOD, 4)), run(4, (BAD, 4)), run(5, (GOOD, 0))], 3, "(3)"),
        ([run(1, (GOOD, 4)), run(2, (GOOD, 4))], 1, "of the runs that succeed and in which both routes act (2)"),
        ([run(1, (GOOD, 0), (GOOD, 0)), run(2, (GOOD, 3), (GOOD, 0))], 2, "in which a reflex acts (1)"),
        ([run(1, (GOOD, 9), (GOOD, 0)), run(2, (GOOD, 1), (GOOD, 1))], 2, "in which both routes act (1)"),
        ([run(1, (BAD, 7)), run(2, (BAD, 3))], 2, "of the runs there are (2)"),
    ],
)
def test_the_run_with_the_median_number_of_switches_is_drawn(runs, seed, among):
    found, words = typical(runs)
    assert found["seed"] == seed
    assert among in words


def test_an_end_that_nobody_knows_is_null_for_a_script():
    agent = {
        "outcome": GOOD, "collisions": 0, "struck": 1, "route_switches": 2, "time_reactive": 1.0,
        "time_deliberative": 3.0, "following": {"distance_error": 0.25},
    }  # fmt: skip
    alone = {"sim_time": 60.0, "agents": {"R3": {**agent, "following": {"distance_error": None}}}}
    found = numbers_of([{"sim_time": 60.0, "agents": {"R3": agent}}, alone], "R3")
    told = json.loads(json.dumps(_plain(asdict(found)), allow_nan=False))
    assert told["distance_error"] == {"value": 0.25, "low": None, "high": None, "of": 1}
    assert told["struck"]["value"] == 1.0
