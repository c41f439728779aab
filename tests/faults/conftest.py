"""EXP1 with something broken, and what came of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest

from rocs_bt import AgentResult, run
from rocs_bt.catalog import Catalog
from rocs_bt.declare import replaced
from rocs_bt.event import BlockFailed, BodyMoved, ContactBegan, Event, SensorFailed
from rocs_bt.running import RunResult
from rocs_bt.simulation import SimulatedWorld


@dataclass
class Outcome:
    """A run with a fault.

    Attributes:
        stage: Its world and devices.
        result: What the run says of itself.
        events: All that happened.
        driven: For each block that failed, whether the wheels were still asked to turn when that was told.
    """

    stage: SimulatedWorld | None = None
    result: RunResult | None = None
    events: list[Event] = field(default_factory=list)
    driven: list[bool] = field(default_factory=list)

    def emit(self, event: Event) -> None:
        """Note an event."""
        self.events.append(event)
        if isinstance(event, BlockFailed):
            self.driven.append(any(any(m.target) for m in self.stage.world._motors["R2"]))

    @property
    def agent(self) -> AgentResult:
        return self.result.summary.agents["R2"]

    def of(self, kind: type) -> list[Any]:
        return [e for e in self.events if isinstance(e, kind)]

    @property
    def touched(self) -> list[str]:
        """What R2 ran into."""
        return [e.other for e in self.of(ContactBegan)]

    @property
    def sensors(self) -> set[str]:
        """Those that were told to have failed."""
        return {e.sensor for e in self.of(SensorFailed)}

    def moved(self, since: float) -> float:
        """How far R2 got from where it was at a time [m]."""
        poses = [e for e in self.of(BodyMoved) if e.agent == "R2" and e.t >= since]
        return max(((e.x - poses[0].x) ** 2 + (e.y - poses[0].y) ** 2) ** 0.5 for e in poses)

    def coast(self) -> float:
        """Let the world move on for a second after the run; how fast R2 then is [m/s]."""
        world = self.stage.world
        world.advance(200)
        return abs(world.twist("R2").forward) + abs(world.twist("R2").turn)


@pytest.fixture(scope="session")
def broken() -> Callable[..., Outcome]:
    """Runs EXP1 with a fault: `prepare` gets the stage, `rules` replaces R2's; the rest is for `run`."""

    def broken(
        prepare: Callable[[SimulatedWorld], None] = lambda stage: None,
        rules: tuple[str, ...] | None = None,
        **kwargs: Any,
    ) -> Outcome:
        outcome = Outcome()

        def begin(stage: SimulatedWorld) -> None:
            outcome.stage = stage
            prepare(stage)

        kwargs = {"seed": 3, "duration": 10.0, "report": False, **kwargs}
        catalog = Catalog()
        spec = catalog.load_scenario("exp1")
        if rules is not None:
            spec = replaced(spec, agents=tuple(replaced(agent, rules=rules) for agent in spec.agents))
        outcome.result = run(spec, catalog, prepare=begin, sinks=[outcome], **kwargs)
        return outcome

    return broken
