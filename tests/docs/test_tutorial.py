"""docs/tutorial.md: every file is written, every command is run, and it prints what the page says.

`python tests/docs/test_tutorial.py` writes the new outputs into the page, after a change that is meant. A line `...` of
the page stands for any lines; an output with such a line is not renewed.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from rocs_bt.cli.main import call

TUTORIAL = Path(__file__).resolve().parents[2] / "docs" / "tutorial.md"
STEP = re.compile(
    r"[Ss]ave as `(?P<file>[^`]+)`:\n\n```\w+\n(?P<content>.*?)```|```console\n(?P<console>.*?)```", re.DOTALL
)
COMMAND = re.compile(r"^\$ (?P<command>.*)\n(?P<said>(?:(?!\$ ).*\n)*)", re.MULTILINE)
TIMES = re.compile(r"simulated in [\d.]+ s \([\d.]+ times real time\)")


def play(folder: Path) -> Iterator[tuple[str, str, str]]:
    """Follow the page in a folder: each command, what the page says that it prints, and what it prints."""
    for step in STEP.finditer(TUTORIAL.read_text("utf-8")):
        if step["file"]:
            (folder / step["file"]).write_text(step["content"], "utf-8")
            continue
        for command in COMMAND.finditer(step["console"]):
            program, *arguments = shlex.split(command["command"])
            if program == "cd":
                folder = folder / arguments[0]
                yield command["command"], command["said"], ""
                continue
            assert program == "rocs-bt"
            with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as out:
                call(arguments)
            lines = [line.rstrip() for line in out.getvalue().replace(f"{folder}{os.sep}", "").splitlines()]
            yield command["command"], command["said"], "".join(f"{line}\n" for line in lines)


def pattern(said: str) -> str:
    parts = [re.escape(TIMES.sub("<times>", part)) for part in re.split(r"^\.\.\.\n", said, flags=re.MULTILINE)]
    return "(?:.*\n)*?".join(parts)


def test_every_command_prints_what_the_page_says(monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "100")
    commands = 0
    for command, said, printed in play(tmp_path):
        assert re.fullmatch(pattern(said), TIMES.sub("<times>", printed)), f"{command}\n{printed}"
        commands += 1
    assert commands > 10


@pytest.mark.parametrize("command", ["new", "check", "run", "show", "rules test", "replay", "compare"])
def test_the_page_uses_the_main_commands(command):
    assert f"$ rocs-bt {command}" in TUTORIAL.read_text("utf-8")


if __name__ == "__main__":
    os.environ["COLUMNS"] = "100"
    with tempfile.TemporaryDirectory() as name:
        played = list(play(Path(name).resolve()))
    text, start = TUTORIAL.read_text("utf-8"), 0
    for command, said, printed in played:
        old = f"$ {command}\n{said}"
        start = text.index(old, start)
        new = old if re.search(r"^\.\.\.$", said, re.MULTILINE) else f"$ {command}\n{printed}"
        text = text[:start] + new + text[start + len(old) :]
        start += len(new)
    TUTORIAL.write_text(text, "utf-8")
