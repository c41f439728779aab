"""Dialects of missions in XML: the vocabulary of nodes that a file uses."""

from __future__ import annotations

from typing import Final

NEWEST: Final = "lyrical"
"""Distribution of ROS 2 with the Nav2 that a mission means if it names none."""

DISTRIBUTIONS: Final = ("humble", "jazzy", "kilted", NEWEST)
"""Distributions of ROS 2 that a mission may name, the oldest first."""

_NAV2: Final = tuple(
    f"{of}{name}" for of in ("nav2", "nav2_servers") for name in ("", *(f":{d}" for d in DISTRIBUTIONS))
)

DIALECTS: Final = ("rocs", *_NAV2)
"""rocs_bt's nodes; Nav2's nodes without ROS; nodes that call a running Nav2. `nav2:humble` names a distribution."""


def parts_of(dialect: str) -> tuple[str, str]:
    """Family of a dialect (`nav2`, `nav2_servers`, `rocs` or empty) and the distribution that it means."""
    family, _, distribution = dialect.partition(":")
    return family, distribution or NEWEST
