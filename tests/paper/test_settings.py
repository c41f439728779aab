"""What scenarios say beside each other: nothing that any of their specs says can change unseen."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from benchmarks.paper.reuse import _pairs
from benchmarks.paper.settings import OMITTED, UNITS, settings
from rocs_bt.base.geometry import Pose2
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
    SuccessSpec,
)
from rocs_bt.declare import Field, Value, fields_of, replaced, values_of
from rocs_bt.share.scenario import ShareSpec

HERE = Pose2(1.0, -2.0, 0.5)
SPECS = (
    *(ScenarioSpec, RateSpec, PlaceSpec, AgentSpec, ActorSpec),
    *(RequirementSpec, FactSpec, ShareSpec, GroundSpec, PushSpec, SuccessSpec),
)
LEFT_OUT = {
    *(f"ScenarioSpec.{name}" for name in ("name", "file", "doc", "bases", "format")),
    "RequirementSpec.doc",
    "AgentSpec.perturbations",  # no key of a scenario: a comparison sets them
}
"""Words for people, and where things are in which file."""


FULL = ScenarioSpec(
    name="full",
    file=Path("full.toml"),
    doc="Says something of everything.",
    world="arena",
    duration=60.0,
    end_on_collision=False,
    rate=RateSpec(sensors=20.0),
    places=(
        PlaceSpec(name="goal", pose=HERE, agents=("R1", "R2"), z=0.5, height_tolerance=0.2),
        PlaceSpec(
            name="box",
            kind="object",
            pose=HERE._replace(yaw=math.nan),
            agents=("R1",),
            attributes={"width": 0.5, "near": ["goal"]},
            z=1.0,
            height_tolerance=0.3,
        ),
    ),
    agents=tuple(
        AgentSpec(
            name=name,
            robot="pioneer_p3dx",
            mission="go_to",
            rules=("a", "b"),
            pose=HERE,
            jitter=HERE,
            success=SuccessSpec(goal="goal", after={"box": 5.0}, shortest_path=3.0),
            latency=0.1,
            parameters=told,
            overlay={"sensor": 1},
        )
        for name, told in (("R1", {"goal": "goal", "hold": True}), ("R2", {"cruise": "0.5 m/s", "ways": [1, 2.5]}))
    ),
    actors=(
        ActorSpec(
            name="M1", robot="pioneer_p3dx", script="random_walk", pose=HERE, parameters={"max_speed": "0.3 m/s"}
        ),
        ActorSpec(name="door", script="slide", pose=HERE, jitter=HERE, parameters={"by": [1.0, 0.0]}),
    ),
    requirements=(
        RequirementSpec(name="clear", require="always min_clearance > 0.05 m", agent="R1", doc="Keeps clear."),
    ),
    facts=(
        FactSpec(node="hall", kind="place", agents=("R1",), attributes={"width": "2 m", "connects": [{"to": "store"}]}),
        FactSpec(node="hall", agents=("R2",), at=5.0, attributes={"width": "3 m"}),
    ),
    bases=(Path("base.toml"),),
    tables={
        "share": ShareSpec(
            agents=("R1",),
            kinds=("peer",),
            relations=("near",),
            private=("x",),
            listen="a:1",
            peers=("b:2",),
            keys=Path("keys"),
        )
    },
    grounds=(
        GroundSpec(name="bumps", kind="rough", pose=HERE, length=4.0, width=3.0, height=0.04, grain=0.2, count=2),
    ),
    pushes=(PushSpec(robot="R1", at=3.0, until=9.0, force=(10.0, -60.0, 0.5), spread=0.5),),
)


def changed(value: Any) -> Iterator[tuple[str, Any]]:
    """The value with each one thing in it changed, and what that is."""
    if isinstance(value, Value):
        yield from (
            (where or f"{type(value).__name__}.{name}", replaced(value, **{name: other}))
            for name, old in values_of(value).items()
            for where, other in changed(old)
        )
    elif isinstance(value, Mapping):
        if not any(isinstance(old, Value) for old in value.values()):
            yield "", {**value, "another": 1.0}
        for key, old in value.items():
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
        return {"of": 1}
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
    assert not differing(FULL, replaced(FULL))


def test_the_scenario_of_this_test_says_something_in_every_field_of_every_spec():
    """A field that is new, or that this test does not set, is missing here: set it in FULL."""
    every = {f"{spec.__name__}.{field.name}" for spec in SPECS for field in fields_of(spec)}
    within = {"ScenarioSpec.rate", "AgentSpec.success"}  # of which each field is changed instead
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
    every = [(spec.__name__, field.name) for spec in SPECS for field in fields_of(spec)]
    called = {
        f"{spec}.name" for spec in ("PlaceSpec", "AgentSpec", "ActorSpec", "RequirementSpec", "GroundSpec")
    }  # in the rows
    assert {f"{spec}.{name}" for spec, name in every if name in OMITTED} == LEFT_OUT | called


def test_what_is_not_set_on_one_side_differs():
    bare = replaced(FULL, agents=tuple(replaced(a, success=SuccessSpec(), latency=None) for a in FULL.agents))
    assert differing(FULL, bare) == {"success's goal", "success's after", "success's shortest path", "latency"}
    assert "share's rate" in differing(FULL, replaced(FULL, tables={}))


def test_every_number_has_its_unit():
    def a_number(field: Field) -> bool:
        return field.hint is float

    bare = {field.name for spec in SPECS for field in fields_of(spec) if a_number(field)} - UNITS.keys()
    assert bare == {"loss"}, "a part of messages, which has none"


def test_texts_are_for_people_and_numbers_in_full_where_rounding_would_hide_a_difference():
    agent, actor = FULL.agents[1], FULL.actors[0]
    rows = {
        row.what: (row.first, row.second) for row in settings(agent, replaced(agent, pose=Pose2(1.0, -2.0, 0.5001)))
    }
    assert rows["start"] == ("1.0 m, -2.0 m, 0.5 rad", "1.0 m, -2.0 m, 0.5001 rad")
    assert rows["jitter"][0] == "1 m, -2 m, 0.5 rad"
    assert rows["success's after"][0] == "box 5 s"
    assert rows["mission's ways"][0] == "1, 2.5"
    rows = {row.what: (row.first, row.second) for row in settings(None, actor)}
    assert rows["script's max_speed"] == ("", "0.3 m/s")
    rows = {row.what: (row.first, row.second) for row in settings(FULL, None)}
    assert rows["duration"] == ("60 s", "")
    assert (
        rows["place goal"][0]
        == "kind: goal; pose: 1 m, -2 m, 0.5 rad; tolerance: 0.1 m; agents: R1, R2; z: 0.5 m; height tolerance: 0.2 m"
    )
    assert rows["fact hall #2"][0] == "node: hall; agents: R2; at: 5 s; attributes: width 3 m"
    assert (rows["rate's control"][0], rows["actors"][0]) == ("20 Hz", "M1, door")
