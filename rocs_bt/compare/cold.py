"""Cold comparison: loss of frozen planners on robots with perturbations of which they do not know."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from ..base.errors import InputError
from ..catalog import Catalog, Perturbation, PlannerSpec
from .comparison import Comparison
from .episode import SceneRef
from .record import EpisodeRecord
from .runner import EpisodeRunner, agent_of
from .statistics import Estimate
from .verdict import Verdict, adjusted

POOLED = "all"
"""Name of the row over all perturbations together."""

STEPS = 7
"""Maximum number of strengths of a walk outward."""


@dataclass(frozen=True)
class Loss:
    """Loss of a planner by a perturbation in a metric, paired by scene and seed."""

    planner: str
    perturbation: str  # with its strength, such as `delay=0.1`; `POOLED` for all together
    warm: Estimate
    cold: Estimate
    verdict: Verdict  # claim that warm is better; its difference is the loss, positive if cold is worse

    def as_dict(self) -> dict[str, Any]:
        """Loss as a dict for JSON."""
        means = {"warm": self.warm.value, "cold": self.cold.value}
        plain = {name: None if np.isnan(value) else value for name, value in means.items()}
        return {**self.verdict.as_dict(), "planner": self.planner, "perturbation": self.perturbation, **plain}


@dataclass(frozen=True)
class StrengthWalk:
    """Walk of a perturbation outward, to the first strength at which the planner breaks.

    A planner breaks where its success share is below half of that without the perturbation.

    Attributes:
        planner: Name of the planner.
        perturbation: Perturbation at its first strength.
        shares: Success share at each strength played.
        breaks: Strength at which the planner breaks; None if it breaks at none that was played.
        reason: Reason for which a walk without a break ended.
    """

    planner: str
    perturbation: Perturbation
    shares: tuple[tuple[Perturbation, float], ...]
    breaks: Perturbation | None = None
    reason: str = ""

    def __str__(self) -> str:
        what = f"{self.planner} with {self.perturbation.name}"
        if self.breaks is None:
            last = self.shares[-1][0].amount if self.shares else "no strength"
            return f"{what}: holds up to {last} ({self.reason})"
        held = [each.amount for each, _ in self.shares[:-1]]
        success = f"success {100.0 * self.shares[-1][1]:.3g} %"
        return f"{what}: breaks at {self.breaks.amount} ({success})" + (f", holds at {held[-1]}" if held else "")

    def as_dict(self) -> dict[str, Any]:
        """Walk as a dict for JSON; strengths are in SI units."""
        return {
            "planner": self.planner,
            "perturbation": self.perturbation.name,
            "unit": self.perturbation.unit,
            "shares": [[each.strength.value, share] for each, share in self.shares],
            "breaks": None if self.breaks is None else self.breaks.strength.value,
            "reason": self.reason,
        }


def applicable(
    planner: PlannerSpec, perturbations: Iterable[Perturbation], scenes: Iterable[SceneRef], catalog: Catalog
) -> Iterator[Perturbation | InputError]:
    """Perturbations with an effect on the robots of a planner in all scenes; an error for each of the others.

    Of each family only the first scene is examined.
    """
    runner = EpisodeRunner(catalog.project, code=catalog.code)
    prepared = [runner.prepare(scene) for scene in {scene.group: scene for scene in reversed(list(scenes))}.values()]
    robots = [each.catalog.robot_of(agent_of(each.with_planner(planner), each.agent)) for each in prepared]
    for perturbation in perturbations:
        try:
            for robot in robots:
                perturbation.of(robot)
        except InputError as error:
            yield error
        else:
            yield perturbation


def losses(comparison: Comparison, metrics: Sequence[str]) -> list[Loss]:
    """Loss of each planner by each of its perturbations and by all together, adjusted for multiple claims.

    The planners of the episodes are named `PLANNER` and `PLANNER~PERTURBATION`.
    """
    claims, found = [], list[tuple[str, str, Estimate, Estimate]]()
    for warm in (name for name in comparison.planners if "~" not in name):
        cold = [name for name in comparison.planners if name.startswith(f"{warm}~")]
        tables = [(name, comparison) for name in cold]
        if len(cold) > 1 and (pooled := _pooled(comparison, warm, cold)) is not None:
            tables.append((f"{warm}~{POOLED}", pooled))
        for name, table in tables:
            for metric in metrics:
                claims.append((table, warm, name, metric))
                estimates = comparison.estimate(warm, metric), table.estimate(name, metric)
                found.append((warm, name.removeprefix(f"{warm}~"), *estimates))
    verdicts = [table.verdict(warm, name, metric, claims=len(claims)) for table, warm, name, metric in claims]
    return [Loss(*each, verdict) for each, verdict in zip(found, adjusted(verdicts), strict=True)]


def _pooled(comparison: Comparison, warm: str, cold: Sequence[str]) -> Comparison | None:
    """Episodes of a planner with all perturbations, each paired with that without; None for a single pair.

    The sample units remain the scenes, or the seeds of a single scene: perturbations are repetitions of a unit.
    """
    scenes = len(comparison.scenes) > 1
    if not scenes and len(comparison.seeds) < 2:
        return None

    def repeated(record: EpisodeRecord, planner: str, number: int) -> EpisodeRecord:
        scene = record.scene if scenes else f"{record.scene}, seed {record.seed}"
        seed = record.seed * len(cold) + number if scenes else number
        key = f"{record.key} {number}"
        return msgspec.structs.replace(record, planner=planner, scene=scene, seed=seed, key=key)

    pairs = [(comparison.of(warm), warm, number) for number in range(len(cold))]
    pairs += [(comparison.of(name), f"{warm}~{POOLED}", number) for number, name in enumerate(cold)]
    return Comparison(repeated(record, name, number) for records, name, number in pairs for record in records)


def walk_outward(
    planner: PlannerSpec,
    perturbation: Perturbation,
    warm: float,
    play: Callable[[PlannerSpec], Iterable[EpisodeRecord]],
) -> StrengthWalk:
    """Play a planner at ever harder strengths of a perturbation until it breaks."""
    shares, each, end = list[tuple[Perturbation, float]](), perturbation, f"the last of {STEPS} strengths"
    if warm <= 0.0:
        return StrengthWalk(planner.name, perturbation, (), None, "it never succeeds without the perturbation")
    for _ in range(STEPS):
        try:
            share = float(np.mean([record.success for record in play(planner.under(each))]))
        except InputError as error:  # such as a delay above the maximum of the driver
            end = f"{each.amount} is not possible: {error}"
            break
        shares.append((each, share))
        if share < 0.5 * warm:
            return StrengthWalk(planner.name, perturbation, tuple(shares), each)
        each = each.next()
    return StrengthWalk(planner.name, perturbation, tuple(shares), None, end)
