"""TreeError, the base class of all errors of behaviour trees."""

from __future__ import annotations

from ..base.errors import InputError


class TreeWarning(UserWarning):
    """A document of trees can be loaded, but contains what is probably a mistake."""


class TreeError(InputError):
    """Raised if a tree cannot be built or continued, because of a port, a script, a key or a node."""
