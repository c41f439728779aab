"""No command imports a file of the current folder in place of a module of Python or of a dependency."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path

import click
import pytest

from rocs_bt.cli.main import group

SCENARIOS = Path(__file__).parents[2] / "scenarios"
DOCK = SCENARIOS / "dock.toml"  # its mission is no Python
COMMANDS = f"""
list
new project
show go_to
show dock
show --palette
check {DOCK}
run {DOCK} --for 0.2 --out run --knowledge known
drive {SCENARIOS}/exp1_ros2.toml --wait 0.1 --for 0.1
sim {DOCK} --ros2 --for 0.2 --rate 0
replay run
replay run --why 0.1
report run
export run --rosbag bag
plot run
run exp1 --planner go_to_origin --for 0.2
compare go_to_origin --scenario exp1 --seeds 1 --wall-limit 20
search go_to_origin --family barn_like --budget 1 --set goal=1
scene barn_like 1 --dry-run
import map maps
rules replay avoid_collision run
rules test avoid_collision
rules tune avoid_collision run --rule Flinch --threshold flinch_near --steps 2
knowledge export known --out exported.json
knowledge import exported.json known
knowledge query known robot
knowledge show known
knowledge why known
knowledge keys A B
requirements run
identify pioneer_p3dx
docs --path
doctor
doctor --ros2 jackal_ros2
language-server --help
studio --help
"""
RUN_ALL = """
import os, sys
from rocs_bt.base import python_content
def load_module(path, load=python_content.load_module):
    loaded.append(path)
    return load(path)
python_content.load_module = load_module  # the only door of Python content
from rocs_bt.cli.main import main
os.environ["PYTHONPATH"] = os.pathsep  # empty entries are the current folder; PYTHONPATH=$PYTHONPATH:/lib makes one
for command in sys.argv[1:]:
    mark, _, line = command.partition(":")
    sys.argv[1:], loaded = line.split(), []
    try:
        main()
    except SystemExit as end:
        if end.code == 3: raise
    assert "PYTHONSAFEPATH" not in os.environ, "scripts that a user's code starts do not see their folder"
    assert mark == "code" or not loaded, f"'{line}' runs {loaded[0]}"
"""
TRAP = "open({mark!r}, 'w').close()\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a file for each module that rocs_bt could import; each leaves a mark when it is run."""
    (tmp_path / "marks").mkdir()
    (tmp_path / "here").mkdir()
    modules = {*sys.stdlib_module_names, *packages_distributions()} - {"pathlib", "rocs_bt"}
    for name in modules:
        if name.isidentifier():
            (tmp_path / "here" / f"{name}.py").write_text(TRAP.format(mark=str(tmp_path / "marks" / name)))
    (tmp_path / "here/maps").mkdir()
    (tmp_path / "here/maps/room.pgm").write_bytes(b"P5 90 90 255 " + bytes([254] * 8100))
    (tmp_path / "here/maps/room.yaml").write_text("image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n")
    return tmp_path / "here"


def marks(folder: Path) -> list[str]:
    return sorted(each.name for each in (folder.parent / "marks").iterdir())


def python(folder: Path, *arguments: str) -> None:
    """Run Python in a folder, as a user does whose environment says nothing of its path."""
    shell = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    command = [sys.executable, *arguments]
    done = subprocess.run(command, cwd=folder, env=shell, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr


def leaves(command: click.Command, path: tuple[str, ...] = ()) -> Iterator[tuple[str, click.Command]]:
    if isinstance(command, click.Group):
        for name in command.list_commands(click.Context(command)):
            found = command.get_command(click.Context(command), name)
            assert found is not None
            yield from leaves(found, (*path, name))
    else:
        yield " ".join(path), command


def lines() -> list[tuple[str, bool]]:
    """Each command line, and whether its command has --no-code."""
    table = [each for each in COMMANDS.splitlines() if each]
    found = []
    for name, command in leaves(group):
        own = [each for each in table if f"{each} ".startswith(f"{name} ")]
        assert own, f"the table above has no line for the command '{name}'"
        found += [(each, any("--no-code" in parameter.opts for parameter in command.params)) for each in own]
    return sorted(found, key=lambda each: table.index(each[0]))


def test_the_trap_works(folder: Path) -> None:
    python(folder, "-c", "import struct")
    assert "struct" in marks(folder)


def test_no_command_imports_a_file_of_the_current_folder(folder: Path) -> None:
    table = lines()
    free = [f"{'code' if has else ''}:{each}" for each, has in table]
    python(folder, "-P", "-c", RUN_ALL, *free, *(f":{each} --no-code" for each, has in table if has))
    assert marks(folder) == []


def test_python_m_imports_no_dependency_from_the_current_folder(folder: Path) -> None:
    for name in sys.stdlib_module_names:  # Python itself imports some of them before any line of rocs_bt
        (folder / f"{name}.py").unlink(missing_ok=True)
    python(folder, "-m", "rocs_bt", "--version")
    assert marks(folder) == []
