"""The P3DX's mind on mock devices."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from rocs_bt.agent import Agent, Mind
from rocs_bt.catalog import Catalog, PlaceSpec
from rocs_bt.clock import Clock
from rocs_bt.event import ListSink
from rocs_bt.geometry import Pose2
from rocs_bt.testing.mock_agent import MockStage, mock_agent

GOAL = PlaceSpec("goal", "goal", Pose2(50.0, 0.0), 0.1, ("R1",))


def go(mission: Any) -> Any:
    """The mission: drive on and on."""
    return mission.act("GoTo", goal="goal")


class Ahead:
    """What the sonar hears ahead [m]; everything else is far away."""

    def __init__(self, stage: MockStage) -> None:
        self._sonar: Any = stage.sensors["sonar"]
        self._count = 0
        self(math.inf)

    def __call__(self, distance: float) -> None:
        self._count += 1  # a sound sensor never says the same twice
        noise = 1e-6 * self._count
        beams = [1.5 + noise] * 16
        for beam in (3, 4):
            beams[beam] = min(distance, 1.5) + noise
        self._sonar.values = beams


@pytest.fixture(scope="session")
def p3dx() -> Any:
    return Catalog().load_robot("pioneer_p3dx")


@pytest.fixture(scope="session")
def rules() -> list[Any]:
    return [Catalog().find("rules", "avoid_collision").path]


@pytest.fixture
def make_agent(p3dx: Any, rules: list[Any]) -> Callable[..., tuple[Agent, MockStage, ListSink, Ahead]]:
    def make(clock: Clock, build: Callable[..., Any] = go, **kwargs: Any) -> tuple[Agent, MockStage, ListSink, Ahead]:
        sink = ListSink()
        mind = Mind(build, rules=rules, places=[GOAL], **kwargs.pop("mind", {}))
        agent, stage = mock_agent(p3dx, mind, clock, sink, **kwargs)
        return agent, stage, sink, Ahead(stage)

    return make
