"""The current folder is kept off the path from which Python imports modules.

Otherwise a file such as `struct.py` in the folder of a user is run in place of the module of that name, by this process
or by an interpreter that a library starts: `import mujoco` imports glfw, which starts one, and so does a pool of
processes.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path


def keep_current_folder_off_path() -> None:
    """Remove the current folder from the path of this process, and keep it off that of interpreters it starts."""
    start_safe_interpreters()
    here, own = os.getcwd(), str(Path(__file__).resolve().parents[1])  # own: a checkout from which rocs_bt is run
    sys.path[:] = [each for each in sys.path if (path := os.path.abspath(each or here)) != here or path == own]


def start_safe_interpreters() -> None:
    """Keep the current folder off the path of Python interpreters that this process starts."""
    os.environ.setdefault("PYTHONSAFEPATH", "1")
