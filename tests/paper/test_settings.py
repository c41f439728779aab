"""What scenarios say beside each other: nothing that any of their specs says can change unseen."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import Field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.paper.reuse import _pairs
from benchmarks.paper.settings import OMITTED, UNITS, settings
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.toml_table import Table
from rocs_bt.catalog import (
    ActorSpec,
    AgentSpec,
    FactSpec,
    GroundSpec,
    PlaceSpec,
    PushSpec,
    RateSpec,
    RequirementSpec,
    ScenarioSpec,
    ShareSpec,
)
from rocs_bt.catalog.values import ParameterTable

HERE = Pose2(1.0, -2.0, 0.5)
SPECS = (
    *(ScenarioSpec, RateSpec, PlaceSpec, AgentSpec, ActorSpec),
    *(RequirementSpec, FactSpec, ShareSpec, GroundSpec, PushSpec),
)
LEFT_OUT = {
    *(f"ScenarioSpec.{name}" for name in ("name", "file", "doc", "bases")),
    *(f"RequirementSpec.{name}" for name in ("doc", "position")),
    *(f"{spec}Spec.line" for spec in ("Rate", "Place", "Agent", "Actor", "Requirement", "Share", "Ground", "Push")),
    "AgentSpec.parameters_at",
    "AgentSpec.perturbations",  # no key of a scenario: a comparison sets them
    *("ActorSpec.positions", "PlaceSpec.positions"),
}
"""Words for people, and where things stand in which file."""


def fact(attributes: Mapping[str, Any]) -> Table:
    return Table(Path("full.toml"), {"node": "hall", "kind": "place", **attributes}, ("fact", 0), {})


FULL = ScenarioSpec(
    name="full",
    file=Path("full.toml"),
    doc="Says something of everything.",
    world="arena",
    duration=60.0,
    end_on_collision=False,
    rate=RateSpec(sensors=20.0),
    places=(
        PlaceSpec("goal", "goal", HERE, 0.1, ("R1", "R2"), z=0.5, height_tolerance=0.2),
        PlaceSpec(
            "box",
            "object",
            HERE._replace(yaw=math.nan),
            0.1,
            ("R1",),
            {"width": 0.5, "near": ["goal"]},
            z=1.0,
            height_tolerance=0.3,
        ),
    ),
    agents=tuple(
        AgentSpec(name, "pioneer_p3dx", "go_to", ("a", "b"), HERE, HERE, "goal", False, {"box": 5.0}, 3.0, 0.1, told)
        for name, told in (("R1", {"goal": "goal", "hold": True}), ("R2", {"cruise": "0.5 m/s", "ways": [1, 2.5]}))
    ),
    actors=(
        ActorSpec("M1", "pioneer_p3dx", "random_walk", HERE, HERE, {"max_speed": "0.3 m/s"}),
        ActorSpec("door", "", "slide", HERE, HERE, {"by": [1.0, 0.0]}),
    ),
    requirements=(RequirementSpec("clear", "always min_clearance > 0.05 m", ("R1",), "Keeps clear.", 1, (1, 1)),),
    facts=(
        FactSpec("hall", "place", ("R1",), 0.0, fact({"width": "2 m", "connects": [{"to": "store", "open": True}]})),
        FactSpec("hall", "", ("R2",), 5.0, fact({"width": "3 m"})),
    ),
    bases=(Path("base.toml"),),
    share=ShareSpec(("R1",), ("peer",), ("near",), ("x",), listen="a:1", peers=("b:2",), keys=Path("keys")),
    grounds=(GroundSpec("bumps", "rough", HERE, 4.0, 3.0, 0.04, 0.2, 2, 5),),
    pushes=(PushSpec("R1", (10.0, -60.0, 0.5), 3.0, 9.0, 0.1, 0.5, 7),),
)


def changed(value: Any) -> Iterator[tuple[str, Any]]:
    """The value with each one thing in it changed, and what that is."""
    if is_dataclass(value):
        yield from (
            (where or f"{type(value).__name__}.{field.name}", replace(value, **{field.name: other}))
            for field in fields(value)
            for where, other in changed(getattr(value, field.name))
        )
    elif isinstance(value, Table):
        yield from (("", fact(data)) for _, data in changed({**value.data}) if data.keys() >= {"node", "kind"})
    elif isinstance(value, Mapping):
        yield "", {**value, "another": 1.0}
        for key, old in value.items():
            if key not in FactSpec.KEYS:
                yield "", {name: of for name, of in value.items() if name != key}
                yield from ((where, {**value, key: other}) for where, other in changed(old))
    elif isinstance(value, Pose2):
        yield from (("", value._replace(**{name: getattr(value, name) + 1e-9})) for name in ("x", "y"))
        yield "", value._replace(yaw=0.1 if math.isnan(value.yaw) else value.yaw + 1e-9)
    elif isinstance(value, (tuple, list)):
        yield "", value[1:]
        yield from (
            (where, type(value)([*value[:at], other, *value[at + 1 :]]))
            for at, each in enumerate(value)
            for where, other in changed(each)
        )
    else:
        yield "", other_than(value)


def other_than(value: Any) -> Any:
    """Another value of its kind, as like it as can be."""
    if value is None:
        return ParameterTable(Path("full.toml"), 1, 1, {})
    if isinstance(value, bool):
        return not value
    if isinstance(value, (int, float)):
        return 1e9 if math.isinf(value) else value + type(value)(1e-9 if isinstance(value, float) else 1)
    if isinstance(value, Path):
        return value / "other"
    assert isinstance(value, str), f"the test knows no other value than {value!r}"
    return value + "x"


CHANGES = list(changed(FULL))


def differing(first: ScenarioSpec, second: ScenarioSpec) -> set[str]:
    """What a diff lists as different: of the scenarios, and of the robots that take each other's part."""
    pairs = [(first, second), *_pairs(first.agents, second.agents), *_pairs(first.actors, second.actors)]
    return {row.what for pair in pairs for row in settings(*pair) if not row.same}


def test_nothing_differs_from_itself():
    assert not differing(FULL, replace(FULL))


def test_the_scenario_of_this_test_says_something_in_every_field_of_every_spec():
    """A field that is new, or that this test does not set, is missing here: set it in FULL."""
    every = {f"{spec.__name__}.{field.name}" for spec in SPECS for field in fields(spec)}
    within = {"ScenarioSpec.rate", "ScenarioSpec.share"}  # of which each field is changed instead
    assert {where for where, _ in CHANGES} == every - within


@pytest.mark.parametrize("where", sorted({where for where, _ in CHANGES} - LEFT_OUT))
def test_no_field_of_any_spec_changes_unseen(where: str) -> None:
    for other in (other for at, other in CHANGES if at == where):
        assert differing(FULL, other), other
        assert differing(other, FULL) == differing(FULL, other)


@pytest.mark.parametrize("where", sorted(LEFT_OUT))
def test_words_for_people_and_places_in_files_are_no_settings(where: str) -> None:
    assert not any(differing(FULL, other) for at, other in CHANGES if at == where)


def test_what_is_left_out_is_no_more_than_that():
    every = [(spec.__name__, field.name) for spec in SPECS for field in fields(spec)]
    called = {
        f"{spec}.name" for spec in ("PlaceSpec", "AgentSpec", "ActorSpec", "RequirementSpec", "GroundSpec")
    }  # in the rows
    assert {f"{spec}.{name}" for spec, name in every if name in OMITTED} == LEFT_OUT | called


def test_what_is_not_set_on_one_side_differs():
    bare = replace(FULL, agents=tuple(replace(a, success=None, shortest_path=None, latency=None) for a in FULL.agents))
    assert differing(FULL, bare) == {"success", "shortest path", "latency"}
    assert "share's rate" in differing(FULL, replace(FULL, share=None))


def test_every_number_has_its_unit():
    def a_number(field: Field[Any]) -> bool:
        return "float" in str(field.type)

    bare = {field.name for spec in SPECS for field in fields(spec) if a_number(field)} - UNITS.keys()
    assert bare == {"loss"}, "a part of messages, which has none"


def test_texts_are_for_people_and_numbers_in_full_where_rounding_would_hide_a_difference():
    agent, actor = FULL.agents[1], FULL.actors[0]
    rows = {row.what: (row.first, row.second) for row in settings(agent, replace(agent, pose=Pose2(1.0, -2.0, 0.5001)))}
    assert rows["start"] == ("1.0 m, -2.0 m, 0.5 rad", "1.0 m, -2.0 m, 0.5001 rad")
    assert rows["jitter"][0] == "1 m, -2 m, 0.5 rad"
    assert rows["after"][0] == "box 5 s"
    assert rows["mission's ways"][0] == "1, 2.5"
    rows = {row.what: (row.first, row.second) for row in settings(None, actor)}
    assert rows["script's max_speed"] == ("", "0.3 m/s")
    rows = {row.what: (row.first, row.second) for row in settings(FULL, None)}
    assert rows["duration"] == ("60 s", "")
    assert (
        rows["place goal"][0]
        == "kind: goal; pose: 1 m, -2 m, 0.5 rad; tolerance: 0.1 m; agents: R1, R2; z: 0.5 m; height tolerance: 0.2 m"
    )
    assert rows["fact hall #2"][0] == "node: hall; agents: R2; at: 5 s; table: width 3 m"
    assert (rows["rate's control"][0], rows["actors"][0]) == ("20 Hz", "M1, door")
