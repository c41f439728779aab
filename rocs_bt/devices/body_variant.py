"""Variant of a robot's body in the simulated world, which differs from the robot's model file."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BodyVariant:
    """Differences of a simulated body from its model file.

    Attributes:
        size: Factor of all lengths of the model; masses that the model declares do not change.
        friction: Sliding friction of all geoms that touch with friction; None for that of the model.
    """

    size: float = 1.0
    friction: float | None = None


AS_MODELLED = BodyVariant()
"""No difference from the model file."""
