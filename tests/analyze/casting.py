"""Rays among round things: what a sensor hears, for tests."""

import math


def cast(pose, bearings, things, reach):
    """The range of each ray [m], +inf without an echo; bearings from the robot's heading, things as (x, y, radius)."""
    told = []
    for bearing in bearings:
        c, s = math.cos(pose.yaw + bearing), math.sin(pose.yaw + bearing)
        nearest = math.inf
        for x, y, radius in things:
            dx, dy = x - pose.x, y - pose.y
            along = dx * c + dy * s
            gap = radius**2 - (dx**2 + dy**2 - along**2)
            if along > 0.0 and gap >= 0.0:
                nearest = min(nearest, along - math.sqrt(gap))
        told.append(nearest if nearest <= reach else math.inf)
    return told
