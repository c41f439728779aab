"""Search for trouble: scenes of a family are drawn until a planner fails in one, which is then made small."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np

from ...catalog import CachingCatalog, Catalog, PlannerSpec
from ...control.footprint import Footprint
from ...errors import Fault, InputError
from ..record import OUTCOMES, EpisodeRecord
from ..store import Store
from ..sweep import WALL_LIMIT, cores, local_pool
from .draft import Draft
from .player import SEED, Player
from .shrink import Shrinking
from .space import SampledScene, SearchSpace

FAILURES = tuple(outcome for outcome in OUTCOMES if outcome not in ("success", "interrupted"))


@dataclass(frozen=True)
class SearchResult:
    """What a search came to.

    Attributes:
        drawn: The scene in which the planner failed, as it was drawn; None where it failed in none.
        found: That scene as the search plays it; its start has no jitter.
        first: The episode in it.
        smallest: What is left of it.
        last: The episode in that.
        searched: How many episodes counted until it was found.
        shrunk: How many counted afterwards.
        done: Whether nothing more could be left out; False where the budget was spent before.
    """

    sampled: SampledScene | None = None
    found: Draft | None = None
    first: EpisodeRecord | None = None
    smallest: Draft | None = None
    last: EpisodeRecord | None = None
    searched: int = 0
    shrunk: int = 0
    done: bool = True


@dataclass(frozen=True, kw_only=True)
class SearchOptions:
    """What is sought, and how far.

    Attributes:
        name: The scene's name in the end; planner and family where empty.
        failures: Which outcomes are sought; all but success by default.
        budget: Number of episodes at most.
        seed: Seed of the draws.
        workers: Number of local processes; None for one for each core.
        wall_limit: Longest time to compute an episode [s].
    """

    name: str = ""
    failures: tuple[str, ...] = FAILURES
    budget: int = 300
    seed: int = 1
    workers: int | None = None
    wall_limit: float = WALL_LIMIT


def search(
    planner: PlannerSpec,
    space: SearchSpace,
    options: SearchOptions | None = None,
    *,
    catalog: Catalog | None = None,
    store: Store | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> SearchResult:
    """Draw scenes until a planner fails in one, then make that one as small as can be.

    The same arguments find the same scene, however many processes play; what was played before is in the store.

    Args:
        planner: Who decides.
        space: Where scenes are drawn from.
        options: What is sought, and how far.
        catalog: Where content is found; the project around the current folder by default.
        store: Where episodes are kept; in memory by default.
        executor: Who plays them; local processes by default.
        progress: Told how many episodes have counted.

    Raises:
        InputError: Content is wrong, nothing within the ranges makes a scene, or the planner is an oracle.
    """
    if planner.oracle:
        hint = "Search a planner that senses for itself."
        raise InputError(
            Fault(f"'{planner.name}' is told the map of a family's scene; a search changes it.", hint=hint)
        )
    options, home = options or SearchOptions(), catalog or Catalog.here()
    keeping = CachingCatalog(home.project, code=home.code)
    with ExitStack() as stack:
        pool = executor or stack.enter_context(local_pool(options.workers or cores()))
        kept = stack.enter_context(Store()) if store is None else store
        player = Player(planner, keeping, kept, pool, options.budget, options.wall_limit, progress)
        sampled: dict[Draft, SampledScene] = {}
        name = options.name or default_name(planner, space)
        drafts = _drafts(space, planner.name, name, options.seed, sampled)
        found = player.first(drafts, lambda record: record.outcome in options.failures, skip_invalid=False)
        if found is None:
            return SearchResult(searched=player.count)
        searched = player.count
        robot = keeping.load_robot(found[0].robot)
        shrinking = Shrinking(player, *found, Footprint(robot.length, robot.width))
        shrinking.run()
    return SearchResult(
        sampled[found[0]], *found, shrinking.draft, shrinking.record,
        searched, player.count - searched, player.count < options.budget,
    )  # fmt: skip


def default_name(planner: PlannerSpec, space: SearchSpace) -> str:
    """What the scene is called in which a planner fails."""
    return f"{planner.name}_in_{space.family.name}"


def _drafts(
    space: SearchSpace, planner: str, name: str, seed: int, sampled: dict[Draft, SampledScene]
) -> Iterator[Draft]:
    """Drafts without end; what each was drawn as is noted."""
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    while True:
        made = space.sample(rng)
        draft = Draft.of(made.scene, name, f"Where {planner} fails: what a search left of {made.scene.name}.")
        sampled[draft] = made
        yield draft


__all__ = ["FAILURES", "SEED", "SearchOptions", "SearchResult", "default_name", "search"]
