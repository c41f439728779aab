"""A stage of the shipped EXP1, and a mind that only drives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import pytest

from rocs_bt.base.errors import BlockError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, GroundSpec, ScenarioSpec
from rocs_bt.declare import replaced
from rocs_bt.event import EventSink, ListSink
from rocs_bt.running import LoopResult, RunLoop, SimulatedStage
from rocs_bt.simulation import SimulatedWorld, build_world

from .yard import BOOM, SCENARIO, WEST

Script = Callable[[float], Sequence[float] | None]


@dataclass
class Wheels:
    """A mind that drives by a script: the rim speeds at a time, or None for no command at all."""

    name: str
    stage: SimulatedWorld
    script: Script
    status: str = "RUNNING"
    reason: str = ""
    failure: BlockError | None = None
    running: str = ""
    reflex: str = ""
    held: bool = False
    waiting: bool = False
    stopped: int = 0

    def step(self, count: int) -> None:
        speeds = self.script(self.stage.clock.now())
        if speeds is not None:
            self.stage.actuators[self.name]["wheels"].command(speeds)

    def reading(self, rule: str) -> str:
        return ""

    def brake(self) -> None:
        self.stage.actuators[self.name]["wheels"].neutral()

    def stop(self, by: str = "") -> None:
        self.stopped += 1
        self.stage.actuators[self.name]["wheels"].neutral()


@pytest.fixture(scope="session")
def catalog() -> Catalog:
    return Catalog()


@pytest.fixture(scope="session")
def exp1(catalog: Catalog) -> ScenarioSpec:
    return catalog.load_scenario("exp1")


@pytest.fixture(scope="session")
def make_mind() -> type[Wheels]:
    return Wheels


@pytest.fixture(scope="session")
def play(catalog: Catalog) -> Callable[..., tuple[LoopResult, Wheels, SimulatedWorld]]:
    """Play a scenario with a mind that only drives."""

    def play(
        scenario: ScenarioSpec,
        script: Script,
        sink: EventSink,
        *,
        seed: int = 1,
        duration: float = 5.0,
        change: Callable[[Wheels, float], bool | None] = lambda mind, t: None,
    ) -> tuple[LoopResult, Wheels, SimulatedWorld]:
        stage = build_world(scenario, catalog, seed, sink)
        mind = Wheels("R2", stage, script)

        def watch(t: float) -> bool:
            return change(mind, t) is not False

        place = SimulatedStage(stage, [mind], sink, control=scenario.rate.control_rate)
        episode = RunLoop(place, [mind], sink, duration=duration, between=watch)
        return episode.run(), mind, stage

    return play


@pytest.fixture
def built(exp1, catalog):
    """Build the world of EXP1 without R1, and with other ground."""

    def build(*grounds: GroundSpec, at: Pose2 = WEST, seed: int = 1, sink=None, **changed):
        start = replaced(exp1.agents[0], pose=at, jitter=Pose2(0.0, 0.0, 0.0))
        fields = {"agents": (start,), "actors": (), "world": "arena", "grounds": grounds, **changed}
        return build_world(replaced(exp1, **fields), catalog, seed, sink or ListSink())

    return build


@pytest.fixture
def swinging(tmp_path):
    for folder in ("scenarios/worlds", "planners/missions", "rules", "robots"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "scenarios/worlds/yard.xml").write_text(BOOM)
    wait = '<root BTCPP_format="4"><BehaviorTree ID="wait"><Sleep msec="9000"/></BehaviorTree></root>'
    (tmp_path / "planners/missions/wait.xml").write_text(wait)

    def build(x: float, seed: int = 1):
        (tmp_path / "scenarios/swing.toml").write_text(SCENARIO.format(x=x))
        catalog, sink = Catalog(tmp_path), ListSink()
        return build_world(catalog.load_scenario("swing"), catalog, seed, sink), sink

    return build
