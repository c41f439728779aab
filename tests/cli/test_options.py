"""Options of the command line: one name for one thing, each with a description."""

from collections.abc import Iterator

import click
import pytest

from rocs_bt.cli.main import COMMANDS, group


def commands(parent: click.Group, context: click.Context, path: str = "") -> Iterator[tuple[str, click.Command]]:
    for name in parent.list_commands(context):
        found = parent.get_command(context, name)
        yield f"{path}{name}", found
        if isinstance(found, click.Group):
            yield from commands(found, context, f"{path}{name} ")


FOUND = dict(commands(group, click.Context(group)))


def options(name: str) -> dict[str, click.Option]:
    return {text: o for o in FOUND[name].params if isinstance(o, click.Option) for text in o.opts}


def test_all_commands_are_looked_at():
    assert set(COMMANDS) < set(FOUND)
    assert "rules tune" in FOUND


@pytest.mark.parametrize("name", FOUND)
def test_every_option_is_described(name):
    assert [text for text, option in options(name).items() if not option.help] == []


@pytest.mark.parametrize("name", ["compare", "search"])
def test_worker_processes_are_jobs(rocs_bt, name):
    jobs = options(name)["--jobs"]
    assert jobs is options(name)["-j"]
    told = rocs_bt(name, "tree", "--family", "maze", "-j", 0)
    assert (told.code, "'--jobs' / '-j'" in told.err) == (2, True)


def test_one_name_for_one_thing():
    every = {text for name in FOUND for text in options(name)}
    assert {"--jobs", "--out", "--dry-run", "--tree", "--scenes", "--stop-early", "--cell-size"} <= every
    others = "--workers --processes --threads --output --keep --main --scenarios --early --cell"
    assert not every & set(others.split())
    assert {type(options(name)["--out"].type) for name in FOUND if "--out" in options(name)} == {click.Path}
    for flag in ("--json", "--no-code"):
        assert all(options(name)[flag].is_flag for name in FOUND if flag in options(name))
