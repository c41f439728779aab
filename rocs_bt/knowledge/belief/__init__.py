"""Belief: what may be there, how surely, and where: tracks that sightings begin, move and end."""

from .belief import Belief, BeliefSettings, BeliefUpdate, Sighting, Track

__all__ = ["Belief", "BeliefSettings", "BeliefUpdate", "Sighting", "Track"]
