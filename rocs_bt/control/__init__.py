"""Numerics that know no MAPE-K: drive kinematics, paths, speed profiles and the trajectory follower.

It imports geometry and errors only, and is the only folder that imports casadi. Whoever moves a robot may import it.
"""
