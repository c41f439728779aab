"""Control nodes, which decide which of their children are ticked."""
