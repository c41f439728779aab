"""One episode of a sweep again, this time with its recording and its report."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .._run import run
from ..catalog import Catalog, PlannerSpec
from ..errors import Fault, InputError
from ..simulation import RunResult
from .episode import FamilyScene, ScenarioScene, SceneRef
from .record import EpisodeRecord
from .runner import EpisodeRunner

_FAMILY_SCENE = re.compile(r"(?P<family>[A-Za-z]\w*)(?:\((?P<parameters>.*)\))?-(?P<index>\d+)")


def replay_command(record: EpisodeRecord) -> str:
    """What a person types to play an episode again and look at it."""
    return episode_command(record.planner, record.scene, record.seed)


def episode_command(planner: str, scene: str, seed: int) -> str:
    """What a person types to play a planner in a scene, by the names that records have for both."""
    return shlex.join(["rocs-bt", "episode", planner, scene, "--seed", str(seed)])


def scene_by_name(name: str, catalog: Catalog) -> SceneRef:
    """A scene by the name that records have for it: `barn_like-17`, `crowd(people=12)-17`, `exp1`, `exp3:R2`.

    Raises:
        InputError: There is no such scenario, and the name is not that of a family's scene.
    """
    scenario, _, agent = name.partition(":")
    if any(entry.name == scenario for entry in catalog.list("scenario")) or scenario.endswith(".toml"):
        return ScenarioScene(scenario, agent)
    if (found := _FAMILY_SCENE.fullmatch(name)) is None:
        hint = "Give a scenario, or a scene of a family, such as barn_like-17."
        raise InputError(Fault(f"there is no scenario '{name}', and it is no scene of a family.", hint=hint))
    catalog.find("family", found["family"])
    told = [each.partition("=") for each in re.split(r",\s*", found["parameters"] or "") if each]
    parameters = tuple(sorted((key, parse_value(text)) for key, _, text in told))
    return FamilyScene(found["family"], int(found["index"]), parameters)


def replay_episode(planner: PlannerSpec | str, scene: str, seed: int, catalog: Catalog, out: Path) -> RunResult:
    """Play one episode with summary.json, run.mcap and report.html.

    Args:
        planner: Who decides.
        scene: Where, by the name that records have for it.
        seed: The episode's seed.
        catalog: Where content is found.
        out: The folder to write to.

    Raises:
        InputError: There is no such planner or scene, or something in it is wrong.
    """
    chosen = catalog.load_planner(planner) if isinstance(planner, str) else planner
    prepared = EpisodeRunner(catalog.project).prepare(scene_by_name(scene, catalog))
    again = episode_command(chosen.name, scene, seed)
    return run(prepared.with_planner(chosen), prepared.catalog, seed=seed, out=out, command=again)


def parse_parameters(texts: Sequence[str]) -> dict[str, Any]:
    """Parameters as a command line has them: each is NAME=VALUE, with its unit.

    Raises:
        InputError: One sets nothing.
    """
    given = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not name or not equals or not value:
            raise InputError(Fault(f"--set takes NAME=VALUE, found '{text}'.", hint="Such as --set people=12."))
        given[name] = parse_value(value)
    return given


def parse_value(text: str) -> Any:
    """A parameter as it was given: a number, or a text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
