"""Makes a virtual environment with ROS 2: `python tests/ros2/environment.py FOLDER REQUIREMENTS`.

The environment has the running Python, the wheels of REQUIREMENTS and, behind them, the packages of the environment
that runs this script, rocs_bt among them. On machines without such wheels the script succeeds and leaves the reason
in FOLDER/unavailable, so that tests skip with it.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

MACHINE = f"{sys.platform} {platform.machine()}, Python {sys.version_info[0]}.{sys.version_info[1]}"
HAS_WHEELS = MACHINE.startswith("linux x86_64") and sys.version_info < (3, 14)


def make(folder: Path, requirements: Path) -> None:
    """Make the environment anew."""
    what = f"Setting up {folder.name} with ROS 2 ({requirements.name})"
    print(f"{what}: downloads about 45 MB once, needs about 170 MB of disk.", flush=True)
    venv.create(folder, clear=True, with_pip=False, symlinks=True)
    packages = Path(sysconfig.get_path("purelib", vars={"base": str(folder)}))
    ours = os.path.relpath(sysconfig.get_path("purelib"), folder)
    (packages / "ours.pth").write_text(f"import os, site, sys; site.addsitedir(os.path.join(sys.prefix, {ours!r}))\n")
    pip = [sys.executable, "-m", "pip", "--python", str(folder / "bin" / "python"), "--disable-pip-version-check"]
    install = ["install", "--quiet", "--no-deps", "--only-binary", ":all:", "--requirement", str(requirements)]
    done = subprocess.run([*pip, *install], capture_output=True, text=True)
    if done.returncode and HAS_WHEELS:
        raise SystemExit(done.stderr)
    if done.returncode:
        reason = f"{requirements.name} has packages without a wheel for {MACHINE}"
        (folder / "unavailable").write_text(f"{reason}\n")
        print(f"Tests with ROS 2 will skip: {reason}.")


if __name__ == "__main__":
    make(Path(sys.argv[1]).resolve(), Path(sys.argv[2]))
