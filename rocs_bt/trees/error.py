"""What can go wrong in a mission's tree."""

from __future__ import annotations

from ..errors import InputError


class TreeError(InputError):
    """A tree that cannot be built or cannot go on: a port, a script, a key or a node used against its contract."""
