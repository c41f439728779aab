"""Nodes that decide which of their children are ticked."""
