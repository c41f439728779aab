"""Numerics of motion control: drive kinematics, paths, speed profiles, the trajectory follower and filters.

The package does not depend on MAPE-K: it imports only geometry and errors, so any code that moves a robot may import
it. It is the only package that imports casadi.
"""
