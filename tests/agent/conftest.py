"""The P3DX's mind on mock devices."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rocs_bt.agent import Agent, AgentRuntime, Controller
from rocs_bt.base.clock import Clock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, PlaceSpec
from rocs_bt.event import ListSink
from rocs_bt.testing.mock_agent import MockDevices, mock_agent

GOAL = PlaceSpec(name="goal", pose=Pose2(50.0, 0.0), agents=("R1",))


def go(mission: Any) -> Any:
    """The mission: drive on and on."""
    return mission.act("GoTo", goal="goal")


class Ahead:
    """What the sonar hears ahead [m]; everything else is far away. It never says the same twice, as a sound one."""

    def __init__(self, stage: MockDevices) -> None:
        sonar: Any = stage.sensors["sonar"]
        sonar.values = self
        self._distance, self._count = math.inf, 0

    def __call__(self, distance: float) -> None:
        self._distance = distance

    def __iter__(self) -> Iterator[float]:
        self._count += 1
        for beam in range(16):
            yield min(self._distance if beam in (3, 4) else math.inf, 1.5) + 1e-6 * self._count


@pytest.fixture(scope="session")
def p3dx() -> Any:
    return Catalog().load_robot("pioneer_p3dx")


@pytest.fixture(scope="session")
def rules() -> list[Any]:
    return [Catalog().find("rules", "avoid_collision").path]


@pytest.fixture
def make_agent(p3dx: Any, rules: list[Any]) -> Callable[..., tuple[Agent, MockDevices, ListSink, Ahead]]:
    def make(clock: Clock, build: Callable[..., Any] = go, **kwargs: Any) -> tuple[Agent, MockDevices, ListSink, Ahead]:
        sink = ListSink()
        mind = Controller(build, rules=rules, places=[GOAL], **kwargs.pop("mind", {}))
        agent, stage = mock_agent(p3dx, mind, AgentRuntime(clock, sink), **kwargs)
        return agent, stage, sink, Ahead(stage)

    return make
