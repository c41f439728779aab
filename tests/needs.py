"""What tests need that a machine may lack: each skips its test with the reason, and `make test` prints the reasons.

Other files skip nothing, but for those that tests/test_house.py lists.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.expression import kernel_missing

from . import chromium

PACKAGES = {
    "behaviortreepy": "BehaviorTree.CPP as an oracle: there is no wheel of behaviortreepy for this platform",
    "build": "building a wheel needs the extra 'test'",
    "cryptography": "keys of sharing need the extra 'share'",
    "cyclonedds": "DDS needs the extra 'ros2', and cyclonedds has no wheel for some platforms",
    "dask": "clusters need the extra 'cluster'",
    "distributed": "clusters need the extra 'cluster'",
    "furo": "building the manual needs the extra 'docs'",
    "hatchling": "building a wheel needs the extra 'test'",
    "jsonschema": "checking JSON Schemas needs the extra 'test'",
    "myst_parser": "building the manual needs the extra 'docs'",
    "pygls": "the language server needs the extra 'editor'",
    "rosbags": "types of messages of ROS 2 need the extra 'ros2'",
    "sphinx": "building the manual needs the extra 'docs'",
    "sphinx_click": "building the manual needs the extra 'docs'",
    "zenoh": "sharing needs the extra 'share'",
}
MANUAL = ("sphinx", "myst_parser", "furo", "sphinx_click")

kernel = pytest.mark.skipif(
    bool(kernel_missing()), reason=f"the C kernel of rules and expressions is not compiled here: {kernel_missing()}"
)


def package(*names: str) -> ModuleType:
    """The first of some optional packages, all of which are needed."""
    first, *_ = [pytest.importorskip(name, reason=PACKAGES[name]) for name in names]
    return first


def linux(what: str) -> pytest.MarkDecorator:
    """A test of something that only Linux has."""
    return pytest.mark.skipif(sys.platform != "linux", reason=f"only Linux {what}")


def posix(what: str) -> pytest.MarkDecorator:
    """A test of something that Windows lacks."""
    return pytest.mark.skipif(sys.platform == "win32", reason=f"Windows {what}")


def browser() -> str:
    """Path of a Chromium."""
    if (path := chromium.find()) is None:
        pytest.skip(f"tests of pages need Chromium: none of {', '.join(chromium.NAMES)} is installed")
    return path


def program(name: str, what: str) -> str:
    """Path of a program, which does something."""
    if (path := shutil.which(name)) is None:
        pytest.skip(f"the program '{name}', which {what}, is not installed")
    return path


@contextmanager
def opengl() -> Iterator[None]:
    """A block that renders images."""
    try:
        yield
    except InputError as error:
        if "no OpenGL backend works" not in str(error):
            raise
        pytest.skip(f"pictures and videos need OpenGL: {error}")


@contextmanager
def disk(folder: Path, size: str) -> Iterator[Path]:
    """A small disk of its own in a new folder."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder]
    done = subprocess.run(mount, capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"only root can mount a small disk, and not in every container: {done.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)
