"""MuJoCo's library. The only import of it, made when a world is constructed, for it takes 0.2 s.

MuJoCo's warnings go to the logger `rocs_bt.mujoco`, which by default prints them on stderr. MuJoCo itself would append
them to the file MUJOCO_LOG.TXT in the current folder.
"""

import logging

from ...base.current_folder import environment, safe_path

with environment(safe_path()):  # MuJoCo imports glfw, which starts an interpreter to test its library
    import mujoco

__all__ = ["mujoco"]

_REPORTED = (" in QPOS ", " in QVEL ", " in QACC ")  # the world raises an error for these


def _warn(message: str) -> None:
    if not any(words in message for words in _REPORTED):
        logging.getLogger("rocs_bt.mujoco").warning("MuJoCo: %s", message.strip())


mujoco.set_mju_user_warning(_warn)
