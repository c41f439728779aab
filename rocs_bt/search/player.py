"""Player: finds the first of several drafts in which a planner fails, within a budget of episodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from itertools import islice
from typing import TypeAlias

from ..base.errors import InputError
from ..catalog import Catalog, PlannerSpec
from ..compare.record import EpisodeRecord
from ..compare.run_sweep import SweepOptions, episodes_of, play_episodes
from ..compare.store import EpisodeStore
from .draft import Draft

SEED = 1
"""Seed of every episode; a search varies only scenes."""

_WAVE = 8  # batch size: drafts that are generated and played together

Fails: TypeAlias = Callable[[EpisodeRecord], bool]


@dataclass
class Player:
    """Plays one planner in drafts (modified scenes), each at most once; the number of processes has no effect.

    Attributes:
        planner: Planner under test.
        catalog: Source of content.
        store: Store of episodes.
        executor: Executor of the episodes.
        budget: Maximum number of counted episodes. Drafts are played in batches; episodes after the first failure in a
            batch do not count.
        wall_limit: Maximum wall-clock time of an episode [s].
        progress: Callback with the number of counted episodes.
        count: Number of counted episodes.
    """

    planner: PlannerSpec
    catalog: Catalog
    store: EpisodeStore
    executor: Executor
    budget: int
    wall_limit: float
    progress: Callable[[float], None]
    count: int = 0
    _passed: set[Draft] = field(default_factory=set)

    def first(
        self, drafts: Iterable[Draft], fails: Fails, *, skip_invalid: bool = True
    ) -> tuple[Draft, EpisodeRecord] | None:
        """First draft in which the planner fails, with its episode; None if there is none within the budget.

        Args:
            drafts: Candidate drafts, consumed lazily.
            fails: Predicate that is True for a failed episode.
            skip_invalid: Whether to skip drafts that cannot be played, for example because the robot is inside an
                obstacle.

        Raises:
            InputError: Content is invalid, and `skip_invalid` is False.
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
        """Drafts that have not been played successfully before; each only once."""
        seen: set[Draft] = set()
        for draft in drafts:
            if draft not in self._passed and draft not in seen:
                seen.add(draft)
                yield draft

    def _play(self, drafts: Sequence[Draft], fails: Fails, skip_invalid: bool) -> list[EpisodeRecord | None]:
        """Play an episode in each draft until the planner fails in one; None for a draft that cannot be played."""
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
        options = SweepOptions(wall_limit=self.wall_limit, stop_when=lambda records: fails(records[-1]))
        scenes = [draft.scene_ref for draft in drafts]
        by_scene = episodes_of([self.planner], scenes, (SEED,), self.catalog, options)
        return play_episodes(by_scene, self.store, self.executor, options).records()
