"""Measured values of an agent for people: label and text with unit."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..record.file.summary import AgentResult, Finding, Following, Localisation

Number = tuple[str, float | str | None, str]
"""Label, value and format of a number; the value is None if it was not measured."""

_REJECTED = ("oversized", "unauthenticated", "malformed", "flooded", "refused")


def numbers(result: AgentResult) -> list[tuple[str, str]]:
    """Measured values as pairs of label and text with unit; missing values are omitted."""
    wanted = (
        ("time to goal", result.time_to_goal, "{:.2f} s"),
        ("path length", result.path_length, "{:.2f} m"),
        ("minimum clearance", result.min_clearance, "{:.3f} m"),
        ("collisions", result.collisions, "{}"),
        ("struck by others", result.struck, "{}"),
        ("falls", 1 if result.fell else None, "{}"),
        ("reflex activations", result.reflex_activations, "{}"),
        ("fired again while latched", result.reflex_refirings, "{}"),
        ("exceptions of content", sum(result.exceptions.values()) or None, "{}"),
        ("plan/reflex switches", result.route_switches, "{}"),
        ("actions resumed after a reflex", result.replans, "{}"),
        ("commands limited by the safety gate", sum(result.commands_limited.values()) or None, "{}"),
        ("time deliberative", result.time_deliberative, "{:.2f} s"),
        ("time reactive", result.time_reactive, "{:.2f} s"),
        ("cross-track error, rms", _scaled(result.tracking_error.cross_rms, 100), "{:.2f} cm"),
        *_following(result.following),
        *_localisation(result.localisation),
        *_sharing(result.sharing),
        ("follower, median", _scaled(result.solve_time.median, 1e6), "{:.0f} µs"),
    )
    return [(label, form.format(value)) for label, value, form in wanted if value is not None]


def _following(following: Following | None) -> list[Number]:
    if following is None:
        return []
    return [
        (f"distance to {following.leader}, mean", following.mean_distance, "{:.2f} m"),
        ("error of the follow distance, mean", following.distance_error, "{:.2f} m"),
        ("time within the follow band", _scaled(following.in_band, 100), "{:.1f} %"),
        ("minimum distance while driving", following.least_driving, "{:.2f} m"),
    ]


def _localisation(error: Localisation | None) -> list[Number]:
    if error is None:
        return []
    return [
        ("position error of the estimate, rms", 100 * error.position_rms, "{:.2f} cm"),
        ("position error of the estimate, maximum", 100 * error.position_max, "{:.2f} cm"),
        ("heading error of the estimate, rms", math.degrees(error.heading_rms), "{:.2f}°"),
        ("heading error of the estimate, maximum", math.degrees(error.heading_max), "{:.2f}°"),
        ("consistency of the estimate (NEES / 3)", error.nees, "{:.2f}"),
    ]


def _sharing(shared: Mapping[str, float] | None) -> list[Number]:
    if shared is None:
        return []
    return [
        ("writes sent to peers", shared.get("written"), "{}"),
        ("writes of peers accepted", shared.get("merged"), "{}"),
        ("messages of peers rejected", sum(shared[reason] for reason in _REJECTED), "{}"),
    ]


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def requirement(finding: Finding) -> dict[str, str | float | None]:
    """A requirement as texts, with the time of its minimum margin [s]."""
    margin = "" if finding.margin is None else f"minimum margin {finding.margin:.3g} {finding.unit}".rstrip()
    unknown = f"{finding.unknown} of {finding.samples} samples without a value" if finding.unknown else ""
    at = finding.violated if finding.violated is not None else finding.worst
    when = "" if at is None else f" {'at' if finding.violated is not None else 'nearest at'} {at:.2f} s"
    decided = f"{finding.verdict}{when}{finding.reading and f': {finding.reading}'}"
    text = ", ".join(filter(None, (decided, margin, unknown)))
    return {"name": finding.name, "require": finding.require, "text": text, "t": at}
