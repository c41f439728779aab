"""Check of planners before a sweep or a search: what `check` calls an error in a scene is refused."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..base.errors import Fault, InputError
from ..catalog import Catalog, PlannerSpec
from ..check import check_scenario
from ..declare import replaced
from .episode import FamilyScene, ScenarioScene, SceneRef
from .runner import EpisodeRunner


def check_planners(planners: Sequence[PlannerSpec], scenes: Iterable[SceneRef], catalog: Catalog) -> tuple[Fault, ...]:
    """Check each planner in each scenario, in the first scene of each family, and in the first generated scene.

    The scenes of a family differ in their worlds only; what a run refuses in one of the others ends the sweep. A
    planner with perturbations is checked without them, because a check compares the world with the robot's own model.
    Returns the warnings, each once.

    Raises:
        InputError: There are errors; contains all of them.
    """
    checked = {
        (p.name.partition("~")[0] if p.perturbations else p.name): replaced(p, perturbations=()) for p in planners
    }
    runner, first = EpisodeRunner(catalog.project, code=catalog.code), dict[object, SceneRef]()
    for scene in scenes:
        group = scene.group if isinstance(scene, (FamilyScene, ScenarioScene)) else type(scene)
        first.setdefault(group, scene)
    errors, warnings = dict[Fault, None](), dict[Fault, None]()
    for scene in first.values():
        try:
            prepared = runner.prepare(scene)
        except InputError:
            if isinstance(scene, ScenarioScene):
                check_scenario(scene.scenario, runner.catalog).refuse()
            raise
        for planner in checked.values():
            try:
                findings = check_scenario(prepared.with_planner(planner), prepared.catalog)
                findings.refuse()
            except InputError as error:
                errors |= dict.fromkeys(error.faults)
            else:
                warnings |= dict.fromkeys(findings.warnings)
    if errors:
        raise InputError(*errors)
    return tuple(warnings)
