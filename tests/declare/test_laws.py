"""Laws of declared values: for every declared class, each wrong value is one fault at its key, and all come at once."""

from __future__ import annotations

import contextlib
import inspect
import math
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rocs_bt.simulation.identified_file
import rocs_bt.simulation.scripted_objects
import rocs_bt.simulation.scripted_robots  # noqa: F401 - declares classes, as those above
from rocs_bt import AtomicAction
from rocs_bt.analyze import Analyze
from rocs_bt.base.errors import Fault, InputError
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.toml_text import as_toml
from rocs_bt.base.units import ANGLE, LENGTH, NONE, POSITIVE, SPEED, TIME, Bounds, Dimension, Metres, Quantity, Radians
from rocs_bt.catalog import Catalog, ScenarioSpec
from rocs_bt.compare import load_family
from rocs_bt.declare import (
    MISSING,
    Content,
    Declared,
    Field,
    InFile,
    InUnit,
    Key,
    Keys,
    Kinds,
    Names,
    Open,
    Option,
    Rest,
    Scope,
    SetByPrograms,
    TableName,
    Value,
    Word,
    fields_of,
    location_of,
    read,
    read_arguments,
    read_root,
    read_value,
    read_values,
    replaced,
    values_of,
)
from rocs_bt.monitor import Monitor


class Device(Declared):
    name: str
    driver: str
    noise: Annotated[float, InUnit("unit"), Bounds(0.0)] = 0.0  # before its unit, and read after it
    unit: str = "1"


class Beam(Device):
    rays: Annotated[int, Bounds(1, 9)]
    reach: Annotated[float, LENGTH, POSITIVE] = 2.0
    angles: tuple[Annotated[float, ANGLE], ...] = ()


class Own(Device):
    parameters: Annotated[Open, Rest()] = Open()
    gain: float = 1.0  # no parameter, though it is declared after them


def drivers() -> dict[str, type[Declared]]:
    return {"beam": Beam, "plain": Device, "": Own}


BY_DRIVER = Kinds("driver", drivers, "driver")


class Corner(Value):
    x: Metres
    y: Metres = 0.0

    def _made(self) -> tuple[float, float]:
        return self.x, self.y


class Part(Value):
    name: Annotated[str, TableName()]
    share: Annotated[float, Bounds(0.0, 1.0)] = 0.5
    word: Literal["one", "two"] = "one"
    many: Annotated[tuple[int, ...], Key("counts")] = ()
    late: Annotated[float | None, TIME, Bounds(0.0, 60.0), Word("measured")] = 0.0


class Whole(Value):
    doc: str
    flag: bool = False
    at: Annotated[tuple[float, float], Keys(Corner, here=True)]
    far: Annotated[tuple[float, float], Keys(Corner)] = (0.0, 0.0)
    strength: Annotated[Quantity, POSITIVE] = Quantity(1.0, NONE)
    pair: tuple[Metres, Radians] = (0.0, 0.0)
    devices: Annotated[tuple[Device, ...], Key("device"), BY_DRIVER] = ()
    free: Open = Open()


def classes(of: type[Declared] = Declared) -> Iterator[type[Declared]]:
    for cls in of.__subclasses__():
        yield cls
        yield from classes(cls)


RESULTS = "rocs_bt.simulation.identify"
"""Module of values that no file contains."""

SHIPPED = sorted(
    (c for c in classes() if c.__module__.startswith("rocs_bt.") and c.__module__ != RESULTS),
    key=lambda c: c.__qualname__,
)
SHIPPED = [cls for cls in SHIPPED if not inspect.isabstract(cls)]


def ordinary(each: Field) -> bool:
    """Whether a field is one number, text or flag in the table of its class."""
    nested = isinstance(each.hint, type) and issubclass(each.hint, Declared)
    special = any(each.mark(m) for m in (Keys, Rest, SetByPrograms, TableName, Kinds))
    plain = each.hint in (float, int, str, bool, Quantity) or bool(each.options)
    return plain and not (nested or special or each.many)


ALSO = {"count": ("kind", 'kind = "step"'), "height_tolerance": ("z", 'z = "1 m"')}
"""Keys that need another one: its name and a line of it."""

FAMILIES = [type(load_family(Catalog(), entry.name)) for entry in Catalog().list("family")]

CASES = [(cls, each) for cls in (*SHIPPED, *FAMILIES) for each in fields_of(cls) if ordinary(each)]


def written(each: Field, number: float) -> Any:
    of = each.mark(Dimension) or NONE
    return number if of == NONE and not isinstance(of, InUnit) else f"{number!r} {of}"


def valid(each: Field) -> Any:
    """A valid value of a field, as in a file."""
    if each.options:
        return next(option for option in each.options if option)
    if each.hint is str:
        return "a" if not each.mark(Content) else "any"
    bounds = each.mark(Bounds) or Bounds()
    low = bounds.low if math.isfinite(bounds.low) else 0.0
    middle = 0.5 * (low + bounds.high) if math.isfinite(bounds.high) else low + 1.0
    if each.hint is int:
        return round(middle)
    return {bool: True, Quantity: "2 s"}.get(each.hint, written(each, middle))


def wrong(each: Field) -> Iterator[Any]:
    """Wrong values of a field, as in a file: of another type, without a unit, of another one, out of bounds."""
    yield from ([], {"a": 1})
    if each.hint is not bool and each.hint is not Quantity:
        yield True
    if each.options:
        yield "nonsense"
    if each.hint in (int, bool):
        yield "1"
    if each.hint is str or each.options:
        yield 3
    if each.hint is float:
        yield from ("much", "3 kg/s2")
        if (each.mark(Dimension) or NONE) != NONE:
            yield 1.0
    bounds = each.mark(Bounds)
    if bounds is not None and each.hint in (int, float):
        step = 1 if each.hint is int else 0.1
        beyond = [bounds.low - step] if math.isfinite(bounds.low) else []
        beyond += [bounds.high + step] if math.isfinite(bounds.high) else []
        for number in beyond:
            yield int(number) if each.hint is int else written(each, number)


def faults(cls: type[Declared], text: str, folder: Path) -> tuple[Fault, ...]:
    file = folder / "it.toml"
    file.write_text(text, "utf-8")
    try:
        root = read_toml(file)
        if issubclass(cls, (Monitor, Analyze)):
            read_arguments({each.key: each for each in fields_of(cls)}, Open.of(root, root.data), cls.__name__)
            return ()
        read(cls, root, Scope(names={"agent": ["any", "a"], "goal": ["a"], "robot": ["a"]}))
        root.done()
    except InputError as error:
        return error.faults
    return ()


@pytest.mark.parametrize(("cls", "each"), CASES, ids=lambda of: getattr(of, "__name__", getattr(of, "name", "")))
def test_a_wrong_value_is_one_fault_at_its_key_that_names_it(cls: type[Declared], each: Field, tmp_path: Path) -> None:
    also, line = ALSO.get(each.key, ("", ""))
    needed = [f for f in fields_of(cls) if f is not each and (f.required or f.mark(InFile)) and ordinary(f)]
    others = [f for f in needed if f.key != also]
    head = f"{line}\n" + "".join(f"{f.key} = {as_toml({'v': valid(f)}).partition('= ')[2]}" for f in others)
    before = {(f.line, f.message) for f in faults(cls, head, tmp_path)}
    row = head.count("\n") + 1
    for value in wrong(each):
        found = faults(cls, f"{head}{each.key} = {as_toml({'v': value}).partition('= ')[2]}", tmp_path)
        new = [f for f in found if f.line == row]
        assert len(new) == 1, (value, found)
        assert (new[0].line, new[0].column) == (row, 1)
        assert each.key in new[0].message or repr(value)[1:-1] in new[0].message, new[0]
        assert {(f.line, f.message) for f in found if f.line != row} <= before | {(0, f.message) for f in found}


GOOD = """doc = "All."
x = "1 m"
far = { x = "2 m" }
strength = "0.3 s"
pair = ["1 m", "1 rad"]
[[device]]
name = "eye"
driver = "beam"
unit = "m"
noise = "2 cm"
rays = 3
angles = ["90 deg", "0 rad"]
[[device]]
name = "mine"
driver = "parts.py:Mine"
reach = "any"
gain = 2
[device.more]
deep = 3
"""


def of(text: str, tmp_path: Path) -> tuple[Whole, tuple[Fault, ...]]:
    file = tmp_path / "whole.toml"
    file.write_text(text, "utf-8")
    root = read_toml(file)
    made = read(Whole, root)
    try:
        root.done()
    except InputError as error:
        return made, error.faults
    return made, ()


def test_a_document_becomes_an_object_in_si_units(tmp_path: Path) -> None:
    made, found = of(GOOD, tmp_path)
    assert not found
    eye, mine = made.devices
    assert isinstance(eye, Beam)
    assert (made.at, made.far, str(made.strength)) == ((1.0, 0.0), (2.0, 0.0), "0.3 s")
    assert made.pair == (1.0, 1.0)
    assert (eye.noise, eye.rays, eye.reach, eye.angles) == (0.02, 3, 2.0, (math.pi / 2.0, 0.0))
    assert isinstance(mine, Own)
    assert mine.gain == 2.0
    assert mine.parameters == {"reach": "any", "more": {"deep": 3}}
    assert location_of(mine.parameters, "reach") == (tmp_path / "whole.toml", 16, 1)
    assert [location_of(mine.parameters, *key)[1:] for key in (["more"], ["more", "deep"])] == [(18, 1), (19, 1)]
    assert (location_of(eye).line, location_of(mine).line, location_of(mine, "driver")[1:]) == (6, 13, (15, 1))
    assert location_of(replaced(made, doc="x")) == location_of(made)


SPOILED = {
    'doc = "All."': "doc = 1",
    'x = "1 m"\nfar': 'x = "1 s"\nfar',
    '"0.3 s"': '"-0.3 s"',
    '"2 cm"': '"2 s"',
    'pair = ["1 m",': 'pair = ["1 rad",',
    "rays = 3": "rays = 10",
    '"90 deg"': "90",
    'name = "mine"': "nam = 3",
}
"""Independent faults: each text and what spoils it."""


def test_independent_faults_come_all_at_once(tmp_path: Path) -> None:
    random = np.random.default_rng(7)
    for _ in range(40):
        chosen = [old for old in SPOILED if random.random() < 0.5]
        text = GOOD
        for old in chosen:
            text = text.replace(old, SPOILED[old])
        found = of(text, tmp_path)[1]
        assert len({(f.line, f.column) for f in found}) == len(found) == len(chosen), (chosen, found)


def test_a_kind_says_what_it_needs_and_a_misspelt_key_what_was_meant(tmp_path: Path) -> None:
    found = of(GOOD.replace("rays = 3", "rais = 3"), tmp_path)[1]
    assert [(f.line, f.message) for f in sorted(found, key=lambda f: f.line)] == [
        (6, "the driver 'beam' needs 'rays'."),
        (11, "unknown key 'rais' in device.0."),
    ]
    assert "It takes: rays, reach, angles." in str(found)
    assert "Did you mean 'rays'?" in str(found)
    found = of(GOOD.replace('"beam"', '"beem"'), tmp_path)[1]
    assert [f.message for f in found] == ["no driver is named 'beem'."]
    assert "Did you mean 'beam'?" in found[0].hint


def test_values_that_no_file_contains_have_faults_without_a_place() -> None:
    good = {"name": "eye", "driver": "beam", "rays": 2, "reach": "50 cm"}
    assert read_values(Beam, good, "the beam").reach == 0.5
    with pytest.raises(InputError) as caught:
        read_values(Beam, {**good, "rays": "2", "rech": 1}, "the beam")
    assert [str(fault) for fault in caught.value.faults] == [
        "rays must be a whole number, found '2'.",
        "no parameter is named 'rech'. Did you mean 'reach'? "
        "The beam has: angles, driver, name, noise, rays, reach, unit.",
    ]
    for pair in (["1 m"], ["1 m", "1 rad", "2 rad"]):
        with pytest.raises(InputError, match=f"pair must have 2 values, found {len(pair)}"):
            read_values(Whole, {"doc": "", "x": "1 m", "pair": pair}, "it")


@pytest.mark.parametrize("cls", SHIPPED, ids=lambda cls: cls.__name__)
def test_every_key_is_described(cls: type[Declared]) -> None:
    docs = " ".join(base.__doc__ or "" for base in cls.__mro__)
    others = [f.name for f in fields_of(cls) if not f.mark(Option)]  # an option has a help
    assert [name for name in others if not re.search(rf"\b{name}\b", docs, re.IGNORECASE)] == []


def test_objects_made_in_python_are_values() -> None:
    one, two = (Part(name="a", many=(1, 2)) for _ in range(2))
    assert one == two
    assert hash(one) == hash(two)
    assert replaced(one, share=0.25) != one
    assert location_of(one) == (None, 0, 0)
    with pytest.raises(TypeError, match="Part takes no shares"):
        Part(name="a", shares=1.0)
    with pytest.raises(TypeError, match="Part needs name"):
        Part()
    with pytest.raises(AttributeError, match="Use replaced"):
        one.share = 1.0


Speeds, Points = Annotated[Sequence[float], SPEED, POSITIVE], Annotated[Sequence[Sequence[float]], LENGTH]
GIVEN: list[tuple[Any, list[Any], list[tuple[Any, str]]]] = [
    (float, [1.0, 1, np.float32(1), np.int64(1)], [("0.5 m/s", "a number"), (True, "a number"), (math.nan, "finite")]),
    (int, [3, np.int32(3)], [(1.0, "a whole number"), (True, "a whole number"), ("3", "a whole number")]),
    (str, [""], [(3, "a text")]),
    (bool, [True], [(1, "true or false"), ("yes", "true or false")]),
    (Speeds, [[1.0, 2], (1,), np.ones(2), []], [("12", "a list"), ({1: 2}, "a list"), (["1 m"], "a number")]),
    (Speeds, [], [(1.0, "a list"), ([1.0, None], "a number"), ([1.0, -2.0], "positive, found -2 m/s")]),
    (Points, [[(1, 2), [3, 4, 5]], np.zeros((3, 2))], [([1.0, 2.0], "a list"), ([["a"]], "a number")]),
    (tuple[float, str], [(1.0, "a"), [2, ""]], [((1.0,), "2 values, found 1"), ((1.0, 2.0), "a text")]),
    (Literal["one", "two"], ["one"], [("three", "")]),
    (int | str, ["a", 3], []),
    (Callable[[float], bool], [len], []),
]
"""Types of annotations: values that fit, and values that do not with what they must be."""


@pytest.mark.parametrize(("hint", "good", "bad"), GIVEN)
def test_values_that_programs_give_are_checked_against_their_annotation(hint: Any, good: Any, bad: Any) -> None:
    each = Field.annotated("x", hint, MISSING, object)
    assert [fault for value in good for fault in each.faults(value, "x of it")] == []
    for value, wanted in bad:
        (fault,) = each.faults(value, "x of it")
        assert "x of it" in fault.message
        assert wanted in fault.message


@pytest.mark.parametrize("hint", [3, Final[int], TypeVar("T"), Sequence[TypeVar("T")]])
def test_an_annotation_that_is_no_type_is_refused_with_advice(hint: Any) -> None:
    with pytest.raises(InputError, match=r"'x' of 'Part' has the type .* Write a type, or Any"):
        Field.annotated("x", hint, MISSING, Part)


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=2) | st.tuples(inner),
    max_leaves=8,
)


@given(st.sampled_from([hint for hint, _, _ in GIVEN]), ANYTHING)
def test_no_value_makes_a_check_or_a_reading_raise_anything_else(hint: Any, value: Any) -> None:
    each = Field.annotated("x", hint, MISSING, object)
    each.faults(value, "x")
    with contextlib.suppress(InputError):
        read_value(each, value)


def test_every_name_without_an_underscore_can_be_a_field_unless_a_base_defines_it() -> None:
    assert [name for name in dir(Value) if name[0] != "_"] == []

    class Body(AtomicAction):
        def travel(self) -> None: ...

    for name, owner in (("travel", "Body"), ("act", "AtomicAction"), ("live", "Action")):
        with pytest.raises(InputError, match=f"'{name}' cannot be a field of 'Walk': it is a member of {owner}"):
            type("Walk", (Body,), {"__annotations__": {name: float}})


def test_a_field_may_have_the_name_of_an_attribute_of_a_mixin() -> None:
    class Mixin:
        speed: float
        reach: float = 2.0

    class Arm(Mixin, Value):
        speed: float = 0.4
        reach: float

    assert values_of(Arm()) == {"speed": 0.4, "reach": 2.0}


def test_a_default_may_be_changed_without_an_annotation() -> None:
    class Mixin:
        share = 0.25

    class Half(Mixin, Part):
        many = (1, 2)

    made = Half(name="a")
    assert (made.many, made.share) == (Half.many, Half.share) == ((1, 2), 0.25)
    defaults = {each.name: each.default for each in fields_of(Half)}
    assert (defaults["many"], defaults["share"]) == ((1, 2), 0.25)


def test_every_shipped_scenario_has_the_places_of_its_tables() -> None:
    catalog = Catalog()
    for entry in catalog.list("scenario"):
        scenario = catalog.read_scenario(entry.name)
        assert isinstance(scenario, ScenarioSpec)
        for each in (*scenario.agents, *scenario.places):
            assert location_of(each).line > 0, (entry.name, each.name)


def test_a_text_may_name_what_the_document_declares(tmp_path: Path) -> None:
    class Team(Value):
        all: Annotated[tuple[str, ...], Names("robot", "no robot", all=True)] = ()
        some: Annotated[tuple[str, ...], Names("robot", "no robot")] = ()

    file = tmp_path / "team.toml"
    file.write_text('some = ["R1", "R3"]', "utf-8")
    with pytest.raises(InputError, match="no robot is named 'R3'"):
        read_root(Team, read_toml(file), Scope(names={"robot": ["R1", "R2"]}))
    file.write_text('some = ["R1"]', "utf-8")
    assert read_root(Team, read_toml(file), Scope(names={"robot": ["R1", "R2"]})).all == ("R1", "R2")
