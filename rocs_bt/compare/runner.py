"""Bench: where episodes are played one after the other, with all that they share kept; and what a worker does."""

from __future__ import annotations

import faulthandler
import math
import multiprocessing
import threading
import time
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .._run import run
from ..catalog import AgentSpec, CachingCatalog, PlannerSpec, RequirementSpec, ScenarioSpec
from ..drivers.mujoco import MujocoWorld
from ..errors import InputError, unknown
from ..event import BodyMoved, Event, unpack
from ..simulation import SimulatedWorld
from .episode import Episode, FamilyScene, ScenarioScene, SceneRef
from .family import AGENT, load_family
from .metric import METRICS, ZERO_ON_FAILURE, EpisodeData, measure_all
from .record import EpisodeRecord
from .store import Cost

SCENES = 4
"""How many scenes stay set up at a time: a sweep goes from scene to scene."""


@dataclass(frozen=True)
class PreparedScene:
    """A scene that is ready to be played.

    Attributes:
        catalog: Where its content is found.
        scenario: The scenario, whoever plans in it.
        agent: Whose planner is compared.
        reference_length: How long a shortest way from start to goal is, as far as is known [m].
        difficulty: How hard it is, by measure.
        privileged: Information for oracle planners only.
    """

    catalog: CachingCatalog
    scenario: ScenarioSpec
    agent: str
    reference_length: float
    difficulty: Mapping[str, float] = field(default_factory=dict)
    privileged: Mapping[str, Any] = field(default_factory=dict)

    def with_planner(self, planner: PlannerSpec) -> ScenarioSpec:
        """The scenario in which a planner is the mind of the agent; an oracle is told what it may know."""
        return planner.drives(self.scenario, self.agent, self.privileged)


class EpisodeRunner:
    """Plays episodes. It keeps catalogs, compiled worlds and rules; what it plays is the same with and without.

    Args:
        project: The project in which content is found; None for shipped content.
        code: Whether Python content may run.
    """

    def __init__(self, project: Path | None = None, *, code: bool = True) -> None:
        self.catalog = CachingCatalog(project, code=code)
        self._prepared: OrderedDict[SceneRef, PreparedScene] = OrderedDict()

    def prepare(self, scene: SceneRef) -> PreparedScene:
        """A scene, made or found.

        Raises:
            InputError: There is no such scenario, family or agent, or something in it is wrong.
        """
        if scene not in self._prepared:
            self._prepared[scene] = self._prepare(scene)
            if len(self._prepared) > SCENES:
                self._prepared.popitem(last=False)
        self._prepared.move_to_end(scene)
        return self._prepared[scene]

    def play(self, episode: Episode) -> EpisodeRecord:
        """Play one episode in lockstep, without a recording.

        Raises:
            InputError: Something in the content is wrong.
            RocsError: The engine failed.
        """
        prepared, planner = self.prepare(episode.scene), episode.planner
        scenario, agent = prepared.with_planner(planner), prepared.agent
        if episode.require:
            asked = RequirementSpec(episode.require, episode.require, (agent,))
            scenario = replace(scenario, requirements=(*scenario.requirements, asked))
        sink = MetricSink(agent)
        summary = run(
            scenario,
            prepared.catalog,
            seed=episode.seed,
            report=False,
            prepare=sink.prepare,
            sinks=[sink],
        ).summary
        result = summary.agents[agent]
        measured = EpisodeData(
            outcome=result.outcome,
            time_limit=scenario.duration,
            reference_length=prepared.reference_length,
            agent=result,
            path=sink.path(),
            clearances=sink.clearances,
            energy=sink.energy,
        )
        return EpisodeRecord(
            key=episode.key,
            planner=planner.name,
            family=episode.scene.group,
            scene=episode.scene.name,
            seed=episode.seed,
            outcome=result.outcome,
            reason=result.reason,
            metrics=measure_all(measured),
            sim_time=summary.sim_time,
            time_limit=scenario.duration,
            difficulty=prepared.difficulty,
            track=sink.track(),
            content=summary.content_hash,
            trajectory_hash=summary.trajectory_hash or "",
            reproducible=planner.latency is not None,
        )

    def _prepare(self, ref: SceneRef) -> PreparedScene:
        if isinstance(ref, ScenarioScene):
            return self._prepare_scenario(ref)
        if isinstance(ref, FamilyScene):
            scene = load_family(self.catalog, ref.family, dict(ref.parameters)).scene(ref.index)
        else:
            scene = ref.scene
        catalog = scene.added_to(self.catalog)
        scenario = catalog.load_scenario(scene.name)
        length = scene.reference_length or _shortest(scenario, _agent(scenario, AGENT))
        return PreparedScene(catalog, scenario, AGENT, length, scene.difficulty, scene.privileged)

    def _prepare_scenario(self, ref: ScenarioScene) -> PreparedScene:
        scenario = self.catalog.load_scenario(ref.scenario)
        agent = _agent(scenario, ref.agent)
        return PreparedScene(self.catalog, scenario, agent.name, _shortest(scenario, agent))


def _agent(scenario: ScenarioSpec, name: str) -> AgentSpec:
    """An agent of a scenario by its name; the first one where the name is empty."""
    agents = {agent.name: agent for agent in scenario.agents}
    wanted = name or scenario.agents[0].name
    if wanted not in agents:
        raise InputError(unknown("agent", wanted, agents, f"The scenario '{scenario.name}'"))
    return agents[wanted]


def _shortest(scenario: ScenarioSpec, agent: AgentSpec) -> float:
    """The shortest way from an agent's start to its goal [m]: as the scenario tells, or straight; 0 without a goal."""
    if agent.shortest is not None:
        return agent.shortest
    goals = [place.pose for place in scenario.places if place.name == agent.success]
    return agent.pose.distance(goals[0]) if goals else 0.0


STEP = 0.05
"""How much of its way lies between two looks at the clearance, and two positions of the way [m]."""

TRACK = 0.1
"""How much of its way lies between two positions that are kept for pictures [m]."""


class MetricSink:
    """Watches one agent of a run in lockstep.

    Args:
        agent: Its name.

    Attributes:
        clearances: How near its hull was to anything but the floor, at each STEP of its way [m].
        energy: What it spent on gathering speed [J/kg]; None for a robot whose wheels nobody measures.
    """

    def __init__(self, agent: str) -> None:
        self.agent = agent
        self.clearances: list[float] = []
        self.energy: float | None = None
        self._world: MujocoWorld | None = None
        self._points: list[tuple[float, float]] = []
        self._driven = 0.0
        self._next = 0.0
        self._kinetic: float | None = None

    def prepare(self, stage: SimulatedWorld) -> None:
        """Take note of the world; for `run`'s argument of that name."""
        self._world = stage.world

    def emit(self, event: Event) -> None:
        """Look, where the event says that the agent was moved."""
        if not isinstance(event, BodyMoved) or event.agent != self.agent:
            return
        if self._points:
            self._driven += math.dist(self._points[-1], (event.x, event.y))
        self._points.append((event.x, event.y))
        if self._world is not None and self._driven >= self._next:
            self.clearances.append(self._world.clearance(self.agent)[0])
            self._next = self._driven + STEP
        if event.wheels:
            self._weigh(unpack(event.wheels))

    def path(self, step: float = STEP) -> npt.NDArray[np.float64]:
        """(n, 2) Where it was, at equal steps of its way [m]: the same way gives the same, however it was sampled."""
        points = np.array(self._points, dtype=float).reshape(-1, 2)
        if len(points) < 2:
            return points
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        at = np.arange(0.0, along[-1], step)
        return np.column_stack([np.interp(at, along, points[:, axis]) for axis in (0, 1)])

    def track(self) -> bytes:
        """Where it was about every TRACK of its way, and at the end: (n, 2) float32 as bytes."""
        return np.vstack([self.path(TRACK), *self._points[-1:]]).astype(np.float32).tobytes()

    def _weigh(self, rims: list[float]) -> None:
        """Add what the drive's speed gained since the last look: half the mean square of its rims' speeds."""
        kinetic = sum(v * v for v in rims) / (2.0 * len(rims))
        self.energy = (self.energy or 0.0) + max(kinetic - (kinetic if self._kinetic is None else self._kinetic), 0.0)
        self._kinetic = kinetic


_ONE_AT_A_TIME = threading.Lock()  # a process plays one episode at a time, however many threads an executor has in it


def run_episode(episode: Episode) -> tuple[EpisodeRecord, Cost]:
    """Play a trial. An episode that breaks down is a record as well, with the outcome `error`.

    In a process that an executor started a trial that takes longer than its wall limit ends that process, even where
    it hangs in C code that holds the interpreter: whoever started it does the rest.

    Raises:
        InputError: Something in the content is wrong, so that no other episode would do better.
    """
    with _ONE_AT_A_TIME, _limited(episode.wall_limit):
        wall, cpu = time.perf_counter(), time.process_time()
        runner = _process_runner(episode.project, episode.code)
        limit = runner.prepare(episode.scene).scenario.duration
        try:
            record = runner.play(episode)
        except InputError:
            raise
        except Exception as error:  # noqa: BLE001 - the process's boundary: one broken episode must not end a sweep
            record = error_record(episode, f"{type(error).__name__}: {error}", limit, reproducible=True)
        return record, Cost(time.perf_counter() - wall, time.process_time() - cpu)


def error_record(episode: Episode, reason: str, time_limit: float, *, reproducible: bool) -> EpisodeRecord:
    """The record of an episode that did not come to an end: a failure, of which nothing else is known.

    Args:
        episode: What was to be played.
        reason: Why it broke down.
        time_limit: T_max [s]; 0 where that is not known either.
        reproducible: Whether it would break down again.
    """
    time = time_limit if time_limit > 0.0 else None
    return EpisodeRecord(
        key=episode.key,
        planner=episode.planner.name,
        family=episode.scene.group,
        scene=episode.scene.name,
        seed=episode.seed,
        outcome="error",
        reason=reason,
        metrics={**dict.fromkeys(METRICS), **dict.fromkeys(ZERO_ON_FAILURE, 0.0), "time": time},
        time_limit=time_limit,
        reproducible=reproducible,
    )


@lru_cache(maxsize=1)
def _process_runner(project: Path | None, code: bool) -> EpisodeRunner:
    """This process's bench."""
    return EpisodeRunner(project, code=code)


@contextmanager
def _limited(seconds: float) -> Iterator[None]:
    """End this process, where it is nobody's main one, unless the block is done in time [s]."""
    if multiprocessing.parent_process() is None:
        yield
        return
    # faulthandler's clock is a thread in C that needs no interpreter lock; it tells on stderr where the process hung.
    faulthandler.dump_traceback_later(seconds, exit=True)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
