"""Search for failures: find a scene in which a planner fails, and simplify the scene as far as possible."""
