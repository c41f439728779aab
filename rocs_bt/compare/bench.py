"""Bench: where episodes are played, one after the other, with everything kept that they share."""

from __future__ import annotations

import tempfile
from collections import OrderedDict
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from .._run import run
from ..catalog import AgentSpec, KeepingCatalog, PlannerSpec, RequirementSpec, ScenarioSpec
from ..errors import InputError, unknown
from ..plan import Mission, mission_arguments
from ..simulation import Build
from .family import AGENT, load_family
from .metric import Measured, measure_all
from .probe import Probe
from .record import EpisodeRecord
from .trial import FamilyScene, Place, ScenarioScene, Trial

SCENES = 4
"""How many scenes stay set up at a time: a sweep goes from scene to scene."""


@dataclass(frozen=True)
class Setting:
    """A scene that is ready to be played.

    Attributes:
        catalog: Where its content is found.
        scenario: The scenario, whoever plans in it.
        agent: Whose planner is compared.
        reference_length: How long a shortest way from start to goal is, as far as is known [m].
        difficulty: How hard it is, by measure.
        told: What only an oracle is told.
    """

    catalog: KeepingCatalog
    scenario: ScenarioSpec
    agent: str
    reference_length: float
    difficulty: Mapping[str, float] = field(default_factory=dict)
    told: Mapping[str, Any] = field(default_factory=dict)

    def missions(self, planner: PlannerSpec) -> dict[str, Build] | None:
        """The mission of an oracle, which is told what only an oracle is told, for `run`; None for other planners."""
        if not planner.oracle:
            return None
        build = self.catalog.load_mission(planner.mission, planner.nodes)
        arguments = mission_arguments(build, planner.parameters)

        def told_build(mission: Mission) -> Any:
            mission.told = self.told
            return build(mission, **arguments)

        return {self.agent: told_build}


class Bench:
    """Plays episodes. It keeps catalogs, compiled worlds and rules; what it plays is the same with and without.

    Args:
        project: The project in which content is found; None for shipped content.
        code: Whether Python content may run.
    """

    def __init__(self, project: Path | None = None, *, code: bool = True) -> None:
        self.catalog = KeepingCatalog(project, code=code)
        self._settings: OrderedDict[Place, tuple[Setting, ExitStack]] = OrderedDict()

    def setting(self, place: Place) -> Setting:
        """A scene, made or found.

        Raises:
            InputError: There is no such scenario, family or agent, or something in it is wrong.
        """
        if place in self._settings:
            self._settings.move_to_end(place)
            return self._settings[place][0]
        stack = ExitStack()
        made = self._of_family(place, stack) if isinstance(place, FamilyScene) else self._of_scenario(place)
        self._settings[place] = made, stack
        if len(self._settings) > SCENES:
            self._settings.popitem(last=False)[1][1].close()
        return made

    def play(self, trial: Trial) -> EpisodeRecord:
        """Play one episode in lockstep, without a recording.

        Raises:
            InputError: Something in the content is wrong.
            RocsError: The engine failed.
        """
        setting, planner = self.setting(trial.place), trial.planner
        scenario, agent = planner.drives(setting.scenario, setting.agent), setting.agent
        if trial.require:
            asked = RequirementSpec(trial.require, trial.require, (agent,))
            scenario = replace(scenario, requirements=(*scenario.requirements, asked))
        probe = Probe(agent)
        summary = run(
            scenario,
            setting.catalog,
            seed=trial.seed,
            report=False,
            missions=setting.missions(planner),
            prepare=probe.prepare,
            sinks=[probe],
        ).summary
        result = summary.agents[agent]
        measured = Measured(
            outcome=result.outcome,
            time_limit=scenario.duration,
            reference_length=setting.reference_length,
            agent=result,
            way=probe.way(),
            clearances=probe.clearances,
            energy=probe.energy,
        )
        return EpisodeRecord(
            key=trial.key,
            planner=planner.name,
            family=trial.place.group,
            scene=trial.place.name,
            seed=trial.seed,
            outcome=result.outcome,
            reason=result.reason,
            metrics=measure_all(measured),
            sim_time=summary.sim_time,
            time_limit=scenario.duration,
            difficulty=setting.difficulty,
            track=probe.track(),
            content=summary.content_hash,
            trajectory_hash=summary.trajectory_hash or "",
            reproducible=planner.latency is not None,
        )

    def close(self) -> None:
        """Let go of the scenes."""
        while self._settings:
            self._settings.popitem()[1][1].close()

    def _of_family(self, place: FamilyScene, stack: ExitStack) -> Setting:
        family = load_family(self.catalog, place.family, dict(place.parameters))
        scene = family.scene(place.index)
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rocs_bt-scene-")))
        catalog = self.catalog.with_scenes(folder)
        scenario = catalog.load_scenario(str(scene.write(folder)))
        told = {**scene.extras, "reference": scene.reference}
        return Setting(catalog, scenario, AGENT, scene.reference_length, scene.difficulty, told)

    def _of_scenario(self, place: ScenarioScene) -> Setting:
        catalog = self.catalog if place.folder is None else self.catalog.with_scenes(place.folder)
        scenario = catalog.load_scenario(place.scenario)
        names = [agent.name for agent in scenario.agents]
        name = place.agent or names[0]
        if name not in names:
            raise InputError(unknown("agent", name, names, f"The scenario '{scenario.name}'"))
        (agent,) = (each for each in scenario.agents if each.name == name)
        return Setting(catalog, scenario, name, _shortest(scenario, agent))


def _shortest(scenario: ScenarioSpec, agent: AgentSpec) -> float:
    """The shortest way from an agent's start to its goal [m]: as the scenario tells, or straight; 0 without a goal."""
    if agent.shortest is not None:
        return agent.shortest
    goals = [place.pose for place in scenario.places if place.name == agent.success]
    return agent.pose.distance(goals[0]) if goals else 0.0
