"""Numerics without MAPE-K: drive kinematics, paths, speed profiles, the trajectory follower and filters.

This package imports only geometry and errors, and is the only one that imports casadi. Any code that moves a robot may
import it.
"""
