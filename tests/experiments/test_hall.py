"""The hall: a robot without a map drives through a hall in which eight people walk."""

import pytest

from rocs_bt import run
from rocs_bt.event import ContactBegan, ListSink


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(2, 12))])
def test_the_robot_drives_through_the_hall_and_into_none_of_the_people(seed: int) -> None:
    sink = ListSink()
    summary = run("hall", seed=seed, sinks=[sink], report=False).summary
    found = summary.agents["R"]
    assert found.outcome == "success"
    assert found.collisions == 0
    contacts = [event for event in sink.events if isinstance(event, ContactBegan)]
    assert not contacts, "polite people and the robot make way for each other"
