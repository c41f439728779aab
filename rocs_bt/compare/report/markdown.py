"""Comparison as Markdown tables, for a README, a thesis or a pull request."""

from __future__ import annotations

from collections.abc import Sequence

from ...base.words import counted
from ..cold import Loss, StrengthWalk
from ..comparison import Comparison
from ..metric import metric
from ..replay import replay_command
from ..verdict import Verdict
from .tables import (
    COLD_HEAD,
    LeaderboardRow,
    cold_rows,
    conclusive_first,
    difference,
    headline,
    standings,
    text,
)

_FAILURES = 20  # maximum number of listed failures


def markdown(
    comparison: Comparison,
    metrics: Sequence[str],
    verdicts: Sequence[Verdict],
    losses: Sequence[Loss] = (),
    walks: Sequence[StrengthWalk] = (),
) -> str:
    """Comparison as Markdown: leaderboard, verdicts, losses by perturbations and the first failures.

    Args:
        comparison: The episodes.
        metrics: Metrics of the leaderboard.
        verdicts: Verdicts on pairs of planners; none for a single planner.
        losses: Losses of a cold comparison.
        walks: Walks outward of a cold comparison.
    """
    rows = standings(comparison, metrics)
    parts = [f"**{headline(rows, verdicts)}.** {extent(comparison)}.", _leaderboard(rows, metrics)]
    if verdicts:
        parts.append(_verdicts(verdicts))
    if losses:
        parts.append(table(COLD_HEAD, cold_rows(losses)))
    parts += [f"{walk}." for walk in walks]
    failures = [record for record in comparison.records if not record.success]
    if failures:
        head = ["planner", "scene", "seed", "outcome", "replay"]
        lines = [[r.planner, r.scene, str(r.seed), r.outcome, f"`{replay_command(r)}`"] for r in failures[:_FAILURES]]
        parts.append(table(head, lines))
        if (more := len(failures) - _FAILURES) > 0:
            parts.append(f"and {counted(more, 'more failure')}.")
    return "\n\n".join(parts) + "\n"


def extent(comparison: Comparison) -> str:
    """Numbers of episodes, scenes and seeds in words."""
    scenes, seeds = len(comparison.scenes), counted(len(comparison.seeds), "seed")
    of = f"{scenes} scenes, {seeds} of each" if scenes > 1 else f"the scene {comparison.scenes[0]}, {seeds}"
    return f"{counted(len(comparison.records), 'episode')}: {of}"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Table in Markdown."""
    lines = [head, ["---"] * len(head), *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _leaderboard(rows: Sequence[LeaderboardRow], metrics: Sequence[str]) -> str:
    head = ["planner", *metrics, "outcomes", "effective n"]
    lines = [
        [
            row.planner,
            *(text(row.estimates[name], metric(name)) for name in metrics),
            ", ".join(f"{count} {name}" for name, count in row.outcomes.items()),
            f"{row.size.effective:.0f} of {row.size.episodes}",
        ]
        for row in rows
    ]
    return table(head, lines)


def _verdicts(verdicts: Sequence[Verdict]) -> str:
    head = ["claim", "verdict", "by", "p (Holm)", "P(better)", "scenes", "needed"]
    lines = [
        [
            f"{v.a} better than {v.b} in {v.metric}",
            f"**{v.word}**" if v.word == "better" else v.word,
            difference(v),
            f"{v.p:.2g}",
            f"{v.superiority:.2f}",
            str(v.scenes),
            "–" if v.needed is None else str(v.needed),
        ]
        for v in conclusive_first(verdicts)
    ]
    return table(head, lines)
