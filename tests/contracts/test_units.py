"""Units of all declared parameters: the class, its docstring and the reader of files agree on them."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from rocs_bt import Catalog
from rocs_bt.actions import action_table
from rocs_bt.analyze import ANALYZERS
from rocs_bt.base.errors import InputError, UnitError
from rocs_bt.base.units import NONE, parse_unit
from rocs_bt.catalog import mission_values
from rocs_bt.check import check_content
from rocs_bt.declare import Field, fields_of, read_arguments
from rocs_bt.devices.simulated import ACTUATORS, SENSORS
from rocs_bt.interfaces.action import parameters_of
from rocs_bt.monitor import MONITORS
from rocs_bt.plan import mission_parameters


def owners() -> Iterator[tuple[str, type, Mapping[str, Field]]]:
    """Name, documented class and parameters of every shipped class whose parameters files give."""
    declared: Any = {**MONITORS, **ANALYZERS, **SENSORS, **ACTUATORS}
    yield from ((n, c, {f.name: f for f in fields_of(c)}) for n, c in declared.items())
    yield from ((n, c, parameters_of(c)) for n, c in action_table().items())
    catalog, seen = Catalog(), set[str]()
    for robot in (catalog.load_robot(entry.name) for entry in catalog.list("robot")):
        blocks, devices = [*robot.monitors, *robot.analyzers], [*robot.sensors, *robot.actuators]
        for reference in (*(block.cls for block in blocks), *(device.driver for device in devices)):
            file, _, name = reference.partition(":")
            if name and reference not in seen:
                seen.add(reference)
                cls = catalog.load_class(robot.beside(file), name)
                yield reference, cls, {each.name: each for each in fields_of(cls)}


OWNERS = list(owners())


def numeric(parameter: Field) -> bool:
    return parameter.dimension is not None and parameter.many != "named"


def wrong(parameter: Field) -> Iterator[Any]:
    """Values in the form of the parameter with a unit of another dimension, and a bare one where a unit is needed."""
    bare = [] if parameter.dimension == NONE else [1.5]
    for value in ("3 kg" if "kg" not in str(parameter.dimension) else "3 m", *bare):
        each = [value] * len(parameter.parts) if parameter.parts else value
        yield [each] if parameter.many else each


@pytest.mark.parametrize(("name", "cls", "declared"), OWNERS, ids=[name for name, _, _ in OWNERS])
def test_a_value_of_another_dimension_is_one_fault(name: str, cls: type, declared: Mapping[str, Field]) -> None:
    for parameter in filter(numeric, declared.values()):
        for value in wrong(parameter):
            with pytest.raises(InputError, match=parameter.name) as caught:
                read_arguments({parameter.name: parameter}, {parameter.name: value}, name)
            assert len(caught.value.faults) == (len(parameter.parts) or 1), (parameter, value)


AGENT = 'world = "plane"\n[[agent]]\nname = "R1"\nrobot = "jackal"\nx = "0 m"\ny = "0 m"\nrules = []\n'
MISSION = {
    "scenario": f'format = "scenario/2"\n{AGENT}mission = "{{}}"\n[agent.parameters]\n',
    "planner": 'format = "planner/1"\nmission = "{}"\n[parameters]\n',
}
"""A mission with parameters in a file of each kind, without the last line."""


@pytest.mark.parametrize("kind", MISSION)
@pytest.mark.parametrize("name", [entry.name for entry in Catalog().list("mission")])
def test_a_value_of_another_dimension_is_one_fault_at_its_place(name: str, kind: str, tmp_path: Path) -> None:
    """Of the parameters of each shipped mission, in a scenario and in a planner."""
    catalog, file, text = Catalog(), tmp_path / "own.toml", MISSION[kind].format(name)
    build = catalog.load_mission(name)
    for key, parameter in mission_parameters(build).items():
        for value in wrong(parameter) if numeric(parameter) else ():
            file.write_text(f"{text}{key} = {json.dumps(value)}\n")
            user = catalog.load_planner(str(file)) if kind == "planner" else catalog.load_scenario(str(file)).agents[0]
            with pytest.raises(InputError) as caught:
                mission_values(build, user)
            own = [fault for fault in caught.value.faults if "the mission needs" not in fault.message]
            assert [(f.file, f.line, f.column) for f in own] == [(file, text.count("\n") + 1, 1)]


@pytest.mark.parametrize(("name", "cls", "declared"), OWNERS, ids=[name for name, _, _ in OWNERS])
def test_the_documented_unit_is_the_declared_one(name: str, cls: type, declared: Mapping[str, Field]) -> None:
    docs = "\n".join(inspect.getdoc(base) or "" for base in cls.__mro__ if base.__module__ != "builtins")
    for parameter in filter(numeric, declared.values()):
        entry = re.search(rf"^ +(?:\w+, )*{parameter.name}(?:, \w+)*: (.*(?:\n {{8,}}.*)*)", docs, re.M)
        if entry is None or not (units := re.findall(r"\[([^\] ]+)\]", entry[1])):
            continue
        found = {dimension for dimension in dimensions(parameter) if dimension != NONE}
        assert found == {d for d in map(dimension_of, units) if d not in (None, NONE)}, parameter


def dimensions(parameter: Field) -> set[Any]:
    """All dimensions in a declaration."""
    return {each.dimension for each in (parameter, *parameter.parts)}


def dimension_of(unit: str) -> Any:
    try:
        return parse_unit(unit).dimension
    except UnitError:  # an index or a reference in brackets
        return None


ROBOT = (Path(__file__).parents[2] / "robots/pioneer_p3dx/robot.toml").read_text()
QUANTITY = re.compile(r'^(\w+) = (?:"|\{ x = "|\["|\[\[")[-+.0-9]+ [a-z/0-9]+"', re.M)


def quantities(text: str) -> list[str]:
    """Keys of a file whose first value is a quantity, as `LINE KEY`."""
    return [f"{text[: m.start()].count(chr(10)) + 1} {m[1]}" for m in QUANTITY.finditer(text)]


def mistaken(text: str, line: int) -> str:
    """The text with the first quantity of a line in a unit that no key has."""
    lines = text.split("\n")
    lines[line - 1] = re.sub(r'"([-+.0-9]+) [a-z/0-9]+"', r'"\1 kg2"', lines[line - 1], count=1)
    return "\n".join(lines)


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("units") / "robots/bot"
    folder.mkdir(parents=True)
    model = (Path(__file__).parents[2] / "robots/pioneer_p3dx/robot.xml").read_text()
    (folder / "robot.xml").write_text(model)
    return folder / "robot.toml"


@pytest.mark.parametrize("at", quantities(ROBOT))
def test_a_wrong_unit_in_a_robot_is_one_fault_at_its_line(robot: Path, at: str) -> None:
    line = int(at.split()[0])
    robot.write_text(mistaken(ROBOT, line))
    faults = [fault for fault in check_content([robot]).faults if not fault.warning]
    assert [fault.line for fault in faults] == [line], (at, list(map(str, faults)))
