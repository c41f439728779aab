"""Repetition of one episode of a sweep, with a recording and a report."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .._run import run
from ..base.errors import Fault, InputError
from ..catalog import Catalog, PlannerSpec, ScenarioSpec
from ..running import RunResult
from .episode import FamilyScene, ScenarioScene, SceneRef
from .record import EpisodeRecord
from .runner import EpisodeRunner

_FAMILY_SCENE = re.compile(r"(?P<family>[A-Za-z]\w*)(?:\((?P<parameters>.*)\))?-(?P<index>\d+)")


def replay_command(record: EpisodeRecord) -> str:
    """Shell command that plays an episode again."""
    return f"{episode_command(record.planner, record.scene)} --seed {record.seed}"


def episode_command(planner: str, scene: str) -> str:
    """Shell command that plays an episode, without its seed; planner and scene have the names that records contain."""
    return shlex.join(["rocs-bt", "run", scene, "--planner", planner])


def episode_folder(planner: str, scene: str, seed: int) -> Path:
    """Default folder of the files of an episode that is played again."""
    return Path("runs") / re.sub(r"[^\w.=-]+", "_", f"{planner}-{scene}-{seed}")


def both_command(one: EpisodeRecord, other: EpisodeRecord) -> str:
    """Shell command that shows two episodes over each other on one page, after both were played again."""
    folders = (str(episode_folder(each.planner, each.scene, each.seed)) for each in (one, other))
    return shlex.join(["rocs-bt", "plot", *folders, "--out", str(recorded_page(one, other).parent)])


def recorded_page(one: EpisodeRecord, other: EpisodeRecord | None = None) -> Path:
    """Page of an episode that was played again, or of two over each other; the file need not exist."""
    folders = [episode_folder(each.planner, each.scene, each.seed) for each in (one, other) if each is not None]
    return folders[0] / ("report.html" if other is None else f"with_{folders[1].name}/both.html")


def scene_by_name(name: str, catalog: Catalog) -> SceneRef:
    """Scene with a name as records contain it: `barn_like-17`, `crowd(density=dense)-17`, `exp1`, `exp3:R2`.

    Raises:
        InputError: The name is neither that of a scenario nor that of a scene of a family.
    """
    scenario, _, agent = name.partition(":")
    if any(entry.name == scenario for entry in catalog.list("scenario")) or scenario.endswith(".toml"):
        return ScenarioScene(scenario, agent)
    if (found := _FAMILY_SCENE.fullmatch(name)) is None:
        hint = "Name a scenario, or a scene of a family, such as barn_like-17."
        raise InputError(Fault(f"'{name}' is neither a scenario nor a scene of a family.", hint=hint))
    catalog.find("family", found["family"])
    given = [each.partition("=") for each in re.split(r",\s*", found["parameters"] or "") if each]
    parameters = tuple(sorted((key, parse_value(text)) for key, _, text in given))
    return FamilyScene(found["family"], int(found["index"]), parameters)


def replay_episode(planner: PlannerSpec | str, scene: str, seed: int, catalog: Catalog, out: Path) -> RunResult:
    """Play one episode and write summary.json, run.mcap and report.html.

    Raises:
        InputError: The planner or scene does not exist, or its content is invalid.
    """
    chosen = catalog.load_planner(planner) if isinstance(planner, str) else planner
    scenario, content = episode_scenario(chosen, scene, catalog)
    return run(scenario, content, seed=seed, out=out, command=episode_command(chosen.name, scene))


def episode_scenario(planner: PlannerSpec, scene: str, catalog: Catalog) -> tuple[ScenarioSpec, Catalog]:
    """Scenario of an episode, with its planner, and the catalog of its content.

    Raises:
        InputError: The scene does not exist, or its content is invalid.
    """
    prepared = EpisodeRunner(catalog.project, code=catalog.code).prepare(scene_by_name(scene, catalog))
    return prepared.with_planner(planner), prepared.catalog


def parse_parameters(texts: Sequence[str]) -> dict[str, Any]:
    """Parameters from command-line texts of the form NAME=VALUE, with units.

    Raises:
        InputError: A text does not have this form.
    """
    given = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not name or not equals or not value:
            raise InputError(Fault(f"--set takes NAME=VALUE, found '{text}'.", hint="Example: --set people=12."))
        given[name] = parse_value(value)
    return given


def parse_value(text: str) -> Any:
    """Convert the text of a parameter value to an integer or a float if possible; else return the text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
