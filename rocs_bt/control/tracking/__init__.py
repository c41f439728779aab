"""Tracking of the objects around a robot from the ranges of one sensor: segments, circle fits and Kalman filters."""

from .beams import Beams, Scan
from .motion_belief import MotionBelief
from .segments import Segments, segments_of
from .tracker import TrackedObjects, Tracker, TrackerSettings

__all__ = [
    "Beams",
    "MotionBelief",
    "Scan",
    "Segments",
    "TrackedObjects",
    "Tracker",
    "TrackerSettings",
    "segments_of",
]
