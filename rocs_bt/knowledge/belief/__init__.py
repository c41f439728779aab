"""Belief: tracks of objects with uncertain existence and position, started, updated and ended by sightings."""

from .belief import Belief, BeliefSettings, BeliefUpdate, Sighting, Track

__all__ = ["Belief", "BeliefSettings", "BeliefUpdate", "Sighting", "Track"]
