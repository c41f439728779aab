"""`rocs-bt compare --cold`: planners on robots that differ from their own model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..base.errors import Fault, InputError
from ..catalog import Catalog, Perturbation, PlannerSpec, parse_perturbation
from .terminal import echo, show_table

if TYPE_CHECKING:
    from ..compare import Comparison, EpisodeStore, SweepOptions
    from ..compare.cold import Loss, StrengthWalk
    from ..compare.episode import SceneRef
    from ..compare.record import EpisodeRecord

_WIDE = 1000  # characters, wider than any table


@dataclass(frozen=True)
class ColdPlan:
    """Planners of a cold comparison."""

    pairs: tuple[tuple[PlannerSpec, tuple[Perturbation, ...]], ...]
    skipped: tuple[str, ...]
    catalog: Catalog

    @property
    def planners(self) -> list[PlannerSpec]:
        """Planners without and with their perturbations."""
        return [each for planner, found in self.pairs for each in (planner, *(planner.under(p) for p in found))]

    def losses(self, comparison: Comparison, metrics: Sequence[str]) -> list[Loss]:
        """Losses by the perturbations."""
        from ..compare.cold import losses

        return losses(comparison, metrics)

    def walk(
        self,
        comparison: Comparison,
        places: Sequence[SceneRef],
        seeds: int,
        store: EpisodeStore,
        executor: Executor | None,
        options: SweepOptions,
    ) -> list[StrengthWalk]:
        """Walk each perturbation outward."""
        from ..compare.cold import walk_outward
        from ..compare.run_sweep import episodes_of, play_episodes

        def play(planner: PlannerSpec) -> list[EpisodeRecord]:
            episodes = episodes_of([planner], places, range(1, seeds + 1), self.catalog, options)
            return list(play_episodes(episodes, store, executor, options).records())

        return [
            walk_outward(planner, perturbation, comparison.estimate(planner.name, "success").value, play)
            for planner, found in self.pairs
            for perturbation in found
        ]

    def as_dict(self, losses: Sequence[Loss], walks: Sequence[StrengthWalk]) -> dict[str, Any]:
        """Results as a dict for JSON."""
        plain = {"cold": [loss.as_dict() for loss in losses], "skipped": list(self.skipped)}
        return {**plain, **({"outward": [walk.as_dict() for walk in walks]} if walks else {})}


def cold_plan(
    planners: Sequence[str], places: Sequence[SceneRef], catalog: Catalog, given: Sequence[str], *, early: bool
) -> ColdPlan:
    """Select the perturbations of each planner: those given, or all that the catalog has.

    Perturbations without an effect on the robots are skipped, with a line on stderr.

    Raises:
        InputError: A planner or perturbation does not exist, nothing remains, or `early` is set.
    """
    from ..compare.cold import applicable

    if early:
        raise InputError(Fault("--stop-early and --cold exclude each other.", hint="Remove --stop-early."))
    if named := [name for name in planners if "~" in name]:
        hint = f"Write {named[0].partition('~')[0]} --perturb {named[0].partition('~')[2]}."
        raise InputError(Fault(f"with --cold, '{named[0]}' must not name a perturbation.", hint=hint))
    known = catalog.load_perturbations()
    wanted = [_perturbation(text, known) for text in given] or list(known.values())
    pairs, skipped = [], list[str]()
    for planner in map(catalog.load_planner, planners):
        found = list(applicable(planner, wanted, places, catalog))
        skipped += [f"{planner.name}: {error}" for error in found if isinstance(error, InputError)]
        pairs.append((planner, tuple(each for each in found if isinstance(each, Perturbation))))
    if not any(found for _, found in pairs):
        raise InputError(Fault("no perturbation has an effect.", hint=" ".join(dict.fromkeys(skipped))))
    for line in dict.fromkeys(skipped):
        echo(f"not played: {line}", err=True)
    return ColdPlan(tuple(pairs), tuple(dict.fromkeys(skipped)), catalog)


def _perturbation(text: str, known: Mapping[str, Perturbation]) -> Perturbation:
    """Perturbation of one option --perturb."""
    if "~" in text:
        each = " ".join(f"--perturb {name}" for name in text.split("~"))
        hint = f"Write {each} to play them one by one, or without --cold the planner PLANNER~{text} for all at once."
        raise InputError(Fault(f"--perturb takes one perturbation, found '{text}'.", hint=hint))
    return parse_perturbation(text, known)


def print_cold(losses: Sequence[Loss], walks: Sequence[StrengthWalk]) -> None:
    """Print the table of losses and the walks outward, if there are any."""
    from rich.box import SIMPLE

    from ..compare.report import COLD_HEAD, cold_rows

    if losses:
        show_table(cold_rows(losses), COLD_HEAD, right=range(3, 6), edge=_WIDE, box=SIMPLE, padding=(0, 1, 0, 0))
    for walk in walks:
        echo(str(walk))
