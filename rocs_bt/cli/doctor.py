"""`rocs-bt doctor`: check the installation and optional tools on this machine."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass

import click

from ..base.current_folder import safe_path
from ..base.errors import Fault, InputError, RocsError
from ..base.registered import GROUPS, load, registered, unused
from ..base.units import Bounds
from ..catalog import Catalog
from ..expression import kernel_missing
from .docs import find_manual
from .main import COMMANDS
from .options import QuantityType
from .terminal import echo, styled

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
_COMPILERS = ("cc", "gcc", "clang", "cl")
# MuJoCo selects its GL backend when it is loaded, so each one is tried in a separate process.
_RENDER = """
import mujoco
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
with mujoco.Renderer(model, 16, 16) as renderer:
    renderer.render()
"""


@dataclass(frozen=True)
class _Finding:
    """Result of one check; `needed` means that rocs_bt does not work without it."""

    what: str
    works: bool
    detail: str
    needed: bool = False


@click.command()
@click.argument("robot", required=False)
@click.option("--ros2", is_flag=True, help="Examine the topics of ROBOT, or without ROBOT list all topics.")
@click.option(
    "--for",
    "duration",
    type=QuantityType(bounds=Bounds(0.1)),
    default=3.0,
    show_default=True,
    help="With --ros2: duration of the measurement.",
)
@click.option(
    "--network",
    type=click.Choice(["loopback", "lan"]),
    default="loopback",
    show_default=True,
    help="With --ros2 and without ROBOT.",
)
@click.pass_context
def command(ctx: click.Context, robot: str | None, ros2: bool, duration: float, network: str) -> None:
    """Check the installation and optional tools, and print what to install for missing ones.

    With --ros2: join the ROS 2 network for some seconds and publish nothing. For each topic of ROBOT it shows nodes,
    rate, age by both clocks (age), time from the stamp of the message to its publication (header), number of values,
    and mismatches of type and quality of service.

    Exits with 0 if all is well, 1 if a topic that is not optional has a problem, 2 if the input is invalid or a package
    is missing, 3 if a required part of the installation is missing.
    """
    if ros2:
        ctx.exit(load("rocs_bt.commands", "doctor.ros2")(robot, network, duration))
    if robot is not None:
        hint = f"Write: rocs-bt doctor --ros2 {robot}."
        raise InputError(Fault("a robot is examined only with --ros2.", hint=hint))
    broken = False
    for finding in _findings():
        mark = styled("yes", fg="green") if finding.works else styled("no ", fg="red")
        echo(f"{mark}  {finding.what:<14} {finding.detail}")
        broken |= finding.needed and not finding.works
    if broken:
        echo("rocs_bt cannot run until the required parts are installed.", err=True)
        ctx.exit(3)


def _findings() -> Iterator[_Finding]:
    version = sys.version_info[:2]
    supported = (3, 11) <= version <= (3, 14)
    hint = "" if supported else "; rocs_bt needs 3.11 to 3.14"
    yield _Finding("python", supported, f"{platform.python_version()} at {sys.executable}{hint}", needed=True)
    yield _packages()
    yield _content()
    for kind, hint in (("egl", "install libegl1 and a GL driver (mesa)"), ("osmesa", "install libosmesa6")):
        works = _renders(kind)
        yield _Finding(f"GL {kind}", works, "renders: --video works" if works else f"no rendering; {hint} for --video")
    display = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")) or sys.platform in (
        "darwin",
        "win32",
    )
    yield _Finding("display", display, "--view works" if display else "no display: --view does not work here")
    yield _Finding("encoder", _has("imageio-ffmpeg"), "for --video" if _has("imageio-ffmpeg") else _extra("video"))
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    yield _Finding("browser", browser is not None, browser or "no Chromium or Chrome; tests of the report are skipped")
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    yield _Finding("C compiler", compiler is not None, compiler or "none; rocs_bt works without one")
    missing = kernel_missing()
    yield _Finding(
        "rules' kernel",
        not missing,
        f"rules run in Python: {missing}" if missing else "rules run in the compiled kernel",
    )
    manual = find_manual()
    yield _Finding("manual", manual is not None, "rocs-bt docs opens it" if manual else "not in this installation")
    headers = sysconfig.get_path("include")
    yield _Finding("Python headers", os.path.isfile(f"{headers}/Python.h"), headers)
    for group in GROUPS:
        for name in registered(group):
            try:
                load(group, name)
            except InputError as error:
                yield _Finding("registered", False, f"{error.faults[0].message} {error.faults[0].hint}")
        for found in unused(group, COMMANDS if group == "rocs_bt.commands" else ()):
            package = found.dist.name if found.dist else found.value
            message = f"the {GROUPS[group]} '{found.name}' of the package {package} is not used"
            yield _Finding("registered", False, f"{message}: rocs_bt has one of this name. Rename it.")


def _packages() -> _Finding:
    """Check the required packages, without those of the extras."""
    required = (
        [r for r in importlib.metadata.requires("rocs_bt") or [] if "extra ==" not in r] if _has("rocs_bt") else []
    )
    names = [re.split(r"[^A-Za-z0-9_.-]", r, maxsplit=1)[0] for r in required]
    missing = [n for n in names if not _has(n)]
    if missing:
        return _Finding("packages", False, f"missing: {', '.join(missing)}; reinstall rocs_bt with pip", True)
    found = [f"{n} {importlib.metadata.version(n)}" for n in ("mujoco", "casadi", "py-trees", "numpy") if _has(n)]
    return _Finding("packages", bool(found), ", ".join(found) or "none; install rocs_bt with pip", True)


def _content() -> _Finding:
    try:
        catalog = Catalog.here()
        entries = catalog.list()
    except RocsError as error:
        return _Finding("content", False, str(error), True)
    project = f", project in {catalog.project}" if catalog.project else "; this folder is not in a project"
    return _Finding("content", True, f"{len(entries)} entries; shipped content in {catalog.shipped}{project}", True)


def _has(package: str) -> bool:
    try:
        importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def _extra(name: str) -> str:
    return f'not installed: pip install "rocs_bt[{name}]"'


def _renders(kind: str) -> bool:
    environment = {**os.environ, **safe_path(), "MUJOCO_GL": kind}
    try:
        done = subprocess.run([sys.executable, "-c", _RENDER], env=environment, capture_output=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0
