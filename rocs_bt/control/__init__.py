"""Numerics that know no MAPE-K: drive kinematics, paths, speed profiles and the trajectory follower."""
