"""Pictures of trees: as text, as SVG, and as a page, with ports and where each key comes from."""

from .picture import Card, Key, Line, Picture, picture_of
from .svg import svg
from .text import text

__all__ = ["Card", "Key", "Line", "Picture", "picture_of", "svg", "text"]
