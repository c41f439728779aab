"""Metrics: each is a number computed from one episode, with a unit, a direction, and a value for failures.

Sources: SPL is Anderson et al., On Evaluation of Embodied Navigation Agents (2018), 3; the BARN score is Xiao et al.,
Autonomous Ground Navigation in Highly Constrained Spaces: Lessons Learned From the Second BARN Challenge (2023), with
different bounds in different years; CVaR is Rockafellar and Uryasev, Optimization of Conditional Value-at-Risk (2000).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from ..base.errors import UnknownName, unknown
from ..record import AgentResult
from .company import INTIMATE, PERSONAL, Company

BARN_SPEED = 2.0  # [m/s] assumed speed on the reference path in the BARN challenge
BARN_YEARS: Mapping[str, tuple[float, float]] = {"barn2022": (4.0, 8.0), "barn2024": (2.0, 8.0)}
"""Lower and upper bound of the scored time, as multiples of the optimal time, by challenge year."""

DEFAULT_METRICS = ("success", "collision", "time")
"""Metrics of verdicts and leaderboards by default."""

SHARES = ("success", "collision", "fell", "clean", "untouched")
"""Metrics that are 0 or 1 in each episode, so that their mean is a rate between 0 and 1."""

ZERO_ON_FAILURE = ("success", "clean", "untouched", "spl", *BARN_YEARS)
"""Metrics that are 0 in every failed episode."""

CVAR_SHARE = 0.05
"""Share of the path, that with the smallest clearances, over which CVaR averages."""


@dataclass(frozen=True)
class EpisodeData:
    """Measurements of an episode, from which metrics are computed.

    Attributes:
        outcome: Outcome of the agent.
        time_limit: Time limit T_max [s].
        reference_length: Length of a shortest path [m]; 0 if unknown.
        agent: The agent's part of the run's summary.
        path: Positions at equal steps of path length [m], shape (n, 2).
        clearances: Distances from the hull to the nearest object along the path [m].
        energy: Kinetic energy added by the drive, per mass [J/kg].
        duration: Duration of the episode [s].
        jerk: Root mean square of the horizontal jerk [m/s3].
        company: Things that moved around the robot.
    """

    outcome: str
    time_limit: float
    reference_length: float
    agent: AgentResult
    path: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    clearances: Sequence[float] = ()
    energy: float | None = None
    duration: float = 0.0
    jerk: float | None = None
    company: Company | None = None

    @property
    def success(self) -> bool:
        """Whether the outcome is success."""
        return self.outcome == "success"

    @property
    def time(self) -> float:
        """Time from t = 0 until the goal was reached [s]; T_max if the goal was not reached."""
        reached = self.agent.time_to_goal
        return reached if self.success and reached is not None else self.time_limit


@dataclass(frozen=True)
class Metric:
    """Definition of a metric: a number computed from one episode.

    Attributes:
        name: Name of the metric.
        doc: Definition, including the value on failure.
        measure: Function that computes the metric; it returns None if the metric is undefined for the episode.
        unit: Unit; empty for a share or a count.
        direction: `up` if higher is better, `down` if lower is better.
        until_failure: Whether the value describes only the time before a failure; planners are then compared on the
            episodes in which both succeed. The values of other metrics enter the mean over all episodes.
    """

    name: str
    doc: str
    measure: Callable[[EpisodeData], float | None]
    unit: str = ""
    direction: Literal["up", "down"] = "up"
    until_failure: bool = False


def metric(name: str) -> Metric:
    """Metric by name. Each requirement of a scenario adds two metrics: `margin of NAME` and `holds NAME`.

    Raises:
        UnknownName: No metric has this name.
    """
    if name.startswith(MARGIN_PREFIX):
        doc = f"Minimum margin of the requirement '{name.removeprefix(MARGIN_PREFIX)}'; negative if violated."
        return Metric(name, doc, lambda m: measure_all(m).get(name), until_failure=True)
    if name.startswith(HOLDS_PREFIX):
        doc = f"1 if the requirement '{name.removeprefix(HOLDS_PREFIX)}' is satisfied, 0 if violated."
        return Metric(name, doc, lambda m: measure_all(m).get(name), until_failure=True)
    if name not in METRICS:
        raise UnknownName(unknown("metric", name, METRICS))
    return METRICS[name]


MARGIN_PREFIX = "margin of "
"""Prefix of metrics that are the robustness margin of a requirement; the requirement's name follows."""

HOLDS_PREFIX = "holds "
"""Prefix of metrics that are 1 if a requirement is satisfied, 0 if violated; the requirement's name follows."""

_VERDICTS: Mapping[str, float | None] = {"satisfied": 1.0, "violated": 0.0, "unknown": None}


def measure_all(measured: EpisodeData) -> dict[str, float | None]:
    """Values of all metrics of an episode by name, including those of its requirements; None if undefined."""
    found = {name: each.measure(measured) for name, each in METRICS.items()}
    for requirement in measured.agent.requirements:
        found[f"{MARGIN_PREFIX}{requirement.name}"] = requirement.margin
        found[f"{HOLDS_PREFIX}{requirement.name}"] = _VERDICTS[requirement.verdict]
    return found


def barn_score(time: float, reference_length: float, *, low: float, high: float) -> float:
    """BARN challenge score of a successful episode, between 1 / high and 1 / low.

    Args:
        time: Time to the goal [s].
        reference_length: Length of the reference path [m].
        low: Multiple of the optimal time; shorter times do not increase the score.
        high: Multiple of the optimal time; longer times do not decrease the score.
    """
    optimal = reference_length / BARN_SPEED
    return optimal / min(max(time, low * optimal), high * optimal)


def turning(path: npt.NDArray[np.float64]) -> float | None:
    """Sum of the absolute heading changes along a path, divided by the path length [rad/m].

    Args:
        path: Positions at equal steps of path length [m], shape (n, 2); equal steps make the result independent of the
            sampling rate.
    """
    steps = np.diff(path, axis=0)
    if len(steps) < 2:
        return None
    headings = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    return float(np.abs(np.diff(headings)).sum() / np.hypot(steps[:, 0], steps[:, 1]).sum())


def cvar(values: Sequence[float]) -> float | None:
    """Mean of the lowest values, the share `CVAR_SHARE` of all; None if there are no values."""
    if not len(values):
        return None
    ordered = np.sort(np.asarray(values, dtype=float))
    count = CVAR_SHARE * len(ordered)
    whole = int(count)
    total = ordered[:whole].sum() + (count - whole) * ordered[min(whole, len(ordered) - 1)]
    return float(total / count)


def _spl(m: EpisodeData) -> float | None:
    if m.reference_length <= 0.0:
        return None
    return m.success * m.reference_length / max(m.agent.path_length, m.reference_length)


def _barn(year: str, low: float, high: float) -> Metric:
    """BARN score with the bounds of a year."""

    def score(m: EpisodeData) -> float | None:
        if m.reference_length <= 0.0:
            return None
        return barn_score(m.time, m.reference_length, low=low, high=high) if m.success else 0.0

    bounds = f"{low} to {high} times the optimal time, at {BARN_SPEED:g} m/s"
    return Metric(year, f"BARN score. 0 on failure. Bounds of its year: {bounds}.", score)


def _reflex_share(m: EpisodeData) -> float:
    reactive, deliberative = m.agent.time_reactive, m.agent.time_deliberative
    return reactive / (reactive + deliberative) if reactive + deliberative > 0.0 else 0.0


def _collision(m: EpisodeData) -> float:
    return float((m.agent.collisions or 0) > 0)


def _fell(m: EpisodeData) -> float:
    return float(bool(m.agent.fell))


def _clean(m: EpisodeData) -> float:
    return float(m.success and not _collision(m) and not _fell(m))


def _untouched(m: EpisodeData) -> float:
    return float(_clean(m) and not m.agent.struck)


def _efficiency(m: EpisodeData) -> float | None:
    if m.reference_length <= 0.0 or m.agent.path_length <= 0.0:
        return None
    return min(m.reference_length / m.agent.path_length, 1.0)


def _intrusion(extent: float) -> Callable[[EpisodeData], float | None]:
    return lambda m: None if m.company is None else m.company.intrusion(extent)


def _time_to_collision(m: EpisodeData) -> float | None:
    if m.company is None or not m.company.moved or not math.isfinite(m.company.time_to_collision):
        return None
    return m.company.time_to_collision


METRICS: Mapping[str, Metric] = {
    each.name: each
    for each in (
        Metric("success", "1 if successful, else 0.", lambda m: float(m.success)),
        Metric(
            "collision",
            "1 if the robot drove into something, else 0. Being struck is not a collision.",
            _collision,
            direction="down",
        ),
        Metric("fell", "1 if the robot fell, else 0, whatever the outcome.", _fell, direction="down"),
        Metric("clean", "1 if successful without a collision and without a fall, else 0.", _clean),
        Metric("untouched", "1 if clean and nothing struck the robot, else 0.", _untouched),
        Metric(
            "struck_rate",
            "Contacts per minute that the robot's own motion did not cause.",
            lambda m: 60.0 * (m.agent.struck or 0) / max(m.duration, 1e-9),
            unit="1/min",
            direction="down",
        ),
        Metric(
            "time",
            "Time from the start of the episode to the goal; the time limit on failure, so that the mean is the "
            "restricted mean time.",
            lambda m: m.time,
            unit="s",
            direction="down",
        ),
        Metric(
            "path_length", "Path length.", lambda m: m.agent.path_length, unit="m", direction="down", until_failure=True
        ),
        Metric(
            "spl",
            "Success weighted by path length: shortest path length divided by the path length; 0 on failure.",
            _spl,
        ),
        Metric("path_efficiency", "Shortest path length divided by the path length.", _efficiency, until_failure=True),
        *(_barn(year, low, high) for year, (low, high) in BARN_YEARS.items()),
        Metric(
            "min_clearance",
            "Minimum distance from the hull to any object except the floor; negative on penetration.",
            lambda m: m.agent.min_clearance,
            unit="m",
            until_failure=True,
        ),
        Metric(
            "cvar_clearance",
            "Mean clearance on the tightest 5 % of the path (CVaR).",
            lambda m: cvar(m.clearances),
            unit="m",
            until_failure=True,
        ),
        Metric(
            "smoothness",
            "Absolute heading change per metre, at equal steps of path length, so that the rate does not matter.",
            lambda m: turning(m.path),
            unit="rad/m",
            direction="down",
            until_failure=True,
        ),
        Metric(
            "jerk",
            "Root mean square of the horizontal jerk.",
            lambda m: m.jerk,
            unit="m/s3",
            direction="down",
            until_failure=True,
        ),
        Metric(
            "time_to_collision",
            "Minimum of gap divided by closing speed, over all that moves.",
            _time_to_collision,
            unit="s",
        ),
        Metric(
            "intimate",
            f"Share of the time in which something that moves was nearer than {INTIMATE} m.",
            _intrusion(INTIMATE),
            direction="down",
        ),
        Metric(
            "personal",
            f"Share of the time in which something that moves was nearer than {PERSONAL} m.",
            _intrusion(PERSONAL),
            direction="down",
        ),
        Metric(
            "energy",
            "Kinetic energy added by accelerating, per kilogram.",
            lambda m: m.energy,
            unit="J/kg",
            direction="down",
            until_failure=True,
        ),
        Metric(
            "reflex_share",
            "Share of the driving time in which reflexes controlled the wheels.",
            _reflex_share,
            direction="down",
            until_failure=True,
        ),
        Metric(
            "route_switches",
            "Number of switches between plan and reflex control.",
            lambda m: float(m.agent.route_switches),
            direction="down",
            until_failure=True,
        ),
        Metric(
            "replans",
            "Number of actions that the plan resubmitted after a reflex.",
            lambda m: float(m.agent.replans),
            direction="down",
            until_failure=True,
        ),
        Metric(
            "exceptions",
            "Exceptions raised by content, such as the planner.",
            lambda m: float(sum(m.agent.exceptions.values())),
            direction="down",
        ),
        Metric(
            "tracking",
            "Root mean square distance to the reference path.",
            lambda m: m.agent.tracking_error.cross_rms,
            unit="m",
            direction="down",
            until_failure=True,
        ),
    )
}
"""All metrics by name, the most important first."""
