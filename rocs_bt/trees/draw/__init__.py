"""Drawings of trees as text and SVG, with the ports of each node and the origin of each blackboard key."""

from .picture import Card, Key, Line, Picture, picture_of, port_keys, ports_text
from .svg import svg
from .text import text

__all__ = ["Card", "Key", "Line", "Picture", "picture_of", "port_keys", "ports_text", "svg", "text"]
