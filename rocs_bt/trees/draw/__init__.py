"""Drawings of trees as text and SVG, with ports and the origin of each key."""

from .picture import Card, Key, Line, Picture, picture_of
from .svg import svg
from .text import text

__all__ = ["Card", "Key", "Line", "Picture", "picture_of", "svg", "text"]
