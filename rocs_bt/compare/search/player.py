"""Playing: which of some drafts is the first in which a planner fails, within a budget of episodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from itertools import islice
from typing import TypeAlias

from ...catalog import Catalog, PlannerSpec
from ...errors import InputError
from ..record import EpisodeRecord
from ..store import Store
from ..sweep import SweepOptions, sweep
from .draft import Draft

SEED = 1
"""The seed of every episode: what is searched is scenes."""

_WAVE = 8  # drafts that are made before they are played

Fails: TypeAlias = Callable[[EpisodeRecord], bool]


@dataclass
class Player:
    """Plays a planner in drafts, in their order, however many processes do it; the same draft is never played twice.

    Attributes:
        planner: Who decides.
        catalog: Where its content is found.
        store: Where episodes are kept.
        executor: Who plays them.
        budget: How many episodes may count. Those beyond the first failure, which others played meanwhile, do not.
        wall_limit: How long one may take to compute [s].
        progress: Told how many have counted.
        count: How many have counted.
    """

    planner: PlannerSpec
    catalog: Catalog
    store: Store
    executor: Executor
    budget: int
    wall_limit: float
    progress: Callable[[float], None]
    count: int = 0
    _passed: set[Draft] = field(default_factory=set)

    def first(
        self, drafts: Iterable[Draft], fails: Fails, *, skip_invalid: bool = True
    ) -> tuple[Draft, EpisodeRecord] | None:
        """The first draft in which the planner fails, and its episode; None where none is found within the budget.

        Args:
            drafts: What to try; each is made when it is needed.
            fails: Which episodes count as failures.
            skip_invalid: Whether to skip drafts that cannot be played, such as one with the robot inside an obstacle.

        Raises:
            InputError: Content is wrong, and is not doubtful.
        """
        source = self._new(drafts)
        while wave := list(islice(source, min(_WAVE, self.budget - self.count))):
            records = self._play(wave, fails, skip_invalid)
            self.count += len(records)
            self.progress(self.count)
            for draft, record in zip(wave, records, strict=False):
                if record is not None and fails(record):
                    return draft, record
                self._passed.add(draft)
        return None

    def _new(self, drafts: Iterable[Draft]) -> Iterator[Draft]:
        """Those among drafts in which the planner is not known to do well, each once."""
        seen: set[Draft] = set()
        for draft in drafts:
            if draft not in self._passed and draft not in seen:
                seen.add(draft)
                yield draft

    def _play(self, drafts: Sequence[Draft], fails: Fails, skip_invalid: bool) -> list[EpisodeRecord | None]:
        """The episodes until the first failure; None for a draft that cannot be played."""
        try:
            return list(self._swept(drafts, fails))
        except InputError:
            if not skip_invalid:
                raise
        found: list[EpisodeRecord | None] = []
        for draft in drafts:
            try:
                found += self._swept([draft], fails)
            except InputError:
                found.append(None)
            if found[-1] is not None and fails(found[-1]):
                break
        return found

    def _swept(self, drafts: Sequence[Draft], fails: Fails) -> Iterable[EpisodeRecord]:
        done = sweep(
            [self.planner],
            [draft.scene_ref for draft in drafts],
            (SEED,),
            catalog=self.catalog,
            store=self.store,
            executor=self.executor,
            options=SweepOptions(wall_limit=self.wall_limit, stop_when=lambda records: fails(records[-1])),
        )
        return done.records()
