"""Builds the rules' kernel and the manual with the package, where there is a C compiler and where there is Sphinx.

A wheel that carries it is of this platform and of CPython 3.11 and later; one that does not is of any. An editable
install puts the kernel beside its source. The manual is left out if ROCS_BT_NO_MANUAL is set.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCE = Path("rocs_bt", "expression", "_kernel.c")
BINARY = SOURCE.with_name(f"{SOURCE.stem}.abi3.so")
# Results must be Python's own, bit for bit: no fused multiply-add, nothing of -ffast-math that changes a value.
FLAGS = [
    "-std=c11", "-O3", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math",
    "-DNDEBUG",
]  # fmt: skip  # flags as on a command line


class BuildHook(BuildHookInterface[Any]):
    """Adds the kernel to wheels, and the manual to wheels and sdists; see the module."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called by hatchling before it builds; `version` is `standard` or `editable`."""
        self._folder = tempfile.mkdtemp()
        if self.target_name == "wheel":
            self._add_kernel(version, build_data)
        if version != "editable":
            self._add_manual(build_data)

    def _add_manual(self, build_data: dict[str, Any]) -> None:
        script = Path(self.root, "docs", "build.py")
        if not script.is_file() or os.environ.get("ROCS_BT_NO_MANUAL"):
            return  # a wheel from an sdist has the manual of the sdist
        folder = Path(self._folder, "manual")
        done = subprocess.run([sys.executable, script, folder], capture_output=True, text=True)
        if done.returncode:
            self.app.display_warning(f"The manual is left out: {(done.stdout + done.stderr).strip()[-500:]}")
            return
        for path in folder.rglob("*"):
            if path.is_file() and path.name != ".sources":
                build_data["force_include"][str(path)] = f"rocs_bt/_manual/{path.relative_to(folder).as_posix()}"

    def _add_kernel(self, version: str, build_data: dict[str, Any]) -> None:
        root = Path(self.root)
        made = Path(self._folder, BINARY.name)
        reason = compile_kernel(root / SOURCE, made)
        if reason:
            self.app.display_info(f"The rules' kernel is left out; Python replaces it. {reason}")
        if version == "editable":
            if reason:
                (root / BINARY).unlink(missing_ok=True)  # it may be of another source
            else:
                beside = root / BINARY.with_name(f".{BINARY.name}.{os.getpid()}")
                shutil.copy(made, beside)
                beside.replace(root / BINARY)  # at once: it may be in use
        elif not reason:
            build_data["pure_python"] = False
            build_data["tag"] = f"cp311-abi3-{_platform()}"
            build_data["force_include"][str(made)] = BINARY.as_posix()

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Called by hatchling when it has built the wheel."""
        shutil.rmtree(self._folder, ignore_errors=True)


def compile_kernel(source: Path, binary: Path) -> str:
    """Compile; gives why that is not possible here, or nothing."""
    if os.name == "nt":
        return "It is not built on Windows."
    compiler = _compiler()
    if not compiler:
        return "No C compiler was found."
    shared = ["-bundle", "-undefined", "dynamic_lookup"] if sys.platform == "darwin" else ["-shared"]
    headers = [f"-I{sysconfig.get_path(name)}" for name in ("include", "platinclude")]
    command = [*compiler, *FLAGS, *headers, *shared, str(source), "-o", str(binary), "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"The C compiler does not run: {error}"
    return "" if done.returncode == 0 else f"The C compiler failed: {done.stderr.strip()}"


def _compiler() -> list[str]:
    """The C compiler as words: the one that CC names, the one that built Python, or the system's."""
    wanted = [os.environ.get("CC")] if "CC" in os.environ else [sysconfig.get_config_var("CC"), "cc", "gcc", "clang"]
    words = [shlex.split(command) for command in wanted if command]
    return next((found for found in words if found and shutil.which(found[0])), [])


def _platform() -> str:
    """This platform, as names of wheels tell it."""
    from packaging.tags import sys_tags

    # As hatchling chooses: a wheel that was linked here claims no more than this system.
    tag = next(t for t in sys_tags() if "manylinux" not in t.platform and "musllinux" not in t.platform)
    if sys.platform != "darwin":
        return tag.platform
    from hatchling.builders.macos import process_macos_plat_tag

    return process_macos_plat_tag(tag.platform, compat=False)
