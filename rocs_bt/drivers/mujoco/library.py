"""MuJoCo's library. The only import of it, made when a world is constructed, for it takes 0.2 s."""

from ...current_folder import environment, safe_path

with environment(safe_path()):  # MuJoCo imports glfw, which starts an interpreter to test its library
    import mujoco

__all__ = ["mujoco"]
