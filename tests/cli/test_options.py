"""Options of the command line: one name for one thing, each with a description."""

import math
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.cli.main import COMMANDS, group
from rocs_bt.cli.options import QuantityType
from rocs_bt.declare import options_of
from rocs_bt.record import SubtreeSwap
from rocs_bt.running import RunOptions


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
    assert {"--jobs", "--out", "--dry-run", "--tree", "--scenes", "--stop-early"} <= every
    others = "--workers --processes --threads --output --keep --main --scenarios --early --cell"
    assert not every & set(others.split())
    assert {type(options(name)["--out"].type) for name in FOUND if "--out" in options(name)} == {click.Path}
    for flag in ("--json", "--no-code"):
        assert all(options(name)[flag].is_flag for name in FOUND if flag in options(name))


QUANTITIES = [
    (name, text, o) for name in FOUND for text, o in options(name).items() if isinstance(o.type, QuantityType)
]


def test_no_option_takes_a_number_without_a_unit():
    assert len(QUANTITIES) > 14
    plain = (click.types.FloatParamType, click.FloatRange)
    assert [(name, o.opts) for name in FOUND for o in options(name).values() if isinstance(o.type, plain)] == []


@pytest.mark.parametrize(("name", "text", "option"), QUANTITIES, ids=lambda each: each if isinstance(each, str) else "")
def test_each_quantity_has_a_unit_or_is_in_si_units(name, text, option):
    def read(given):
        return option.type.convert(given, option, None)

    unit, shorter = {"SECONDS": ("s", "ms"), "HZ": ("Hz", "kHz")}.get(option.type.get_metavar(option), ("", "%"))
    assert read("4.5") == read(f"4.5 {unit}") == read(f"4.5{unit}") == 4.5
    factor = {"ms": 1e-3, "kHz": 1e3, "%": 1e-2}[shorter]
    assert read(f"4500{shorter}") == pytest.approx(4500 * factor)
    for wrong in ("4 kg", "4 parsec", "", "four", "inf", "nan", "-1", "4 4"):
        if text == "--why" and wrong == "-1":
            continue
        with pytest.raises(InputError, match=f"^{text} must be"):
            read(wrong)


@pytest.mark.parametrize(("name", "stage"), [("run", "simulation"), ("drive", "hardware")])
def test_the_options_of_a_run_are_those_that_it_declares(name, stage):
    found = {option.name: option for option in options(name).values()}
    for attribute, (each, declared) in options_of(RunOptions).items():
        assert (attribute in found) == (bool(declared.flags) and declared.stage in ("", stage))
        if attribute in found:
            assert (found[attribute].help, found[attribute].default) == (each.doc, each.default)


FUNCTIONS = ("prepare", "go", "preflight", "notice")
"""Options that are functions."""


@pytest.mark.parametrize("name", [name for name, (_, each) in options_of(RunOptions).items() if each.stage])
def test_an_option_of_one_stage_is_refused_on_the_other(name):
    other = {"simulation": "hardware", "hardware": "simulation"}[options_of(RunOptions)[name][1].stage]
    value = {"mode": "threaded", "video": Path("v.mp4"), "follow": "R2", "wait": 0.0, **dict.fromkeys(FUNCTIONS, print)}
    given = {name: value.get(name, True), **({"video": Path("v.mp4")} if name == "follow" else {})}
    if name == "swaps":
        given = {name: (SubtreeSwap("a", "b.xml", 1.0),)}
    if name == "mode":  # `drive` is always threaded
        RunOptions(**given).refuse_other(other)
        return
    with pytest.raises(InputError, match=rf"remove (the option )?.*{name}\."):
        RunOptions(**given).refuse_other(other)


def test_the_command_line_of_a_run_repeats_what_affects_it(tmp_path):
    swap = SubtreeSwap("a b", "b.xml", 1.0)
    given = RunOptions(mode="threaded", duration=2.5, out=tmp_path, report=False, knowledge="k.db", swaps=(swap,))
    text = "rocs-bt run exp1 --seed 1 --mode threaded --for 2.5 --knowledge k.db --swap 'a b=b.xml@1'"
    assert given.command_line("rocs-bt run exp1") == text


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"seed": -1}, "the option seed must be at least 0, found -1"),
        ({"seed": 1.5}, "the option seed must be a whole number, found 1.5"),
        ({"wait": math.inf}, "the option wait must be finite, found inf"),
        ({"duration": 0.0}, "the option duration must be positive, found 0"),
        ({"report": "no"}, "the option report must be true or false, found 'no'"),
        ({"sinks": 3}, "the option sinks must be a list, found 3"),
        ({"sinks": [print]}, "each of the option sinks must be an object of the type EventSink"),
        ({"missions": {"R1": 3}}, "R1 of the option missions must be a function, found 3"),
        ({"progress": True}, "the option progress must be a function, found True"),
        ({"mode": "fast", "seed": -1}, "the option seed .*invalid value 'fast' for the option mode"),
    ],
)
def test_a_wrong_value_of_an_option_is_an_error(given, message):
    with pytest.raises(InputError, match=f"(?s){message}"):
        RunOptions(**given)
