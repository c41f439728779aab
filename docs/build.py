"""Build the manual: `python docs/build.py [FOLDER] [SPHINX OPTIONS]`; the folder is build/manual by default.

A manual that was built from the same sources is used again. `make docs` calls this with `-W`, and the build hook of the
wheel calls it without.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILT = ROOT / "build" / "manual"
FOLDERS = ("docs", "rocs_bt", "planners", "rules", "robots", "scenarios", "examples", "benchmarks")
TYPES = (".py", ".md", ".toml", ".xml", ".png", ".svg", ".txt")
STAMP = ".sources"


def digest() -> str:
    """SHA-256 of the sources of the manual: pages, docstrings, content and the files that pages link to."""
    found = hashlib.sha256()
    paths = [p for folder in FOLDERS for p in (ROOT / folder).rglob("*") if p.suffix in TYPES and p.is_file()]
    for path in sorted([*paths, *ROOT.glob("*.md"), ROOT / "pyproject.toml"]):
        if "runs" in path.parts or "_manual" in path.parts:
            continue
        content = path.read_bytes()
        found.update(f"{path.relative_to(ROOT).as_posix()} {len(content)}\n".encode() + content)
    return found.hexdigest()


def is_current(folder: Path) -> bool:
    """Whether a folder has the manual of these sources."""
    stamp = folder / STAMP
    return stamp.is_file() and stamp.read_text("utf-8") == digest()


def build(folder: Path, options: Sequence[str] = ()) -> int:
    """Build the manual, or copy the current one.

    Args:
        folder: Folder to write; replaced.
        options: Further options of sphinx-build.

    Returns:
        The exit code of sphinx-build.
    """
    if is_current(folder):
        return 0
    shutil.rmtree(folder, ignore_errors=True)
    if is_current(BUILT):
        shutil.copytree(BUILT, folder)
        return 0
    sources = digest()
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    with tempfile.TemporaryDirectory() as doctrees:
        command = [sys.executable, "-m", "sphinx", "-q", "-j", "2", "-b", "html", "-d", doctrees, *options]
        done = subprocess.run([*command, ROOT / "docs", folder], env={**os.environ, "PYTHONPATH": path})
    if done.returncode == 0:
        (folder / ".buildinfo").unlink(missing_ok=True)
        (folder / STAMP).write_text(sources, "utf-8")
    return done.returncode


if __name__ == "__main__":
    given = sys.argv[1:]
    target = Path(given.pop(0)) if given and not given[0].startswith("-") else BUILT
    sys.exit(build(target.absolute(), given))
