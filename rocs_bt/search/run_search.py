"""Search: sample scenes of a family until a planner fails in one, then simplify (shrink) that scene."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ..base.errors import Fault, InputError
from ..catalog import CachingCatalog, Catalog, PlannerSpec
from ..compare.check_planners import check_planners
from ..compare.record import OUTCOMES, EpisodeRecord
from ..compare.run_sweep import WALL_LIMIT, cores, local_pool
from ..compare.store import EpisodeStore
from ..control.footprint import Footprint
from .draft import Draft
from .player import SEED, Player
from .shrink import Shrinking
from .space import SampledScene, SearchSpace

FAILURES = tuple(outcome for outcome in OUTCOMES if outcome not in ("success", "interrupted", "limit"))


@dataclass(frozen=True)
class SearchResult:
    """Result of a search.

    Attributes:
        sampled: Sampled scene in which the planner failed; None if it never failed.
        found: Draft of this scene, without random start offsets (jitter).
        first: Episode in `found`, a failure.
        smallest: Simplified scene in which the planner still fails.
        last: Episode in `smallest`, a failure.
        searched: Number of episodes until the planner failed.
        shrunk: Number of episodes for simplifying the scene.
        done: Whether the simplification finished within the budget.
        warnings: Warnings of the check of the planner in the first sampled scene.
    """

    sampled: SampledScene | None = None
    found: Draft | None = None
    first: EpisodeRecord | None = None
    smallest: Draft | None = None
    last: EpisodeRecord | None = None
    searched: int = 0
    shrunk: int = 0
    done: bool = True
    warnings: tuple[Fault, ...] = ()


@dataclass(frozen=True, kw_only=True)
class SearchOptions:
    """Options of a search.

    Attributes:
        name: Name of the resulting scene; derived from planner and family if empty.
        failures: Outcomes that count as failures; all but success by default.
        budget: Maximum number of episodes.
        seed: Seed of the sampling.
        workers: Number of local processes; None for one per core.
        wall_limit: Maximum wall-clock time of an episode [s].
        warned: Function called before the first episode with the warnings of the check.
    """

    name: str = ""
    failures: tuple[str, ...] = FAILURES
    budget: int = 300
    seed: int = 1
    workers: int | None = None
    wall_limit: float = WALL_LIMIT
    warned: Callable[[Sequence[Fault]], None] = lambda warnings: None


def search(
    planner: PlannerSpec,
    space: SearchSpace,
    options: SearchOptions | None = None,
    *,
    catalog: Catalog | None = None,
    store: EpisodeStore | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> SearchResult:
    """Sample scenes until a planner fails in one, then simplify that scene while the planner still fails.

    Equal arguments give equal results for any number of processes; episodes in the store are not played again.

    Args:
        planner: Planner under test.
        space: Family and ranges of its parameters, from which scenes are sampled.
        options: Options.
        catalog: Source of content; the project around the current folder by default.
        store: Store of episodes; in memory by default.
        executor: Executor of the episodes; local processes by default.
        progress: Callback with the number of counted episodes.

    Raises:
        InputError: `rocs-bt check` finds errors in a sampled scene, no parameters in the ranges give a scene, or the
            planner is an oracle.
    """
    if planner.oracle:
        message = f"'{planner.name}' is an oracle, which gets the family's map; shrinking would change the map."
        raise InputError(Fault(message, hint="Search with a planner that is not an oracle."))
    options, home = options or SearchOptions(), catalog or Catalog.here()
    keeping = CachingCatalog(home.project, code=home.code)
    with ExitStack() as stack:
        pool = executor or stack.enter_context(local_pool(options.workers or cores()))
        kept = stack.enter_context(EpisodeStore()) if store is None else store
        player = Player(planner, keeping, kept, pool, options.budget, options.wall_limit, progress)
        sampled: dict[Draft, SampledScene] = {}
        name = options.name or default_name(planner, space)
        drafts = _drafts(space, planner, name, options.seed, sampled)
        first = next(drafts)
        warnings = check_planners([planner], [first.scene_ref], keeping)
        options.warned(warnings)
        found = player.first(
            chain([first], drafts), lambda record: record.outcome in options.failures, skip_invalid=False
        )
        if found is None:
            return SearchResult(searched=player.count, warnings=warnings)
        searched = player.count
        robot = keeping.load_robot(found[0].robot)
        shrinking = Shrinking(player, *found, Footprint(robot.body.length, robot.body.width))
        shrinking.run()
    return SearchResult(
        sampled[found[0]],
        *found,
        shrinking.draft,
        shrinking.record,
        searched,
        player.count - searched,
        player.count < options.budget,
        warnings,
    )


def default_name(planner: PlannerSpec, space: SearchSpace) -> str:
    """Default name of the scene that a search finds."""
    plain = re.sub(r"[^\w-]+", "_", planner.name).strip("_")  # of PLANNER@ROBOT
    return f"{plain}_in_{space.family.name}"


def _drafts(
    space: SearchSpace, planner: PlannerSpec, name: str, seed: int, sampled: dict[Draft, SampledScene]
) -> Iterator[Draft]:
    """Yield drafts of sampled scenes without end; `sampled` receives the sampled scene of each draft."""
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    while True:
        made = space.sample(rng)
        doc = f"{planner.name} fails here. Shrunk by a search from {made.scene.name}."
        draft = Draft.of(made.scene, name, doc, planner.robot)
        sampled[draft] = made
        yield draft


__all__ = ["FAILURES", "SEED", "SearchOptions", "SearchResult", "default_name", "search"]
