"""TreeError, the base of all errors of behaviour trees."""

from __future__ import annotations

from ..errors import InputError


class TreeError(InputError):
    """A tree that cannot be built or continued: a port, a script, a key or a node violates its contract."""
