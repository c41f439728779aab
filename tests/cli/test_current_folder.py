"""No command imports a file of the current folder in place of a module of Python or of a dependency."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

COMMANDS = """
list | show go_to | palette --no-code | check {exp1} --no-code | run exp1 --for 0.2 --no-code --no-report --out run
replay run | rules test | doctor
"""
RUN_ALL = """
import os, sys
from rocs_bt.cli.main import main
commands = sys.argv[1:]
for command in commands:
    sys.argv[1:] = command.split()
    try:
        main()
    except SystemExit as end:
        if end.code == 3: raise
    assert "PYTHONSAFEPATH" in os.environ
"""
TRAP = "open({mark!r}, 'w').close()\n"
EXP1 = Path(__file__).parents[2] / "scenarios/exp1.toml"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a file for each module that rocs_bt could import; each leaves a mark when it is run."""
    (tmp_path / "marks").mkdir()
    (tmp_path / "here").mkdir()
    modules = {*sys.stdlib_module_names, *packages_distributions()} - {"pathlib", "rocs_bt"}
    for name in modules:
        if name.isidentifier():
            (tmp_path / "here" / f"{name}.py").write_text(TRAP.format(mark=str(tmp_path / "marks" / name)))
    return tmp_path / "here"


def marks(folder: Path) -> list[str]:
    return sorted(each.name for each in (folder.parent / "marks").iterdir())


def test_the_trap_works(folder: Path) -> None:
    unsafe = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    command = [sys.executable, "-c", "import struct"]
    subprocess.run(command, cwd=folder, env=unsafe, capture_output=True, timeout=60)
    assert "struct" in marks(folder)


def test_no_command_imports_a_file_of_the_current_folder(folder: Path) -> None:
    commands = [each.strip().format(exp1=EXP1) for each in COMMANDS.replace("\n", "|").split("|") if each.strip()]
    done = subprocess.run(
        [sys.executable, "-P", "-c", RUN_ALL, *commands], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert marks(folder) == []


def test_python_m_imports_no_dependency_from_the_current_folder(folder: Path) -> None:
    for name in sys.stdlib_module_names:  # Python itself imports some of them before any line of rocs_bt
        (folder / f"{name}.py").unlink(missing_ok=True)
    command = [sys.executable, "-m", "rocs_bt", "--version"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "rocs-bt" in done.stdout
    assert marks(folder) == []


def test_the_simulator_imports_nothing_of_the_current_folder(folder: Path) -> None:
    code = "import rocs_bt.drivers.mujoco; import mujoco"
    done = subprocess.run([sys.executable, "-P", "-c", code], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert marks(folder) == []
