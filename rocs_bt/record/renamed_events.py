"""Renamed events: recordings of earlier versions contain the old names, and are read by this table."""

from __future__ import annotations

from collections.abc import Mapping

RENAMED_EVENTS: Mapping[str, str] = {
    "Approached": "MinClearanceLowered",
    "Followed": "FollowerStepped",
    "Judged": "OutcomeDecided",
    "PeerCame": "PeerAppeared",
    "Touched": "ContactBegan",
}
"""Present name of each renamed event, by its old name, which was also its tag and the end of its schema's name."""
