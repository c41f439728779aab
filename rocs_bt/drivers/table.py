"""Picking a driver by its name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from ..errors import UnknownName, unknown

T = TypeVar("T")


def pick(drivers: Mapping[str, type[T]], driver: str | type[T], kind: str, backend: str) -> type[T]:
    """A driver's class.

    Args:
        drivers: The backend's classes by name.
        driver: What robot.toml names, or the class itself, for one of a user's own.
        kind: `sensor` or `actuator`.
        backend: Whose drivers these are.

    Raises:
        UnknownName: The backend has no such driver; lists those that it has.
    """
    if isinstance(driver, type):
        return driver
    if driver not in drivers:
        raise UnknownName(unknown(f"{kind} driver", driver, drivers, f"The {backend} backend"))
    return drivers[driver]
