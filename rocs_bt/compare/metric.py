"""Metrics: numbers of one episode, each with its unit, its direction, and what it means on failure.

Sources: SPL is Anderson et al., On Evaluation of Embodied Navigation Agents (2018), 3; the BARN score is Xiao et al.,
Autonomous Ground Navigation in Highly Constrained Spaces: Lessons Learned From the Second BARN Challenge (2023), with
the bounds of its years; CVaR is Rockafellar and Uryasev, Optimization of Conditional Value-at-Risk (2000).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from ..errors import UnknownName, unknown
from ..record import AgentResult

BARN_SPEED = 2.0  # [m/s] at which the BARN challenge takes the reference way to be driven
BARN_YEARS: Mapping[str, tuple[float, float]] = {"barn2022": (4.0, 8.0), "barn2024": (2.0, 8.0)}
"""By the year that brought them, the bounds within which the time counts, in multiples of the optimal time."""

DEFAULT_METRICS = ("success", "collision", "time")
"""What planners are judged by, where nothing else is said."""

SHARES = ("success", "collision")
"""0 or 1 in each episode, so that the mean is a share."""

ZERO_ON_FAILURE = ("success", "spl", *BARN_YEARS)
"""0 where an episode fails, however it does."""

CVAR_SHARE = 0.05
"""The share of the way that CVaR looks at."""


@dataclass(frozen=True)
class EpisodeData:
    """What an episode left behind, for metrics to be told from.

    Attributes:
        outcome: The agent's.
        time_limit: T_max [s].
        reference_length: How long a shortest way is [m]; 0 where that is unknown.
        agent: The agent's part of the run's summary.
        path: (n, 2) Where the robot was, at equal steps of its way [m].
        clearances: (n,) How near its hull was to anything there [m].
        energy: What the drive spent on moving [J/kg].
    """

    outcome: str
    time_limit: float
    reference_length: float
    agent: AgentResult
    path: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    clearances: Sequence[float] = ()
    energy: float | None = None

    @property
    def success(self) -> bool:
        """Whether it succeeded."""
        return self.outcome == "success"

    @property
    def time(self) -> float:
        """When the goal was reached, counted from t = 0 [s]; T_max where it was not."""
        reached = self.agent.time_to_goal
        return reached if self.success and reached is not None else self.time_limit


@dataclass(frozen=True)
class Metric:
    """One number of an episode.

    Attributes:
        name: What it is called.
        unit: Its unit; empty for a share or a count.
        direction: Whether more is better (`up`) or less (`down`).
        on_failure: `counts` where a failed episode has a value that belongs into the mean over all episodes;
            `until_failure` where it tells of the way until then, so that planners are to be compared on the episodes
            in which both succeed.
        doc: What it is, and what it is on failure.
        measure: Tells it; None where the episode says nothing of it.
    """

    name: str
    unit: str
    direction: Literal["up", "down"]
    on_failure: Literal["counts", "until_failure"]
    doc: str
    measure: Callable[[EpisodeData], float | None]


def metric(name: str) -> Metric:
    """A metric by its name; `margin of NAME` and `holds NAME` are two for each requirement of a scenario.

    Raises:
        UnknownName: There is none.
    """
    if name.startswith(MARGIN_PREFIX):
        doc = (
            f"The least margin of the requirement '{name.removeprefix(MARGIN_PREFIX)}'; negative where it was violated."
        )
        return Metric(name, "", "up", "until_failure", doc, lambda m: _margin(m, name.removeprefix(MARGIN_PREFIX)))
    if name.startswith(HOLDS_PREFIX):
        doc = f"Whether the requirement '{name.removeprefix(HOLDS_PREFIX)}' is satisfied: 1, or 0 where it is violated."
        return Metric(name, "", "up", "until_failure", doc, lambda m: _holds(m, name.removeprefix(HOLDS_PREFIX)))
    if name not in METRICS:
        raise UnknownName(unknown("metric", name, METRICS))
    return METRICS[name]


MARGIN_PREFIX = "margin of "
"""Before a requirement's name: the metric of its robustness."""

HOLDS_PREFIX = "holds "
"""Before a requirement's name: 1 where it is satisfied, 0 where it is violated, None where that is unknown."""

_VERDICTS: Mapping[str, float | None] = {"satisfied": 1.0, "violated": 0.0, "unknown": None}


def measure_all(measured: EpisodeData) -> dict[str, float | None]:
    """All metrics of an episode, those of its requirements' margins included."""
    found = {name: each.measure(measured) for name, each in METRICS.items()}
    for requirement in measured.agent.requirements:
        found[f"{MARGIN_PREFIX}{requirement.name}"] = requirement.margin
        found[f"{HOLDS_PREFIX}{requirement.name}"] = _VERDICTS[requirement.verdict]
    return found


def barn_score(time: float, reference_length: float, *, low: float, high: float) -> float:
    """The BARN challenge's score of a success.

    Args:
        time: How long it took [s].
        reference_length: How long the reference way is [m].
        low: Below this multiple of the optimal time nothing more is won.
        high: Above this multiple nothing more is lost.

    Returns:
        Between 1 / high and 1 / low.
    """
    optimal = reference_length / BARN_SPEED
    return optimal / min(max(time, low * optimal), high * optimal)


def turning(path: npt.NDArray[np.float64]) -> float | None:
    """How much a way turns, all turns added up regardless of their sign, a metre [rad/m].

    Args:
        path: (n, 2) Positions at equal steps of the way [m], so that it does not matter how often they were taken.
    """
    steps = np.diff(path, axis=0)
    if len(steps) < 2:
        return None
    headings = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    return float(np.abs(np.diff(headings)).sum() / np.hypot(steps[:, 0], steps[:, 1]).sum())


def cvar(values: Sequence[float], share: float = CVAR_SHARE) -> float | None:
    """The mean of the least values, those of a share of all; None of nothing."""
    if not len(values):
        return None
    ordered = np.sort(np.asarray(values, dtype=float))
    count = share * len(ordered)
    whole = int(count)
    total = ordered[:whole].sum() + (count - whole) * ordered[min(whole, len(ordered) - 1)]
    return float(total / count)


def _spl(m: EpisodeData) -> float | None:
    if m.reference_length <= 0.0:
        return None
    return m.success * m.reference_length / max(m.agent.path_length, m.reference_length)


def _barn(year: str) -> Callable[[EpisodeData], float | None]:
    low, high = BARN_YEARS[year]

    def score(m: EpisodeData) -> float | None:
        if m.reference_length <= 0.0:
            return None
        return barn_score(m.time, m.reference_length, low=low, high=high) if m.success else 0.0

    return score


def _reflex_share(m: EpisodeData) -> float:
    reactive, deliberative = m.agent.time_reactive, m.agent.time_deliberative
    return reactive / (reactive + deliberative) if reactive + deliberative > 0.0 else 0.0


def _exceptions(m: EpisodeData) -> float:
    return float(sum(m.agent.exceptions.values()))


def _holds(measured: EpisodeData, requirement: str) -> float | None:
    verdicts = {r.name: r.verdict for r in measured.agent.requirements}
    return _VERDICTS[verdicts.get(requirement, "unknown")]


def _margin(m: EpisodeData, name: str) -> float | None:
    return next((r.margin for r in m.agent.requirements if r.name == name), None)


_YEARS = "0 on failure. Bounds of its year: {} to {} times the optimal time, at {:g} m/s."

METRICS: Mapping[str, Metric] = {
    each.name: each
    for each in (
        Metric("success", "", "up", "counts", "1 where it succeeded, else 0.", lambda m: float(m.success)),
        Metric(
            "collision", "", "down", "counts", "1 where it ran into something, else 0; a robot that is struck while it "
            "stands collides with nothing.", lambda m: float((m.agent.collisions or 0) > 0),
        ),
        Metric(
            "time", "s", "down", "counts", "When the goal was reached, on the clock that starts with the episode; on "
            "failure the time limit, so that its mean is the restricted mean time.", lambda m: m.time,
        ),
        Metric("path_length", "m", "down", "until_failure", "How far it drove.", lambda m: m.agent.path_length),
        Metric(
            "spl", "", "up", "counts", "Success weighted by path length: a shortest way's length over its own; 0 on "
            "failure.", _spl,
        ),
        *(
            Metric(year, "", "up", "counts", f"The BARN score. {_YEARS.format(*bounds, BARN_SPEED)}", _barn(year))
            for year, bounds in BARN_YEARS.items()
        ),
        Metric(
            "min_clearance", "m", "up", "until_failure", "How near its hull came to anything but the floor; below 0 "
            "inside.", lambda m: m.agent.min_clearance,
        ),
        Metric(
            "cvar_clearance", "m", "up", "until_failure", "The mean clearance of the tightest 5 % of its way (CVaR).",
            lambda m: cvar(m.clearances),
        ),
        Metric(
            "smoothness", "rad/m", "down", "until_failure", "How much its way turns a metre, told at equal steps of "
            "the way, so that it does not depend on how often one looks.", lambda m: turning(m.path),
        ),
        Metric(
            "energy", "J/kg", "down", "until_failure", "What it spent on gathering speed, a kilogram.",
            lambda m: m.energy,
        ),
        Metric(
            "reflex_share", "", "down", "until_failure", "The share of its driven time in which reflexes had the "
            "wheels.", _reflex_share,
        ),
        Metric(
            "route_switches", "", "down", "until_failure", "How often the wheels went from plan to reflex or back.",
            lambda m: float(m.agent.route_switches),
        ),
        Metric("replans", "", "down", "until_failure", "How often the plan sent its action again after a reflex.",
               lambda m: float(m.agent.replans)),
        Metric("exceptions", "", "down", "counts", "Exceptions that content raised, such as the planner.", _exceptions),
        Metric("tracking", "m", "down", "until_failure", "How far it was beside its reference path, root mean square.",
               lambda m: m.agent.tracking_error.cross_rms),
    )
}  # fmt: skip
"""All metrics by name, the most important first."""
