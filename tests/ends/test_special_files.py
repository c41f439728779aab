"""Named pipes, sockets, devices, folders and endless files in place of files: every reader and writer refuses them.

None waits for content that never comes, and none replaces them.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import click
import pytest

import rocs_bt as package
from rocs_bt.base import files
from rocs_bt.cli.main import call, group

from .. import needs

pytestmark = needs.posix("has no named pipes")

ENGINE = Path(package.__file__).parent
MESH = '<mujoco><asset><mesh name="m" file="m.stl"/></asset></mujoco>'
WORLD = '<mujoco><include file="walls.xml"/></mujoco>'
SUBTREES = '<root BTCPP_format="4"><include path="part.xml"/></root>'
BTPROJ = '<root BTCPP_format="4" project_name="p"><include path="part.xml"/></root>'
YAML = "image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.2\nnegate: 0\n"
KNOWLEDGE = '{"format": "knowledge/1", "agents": []}'

READ: list[tuple[str, str, dict[str, str]]] = [
    # command, the file in the way, files beside it
    ("check rules/keep_clear.toml", "rules/keep_clear.toml", {}),
    ("check planners/brisk.toml", "planners/brisk.toml", {}),
    ("check planners/missions/patrol.py", "planners/missions/patrol.py", {}),
    ("check planners/missions/x.xml", "planners/missions/x.xml", {}),
    ("check planners/missions/x.xml", "planners/missions/part.xml", {"planners/missions/x.xml": SUBTREES}),
    ("check x.btproj", "x.btproj", {}),
    ("check x.btproj", "part.xml", {"x.btproj": BTPROJ}),
    ("check planners/routes/x.py", "planners/routes/x.py", {}),
    ("check planners/nodes/x.py", "planners/nodes/x.py", {}),
    ("check scenarios/families/x.py", "scenarios/families/x.py", {}),
    ("check scenarios/schema/x.toml", "scenarios/schema/x.toml", {}),
    ("check scenarios/first.toml", "scenarios/first.toml", {}),
    ("check scenarios/worlds/yard.xml", "scenarios/worlds/yard.xml", {}),
    ("check scenarios/worlds/w.xml", "scenarios/worlds/walls.xml", {"scenarios/worlds/w.xml": WORLD}),
    ("check scenarios/worlds/w.xml", "scenarios/worlds/m.stl", {"scenarios/worlds/w.xml": MESH}),
    ("check robots/rover/robot.toml", "robots/rover/robot.toml", {}),
    ("check robots/rover/robot.xml", "robots/rover/robot.xml", {}),
    ("check robots/rover/identified.toml", "robots/rover/identified.toml", {}),
    ("check rules/tests/keep_clear.toml", "rules/tests/keep_clear.toml", {}),
    ("check --palette p.xml planners/missions", "p.xml", {}),
    ("run first --for 0.1", "scenarios/first.toml", {}),
    ("run p.toml", "p.toml", {}),
    ("run first --for 0.1 --knowledge k.json", "k.json", {}),
    ("run first --for 2 --swap patrol=p.xml@1", "p.xml", {}),
    ("drive p.toml", "p.toml", {}),
    ("sim p.toml --ros2", "p.toml", {}),
    ("studio p --no-browser", "p", {}),
    ("show p.xml", "p.xml", {}),
    ("show rules/keep_clear.toml", "rules/keep_clear.toml", {}),
    ("show patrol --robot rover", "robots/rover/robot.toml", {}),
    ("identify rover --dry-run", "robots/rover/robot.xml", {}),
    ("rules test", "rules/keep_clear.toml", {}),
    ("rules test rules/keep_clear.toml", "rules/tests/keep_clear.toml", {}),
    ("rules replay keep_clear r", "r/run.mcap", {}),
    ("rules tune keep_clear r --rule AvoidCollision --threshold near", "r/run.mcap", {}),
    ("replay r", "r/run.mcap", {}),
    ("replay r/run.mcap --why 1", "r/run.mcap", {}),
    ("replay --bag b.mcap --robot rover", "b.mcap", {}),
    ("replay --bag b.db3 --robot rover", "b.db3", {}),
    ("replay --bag b.bag --robot rover", "b.bag", {}),
    ("replay --bag b --robot rover", "b/metadata.yaml", {}),
    ("replay --bag b --robot rover", "b/b.mcap", {}),
    ("report r", "r/run.mcap", {}),
    ("export r --rosbag bag", "r/run.mcap", {}),
    ("plot r", "r/run.mcap", {}),
    ("requirements r", "r/run.mcap", {}),
    ("knowledge show k.json", "k.json", {}),
    ("knowledge export k.json", "k.json", {}),
    ("knowledge export r", "r/run.mcap", {}),
    ("knowledge import k.json kept.json", "k.json", {}),
    ("knowledge import k.json kept.json", "kept.json", {"k.json": KNOWLEDGE}),
    ("knowledge query r true", "r/run.mcap", {}),
    ("knowledge why k.json", "k.json", {}),
    ("compare brisk --scenario first --store s", "s/episodes.sqlite", {}),
    ("compare brisk --scenario p.toml", "p.toml", {}),
    ("compare p.toml --scenario first", "p.toml", {}),
    ("search brisk --family maze --store s", "s/episodes.sqlite", {}),
    ("run p.toml --planner brisk", "p.toml", {}),
    ("import map maps", "maps/m.pgm", {"maps/m.yaml": YAML}),
    ("import barn maps", "maps/world_0.world", {}),
    ("knowledge keys R1", "keys/authority.key", {}),
]
WRITTEN = [
    "show --palette --out p",
    "show patrol --out p",
    "show patrol --format svg --out p",
    "compare brisk careful --scenario first --report p",
    "compare brisk careful --scenario first --markdown p",
    "compare brisk careful --scenario first --export p",
    "new p",
    "run first --for 0.1 --out p",
    "run first --for 0.1 --video p.gif",
    "run first --for 0.1 --knowledge p",
    "search brisk --family maze --out p",
    "scene maze 1 --out p",
    "knowledge keys R1 --out p",
    "run first --planner brisk --for 0.1 --out p",
]


class _TooLong(BaseException):
    """Raised if a command waits."""


@contextmanager
def _ends() -> Iterator[None]:
    """The body ends; the time, which is ample, is only reached by what waits for ever."""

    def stop(*_: object) -> None:
        raise _TooLong

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, 60.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _pipe(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    os.mkfifo(path)


def _refused(line: str, capsys: pytest.CaptureFixture[str], *names: str) -> None:
    with _ends():
        code = call(line.split())
    out, err = capsys.readouterr()
    assert code == 2, out + err
    assert "Traceback" not in out + err
    assert re.search("it is a named pipe", out + err), out + err
    for name in names:
        assert name in out + err


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pipes") / "yard"
    assert call(["new", str(folder)]) == 0
    (folder / "maps").mkdir()
    return folder


@pytest.fixture
def project(template: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = shutil.copytree(template, tmp_path / "yard")
    monkeypatch.chdir(folder)
    return Path(folder)


@pytest.mark.parametrize(("line", "pipe", "beside"), READ, ids=[f"{line}: {pipe}" for line, pipe, _ in READ])
def test_no_command_waits_for_a_pipe_that_it_reads(line, pipe, beside, project, capsys):
    for name, text in beside.items():
        (project / name).write_text(text)
    _pipe(project / pipe)
    _refused(line, capsys, Path(pipe).name)


@pytest.mark.parametrize("line", WRITTEN)
def test_no_command_replaces_a_pipe_or_waits_for_it_to_write(line, project, capsys):
    target = project / line.split()[-1] if line != "new p" else project / "p"
    _pipe(target)
    with _ends():
        code = call(line.split())
    out, err = capsys.readouterr()
    assert code == 2, out + err
    assert "Traceback" not in out + err
    assert target.is_fifo()


def _file_options(command: click.Command, name: str) -> Iterator[tuple[str, str]]:
    if isinstance(command, click.Group):
        for each in command.list_commands(click.Context(command)):
            inner = command.get_command(click.Context(command), each)
            assert inner is not None
            yield from _file_options(inner, f"{name} {each}".strip())
    for parameter in command.params:
        if isinstance(parameter.type, click.Path):
            yield name, parameter.opts[0] if isinstance(parameter, click.Option) else ""


def test_every_option_of_the_command_line_that_names_a_file_is_in_the_tables():
    lines = [*(line for line, _, _ in READ), *WRITTEN]
    for command, option in _file_options(group, ""):
        assert any(line.startswith(command) for line in lines), command
        assert any(option in line for line in lines), option


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(path))


SPECIAL: dict[str, Callable[[Path], object]] = {
    "a named pipe": os.mkfifo,
    "a socket": _socket,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    "a folder": lambda path: path.mkdir(),
}


@pytest.mark.parametrize("what", SPECIAL)
def test_what_is_no_regular_file_is_neither_read_nor_replaced(what, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # names of sockets are short
    path = Path("x")
    SPECIAL[what](path)
    before = os.lstat(path)
    for use in (files.read_bytes, files.check_regular, files.create, lambda p: files.write_whole(p, "text")):
        with _ends(), pytest.raises(OSError, match=f"it is {what}"):
            use(path)
    with pytest.raises(package.InputError, match=f"x: cannot read the file: it is {what}"):
        files.read_text(path)
    assert os.lstat(path) == before


def test_a_file_without_end_is_refused_unread(tmp_path):
    with (tmp_path / "x").open("wb") as file:
        file.truncate(1 << 40)
    for read in (files.read_bytes, files.read_text):
        with pytest.raises((OSError, package.InputError), match="it has 1,099,512 MB; the maximum is"):
            read(tmp_path / "x")


OPENED = re.compile(
    r"\.(read|write)_(text|bytes)\(|(?<!def )\b(?<!\.)(io\.|os\.)?open\(|\.open\([\"'][rwax]|tomllib\.load\("
)
EXEMPT = {
    # files of the system, or of this package, which no user names
    "base/files.py",
    "record/file/folder_lock.py",
    "devices/isolated/silence.py",
    "ros2/network/rclpy_transport.py",
    "cli/terminal.py",
    "studio/live.py",
}


def test_the_engine_opens_files_in_one_module_only():
    found = {
        f"{name}: {line.strip()}"
        for file in sorted(ENGINE.rglob("*.py"))
        if (name := file.relative_to(ENGINE).as_posix()) not in EXEMPT and not name.startswith("_content")
        for line in file.read_text().splitlines()
        if OPENED.search(line)
    }
    assert not found
