"""Content that prints: a command with an output for programs keeps its standard output to itself."""

import json
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import click
import pytest

from rocs_bt.cli import main
from rocs_bt.cli.content import _reserve

from ..noise import WAYS, write_noisy_project
from ..waiting import GUARD


@pytest.fixture(scope="module")
def noisy(tmp_path_factory):
    return write_noisy_project(tmp_path_factory.mktemp("noisy") / "project")


@pytest.mark.parametrize(
    ("line", "read"),
    [
        ("check --json", json.loads),
        ("run loud --for 0.2 --json", json.loads),
        ("list --json", json.loads),
        ("show --palette", ElementTree.fromstring),
        ("show loud --format svg", ElementTree.fromstring),
    ],
)
def test_standard_output_is_only_what_the_command_writes(noisy, line, read):
    command = [sys.executable, "-m", "rocs_bt", *line.split()]
    done = subprocess.run(command, cwd=noisy, capture_output=True, timeout=GUARD)
    read(done.stdout.decode())
    loads = not line.startswith("list")  # which runs no code
    for way in WAYS:
        assert (f"{way} import\n".encode() in done.stderr) == loads
        assert (f"{way} tick\n".encode() in done.stderr) == line.startswith("run")


def leaves(group, context):
    for name in group.list_commands(context):
        found = group.get_command(context, name)
        yield from leaves(found, context) if isinstance(found, click.Group) else [found]


def test_every_command_with_json_keeps_its_standard_output():
    found = [p for c in leaves(main.group, click.Context(main.group)) for p in c.params if "--json" in p.opts]
    assert len(found) >= 10
    assert {option.callback for option in found} == {_reserve}


def test_standard_output_is_restored(capfd, noisy, monkeypatch):
    monkeypatch.chdir(noisy)
    assert main.call(["list", "--json"]) == 0
    json.loads(capfd.readouterr().out)
    print("after")
    assert capfd.readouterr().out == "after\n"
